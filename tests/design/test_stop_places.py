"""Stops beside the motion, and inside the travel of a damper that has ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from design.one_joint import LEG, PROJECT
from synth.api.designs import design as design_of
from synth.design.leg_design import LegDesign
from synth.design.stop_places import CLOCKING, least_stops, moved_range, within_damper

MOVED = moved_range(-160.2, -90.4)  # -166 and -85
STOPS = (-169.0, -82.0)


def test_the_closest_stops_leave_a_degree_to_the_motion_and_the_tolerance_of_their_flanks() -> None:
    assert least_stops(MOVED, asked=False) == (-163.5, -87.5)
    assert least_stops((-170.0, -80.0), asked=True) == (-171.5, -78.5)


@pytest.mark.parametrize("turns", [76.0, 77.0, 80.0, 88.9])
def test_stops_are_drawn_closer_for_a_damper(turns: float) -> None:
    least = least_stops(MOVED, asked=False)
    travel, stops = within_damper(MOVED, STOPS, least, turns)
    assert stops[1] - stops[0] == pytest.approx(max(turns - 2.0 * CLOCKING, least[1] - least[0]))
    assert STOPS[0] <= stops[0] <= least[0]
    assert least[1] <= stops[1] <= STOPS[1]
    assert stops[0] + 1.5 <= travel[0] + 1e-9
    assert travel[1] <= stops[1] - 1.5 + 1e-9


@pytest.mark.parametrize("turns", [75.9, 89.0, 200.0])
def test_stops_stay_for_a_damper_that_turns_far_enough_or_never_can(turns: float) -> None:
    assert within_damper(MOVED, STOPS, least_stops(MOVED, asked=False), turns) == (MOVED, STOPS)


def test_stops_of_a_stated_range_stay() -> None:
    travel, stops = (-170.0, -80.0), (-171.5, -78.5)
    assert within_damper(travel, stops, least_stops(travel, asked=True), 94.0) == (travel, stops)


ROW = "part,vendor,direction,continuous,travel [deg],max_torque [N*m],speed [rpm],max_speed [rpm],source"


def with_vane(folder: Path, turns: float, damper: str, between: str = "", *, solids: bool = False) -> LegDesign:
    """A design that may take a vane damper that ``turns`` so far (deg), or only that."""
    (folder / "vane.csv").write_text(f"{ROW}\nVANE,Acme,both,no,{turns},0.1,20,400,mine\n")
    (folder / "one.leg.yaml").write_text(LEG.format(range=between))
    text = PROJECT.format(spring="make: true", amplitude=30, frequency=2)
    text = text.replace("spring: {make: true}", f"spring: {{make: true}}, damper: {{{damper}}}")
    (folder / "p.yaml").write_text(text.replace("select: {", "select: {catalogs: [vane.csv], "))
    return design_of(folder / "p.yaml", solids=solids).design


def test_a_damper_turns_from_stop_to_stop_not_only_through_the_motion(tmp_path: Path) -> None:
    """One of 91 deg was taken without a word for stops 93 deg apart."""
    between = "\n    range: [120 deg, 210 deg]"
    named = with_vane(tmp_path, 91.0, "part: VANE", between)
    (said,) = [text for _, text in named.warnings if "VANE turns by" in text]
    assert "VANE turns by 91 deg only, and the joint turns it by 93 deg from stop to stop" in said
    free = with_vane(tmp_path, 91.0, "direction: both", between)
    assert "VANE" not in [option.part for option in free.dampers.ranked[0]]
    assert free.dampers.left_out[0]["turns less than 93 deg"] >= 1


def test_stops_of_an_unstated_range_are_drawn_for_the_chosen_damper(tmp_path: Path) -> None:
    """The motion turns the joint by 50 deg; its stops would stand 67 deg apart."""
    design = with_vane(tmp_path, 62.0, "part: VANE", solids=True)
    assert design.drawn is not None
    (joint,) = design.drawn.dimensions.joints
    first, last = joint.stop_angles
    moved = np.degrees(np.concatenate([design.built.to_measured(m)[:, 0] for m in design.built_motions]))
    assert last - first == pytest.approx(62.0 - 2.0 * CLOCKING)
    assert first + 1.5 < moved.min() < moved.max() < last - 1.5
    assert joint.damper.travel == pytest.approx(62.0)
    assert not [text for _, text in design.warnings if "VANE turns by" in text]

"""A range that the target states is drawn as it stands; what it leaves out is told, simulated and counted."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from design.one_joint import designed
from synth.api.designs import Design
from synth.design.drawn_springs import seats_set
from synth.design.free_angle_reach import out_of_reach, refuse_stops
from synth.design.held_to_ranges import held_to_ranges
from synth.design.leg_design import LegDesign
from synth.errors import UserError
from synth.files.joint_curves import stops_at_range, without_held
from synth.files.project_options import MeasuredSpring
from synth.model_checks.designed_leg import designed_leg_checks
from synth.remarks import severity_of


@pytest.fixture(scope="module")
def wide(tmp_path_factory: pytest.TempPathFactory) -> LegDesign:
    return designed(tmp_path_factory.mktemp("wide"), between=(120, 215), solids=False)


@pytest.fixture(scope="module")
def leaning(tmp_path_factory: pytest.TempPathFactory) -> LegDesign:
    """The rest pose, at 170 deg, and half of the motion lie outside the range."""
    return designed(tmp_path_factory.mktemp("leaning"), between=(175, 205))


def test_a_range_that_holds_the_motion_changes_nothing(wide: LegDesign) -> None:
    assert wide.ranges[0].outside == ()
    assert not any("range" in text for _, text in wide.warnings)
    assert wide.built.joints[0].effects == {}
    assert held_to_ranges(wide).sets == wide.sets


def test_a_stated_range_is_drawn_as_it_stands(leaning: LegDesign) -> None:
    """It was widened, without a word, until it held the rest pose."""
    assert leaning.drawn is not None
    knee = leaning.drawn.dimensions.joints[0]
    np.testing.assert_allclose([*knee.range, *knee.stop_angles], [175.0, 205.0, 173.5, 206.5], atol=1e-9)
    assert knee.rest_angle == pytest.approx(175.0)


def test_what_a_stated_range_leaves_out_is_told(leaning: LegDesign) -> None:
    assert leaning.ranges[0].outside == ("wanted motion", "rest pose")
    told = [text for joint, text in leaning.warnings if joint == "knee"][:2]
    assert [severity_of(text) for text in told] == ["decide", "decide"]
    assert "a range of 175 to 205 deg" in told[0]
    assert "the wanted motion takes 140.8 to 210.0 deg" in told[0]
    assert "rest pose is at 170.0 deg" in told[1]
    assert "it is drawn at that end of its range" in told[1]


def test_the_error_that_is_told_has_the_stops(leaning: LegDesign) -> None:
    """It was that of a leg without stops, which moved nearly as wanted: nothing was told."""
    (error,) = np.degrees(leaning.errors)
    assert error > 5.0
    told = [str(text) for _, text in leaning.warnings if "the built leg will move" in text]
    assert told == [f"knee: the built leg will move {error:.1f} deg (RMS) off the wanted motion"]


def test_the_built_leg_and_its_forecasts_stop_at_the_stops(wide: LegDesign, leaning: LegDesign) -> None:
    """Released at 210 deg it starts from the stop at 206.5, swings to that at 173.5 and stays there."""
    motion = np.degrees(leaning.built.to_measured(leaning.built_motions[0]))[:, 0]
    assert motion[0] == pytest.approx(206.5)
    assert motion.min() > 173.5 - 1.0
    assert motion[-1] == pytest.approx(173.5, abs=0.1)
    wanted = np.degrees(leaning.wanted.leg.to_measured(leaning.wanted.motions[0]))[:, 0]
    assert wanted[0] == pytest.approx(210.0)
    error = float(np.sqrt(np.mean(leaning.errors**2)))
    assert error > 3.0 * float(np.sqrt(np.mean(wide.errors**2)))
    for chosen in (leaning.sets.chosen.forecast, leaning.sets.measured):
        assert chosen.nominal == pytest.approx(error, rel=0.02)
        assert chosen.chance == 0.0
    assert wide.sets.measured.chance > 0.9
    assert leaning.sets.chosen.forecast.shares


def test_the_exported_model_stops_where_the_prediction_does(tmp_path: Path) -> None:
    """MuJoCo moves the leg within 0.3 deg; the files name no stop as missing, because their limits are the stops."""
    pytest.importorskip("mujoco")
    made = designed(tmp_path, between=(150, 215), solids=False)
    knee = made.built.joints[0]
    assert stops_at_range(knee)
    assert without_held(knee, ()) == []
    folder = tmp_path / "result"
    folder.mkdir()
    Design(made, solids=False).write_with(folder)
    (check,) = designed_leg_checks(folder).checks
    assert abs(check.found - check.expected) < check.limit
    assert not any("stop" in text for text in json.loads((folder / "design.json").read_text())["solids"]["notes"])
    known = json.loads((folder / "design.json").read_text())["joints"]["knee"]["range"]
    assert known["outside"] == ["wanted motion"]
    assert [math.floor(end["value"]) for end in known["wanted"]] == [140, 209]


def test_a_free_angle_read_on_a_stop_is_refused(leaning: LegDesign, tmp_path: Path) -> None:
    """The joint lies on its stop at 173.5 deg before its spring is unloaded, at 169; the seat was turned by that."""
    assert leaning.drawn is not None
    assert out_of_reach(leaning) == ["knee"]
    assert any("its spring is unloaded at 169.1 deg, beyond the stop at 173.5" in note for note in leaning.drawn.notes)

    def measured(angle: float, by: Literal["rest", "torque"]) -> LegDesign:
        known = {"knee": MeasuredSpring(free_angle=math.radians(angle), free_angle_by=by)}
        return replace(leaning, project=replace(leaning.project, measured_springs=known))

    with pytest.raises(UserError) as refused:
        Design(measured(173.2, "rest")).write_with(tmp_path)
    (problem,) = refused.value.problems
    assert problem.key == "measured.spring.knee.free_angle"
    assert "173.2 deg is where the knee rests on its stop" in problem.text
    assert "free_angle_by: torque" in problem.text
    assert list(tmp_path.iterdir()) == []
    refuse_stops(measured(173.2, "torque"))
    refuse_stops(measured(180.0, "rest"))
    with pytest.raises(UserError, match=r"166 deg is beyond the stop of the knee at 173\.5 deg"):
        refuse_stops(measured(166.0, "rest"))
    _, settings = seats_set(measured(166.0, "torque"))
    assert math.degrees(settings["knee"].turn) == pytest.approx(169.07 - 166.0, abs=0.1)


def test_a_release_from_a_stop_has_no_rate_into_it(leaning: LegDesign) -> None:
    knee = leaning.built
    low, high = knee.joints[0].ends or (0.0, 0.0)
    for rotation, rate, left in ((low, -1.0, 0.0), (low, 1.0, 1.0), (high, 1.0, 0.0), (0.5 * (low + high), -1.0, -1.0)):
        assert knee.rates_off_stops(np.array([rotation]), np.array([rate])) == pytest.approx([left])
    assert leaning.wanted.releases[0].rate[0] <= 0.0  # from the upper stop

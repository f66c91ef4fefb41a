"""Legs are driven as the recordings were, and only recordings under the same conditions are compared."""

from __future__ import annotations

import json
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synth.arrays import Array
from synth.cli import main
from synth.comparison.compare_sides import Comparison, compare, warnings
from synth.comparison.side import MODEL, NOT_SLOWED, RECORDED, ComparedMotion, Side, joints_of
from synth.drives.servo import ServoSignals
from synth.files.leg_file import write_leg
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIMES = np.arange(0.0, 1.5, 0.005)
START = np.array([0.9])
FREE = Conditions()


def pendulum() -> Leg:
    joint = Joint("knee", Link(0.2, 0.4, 0.1, 1.5e-3), spring=Spring(1.2, 0.3), damper=Damper(0.03))
    return Leg("one link", (joint,))


def torque() -> tuple[Array, Array]:
    return TIMES, 0.3 * np.sin(2 * np.pi * TIMES)[:, None]


def motion(name: str = "a", start: Array = START, conditions: Conditions = FREE, **inputs: Any) -> ComparedMotion:
    """What the pendulum does."""
    moved = simulate(pendulum(), start, np.zeros(1), TIMES, conditions, **inputs)
    return ComparedMotion(name, TIMES, moved, start, np.zeros(1), conditions, **inputs)


def recorded(name: str, *motions: ComparedMotion, **more: Any) -> Side:
    return Side(name, name, RECORDED, pendulum(), motions=motions, **more)


def model(**more: Any) -> Side:
    return Side("leg", "leg", MODEL, pendulum(), joints_of(pendulum()), **more)


def why(found: Comparison) -> str:
    return found.overlays[0].why[1]


def test_a_leg_is_driven_by_the_recordings_known_torque() -> None:
    found = compare([recorded("seen", motion(known_torque=torque())), model()])
    assert found.differences[0].overall < radians(0.001)


def test_a_driven_recording_shows_no_characteristics() -> None:
    found = compare([recorded("seen", motion(known_torque=torque())), model()])
    assert [shown.joints for shown in found.characteristics] == [{"knee": {}}, {"knee": {}}]
    assert "seen: 1 of 1 recordings are driven by a known torque or a servo" in warnings(found)[0]


def test_a_driven_recording_is_not_slowed_down() -> None:
    driven = recorded("seen", motion(known_torque=torque()))
    for stretched in ({"seen": 2.0}, {"leg": 2.0}):
        found = compare([driven, model()], stretch=stretched)
        assert why(found) == NOT_SLOWED
        assert not np.isfinite(found.differences[0].overall)
    assert why(compare([driven, model(pace=2.0)])) == NOT_SLOWED


def test_a_leg_without_the_servo_that_drove_the_recording_is_left_out() -> None:
    still = np.zeros((len(TIMES), 1))
    signals = ServoSignals(TIMES, still + 0.2, still + 6.0, still + 1.0)
    found = compare([recorded("seen", replace(motion(), signals=signals)), model()])
    assert why(found) == "a servo drives this recording, and the leg has none at knee"


@pytest.mark.parametrize(
    "other",
    [
        motion(conditions=Conditions(tip_mass=0.2)),
        motion(conditions=Conditions(tip_mass=0.2, tip_inertia=1e-3, tip_at=0.1)),
        motion(conditions=Conditions(tip_mass=0.2, tip_at=0.15)),
        motion(conditions=Conditions(tip_mass=0.1, tip_at=0.1)),
        motion(conditions=Conditions(tip_mass=0.2, tip_at=0.1, tilt=radians(20))),
        motion(conditions=Conditions(tip_mass=0.2, tip_at=0.1), known_torque=torque()),
    ],
)
def test_recordings_under_other_conditions_are_not_compared(other: ComparedMotion) -> None:
    one = motion(conditions=Conditions(tip_mass=0.2, tip_at=0.1))
    found = compare([recorded("one", one), recorded("other", other)])
    assert why(found) == "no recording with the same joints locked, tip mass, tilt and known torques or commands"
    assert not np.isfinite(found.differences[0].overall)
    assert compare([recorded("one", one), recorded("other", other, ), recorded("same", replace(one, name="b"))]
                   ).differences[1].overall == 0.0  # fmt: skip


def test_a_mass_at_the_links_end_is_at_its_end_stated_or_not() -> None:
    ends = [motion(conditions=Conditions(tip_mass=0.2, tip_at=at)) for at in (None, 0.2)]
    assert compare([recorded("one", ends[0]), recorded("other", ends[1])]).differences[0].overall < 1e-9


def test_recordings_that_one_torque_drove_are_compared() -> None:
    found = compare([recorded("one", motion("a", known_torque=torque())),
                     recorded("other", motion("b", known_torque=torque()))])  # fmt: skip
    assert found.differences[0].overall == 0.0


def test_a_results_driven_recordings_are_left_out_and_a_projects_are_followed(tmp_path: Path) -> None:
    """A result's folder holds angles, not the torque; the page and the screen say so."""
    write_leg(pendulum(), tmp_path / "leg.leg.yaml")
    known, noise = torque(), np.random.default_rng(0)
    for index, start in enumerate((0.9, -0.5)):
        moved = motion(start=np.array([start]), known_torque=known).rotation
        seen = np.degrees(pendulum().to_measured(moved)) + 0.02 * noise.normal(size=moved.shape)
        np.savetxt(
            tmp_path / f"{index}.csv", np.c_[TIMES, seen, known[1]], delimiter=",", fmt="%.8g", comments="",
            header="time [s],knee [deg],knee torque [N*m]",
        )  # fmt: skip
    for kind in ("fit", "gap"):
        (tmp_path / f"{kind}.yaml").write_text(f"kind: {kind}\nleg: leg.leg.yaml\ntrials: [0.csv, 1.csv]\n")
    assert main(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "fitted"), "-q"]) == 0
    assert main(["gap", str(tmp_path / "gap.yaml"), "--out", str(tmp_path / "gapped"), "-q"]) == 0

    def compared(source: str) -> tuple[dict[str, Any], str]:
        out = tmp_path / source.replace(".", "_").partition("#")[0]
        out = out.with_name(f"beside_{out.name}")
        assert main(["compare", str(tmp_path / source), "--out", str(out), "-q"]) == 0
        return json.loads((out / "compare.json").read_text()), (out / "report.html").read_text()

    for source in ("fitted#recorded,fitted", "gapped#recorded,designed"):
        document, page = compared(source)
        told = "a known torque drives this recording and is not in the result's folder: compare its project"
        assert all(set(start["left_out"].values()) == {told} for start in document["starts"])
        assert "overall" not in document["differences"][0]
        assert any(told in text for text in document["warnings"])
        assert told.replace("'", "&#39;") in page
    for source in ("fit.yaml#recorded,fitted", "gap.yaml#recorded,designed"):
        document, _ = compared(source)
        assert document["differences"][0]["overall"]["value"] < 0.3

"""Characteristics of a coupled leg: the leg that had them is found again, or is among the legs that are named."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from synth.arrays import Array
from synth.cli import main
from synth.errors import CannotBeHad
from synth.files.wanted_section import WantedCharacteristics
from synth.fit.wanted_motion import WantedMotion, wanted_motion
from synth.fit.wanted_release import AskedJoint, CharacteristicRelease, oscillation, rise_of
from synth.motion.characteristics import characteristics
from synth.reports.openings.fit_opening import fit_opening
from synth.reports.reading import Result
from synth.swing.leg_model import Damper, Joint, Leg, Link

ROOT = Path(__file__).resolve().parents[2]
RAT = Leg(
    "rat",
    tuple(
        Joint(name, Link(length, mass, com, inertia), zero=np.radians(zero), sign=sign)
        for name, length, mass, com, inertia, zero, sign in (
            ("hip", 0.2, 0.74, 0.091, 3.5e-3, 90, 1),
            ("knee", 0.22, 0.207, 0.075, 1.0885e-3, 180, 1),
            ("ankle", 0.08, 0.09, 0.03, 1e-4, 180, -1),
        )
    ),
)


def own_request(spring: Array, damper: Array, rest: Array, amplitude: Array) -> dict[str, WantedCharacteristics]:
    """What the release of ``RAT`` with these rates (n,) shows, as a request; angles (n,) deg.

    A joint without two swings past rest is asked for by its rise time and a damping ratio of 1.2.
    """
    pairs = zip(RAT.joint_names, np.radians(rest), np.radians(amplitude), strict=True)
    rough = {name: WantedCharacteristics(r, a, 0.2, 2 * np.pi * 2.4) for name, r, a in pairs}
    release = CharacteristicRelease.of(RAT, rough)
    x = np.concatenate([np.log(spring / release.spring), np.log(damper / release.damper)])
    motion, asked = release.motions(x[None])[0], {}
    for j, (name, joint) in enumerate(rough.items()):
        seen = characteristics(release.time, motion[:, j], 0.05 * abs(joint.amplitude) / 3, rest=joint.rest)
        ratio = 1.2 if seen.damping_ratio is None else seen.damping_ratio
        asked[name] = WantedCharacteristics(
            joint.rest, joint.amplitude, ratio, seen.damped_frequency, seen.rise_time if ratio >= 1 else None
        )
    return asked


def rates_of(found: WantedMotion) -> tuple[Array, Array]:
    """(n_leg, n) spring rates N m/rad and damper rates N m s/rad."""
    dampers = [[joint.damper.rate for joint in leg.joints if joint.damper is not None] for leg in found.legs]
    return np.array([leg.spring_rate for leg in found.legs]), np.array(dampers, dtype=float)


UNDERDAMPED = (
    np.array([11.651, 3.19, 0.606]), np.array([0.2753, 0.0469, 0.0075]),
    np.array([90.98848, 118.03328, 111.4257]), np.array([22.91925, 23.14806, -17.07865]),
)  # fmt: skip
OVERDAMPED_ANKLE = (
    np.array([9.811, 2.26, 0.664]), np.array([0.579, 0.0943, 0.0596]),
    np.array([95.0, 100.0, 124.0]), np.array([18.0, 20.0, -15.0]),
)  # fmt: skip


@pytest.mark.parametrize("truth", [UNDERDAMPED, pytest.param(OVERDAMPED_ANKLE, marks=pytest.mark.slow)])
def test_the_leg_that_had_them_is_near_or_named(truth: tuple[Array, Array, Array, Array]) -> None:
    """The ankle's spring came out at 1/550 of the truth, with an interval of 20 %, or the motion was refused."""
    found = wanted_motion(RAT, own_request(*truth))
    springs, dampers = rates_of(found)
    assert np.abs(np.log(springs[0] / truth[0])).max() < np.log(4.0)
    for rates, true in ((springs, truth[0]), (dampers, truth[1])):
        assert np.all(rates.min(axis=0) < 1.25 * true)
        assert np.all(rates.max(axis=0) > 0.8 * true)
    away = np.abs(found.trial.angles - np.radians(truth[2])).max(axis=0)
    assert np.all(away < 1.6 * np.radians(np.abs(truth[3])))  # one ankle turned through 246 deg
    assert "many legs show these characteristics" in found.messages[0]
    assert str(found.messages[0]).count("from") == 3


def test_a_leg_of_one_joint_names_no_others() -> None:
    """Its characteristics fix both rates; the intervals are what 2 % of them make."""
    leg = Leg("one", (Joint("hip", Link(0.3, 0.5, 0.1, 2e-3)),), gravity=0.0)
    found = wanted_motion(leg, {"hip": WantedCharacteristics(0.1, 0.3, 0.2, 2 * np.pi * 3)})
    assert found.messages == ()
    springs, _ = rates_of(found)
    assert 1.05 < springs.max() / springs.min() < 1.15


def test_a_rise_time_alone_leaves_the_spring_of_one_joint_open() -> None:
    """Overdamped, it fixes b/k; the likeliest is the oscillator of the stated ratio."""
    leg = Leg("one", (Joint("hip", Link(0.3, 0.5, 0.1, 2e-3)),), gravity=0.0)
    found = wanted_motion(leg, {"hip": WantedCharacteristics(0.1, 0.3, 1.2, None, 0.09)})
    natural = rise_of(1.2) / 0.09
    assert found.leg.spring_rate[0] == pytest.approx(7e-3 * natural**2, rel=0.01)
    springs, _ = rates_of(found)
    assert springs.max() > 3 * springs.min()
    assert "a rise time fixes the damper for each spring" in found.messages[0]


def test_gravity_is_why_a_frequency_leaves_the_spring_of_a_shank_open() -> None:
    """A human's, 4.6 kg, at 0.95 Hz, where gravity alone makes 0.90: "a rise time" was said, which nobody asked for."""
    leg = Leg("shank", (Joint("knee", Link(0.43, 4.6, 0.2, 0.1)),))
    found = wanted_motion(leg, {"knee": WantedCharacteristics(0.1, 0.5, 0.1, 2 * np.pi * 0.95)})
    assert "gravity holds the link more than its spring does: 2% of a figure" in found.messages[0]


def test_each_damping_is_asked_for_by_what_it_shows() -> None:
    """A second swing of 2 % exists up to 0.53, a first of 5 % up to 0.69; beyond, the rise time is left."""

    def measures(ratio: float) -> set[str]:
        return set(AskedJoint(WantedCharacteristics(0.0, 0.3, ratio, 12.0)).measures)

    assert measures(0.3) == {"damping_ratio", "damped_frequency"}
    assert measures(0.6) == {"rise_time", "overshoot"}
    assert measures(0.8) == {"rise_time"}


def test_a_joint_between_two_swings_and_none_is_found() -> None:
    """A ratio of 0.6 was refused: its second swing is smaller than what counts as one."""
    leg = Leg("one", (Joint("hip", Link(0.3, 0.5, 0.1, 2e-3)),), gravity=0.0)
    found = wanted_motion(leg, {"hip": WantedCharacteristics(0.1, 0.3, 0.6, 12.0)})
    damper, inertia = found.leg.joints[0].damper, 2e-3 + 0.5 * 0.1**2
    assert isinstance(damper, Damper)
    assert damper.rate == pytest.approx(2 * 0.6 * 15.0 * inertia, rel=0.01)
    assert found.leg.spring_rate[0] == pytest.approx(inertia * 15.0**2, rel=0.01)


def test_a_joint_that_swings_where_none_is_wanted_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is judged is what was sought: a rise time and no second swing."""
    leg = Leg("one", (Joint("hip", Link(0.3, 0.5, 0.1, 2e-3)),), gravity=0.0)
    asked = WantedCharacteristics(0.1, 0.3, 1.2, None, 0.06)
    time = CharacteristicRelease.of(leg, {"hip": asked}).time
    swinging = 0.1 + 0.3 * oscillation(0.2, 80.0 * time)[:, None]
    monkeypatch.setattr(
        CharacteristicRelease, "motions", lambda self, points: np.repeat(swinging[None], len(points), axis=0)
    )
    with pytest.raises(CannotBeHad, match=r"a damping ratio of 1\.2 \(the nearest motion swings, with one of 0\.2"):
        wanted_motion(leg, {"hip": asked})


def test_the_block_of_the_documentation_works_on_the_examples_leg(tmp_path: Path) -> None:
    """It was refused; the page and the result say that it is one leg of many."""
    text = (ROOT / "docs" / "own_recordings.md").read_text(encoding="utf-8")
    block = next(each for each in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL) if "wanted:" in each)
    leg = (ROOT / "synth" / "examples" / "fit" / "robot.leg.yaml").read_text(encoding="utf-8")
    (tmp_path / "rat.leg.yaml").write_text(leg)
    (tmp_path / "fit.yaml").write_text(block)
    assert main(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "out"), "-q"]) == 0
    document = json.loads((tmp_path / "out" / "fit.json").read_text())
    low, high = document["joints"]["ankle"]["spring_rate"]["interval90"]
    assert high > 4 * low
    assert document["intervals"] == {"by": "wanted characteristics"}
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "one of many legs that show the wanted characteristics" in page
    for joint, left in document["rms"].items():  # of a computed motion only rounding is left, here ten times as much
        left["value"] = 10.0 * document["noise"][joint]["value"]
    opening = fit_opening(Result(tmp_path / "out", "fit.json", document))
    assert not any("missing effect" in step for step in opening.steps)
    assert "the model explains the motion" not in page

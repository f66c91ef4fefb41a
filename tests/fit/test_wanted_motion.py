"""A motion stated by characteristics: the leg found has them, by closed form and as a fit reads them."""

from __future__ import annotations

import json
import shutil
from math import exp, pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest

from synth.cli import main
from synth.drives.servo import Servo
from synth.errors import CannotBeHad
from synth.files.wanted_section import WantedCharacteristics
from synth.fit.wanted_motion import wanted_motion
from synth.fit.wanted_release import natural_frequency, rise_of
from synth.swing.leg_model import Joint, Leg, Link

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"
WANTED = """\
wanted:
  hip: {rest: 105 deg, amplitude: 15 deg, damping_ratio: 1.6, rise_time: 250 ms}
  knee: {rest: 120 deg, amplitude: -25 deg, damping_ratio: 0.38, damped_frequency: 2.2 Hz}
  ankle: {rest: 138 deg, amplitude: 15 deg, damping_ratio: 0.3, damped_frequency: 15 rad/s}
"""


def test_rise_time_equals_the_overdamped_and_undamped_limits() -> None:
    """Far overdamped, 2 zeta ln 9 natural radians; undamped, acos(0.1) - acos(0.9)."""
    assert rise_of(20.0) == pytest.approx(2 * 20 * np.log(9), rel=2e-3)
    assert rise_of(1e-9) == pytest.approx(np.arccos(0.1) - np.arccos(0.9), rel=1e-6)
    assert rise_of(1.0) == pytest.approx(3.3579, rel=1e-4)  # (1 + t) e^-t: 0.5318 to 3.8897


def test_one_link_without_gravity_equals_the_harmonic_oscillator() -> None:
    """Spring k = I w_n^2 and b = 2 zeta w_n I, the free angle where it shall rest."""
    link = Link(0.3, 0.5, 0.1, 2e-3)
    leg = Leg("one", (Joint("hip", link, zero=radians(90)),), gravity=0.0)
    asked = WantedCharacteristics(radians(100), radians(20), 0.25, 2 * pi * 2.0)
    found = wanted_motion(leg, {"hip": asked})
    inertia, natural = 2e-3 + 0.5 * 0.1**2, 2 * pi * 2.0 / sqrt(1 - 0.25**2)
    joint = found.leg.joints[0]
    assert joint.spring is not None
    assert joint.damper is not None
    assert joint.spring.rate == pytest.approx(inertia * natural**2, rel=2e-3)
    assert joint.damper.rate == pytest.approx(2 * 0.25 * natural * inertia, rel=5e-3)
    assert joint.spring.free_angle == pytest.approx(radians(100))
    assert found.messages == ()
    half = pi / asked.damped_frequency if asked.damped_frequency else 0.0
    at = int(np.argmin(np.abs(found.trial.time - half)))
    reached = (found.trial.angles[at, 0] - asked.rest) / asked.amplitude
    assert reached == pytest.approx(-exp(-0.25 * natural * half), abs=0.01)


def test_a_stated_frequency_takes_precedence_over_the_rise_time() -> None:
    assert natural_frequency(WantedCharacteristics(0.0, 0.3, 0.6, 8.0, 0.5)) == pytest.approx(10.0)


def test_characteristics_that_gravity_forbids_are_refused() -> None:
    """A heavy link that hangs swings at 1.3 Hz by itself."""
    leg = Leg("one", (Joint("hip", Link(0.3, 0.5, 0.1, 1e-3)),))
    with pytest.raises(CannotBeHad, match="Gravity alone swings it at"):
        wanted_motion(leg, {"hip": WantedCharacteristics(0.0, 0.3, 0.1, 2 * pi * 0.4)})


def project(tmp_path: Path, text: str = WANTED) -> Path:
    shutil.copy(EXAMPLES / "fit" / "robot.leg.yaml", tmp_path)
    path = tmp_path / "fit.yaml"
    path.write_text(f"kind: fit\nleg: robot.leg.yaml\n{text}")
    return path


def test_the_leg_fitted_to_characteristics_has_them(tmp_path: Path) -> None:
    """Three coupled links: what was asked comes out within the 2 % that would be said."""
    out = tmp_path / "out"
    assert main(["fit", str(project(tmp_path)), "--out", str(out), "-q"]) == 0
    document = json.loads((out / "fit.json").read_text())
    for joint, told in document["wanted"].items():
        for key, asked in told["asked"].items():
            if key in told["shown"]:
                assert told["shown"][key]["value"] == pytest.approx(asked["value"], rel=0.02), (joint, key)
        fitted = document["joints"][joint]["spring_rate"]
        assert fitted["interval90"][0] <= told["spring_rate"]["value"] <= fitted["interval90"][1]
    assert document["trials"][0]["file"] == "wanted characteristics"


def test_a_computed_motion_has_no_sensor(tmp_path: Path) -> None:
    """Every one-joint answer said that its readings look filtered, and asked for a trial with a tip mass."""
    (tmp_path / "one.leg.yaml").write_text(
        "kind: leg\nname: one\njoints:\n  - name: knee\n    zero: 180 deg\n    sign: +1\n"
        "    link: {length: 220 mm, mass: 207 g, com: 75 mm, inertia: 10.9 kg*cm^2}\n"
    )
    (tmp_path / "one.yaml").write_text(
        "kind: fit\nleg: one.leg.yaml\nwanted:\n"
        "  knee: {rest: 110 deg, amplitude: 20 deg, damping_ratio: 0.2, damped_frequency: 3 Hz}\n"
    )
    assert main(["fit", str(tmp_path / "one.yaml"), "--out", str(tmp_path / "out"), "-q"]) == 0
    document = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert document["warnings"] == []
    assert not [text for text in document["not_separable"] if "mass scale" in text]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", '"trials" is missing'),
        (WANTED + "trials: [a.csv]\n", "both given"),
        (WANTED.replace("  ankle", "  elbow"), "ankle: every joint"),
        (WANTED.replace("damping_ratio: 0.3, ", ""), "damping_ratio"),
        (WANTED.replace(", damped_frequency: 2.2 Hz", ""), '"damped_frequency", "rise_time" or both'),
        (WANTED.replace("rise_time: 250 ms", "damped_frequency: 1 Hz"), "does not swing"),
        (WANTED.replace("2.2 Hz", "2.2 mm"), "damped_frequency"),
        (WANTED.replace("-25 deg", "0.1 deg"), "too small for a motion"),
        ("wanted: [1]\n", "a mapping"),
    ],
)
def test_mistakes_in_wanted_characteristics_are_reported(
    text: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit", str(project(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err


def test_a_design_accepts_characteristics_instead_of_recordings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(EXAMPLES / "fit" / "robot.leg.yaml", tmp_path)
    wanted = WANTED.replace("\n", "\n  ").replace("wanted:", "  wanted:")
    path = tmp_path / "leg.yaml"
    path.write_text(f"kind: leg-design\nsource:\n  leg: robot.leg.yaml\n{wanted}\ntarget: robot.leg.yaml\n")
    assert main(["compare", f"wish={path}", "--out", str(tmp_path / "out"), "-q"]) == 0
    document = json.loads((tmp_path / "out" / "compare.json").read_text())
    assert (
        document["sides"][1]["off_reference"]["overall"]["value"] < 0.05
    )  # the fit follows the motion that shows them
    assert main(["leg", str(path), "--out", str(tmp_path / "dry"), "--dry-run"]) == 0


def test_figures_that_do_not_describe_the_motion_are_told() -> None:
    """A hip six times as stiff as asked, dragged by the knee, showed its frequency on swings of two degrees."""
    joints = (
        Joint("hip", Link(0.11, 0.16, 0.045, 2e-4), radians(90.0), 1),
        Joint("knee", Link(0.115, 0.07, 0.045, 9e-5), pi, -1),
        Joint("ankle", Link(0.09, 0.025, 0.035, 2e-5), pi, 1, drive=Servo(1.0)),
    )
    ratios = {"hip": (100.0, 20.0, 0.3, 3.0), "knee": (120.0, -15.0, 0.3, 4.0), "ankle": (130.0, 15.0, 0.25, 6.0)}
    asked = {
        name: WantedCharacteristics(radians(rest), radians(way), ratio, 2.0 * pi * frequency)
        for name, (rest, way, ratio, frequency) in ratios.items()
    }
    first, *others = wanted_motion(Leg("dog", joints), asked).messages
    assert first.startswith("wanted: the leg shows the figures, but does not move as they describe: the hip's motion")
    assert "the knee swings to 1." in first
    assert getattr(first, "severity", "") == "decide"
    assert "the ankle's drive is taken as off" in others[0]
    alone = wanted_motion(Leg("hip", joints[:1]), {"hip": asked["hip"]})
    assert not any("does not move" in text for text in alone.messages)


def test_the_page_calls_a_wanted_motion_wanted(tmp_path: Path) -> None:
    """It was "measured" in title, headings, legends and captions, by nobody."""
    shutil.copy(EXAMPLES / "fit" / "robot.leg.yaml", tmp_path)
    (tmp_path / "fit.yaml").write_text(f"kind: fit\nleg: robot.leg.yaml\n{WANTED}")
    assert main(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "out"), "-q"]) == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Fit to wanted motion" in page
    assert "Wanted against fitted motion" in page
    assert "wanted and fitted angles, hip" in page
    for false in ("Fit to recorded motion", "Measured against", "&nbsp;measured", "measured and fitted", "fits worst"):
        assert false not in page

"""A leg whose dampers are all far too strong stands still, and is said to; what is told is told of it as built."""

from __future__ import annotations

from math import inf, radians
from pathlib import Path

import numpy as np
import pytest

from synth.api.designs import Design
from synth.api.designs import design as design_of
from synth.design import choice_rounds
from synth.design.choice_rounds import ChoiceTask
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringSource
from synth.design.still_joints import ANOTHER, WEAKER, secant, swing_of, widths
from synth.estimation.intervals import Estimate
from synth.remarks import severity_of
from synth.swing.leg_model import Damper, DamperCurve, Leg

# Of a mouse: 15 mm and 18 mm, 2 g and 1.2 g. The weakest damper of the catalogue has 1000 times the wanted rate.
LEG = """kind: leg
name: mouse
joints:
  - name: hip
    zero: 0 deg
    sign: -1
    range: [-40 deg, 30 deg]
    link: {length: 15 mm, mass: 2 g, com: 6 mm, inertia: 5e-8 kg*m^2}
  - name: knee
    zero: 0 deg
    sign: +1
    range: [-100 deg, 5 deg]
    link: {length: 18 mm, mass: 1.2 g, com: 8 mm, inertia: 4e-8 kg*m^2}
"""
PROJECT = """kind: leg-design
name: mouse
source:
  leg: mouse.leg.yaml
  wanted:
    hip: {damped_frequency: 4 Hz, damping_ratio: 0.2, rest: 0 deg, amplitude: 20 deg}
    knee: {damped_frequency: 7 Hz, damping_ratio: 0.2, rest: -50 deg, amplitude: 30 deg}
target: mouse.leg.yaml
cad: {shaft_diameter: 3 mm, wall: 1.2 mm, clearance: 0.2 mm, encoder: false}
"""


@pytest.fixture(scope="module")
def sized_for() -> list[Leg]:
    """The legs for whose travel springs were looked for."""
    return []


@pytest.fixture(scope="module")
def mouse(tmp_path_factory: pytest.TempPathFactory, sized_for: list[Leg]) -> Design:
    folder = tmp_path_factory.mktemp("mouse")
    (folder / "mouse.leg.yaml").write_text(LEG)
    (folder / "leg-design.yaml").write_text(PROJECT)
    original = choice_rounds._sources

    def recorded(task: ChoiceTask, leg: Leg) -> list[SpringSource]:
        sized_for.append(leg)
        return original(task, leg)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(choice_rounds, "_sources", recorded)
        return design_of(folder / "leg-design.yaml", solids=False)


def test_a_leg_that_stands_still_is_said_to(mouse: Design, tmp_path: Path) -> None:
    """Its page told speeds of up to 247 rpm, and next to run without --no-cad."""
    made = mouse.design
    assert (widths(made.built_motions) < 0.05 * widths(made.wanted.motions)).all()
    for name in ("hip", "knee"):
        (said,) = [text for joint, text in made.warnings if joint == name and "as built it turns" in text]
        assert severity_of(said) == "decide"
        assert "no damper that meets its constraints is weak enough: the weakest, 6597K8, damps " in said
        assert not any("is turned at up to" in text for joint, text in made.warnings if joint == name)
    mouse.write(tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Not ready to build: as built, hip and knee hardly turn" in page
    assert "Have a leg first that moves" in page


def test_an_undetermined_free_angle_sizes_no_spring(mouse: Design, sized_for: list[Leg]) -> None:
    """The fit's was two turns away: the sheet told 187 deg of winding between stops 73 deg apart."""
    angles = [joint.spring.free_angle for leg in sized_for for joint in leg.joints if joint.spring is not None]
    assert max(map(abs, angles)) < radians(100)
    made = mouse.design
    assert all(made.refit.joints[name].free_angle.is_any_angle for name in ("hip", "knee"))
    between = radians(40 + 30 + 3.5 + 3.5 + 1)  # its range, with the room past the stops on both sides
    hip = made.springs.chosen[0].design or made.springs.chosen[0].check  # to wind, or bought
    assert hip is not None
    assert hip.travel + hip.opening_travel < between


def option(torque: float, speed: float, part: str) -> DamperOption:
    curve = DamperCurve((0.5 * speed, speed), (0.5**0.47 * torque, torque))
    return DamperOption(None, Damper(curve=curve, part=part), "concave", "")


RATE = Estimate(0.01, "N*m*s/rad", 0.009, 0.011)


def test_the_weakest_damper_is_held_against_the_wanted_rate() -> None:
    """At the fastest speed, where a flattening curve is least above a line, and the interval's upper end."""
    weak, strong = option(0.5, 4.0, "weak"), option(5.0, 4.0, "strong")
    assert secant(weak.damper, 4.0) == pytest.approx(0.125)
    assert secant(Damper(rate=0.2), 4.0) == 0.2
    made = swing_of("knee", (radians(40), radians(38)), RATE, 4.0, [strong, weak])
    assert made.times == pytest.approx(0.125 / 0.011)
    assert [severity_of(text) for text in made.warnings] == ["decide"]
    assert "weakest" in made.warnings[0]
    assert made.warnings[0].remedy == WEAKER  # type: ignore[attr-defined]
    assert swing_of("knee", (radians(40), radians(38)), RATE, 4.0, [strong, option(0.4, 4.0, "")]).warnings == []
    unknown = Estimate(1e-4, "N*m*s/rad", 0.0, 0.5)
    assert swing_of("knee", (radians(40), radians(38)), unknown, 4.0, [strong]).warnings == []


@pytest.mark.parametrize(
    ("wanted", "built", "still"), [(40.0, 9.0, True), (40.0, 11.0, False), (0.5, 0.0, False), (40.0, inf, False)]
)
def test_a_small_part_of_the_wanted_motion_is_told(wanted: float, built: float, still: bool) -> None:
    made = swing_of("knee", (radians(wanted), radians(built)), RATE, 4.0, [option(0.04, 4.0, "fits")])
    assert made.still is still
    assert [text.remedy for text in made.warnings] == [ANOTHER] * still  # type: ignore[attr-defined]


def test_the_width_is_that_of_the_widest_release() -> None:
    short, wide = np.array([[0.0, 0.1], [0.1, 0.0]]), np.array([[0.5, 0.0], [0.0, 0.0]])
    assert widths([short, wide]) == pytest.approx([0.5, 0.1])

"""A spring is sized for the free angle that is built, not for that of the fit before the parts were chosen."""

from __future__ import annotations

from math import degrees
from pathlib import Path

import pytest

from synth.api.designs import design as design_of
from synth.design.drawable_springs import STOP_ROOM
from synth.design.wanted_travel import travels

LEG = """kind: leg
name: small
joints:
  - name: a
    zero: 0 deg
    sign: +1
    range: [-25 deg, 25 deg]
    link: {length: 100 mm, mass: 60 g, com: 30 mm, inertia: 4e-5 kg*m^2, includes: none}
  - name: b
    zero: 0 deg
    sign: -1
    range: [10 deg, 95 deg]
    link: {length: 85 mm, mass: 20 g, com: 25 mm, inertia: 1e-5 kg*m^2, includes: none}
"""
PROJECT = """kind: leg-design
name: small
source:
  leg: small.leg.yaml
  wanted:
    a: {damped_frequency: 4 Hz, damping_ratio: 0.3, rest: 3 deg, amplitude: 12 deg}
    b: {damped_frequency: 6 Hz, damping_ratio: 0.3, rest: 60 deg, amplitude: -20 deg}
target: small.leg.yaml
select:
  catalogs: [dampers.csv]
  joints:
    a: {spring: {make: true}, damper: {part: mini}}
    b: {spring: {make: true}, damper: {part: mini}}
"""
DAMPERS = (
    "part,vendor,direction,continuous,max_torque [mN*m],speed [rpm],max_speed [rpm],outer_diameter [mm],"
    "body_length [mm],bolt_circle [mm],bolts [1],bolt_diameter [mm],shaft_side,shaft_form,shaft_size [mm]\n"
    "mini,me,both,yes,3,60,200,12,6,18,2,2.2,bore,d,3\n"
)


def test_travel_and_seat_are_those_of_the_free_angle_that_is_built(tmp_path: Path) -> None:
    """Where rate and free angle can replace each other, the sheet told 44 deg of winding of a spring that winds 29."""
    (tmp_path / "small.leg.yaml").write_text(LEG)
    (tmp_path / "dampers.csv").write_text(DAMPERS)
    (tmp_path / "leg-design.yaml").write_text(PROJECT)
    made = design_of(tmp_path / "leg-design.yaml", solids=False).design
    turned = travels(made.built, made.built_motions)
    for option, travel in zip(made.springs.chosen, turned, strict=True):
        assert option.design is not None
        for designed, own in (
            (option.design.travel, travel.winding),
            (option.design.opening_travel, travel.opening),
        ):
            assert degrees(designed - STOP_ROOM) == pytest.approx(degrees(own), abs=2.5)

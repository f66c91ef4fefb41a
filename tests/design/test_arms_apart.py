"""The angle between the arms of a spring to wind, where at 120 deg the seats of both arms would meet in the joint."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians
from pathlib import Path

import pytest

from design.own_springs import own_spring
from synth.cad import DimensionError, JointDimensions, SpringDimensions, clear_upper_arm_angle
from synth.cad.dimensions import LoadDimensions, coil_fraction
from synth.design.choose_springs import SpringSource, WantedTravel, spring_options, spring_to_wind
from synth.design.clamped_arms import seats_would_meet
from synth.design.drawable_springs import reasons_not_drawn
from synth.files.project_options import CadOptions, SpringChoice
from synth.parts.catalogs import Catalogue

CAD = CadOptions(shaft_diameter=4e-3, clearance=0.3e-3, wall=2.4e-3)
CLOSED = WantedTravel(radians(70.0), 0.0)  # a light leg: thin wire, few coils, closed by 70 deg and more at its stop


def source(drawn: bool = True, **choice: object) -> SpringSource:
    asked = SpringChoice(make=True, **choice)  # type: ignore[arg-type]
    return SpringSource("hip", asked, CLOSED, Catalogue.load(), CAD, drawn=drawn)


def included(found: SpringSource) -> float:
    return degrees(spring_to_wind(found, 0.0107, lasting=False)[0].included_angle)


def drawn(included_angle: float, mean: float = 6.4, wire: float = 0.533) -> JointDimensions:
    """The joint of such a spring: unloaded at 0, closed by up to 79 deg."""
    spring = SpringDimensions(wire, mean, 3.0 + coil_fraction(included_angle), included_angle)
    joint = JointDimensions(
        "hip", spring, 0.0, -40.0, range=(-76.0, -10.0), link_length=200.0, shaft_diameter=3.0,
        clearance=0.3, wall=2.4, zero_angle=0.0, loads=LoadDimensions(spring_rate=0.0107),
    )  # fmt: skip
    return replace(joint, upper_arm_angle=clear_upper_arm_angle(joint))


def test_the_arms_of_a_spring_to_wind_are_so_far_apart_that_their_seats_do_not_meet() -> None:
    assert included(source(drawn=False)) == pytest.approx(120.0)
    assert included(source()) in (pytest.approx(150.0), pytest.approx(180.0))
    assert included(source(included_angle=radians(110.0))) == pytest.approx(110.0)  # the user's own
    little = replace(source(), travel=WantedTravel(radians(10.0), 0.0))
    assert included(little) == pytest.approx(120.0)


def test_the_joint_at_120_deg_is_refused_by_this_angle_and_at_180_deg_is_laid_out() -> None:
    with pytest.raises(DimensionError, match=r"hip\.spring\.included_angle.*seats of both arms would meet"):
        drawn(120.0)
    assert drawn(180.0).spring.included_angle == 180.0


@pytest.mark.parametrize("angle", [120.0, 180.0])
def test_the_choice_judges_as_the_drawing(angle: float) -> None:
    spring = SpringDimensions(0.533, 6.4, 3.0 + coil_fraction(angle), angle)
    assert seats_would_meet(spring, 0.0107, (radians(70.0), 0.0), CAD) == (angle == 120.0)


def test_a_bought_spring_whose_seats_would_meet_is_left_out(tmp_path: Path) -> None:
    _, row = own_spring(tmp_path, 0.0107, 0.533, 6.93, 3 + coil_fraction(120.0))
    thin = replace(CAD, shaft_diameter=3e-3)
    assert list(reasons_not_drawn(row, radians(70.0), thin)) == ["the seats of its arms would meet"]
    assert list(reasons_not_drawn(row, radians(20.0), thin)) == []
    assert spring_options(replace(source(), choice=SpringChoice()), 0.0107)[0][0].row is None

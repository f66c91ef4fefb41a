"""The coil's room on the shaft, as the joint clamps its arms: what is chosen is what the drawing takes."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path

import pytest

from design.own_springs import own_spring
from synth.cad import JointDimensions, SpringDimensions
from synth.cad.dimensions import coil_fraction
from synth.cad.spring_space import spring_space
from synth.design.choose_springs import SpringSource, WantedTravel, spring_to_wind
from synth.design.coil_room import inside_in_joint
from synth.design.drawable_springs import reasons_not_drawn
from synth.design.stop_places import DRAWN_STOP
from synth.files.project_options import CadOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.spring.space import wound_inside_diameter

COILS = 3.0 + coil_fraction(120.0)


def closes_on(wire: float, mean: float, coils: float, travel: float, cad: CadOptions) -> list[str]:
    """What the layout refuses of the coil's space; lengths in mm, ``travel`` in deg; arms as the coils give them."""
    ends = (-travel - DRAWN_STOP, DRAWN_STOP)
    spring = SpringDimensions(wire, mean, coils, (180.0 - 360.0 * coils) % 360.0)
    joint = JointDimensions(
        "hip", spring, 0.0, 0.0, range=ends, stops=ends, zero_angle=0.0,
        shaft_diameter=cad.shaft_diameter * 1e3, clearance=cad.clearance * 1e3, wall=cad.wall * 1e3,
    )  # fmt: skip
    return [problem.dimension for problem in spring_space(joint).problems]


@pytest.mark.parametrize("coils", [3, 5, 9])
def test_the_room_is_that_of_the_layout(coils: int) -> None:
    """The largest shaft by the estimate passes, one 0.6 mm thicker does not: the arms' length is estimated."""
    whole, cad = coils + coil_fraction(120.0), CadOptions()
    inside = inside_in_joint(2e-3, 20e-3, whole, radians(81.0), 0.0, cad) * 1e3
    assert inside < wound_inside_diameter(2.0, 20.0, whole, radians(81.0 + DRAWN_STOP))
    for less, problems in ((0.3, []), (-0.3, ["hip.shaft_diameter"])):
        shaft = replace(cad, shaft_diameter=(inside - less) * 1e-3 - 2 * cad.clearance)
        assert closes_on(2.0, 20.0, whole, 81.0, shaft) == problems


def test_a_bought_spring_whose_bent_coil_meets_the_shaft_is_left_out(tmp_path: Path) -> None:
    """Centred it has 16.5 mm inside, more than the 15.0 mm of a shaft of 14 mm by more than the vendors' 10 %."""
    _, row = own_spring(tmp_path, 1.5, 2.0, 22.0, COILS)
    thick, thin = (CadOptions(shaft_diameter=size, clearance=0.4e-3) for size in (14e-3, 12e-3))
    assert any(
        "the coil would close on the shaft of 14 mm" in why for why in reasons_not_drawn(row, radians(81), thick)
    )
    assert not any("close on the shaft" in why for why in reasons_not_drawn(row, radians(81.0), thin))


@pytest.mark.parametrize("rate", [0.01, 0.02])
def test_a_spring_to_wind_gets_so_much_more_room(rate: float) -> None:
    """The coil of 0.01 N m/rad that no joint clamps is 8.48 mm wide, and would close on its shaft of 6 mm."""
    travel, cad = WantedTravel(radians(80.0), 0.0), CadOptions(shaft_diameter=6e-3, clearance=0.2e-3, wall=2.4e-3)
    source = SpringSource("hip", SpringChoice(make=True), travel, Catalogue.load(), cad, drawn=True)
    option, _ = spring_to_wind(source, rate, lasting=False)
    made = option.design
    assert made is not None
    assert closes_on(0.559, 8.48, 3.0 + 1.0 / 6.0, 80.0, cad) == ["hip.shaft_diameter"]
    assert closes_on(made.wire_diameter * 1e3, made.mean_diameter * 1e3, made.body_coils, 80.0, cad) == []

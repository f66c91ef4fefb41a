"""Winding sheet, request for quotation and result of a spring against numbers computed by hand.

The spring: music wire of 2.54 mm (0.100 in), 26 mm mean diameter, 6.25 coils. Of the wire: E = 196.5 GPa (Shigley,
table 10-5, 0.064 to 0.125 in), at least 271 ksi and +-0.001 in (the maker's table), yield at 0.45/0.577 = 0.78 of the
strength (Shigley, table 10-6). 28.54 mm outside are within 0.64 mm, six coils within 10 deg (Lee Spring).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from synth.cad import SpringDimensions
from synth.cad.torsion_spring import centre_line
from synth.files.shown_units import ShownUnits
from synth.parts.catalogs import Catalogue
from synth.spring.evaluate import check_spring
from synth.spring.spring_result import SpringDesign
from synth.spring.spring_task import SpringLimits, SpringTask
from synth.spring.winding import winding_tolerance
from synth.spring.winding_sheet import request_lines, winding_sheet

WIRE, MEAN, COILS = 2.54e-3, 26e-3, 6.25
MODULUS, STRENGTH = 196.5e9, 271 * 6.894757e6
BENDING = MODULUS * math.pi * WIRE**4 / 64.0  # N m^2, of the wire


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def coil(catalogue: Catalogue, task: SpringTask, **more: Any) -> SpringDesign:
    return check_spring(catalogue.find_material("music wire"), WIRE, MEAN, COILS, task, **more)


@pytest.mark.parametrize(("of_yield", "bears"), [(0.8, True), (0.9, False)])
def test_a_coil_that_opens_bears_less_than_one_that_closes(catalogue: Catalogue, of_yield: float, bears: bool) -> None:
    """Music wire bears 100 % of the handbook's stress with its residual stresses, 85 without and 70 against them.

    So it opens to 70/85 = 0.82 of yield: to 0.8, and not to 0.9, which it bears as it closes.
    """
    index = MEAN / WIRE
    inner = (4 * index**2 - index - 1) / (4 * index * (index - 1))
    per_angle = inner * 32.0 / (math.pi * WIRE**3) * BENDING / (math.pi * MEAN * COILS)  # Pa/rad, no arms
    angle = of_yield * 0.78 * STRENGTH / per_angle
    limits = SpringLimits(safety=1.0)
    opened = coil(catalogue, SpringTask(0.1, opening_travel=angle, limits=limits))
    assert opened.opening_stress == pytest.approx(of_yield * 0.78 * STRENGTH, rel=1e-4)
    assert opened.allowed_opening_stress == pytest.approx(70 / 85 * 0.78 * STRENGTH, rel=1e-4)
    assert opened.feasible is bears
    assert [broken.limit for broken in opened.violations] == ([] if bears else ["stress"])
    assert coil(catalogue, SpringTask(angle, limits=limits)).feasible
    safer = coil(catalogue, SpringTask(0.1, opening_travel=angle, limits=replace(limits, safety=1.25)))
    assert safer.allowed_opening_stress == pytest.approx(0.8 * 70 / 85 * 0.78 * STRENGTH, rel=1e-4)


def test_arms_have_their_share_of_the_angle_and_their_force(catalogue: Catalogue) -> None:
    """A force at the end of a leg bends it as a cantilever, as if a third of it were coiled: 25/3 + 40/3 mm of 532."""
    made = coil(catalogue, SpringTask(0.7, leg_lengths=(0.025, 0.040)))
    coiled, legs = math.pi * MEAN * COILS, (0.025 + 0.040) / 3.0
    written = made.as_json()["arms"]
    assert written["share_of_angle"]["value"] == pytest.approx(legs / (coiled + legs), rel=1e-6)
    torque = 0.7 * BENDING / (coiled + legs)
    assert written["force"] == {"value": pytest.approx(torque / 0.025, rel=1e-4), "unit": "N"}


@pytest.mark.parametrize(("outer", "plus"), [(3.0, 0.10), (31.0, 0.89), (31.75, 0.89), (63.5, 1.78), (127.0, 3.56)])
def test_coils_wider_than_the_maker_lists_have_the_last_tolerance_in_proportion(outer: float, plus: float) -> None:
    """Lee Spring's list ends with 0.89 mm of 31.75 mm; a coil twice as wide is within twice as much."""
    assert winding_tolerance(1e-3, (outer - 1.0) * 1e-3, 5.25, 1e-5).mean_diameter == pytest.approx(plus * 1e-3)


def test_the_sheet_states_how_exact_the_rate_can_be(catalogue: Catalogue) -> None:
    """dk/k = 4 dd/d, dD/D and dN/N, which are independent: 4.00 %, 2.46 % and 0.44 % make 4.7 %."""
    sheet = winding_sheet(coil(catalogue, SpringTask(0.7)))
    together = math.hypot(4 * 0.0254 / 2.54, 0.64 / 26, 10 / 360 / 6.25)
    assert f"{together:.1%}" == "4.7%"
    assert "Tolerances: wire 0.0254 mm, mean diameter 0.64 mm, free angle 10 deg, plus or minus; the rate\n" in sheet
    assert "\nthen is within 4.7%." in sheet
    assert sheet.count("within 4.7%") == 2


def test_a_maker_reads_the_rate_in_his_own_units(catalogue: Catalogue) -> None:
    """1.7 N*m/rad by 1000 mm/m and pi/180 rad/deg, and by 0.112985 N*m an in*lbf."""
    asked = coil(catalogue, SpringTask(0.7), stated_rate=1.7)
    for lines, text in (
        (request_lines(asked), "1.7 N*m/rad = 29.67 N*mm/deg, within"),
        (request_lines(asked, ShownUnits("inch")), "15.05 in*lbf/rad = 0.2626 in*lbf/deg, within"),
    ):
        (line,) = [each for each in lines if each.startswith("Rate in this test: ")]
        assert text in line


@pytest.mark.parametrize("hand", ["right", "left"])
def test_the_sheet_turns_the_far_arm_onwards_along_the_drawn_wire(
    catalogue: Catalogue, hand: Literal["right", "left"]
) -> None:
    """Turned on the way that the wire goes round, the far arm adds turns: the coil closes.

    The drawn wire leaves the near arm at z = 0 and rises. Seen from above the near end lies behind, so a turn that is
    counter-clockwise there is clockwise from the near end.
    """
    line = centre_line(SpringDimensions(2.54, 26.0, 6.25, 90.0, hand=hand), 20.0)
    round_axis = np.hypot(line[:, 0], line[:, 1]) < 13.0 + 1e-6  # not the arms
    turned = np.unwrap(np.arctan2(line[round_axis, 1], line[round_axis, 0]))
    assert abs(turned[-1] - turned[0]) == pytest.approx(6.25 * math.tau, rel=1e-3)
    assert line[-1, 2] > line[0, 2]
    sense = "clockwise" if turned[-1] > turned[0] else "counter-clockwise"
    sheet = winding_sheet(coil(catalogue, SpringTask(0.7, hand=hand)))
    assert f"must turn the far arm {sense} against the near one, seen from the near end: that closes" in sheet

"""Springs that close towards larger measured angles equal a joint with reversed angles."""

from __future__ import annotations

import re
from dataclasses import astuple, replace

import numpy as np
import pytest

from synth.cad import DimensionError, JointDimensions, SpringDimensions, arm_offset
from synth.cad.checked_layout import clear_upper_arm_angle, lay_out
from synth.cad.checks import check_joint
from synth.cad.joint import build_joint
from synth.cad.pose import loaded_wire

SPRING = SpringDimensions(2.032, 17.018, 6.17, 120.0)
TURNED = JointDimensions("ankle", SPRING, 100.0, 120.0, (90.0, 165.0), closes=1)


def other_way(dimensions: JointDimensions) -> JointDimensions:
    """The same joint by angles that are measured in the other sense."""
    low, high = dimensions.range
    return replace(
        dimensions, free_angle=-dimensions.free_angle, rest_angle=-dimensions.rest_angle, range=(-high, -low),
        zero_angle=-dimensions.zero_angle, upper_arm_angle=-dimensions.upper_arm_angle, sign=-dimensions.sign,
        closes=-dimensions.closes,
    )  # fmt: skip


def numbers(item: object) -> list[float]:
    if isinstance(item, (tuple, list)):
        return [number for part in item for number in numbers(part)]
    return [float(item)]  # type: ignore[arg-type]


@pytest.mark.parametrize("sign", [1, -1])
def test_a_reversed_spring_equals_the_joint_with_reversed_angles(sign):
    turned = replace(TURNED, sign=sign)
    turned = replace(turned, upper_arm_angle=clear_upper_arm_angle(turned))
    same = other_way(turned)
    laid, other = lay_out(turned), lay_out(same)
    flanks = [sorted((stop.flank, stop.way) for stop in layout.stops) for layout in (laid, other)]
    assert numbers(flanks[0]) == pytest.approx(numbers(flanks[1]))
    laid, other = replace(laid, stops=()), replace(other, stops=())
    assert numbers(astuple(laid)) == pytest.approx(numbers(astuple(other)), abs=1e-9)
    for angle in (90.0, 120.0, 165.0):
        assert turned.rotation(angle) == same.rotation(-angle)
        wires = [loaded_wire(each, lay_out(each), way * angle) for each, way in ((turned, 1), (same, -1))]
        assert wires[0].points == pytest.approx(wires[1].points, abs=1e-9)


def test_a_reversed_spring_passes_every_gate_and_closes_at_larger_angles():
    dimensions = replace(TURNED, upper_arm_angle=clear_upper_arm_angle(TURNED))
    joint = build_joint(dimensions)
    assert [str(check) for check in check_joint(joint) if not check.passed] == []
    wires = [loaded_wire(dimensions, joint.layout, angle) for angle in (90.0, 100.001, 130.0, 165.0)]
    assert np.all(np.diff([wire.torque for wire in wires]) > 0.0)
    # As it stands, the same work would open the coil.
    opened = lay_out(replace(TURNED, closes=-1, upper_arm_angle=clear_upper_arm_angle(replace(TURNED, closes=-1))))
    assert joint.layout.space.drop < opened.space.drop


def test_a_reversed_spring_has_its_arm_offset_on_the_other_side():
    assert arm_offset(100.0, 120.0, closes=1) == 220.0
    assert arm_offset(100.0, 120.0) == -20.0


def allowed_travel(dimensions: JointDimensions) -> list[float]:
    with pytest.raises(DimensionError, match="the links would meet") as refused:
        lay_out(dimensions)
    return [float(end) for end in re.findall(r"allowed is (\S+) to (\S+) deg", str(refused.value))[0]]


def test_refusals_state_measured_angles():
    folded = replace(TURNED, range=(90.0, 340.0))
    low, high = allowed_travel(folded)
    assert low < 90.0 < high < 340.0
    assert allowed_travel(other_way(folded)) == pytest.approx([-high, -low], abs=0.01)
    wide = replace(TURNED, spring=replace(SPRING, coils=1 + 60 / 360), range=(-120.0, 120.0))
    with pytest.raises(DimensionError, match=r"ankle\.range = \(-120.*allowed is at least -110 deg; .*open more than"):
        lay_out(wide)
    with pytest.raises(DimensionError, match=r"ankle\.closes = 0: allowed is \+1 or -1"):
        lay_out(replace(TURNED, closes=0))

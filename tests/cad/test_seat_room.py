"""The upper arm keeps its way through the pocket's wall wherever its seat stands."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cad_joints import cleared
from synth.cad import JointDimensions, SpringDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.joint import assemble, build_joint
from synth.cad.seat_room import check_seat_room, seat_overlap_at, with_seat_turned
from synth.cad.travel import OVERLAP_LIMIT, Bodies

KNEE = JointDimensions("knee", SpringDimensions(3.429, 26.035, 7.17, 120.0), 111.0, 119.0, range=(60.0, 160.0))


@pytest.mark.parametrize(("sign", "closes"), [(1, -1), (-1, 1)])
def test_a_spring_clears_the_wall_with_its_seat_at_either_end(sign: int, closes: int) -> None:
    """The wall was open for an arm whose seat is at 0: at +13 deg it was met 9.5 deg before the stop, with 4 mm^3."""
    knee = cleared(replace(KNEE, sign=sign, closes=closes))
    joint = build_joint(knee)
    bodies = Bodies(joint)
    (passed,) = check_seat_room(bodies)
    assert passed.passed
    shut = (joint.layout.notch[0] + knee.seat_travel, joint.layout.notch[1] - knee.seat_travel)
    before = Bodies(assemble(knee, replace(joint.layout, notch=shut)))
    (failed,) = check_seat_room(before)
    assert not failed.passed
    assert failed.value > 1.0
    assert seat_overlap_at(before, failed.angle, 0.0) < OVERLAP_LIMIT


def test_the_seat_brings_back_the_free_angle_of_a_spring_that_is_off() -> None:
    """Its arms' angle is off by the turn; the arm in the lower half stays, the other one turns with the seat."""
    knee = cleared(KNEE)
    layout = lay_out(knee)
    other, turned = with_seat_turned(knee, layout, 10.0)
    assert other.spring.included_angle == pytest.approx(110.0)
    assert other.spring.drawn_coils - knee.spring.drawn_coils == pytest.approx(10.0 / 360.0)
    assert turned.upper.direction - layout.upper.direction == pytest.approx(10.0)
    assert turned.lower == layout.lower

"""Springs that are wound up when the joint is assembled: how far the upper arm has to be turned decides."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cad_joints import cleared
from synth.cad import DimensionError, JointDimensions, SpringDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.outlines import cup_outline

LONG = SpringDimensions(2.0, 20.0, 9.0 + 1.0 / 6.0, 120.0)
PRELOADED = JointDimensions("hip", LONG, 220.0, 140.0, range=(130.0, 160.0), link_length=400.0)


def test_the_limit_of_the_free_angle_does_not_depend_on_where_the_angle_is_counted_from() -> None:
    """369.7 deg was refused for the number alone: the joint moved between 114 and 147 deg."""
    there = replace(
        PRELOADED, free_angle=400.0, rest_angle=320.0, range=(310.0, 340.0), zero_angle=360.0, upper_arm_angle=180.0
    )
    here = cleared(PRELOADED)
    assert here.upper_arm_angle == 0.0
    assert lay_out(there).notch == pytest.approx(lay_out(here).notch)


def test_a_free_angle_whose_arm_would_take_the_whole_wall_is_refused_with_the_nearest_that_does_not() -> None:
    with pytest.raises(DimensionError) as caught:
        lay_out(replace(PRELOADED, free_angle=380.0))
    (problem,) = caught.value.problems
    assert problem.dimension == "hip.free_angle"
    most = float(problem.allowed.removeprefix("at most ").removesuffix(" deg"))
    with pytest.raises(DimensionError, match="upper_arm_angle"):  # another obstacle on the way
        lay_out(replace(PRELOADED, free_angle=most))
    with pytest.raises(DimensionError, match=r"hip\.free_angle"):
        lay_out(replace(PRELOADED, free_angle=most + 2.0))


def test_on_its_way_from_the_free_angle_the_seat_is_clear_of_the_stem() -> None:
    """Drawn at -45 deg the seat stood in the stem where the spring is unloaded: it could not be put in."""
    coil = SpringDimensions(1.8, 12.7, 10.25, 90.0)
    asked = JointDimensions(
        "k", coil, 236.0, 92.0, range=(72.0, 112.0), link_length=400.0, shaft_diameter=5.0, link_width=16.0
    )
    with pytest.raises(DimensionError, match=r"k\.upper_arm_angle.*the upper arm's seat would meet the lower link"):
        cleared(asked)
    drawn = cleared(replace(asked, free_angle=220.0))
    layout = lay_out(drawn)
    stem, seat = cup_outline(layout), layout.upper.outline()
    low, free = drawn.opening(drawn.stop_angles[0]), drawn.opening(drawn.free_angle)
    assert all(seat.clear_of(stem.turned(low + (free - low) * k / 100), 0.0) for k in range(101))

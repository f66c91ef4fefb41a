"""The least joint round a shaft: no drawable joint is smaller, and it can be drawn itself."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cad_joints import cleared
from synth.cad import DamperDimensions, DimensionError, JointDimensions, LegDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.hardware import shaft_sizes
from synth.cad.least_joint import damper_does_not_fit, least_halves, least_joint, least_links
from synth.cad.leg_joints import lay_out_leg
from tool_modules import tool


def test_no_random_joint_is_smaller_and_no_damper_of_one_is_left_out() -> None:
    fuzz, seen = tool("fuzz_joints"), 0
    for seed in range(120):
        joint = fuzz.design(seed)
        try:
            layout = lay_out(joint)
        except DimensionError:
            continue
        seen += 1
        taken = layout.upper_bottom + layout.socket_depth, layout.lower_bottom + layout.socket_depth
        sizes = joint.shaft_diameter, joint.clearance, joint.wall, (joint.link_width, joint.tube_wall)
        for least in (least_joint(*sizes), least_joint(*sizes, joint.damper)):
            assert all(a <= b + 1e-9 for a, b in zip(least_halves(least), taken, strict=True))
        assert damper_does_not_fit(least_joint(*sizes, joint.damper)) == []
    assert seen > 15


def smallest_drawn(shaft: float) -> JointDimensions:
    """The least joint with the first wider coil that leaves room for shaft, pin and bending."""
    joint, wider = least_joint(shaft, 0.2, 1.2, (10.0, 1.0)), 0.25
    while True:
        mean = joint.spring.mean_diameter + wider
        spring = replace(joint.spring, mean_diameter=mean, wire_diameter=max(joint.spring.wire_diameter, mean / 24.0))
        try:
            return cleared(replace(joint, spring=spring))
        except DimensionError:
            wider += 0.25
        assert wider < shaft


@pytest.mark.parametrize("shaft", shaft_sizes())
def test_links_little_longer_than_the_least_can_be_drawn(shaft: float) -> None:
    joint, least = smallest_drawn(shaft), least_joint(shaft, 0.2, 1.2, (10.0, 1.0))
    lengths = least_links([joint, joint])

    def leg(shorter: float) -> LegDimensions:
        named = zip(("hip", "knee"), lengths, strict=True)
        return LegDimensions("leg", tuple(replace(joint, name=n, link_length=each - shorter) for n, each in named))

    assert lay_out_leg(leg(0.0))
    with pytest.raises(DimensionError) as refused:
        lay_out_leg(leg(0.01))
    assert len(refused.value.problems) == 2
    bounds = least_links([least, least])
    assert all(bound <= one <= 1.2 * bound for bound, one in zip(bounds, lengths, strict=True))


@pytest.mark.parametrize(
    ("damper", "dimension"),
    [
        (DamperDimensions(11.0, 12.0, 16.0, 2, 2.4), "bolt_circle"),
        (DamperDimensions(11.0, 12.0, 40.0, 2, 2.4), "outer_diameter"),
        (DamperDimensions(40.0, 3.0, 52.0, 4, 3.4), "body_length"),
    ],
)
def test_a_damper_too_small_for_its_shaft_is_known_without_a_spring(damper: DamperDimensions, dimension: str) -> None:
    """The shaft of 12 mm has collars of 22 mm; the same dampers fit on 3 mm but for the short body."""
    found = damper_does_not_fit(least_joint(12.0, 0.4, 3.0, (20.0, 1.5), damper))
    assert dimension in [problem.dimension.rpartition(".")[2] for problem in found]
    thin = damper_does_not_fit(least_joint(3.0, 0.1, 1.2, (6.0, 0.5), damper))
    assert [problem.dimension for problem in thin] == (
        ["joint.damper.bolt_circle"]
        if damper.bolt_circle < 16.8
        else ["joint.damper.body_length"]
        if damper.body_length < 4.0
        else []
    )

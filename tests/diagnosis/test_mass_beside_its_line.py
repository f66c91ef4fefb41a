"""A link whose centre of mass lies beside its line, as with a motor at its side, recorded by MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import pytest

import synth
from fit.simulated_legs import Rig, releases, robot


@pytest.mark.parametrize(("joint", "across"), [(2, 0.015), (1, -0.02)])
def test_a_mass_beside_its_line_is_named_with_its_place(joint: int, across: float) -> None:
    """The ankle had a spring with two rates, 86 % sure, the knee another zero and another free angle."""
    leg = robot()
    link = replace(leg.joints[joint].link, com_across=across)
    true = leg.with_joints(**{leg.joint_names[joint]: {"link": link}})
    found = synth.gap(leg, releases(true, 5, Rig(noise=0.03), count=8))
    assert found.verdict == "effect"
    first = found.ranked[0]
    assert (first.cause.effect, first.cause.joint) == ("link_inertia", leg.joint_names[joint])
    assert first.probability > 0.9
    assert first.cause.parameters["across"].value * link.length == pytest.approx(across, rel=0.1)

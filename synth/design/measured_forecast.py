"""The forecast of a leg whose springs were measured, with their seats set; and the tolerances that remain."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from synth.design.forecast import SpringInHand, damper_tolerance, free_angles_measured, spring_tolerance
from synth.design.judged_sets import SAMPLES_CHOSEN, Judge, Pair
from synth.design.leg_design import LegDesign
from synth.units import quantity


def with_measured_forecast(design: LegDesign, names: Collection[str]) -> LegDesign:
    """The design with the chosen set's forecasts for the springs in hand; the other sets' springs are not in hand.

    ``names``: the joints whose springs are measured. ``built`` has their rates, and free angles with the seats set.
    """
    measured, project = measured_free_angles(design), design.project
    hand = {
        j: SpringInHand(joint.spring.rate, joint.rest, joint.name in measured)
        for j, joint in enumerate(design.built.joints)
        if joint.name in names and joint.spring is not None
    }
    parts = zip(design.springs.chosen, design.dampers.chosen, strict=True)
    pairs = tuple(Pair(spring, damper) for spring, damper in parts)
    judge = Judge(design.wanted, design.built, project.parts, project.fit.seed, in_hand=hand)
    chosen = replace(
        design.sets.chosen,
        forecast=judge.as_they_come(pairs, SAMPLES_CHOSEN, shares=True),
        ready=judge.ready(pairs, SAMPLES_CHOSEN, shares=True),
    )
    return replace(design, sets=replace(design.sets, sets=(chosen, *design.sets.sets[1:])))


def measured_free_angles(design: LegDesign) -> tuple[str, ...]:
    """The joints whose spring's free angle is measured, in the leg's order."""
    known = design.project.measured_springs
    return tuple(name for name in design.built.joint_names if name in known and known[name].free_angle is not None)


def tolerance_json(design: LegDesign, joint: int) -> dict[str, Any]:
    """The tolerances of one joint's parts, with their sources."""
    pair, asked = design.sets.chosen.pairs[joint], design.project.parts.tolerance
    measured = design.built.joint_names[joint] in measured_free_angles(design)
    spring = spring_tolerance(pair.spring, free_angles_measured(asked) if measured else asked)
    source = spring_tolerance(pair.spring, asked).source
    damper = damper_tolerance(pair.damper, asked)
    return {
        "rate": quantity(spring.rate, "percent"),
        "free_angle": quantity(spring.free_angle, "deg"),
        "torque": quantity(damper.torque, "percent"),
        "spring_source": f"{source}; its free angle is measured" if measured else source,
        "damper_source": damper.source,
    }

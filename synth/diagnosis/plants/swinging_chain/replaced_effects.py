"""Effects that the leg file states and a cause of the diagnosis takes the place of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.sentences import stated_parameters
from synth.estimation.intervals import Estimate
from synth.remarks import at_joint, noted
from synth.swing.effects import effect_named
from synth.swing.leg_model import Leg
from synth.units import shown_unit

REPLACING = ("torque", "reading", "structure")  # ways of effects; another changes a number that the file states


def with_replaced_effects(fields: Mapping[str, Any], leg: Leg) -> dict[str, Any]:
    """The fields of a diagnosis with a remark for each named cause that the leg file states otherwise."""
    explained = [_remark(cause, leg) for cause in fields["explanation"]]
    return {**fields, "warnings": (*fields["warnings"], *filter(None, explained))}


def _remark(cause: Cause, leg: Leg) -> str:
    """What the leg file states of a cause; empty if it states none."""
    effect, at_base = effect_named(cause.effect), cause.joint == "base"
    held = leg.effects if at_base else leg.joints[leg.joint_names.index(cause.joint)].effects
    if effect.way not in REPLACING or cause.effect not in held:
        return ""
    values = {**effect.defaults, **held[cause.effect]}
    stated = {p.name: Estimate(values[p.name], shown_unit(p.unit)) for p in effect.parameters}
    numbers = stated_parameters(Cause(cause.effect, cause.joint, stated), effect)
    text = f"the {cause.effect} found is the whole effect, in the place of that in the leg file ({numbers})"
    return noted(f"base: {text}") if at_base else at_joint(cause.joint, text, "note")

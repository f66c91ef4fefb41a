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
from synth.swing.stated_effects import REPLACED_WAYS
from synth.units import shown_unit

ARTICLES = ("a", "an", "another", "its")  # of phrases that are no plain noun behind "has"


def with_replaced_effects(fields: Mapping[str, Any], leg: Leg) -> dict[str, Any]:
    """The fields of a diagnosis with a remark for each named cause that the leg file states otherwise."""
    explained = [_remark(cause, leg) for cause in fields["explanation"] if not cause.absent]
    return {**fields, "warnings": (*fields["warnings"], *filter(None, explained))}


def absent_words(cause: Cause, leg: Leg) -> str:
    """The knee's dry friction in the leg file (torque 0.03 N·m) is not there."""
    effect = effect_named(cause.effect)
    noun = effect.phrase.removeprefix("has ")
    if noun == effect.phrase or noun.split()[0] in ARTICLES:
        noun = effect.name.replace("_", " ")
    whose = noun if cause.joint == "base" else f"{cause.joint}'s {noun}"
    return f"the {whose} in the leg file ({_stated_numbers(cause, leg)}) is not there"


def _remark(cause: Cause, leg: Leg) -> str:
    """What the leg file states of a cause; empty if it states none."""
    if effect_named(cause.effect).way not in REPLACED_WAYS or cause.effect not in _effects_there(cause, leg):
        return ""
    text = f"the {cause.effect} found is the whole effect, in the place of that in the leg file"
    told = f"{text} ({_stated_numbers(cause, leg)})"
    return noted(f"base: {told}") if cause.joint == "base" else at_joint(cause.joint, told, "note")


def _effects_there(cause: Cause, leg: Leg) -> Mapping[str, Mapping[str, float]]:
    """The effects that the leg file states at the cause's place."""
    return leg.effects if cause.joint == "base" else leg.joints[leg.joint_names.index(cause.joint)].effects


def _stated_numbers(cause: Cause, leg: Leg) -> str:
    """The parameters that the leg file states of the effect."""
    effect, given = effect_named(cause.effect), _effects_there(cause, leg)[cause.effect]
    stated = {p.name: Estimate(given[p.name], shown_unit(p.unit)) for p in effect.parameters if p.name in given}
    return stated_parameters(Cause(cause.effect, cause.joint, stated), effect)

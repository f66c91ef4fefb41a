"""Effects that the leg file states and a cause of the diagnosis takes the place of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.swinging_chain.stated_forms import kin_stated
from synth.diagnosis.sentences import stated_parameters
from synth.estimation.intervals import Estimate
from synth.remarks import at_joint, noted
from synth.swing.effects import Effect, effect_named
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
    noun = _noun(effect_named(cause.effect))
    whose = noun if cause.joint == "base" else f"{cause.joint}'s {noun}"
    return f"the {whose} in the leg file ({_stated_numbers(cause, cause.effect, leg)}) is not there"


def _noun(effect: Effect) -> str:
    """Dry friction; the effect's name where its phrase is no noun behind "has"."""
    noun = effect.phrase.removeprefix("has ")
    return effect.name.replace("_", " ") if noun == effect.phrase or noun.split()[0] in ARTICLES else noun


def _remark(cause: Cause, leg: Leg) -> str:
    """What the leg file states of a cause, or of its kin whose place it takes; empty if it states none."""
    if effect_named(cause.effect).way not in REPLACED_WAYS:
        return ""
    places = {}
    if cause.effect in _effects_there(cause, leg):
        places[cause.effect] = "that in the leg file"
    if cause.joint != "base":
        for other in kin_stated(leg, (cause.effect, leg.joint_names.index(cause.joint))):
            places[other] = f"the {_noun(effect_named(other))} that the leg file states"
    if not places:
        return ""
    told = " and ".join(f"{words} ({_stated_numbers(cause, name, leg)})" for name, words in places.items())
    text = f"the {cause.effect} found is the whole effect, in the place of {told}"
    return noted(f"base: {text}") if cause.joint == "base" else at_joint(cause.joint, text, "note")


def _effects_there(cause: Cause, leg: Leg) -> Mapping[str, Mapping[str, float]]:
    """The effects that the leg file states at the cause's place."""
    return leg.effects if cause.joint == "base" else leg.joints[leg.joint_names.index(cause.joint)].effects


def _stated_numbers(cause: Cause, name: str, leg: Leg) -> str:
    """The parameters that the leg file states of an effect at the cause's place."""
    effect, given = effect_named(name), _effects_there(cause, leg)[name]
    stated = {p.name: Estimate(given[p.name], shown_unit(p.unit)) for p in effect.parameters if p.name in given}
    return stated_parameters(Cause(name, cause.joint, stated), effect)

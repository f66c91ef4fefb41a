"""Effects that leg files state where a cause of the diagnosis acts: those in whose place it is, and a trial's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.swinging_chain.stated_forms import kin_stated
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.diagnosis.sentences import stated_parameters
from synth.estimation.intervals import Estimate
from synth.remarks import at_joint, noted
from synth.swing.effects import Effect, effect_named
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import REPLACED_WAYS
from synth.units import shown_unit

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

ARTICLES = ("a", "an", "another", "its")  # of phrases that are no plain noun behind "has"
Stated = Mapping[str, Mapping[str, float]]


def with_replaced_effects(fields: Mapping[str, Any], leg: Leg, trials: Sequence[Trial]) -> dict[str, Any]:
    """The fields of a diagnosis with a remark for each named cause that a leg file states otherwise."""
    causes = [cause for cause in fields["explanation"] if not cause.absent]
    explained = [text for cause in causes for text in _remarks(cause, leg, trials)]
    return {**fields, "warnings": (*fields["warnings"], *explained)}


def own_leg_files(trials: Sequence[Trial]) -> dict[str, list[Trial]]:
    """The trials of each file of a trial's own leg; of a leg made in code, of its name."""
    found: dict[str, list[Trial]] = {}
    for trial in trials:
        if trial.leg is not None:
            found.setdefault(trial.leg_file or trial.leg.name, []).append(trial)
    return found


def some_names(names: Sequence[str]) -> str:
    """The first three names, and how many there are beside them."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def absent_words(cause: Cause, leg: Leg) -> str:
    """The knee's dry friction in the leg file (torque 0.03 N·m) is not there."""
    noun = _noun(effect_named(cause.effect))
    whose = noun if cause.joint == "base" else f"{cause.joint}'s {noun}"
    return (
        f"the {whose} in the leg file ({_stated_numbers(cause, cause.effect, _effects_there(cause, leg))}) is not there"
    )


def _noun(effect: Effect) -> str:
    """Dry friction; the effect's name where its phrase is no noun behind "has"."""
    noun = effect.phrase.removeprefix("has ")
    return effect.name.replace("_", " ") if noun == effect.phrase or noun.split()[0] in ARTICLES else noun


def _remarks(cause: Cause, leg: Leg, trials: Sequence[Trial]) -> list[str]:
    """What each leg file states of a cause or of its kin whose place it takes; none of one that changes a number."""
    if effect_named(cause.effect).way not in REPLACED_WAYS:
        return []
    joint = 0 if cause.joint == "base" else leg.joint_names.index(cause.joint)
    legs = TrialLegs.of(leg, [trial.leg for trial in trials])
    files: list[tuple[str, Leg, list[Trial]]] = [("the leg file", leg, [])] if legs.swung else []
    files += [(file, own[0].leg or leg, own) for file, own in own_leg_files(trials).items()]
    replaced, kept = list[str](), list[str]()
    for file, each, own in files:
        held = _effects_there(cause, each)
        told = {cause.effect: f"that in {file}"} if cause.effect in held else {}
        for other in kin_stated(each, (cause.effect, joint)):
            told[other] = f"the {_noun(effect_named(other))} that {file} states"
        words = [f"{text} ({_stated_numbers(cause, name, held)})" for name, text in told.items()]
        if any((name, joint) in legs.own_places(each) for name in told):
            stated = ", ".join(_stated_numbers(cause, name, held) for name in told)
            text = f"the {cause.effect} found is that of the other trials: {file} states its own ({stated})"
            kept.append(f"{text}, which stays in {some_names([trial.name for trial in own])}")
        else:
            replaced += words
    said = [f"the {cause.effect} found is the whole effect, in the place of {' and '.join(replaced)}"]
    said = [*(said if replaced else []), *kept]
    return [noted(f"base: {text}") if cause.joint == "base" else at_joint(cause.joint, text, "note") for text in said]


def _effects_there(cause: Cause, leg: Leg) -> Stated:
    """The effects that a leg file states at the cause's place."""
    return leg.effects if cause.joint == "base" else leg.joints[leg.joint_names.index(cause.joint)].effects


def _stated_numbers(cause: Cause, name: str, held: Stated) -> str:
    """The parameters that are stated of an effect among those ``held`` at the cause's place."""
    effect, given = effect_named(name), held[name]
    stated = {p.name: Estimate(given[p.name], shown_unit(p.unit)) for p in effect.parameters if p.name in given}
    return stated_parameters(Cause(name, cause.joint, stated), effect)

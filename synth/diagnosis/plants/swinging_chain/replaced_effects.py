"""Effects that leg files state where a cause of the diagnosis acts: those in whose place it is, and a trial's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.swinging_chain.trial_legs import REPLACED_WAYS, TrialLegs
from synth.diagnosis.sentences import stated_parameters
from synth.estimation.intervals import Estimate
from synth.remarks import at_joint, noted
from synth.swing.effects import effect_named
from synth.swing.leg_model import Leg
from synth.units import shown_unit

if TYPE_CHECKING:
    from synth.files.trial_list import Trial


def with_replaced_effects(fields: Mapping[str, Any], leg: Leg, trials: Sequence[Trial]) -> dict[str, Any]:
    """The fields of a diagnosis with a remark for each named cause that a leg file states otherwise."""
    explained = [text for cause in fields["explanation"] for text in _remarks(cause, leg, trials)]
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


def _remarks(cause: Cause, leg: Leg, trials: Sequence[Trial]) -> list[str]:
    """What each leg file states of a cause; none of a cause that changes a stated number."""
    effect, at_base = effect_named(cause.effect), cause.joint == "base"
    if effect.way not in REPLACED_WAYS:
        return []
    joint = 0 if at_base else leg.joint_names.index(cause.joint)
    legs = TrialLegs.of(leg, [trial.leg for trial in trials])
    files: list[tuple[str, Leg, list[Trial]]] = [("the leg file", leg, [])] if legs.swung else []
    files += [(file, own[0].leg or leg, own) for file, own in own_leg_files(trials).items()]
    replaced, kept = list[str](), list[str]()
    for file, each, own in files:
        numbers = _stated_numbers(cause, each.effects if at_base else each.joints[joint].effects)
        if numbers and (cause.effect, joint) in legs.own_places(each):
            names = some_names([trial.name for trial in own])
            text = f"the {cause.effect} found is that of the other trials: {file} states its own ({numbers})"
            kept.append(f"{text}, which stays in {names}")
        elif numbers:
            replaced.append(f"{file} ({numbers})")
    said = [f"the {cause.effect} found is the whole effect, in the place of that in {' and '.join(replaced)}"]
    said = [*(said if replaced else []), *kept]
    return [noted(f"base: {text}") if at_base else at_joint(cause.joint, text, "note") for text in said]


def _stated_numbers(cause: Cause, held: Mapping[str, Mapping[str, float]]) -> str:
    """The effect's numbers where it is among those that a joint or the base holds; else empty."""
    if cause.effect not in held:
        return ""
    effect = effect_named(cause.effect)
    values = {**effect.defaults, **held[cause.effect]}
    stated = {p.name: Estimate(values[p.name], shown_unit(p.unit)) for p in effect.parameters}
    return stated_parameters(Cause(cause.effect, cause.joint, stated), effect)

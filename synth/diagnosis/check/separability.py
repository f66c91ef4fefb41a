"""The causes that these trials could show, their smallest sizes, inseparable causes, and trials that separate them.

Computed from the responses of all candidates at the designed leg (``responses``). These are linear and therefore valid
for every answer of small size.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.check.cause_responses import (
    CauseResponse,
    ResponseProducts,
    responses_for_comparison,
    with_columns_numbered,
)
from synth.diagnosis.check.visible_sizes import designed_size, implausible_size, size_at, visible_size
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Key
from synth.diagnosis.plant import MenuItem
from synth.diagnosis.workbench import Workbench
from synth.estimation.intervals import Estimate

MOST_RIVALS = 4  # most similar causes listed for each cause
# Sine of the angle below which two causes count as inseparable unless seven times larger than the smallest visible
# size:
# such sizes are rare, and forms of one cause differ by as much among themselves.
ALIKE_SINE = 0.15
LEAST_IMPROVEMENT = 1.5  # times as well told apart with a trial, or it is not worth naming: a choice
LEAST_SINE = 0.02  # smaller differences are within the accuracy of integrator and linearisation


@dataclass(frozen=True)
class Rival:
    """A cause that looks like another: ``sine`` of the angle between them, and the size from which they differ.

    ``parts_from`` : parameters of the listed cause (not the rival's), or None if no size within its bounds suffices.
    """

    key: Key
    sine: float
    parts_from: dict[str, Estimate] | None

    def as_json(self) -> dict[str, Any]:
        """The entry under ``looks_like``."""
        parts = None if self.parts_from is None else {k: v.as_json() for k, v in self.parts_from.items()}
        angle = float(np.degrees(np.arcsin(min(self.sine, 1.0))))
        told = {"angle": {"value": angle, "unit": "deg"}, "told_apart_from": parts}
        return {"effect": self.key[0], "joint": self.key[1]} | told


@dataclass(frozen=True)
class VisibleCause:
    """One cause: the smallest visible size, None if there is no plausible one, and similar causes.

    ``only_from`` : the smallest visible size that is not plausible, see ``is_plausible``; None if there is none.
    Of a cause without a size, a stop: its place, an angle at each end of travel from which it is visible. Of a
    ``limit`` : the highest that is visible; lower ones are visible too. ``designed`` : the sizes that the leg file
    states of an effect; the others are then changes from these.
    """

    key: Key
    visible_from: dict[str, Estimate] | None
    rivals: tuple[Rival, ...]
    only_from: dict[str, Estimate] | None = None
    limit: bool = False
    designed: Mapping[str, Estimate] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """The entry under ``causes``."""
        shown = None if self.visible_from is None else {k: v.as_json() for k, v in self.visible_from.items()}
        beyond = None if self.only_from is None else {k: v.as_json() for k, v in self.only_from.items()}
        return {
            "effect": self.key[0],
            "joint": self.key[1],
            "visible_from": shown,
            **({} if beyond is None else {"only_from": beyond}),
            **({"limit": True} if self.limit else {}),
            **({"stated": {k: v.as_json() for k, v in self.designed.items()}} if self.designed else {}),
            "looks_like": [rival.as_json() for rival in self.rivals],
        }


@dataclass(frozen=True)
class InseparableCauses:
    """Inseparable causes, and the trial of a menu that separates them most, if any helps.

    ``sine`` of the smallest angle now; ``with_trial`` : with that trial added. Of three causes a trial may separate one
    from the others, which leaves the smallest angle as it is.
    """

    keys: tuple[Key, ...]
    sine: float
    remedy: str
    with_trial: float

    def as_json(self) -> dict[str, Any]:
        """The entry under ``not_told_apart``."""
        causes = [{"effect": effect, "joint": joint} for effect, joint in self.keys]
        sines = {"sine": self.sine, "sine_with_trial": self.with_trial}
        return {"causes": causes, "remedy": self.remedy or None} | sines


@dataclass(frozen=True)
class Separability:
    """All causes, and groups of inseparable ones.

    ``sines`` (k, k) of the angle between a row's cause, in its plain form, and the nearest form of a column's.
    """

    showings: tuple[VisibleCause, ...]
    clusters: tuple[InseparableCauses, ...]
    sines: Array


@dataclass(frozen=True)
class _Pair:
    """Two causes by the indices of their responses: the assumed true one and the one that looks like it."""

    true: CauseResponse
    other: CauseResponse
    sine: float


def separability(
    bench: Workbench,
    at: EvaluatedHypothesis,
    found: Sequence[CauseResponse],
    made: ResponseProducts,
    menu: Sequence[MenuItem[AngleTrial]],
) -> Separability:
    """Every cause's smallest size, its rivals, and trials that would separate them.

    Parameters
    ----------
    at : the designed leg, linearised; found, made : from ``responses_of``; menu : possible further trials.
    """
    gram = made.gram
    by_key: dict[Key, list[CauseResponse]] = {}
    for response in found:
        by_key.setdefault(response.key, []).append(response)
    pairs: dict[Key, list[_Pair]] = {}
    for key, own in by_key.items():
        true = _plainest_response(own)
        against = [_nearest_form(gram, true, others) for other, others in by_key.items() if other != key]
        pairs[key] = sorted(against, key=lambda pair: pair.sine)
    showings = tuple(_visible_cause(own, pairs[key]) for key, own in by_key.items())
    # Not a set, whose order differs from run to run.
    visible = [showing.key for showing in showings if showing.visible_from is not None]
    alike = [pair for key in visible for pair in pairs[key] if pair.sine < ALIKE_SINE and pair.other.key in visible]
    order = {key: place for place, key in enumerate(by_key)}
    sines = np.zeros((len(order), len(order)))
    for pair in (pair for each in pairs.values() for pair in each):
        sines[order[pair.true.key], order[pair.other.key]] = pair.sine
    both = {(pair.true.key, pair.other.key) for pair in alike}
    mutual = [pair for pair in alike if (pair.other.key, pair.true.key) in both]
    clusters = _clusters(mutual, _sines_with_each_trial(bench, at, by_key, made, mutual, menu), menu)
    return Separability(showings, clusters, sines)


def _plainest_response(responses: Sequence[CauseResponse]) -> CauseResponse:
    """The first visible start of a cause: its plain form."""
    return next((response for response in responses if response.visible is not None), responses[0])


def _nearest_form(gram: Array, true: CauseResponse, others: Sequence[CauseResponse]) -> _Pair:
    """The form of another cause nearest to a response, with its own unknowns free."""
    place = true.columns[0]
    whole = float(gram[place, place])
    best = _Pair(true, others[0], 1.0)
    for other in others:
        part = list(other.columns)
        size = np.sqrt(np.maximum(np.diag(gram)[part], 1e-300))
        inner = gram[np.ix_(part, part)] / np.outer(size, size)
        along = gram[place, part] / size
        explained = float(along @ np.linalg.lstsq(inner, along, rcond=1e-8)[0]) / max(whole, 1e-300)
        sine = float(np.sqrt(np.clip(1.0 - explained, 0.0, 1.0)))
        if sine < best.sine:
            best = _Pair(true, other, sine)
    return best


def _visible_cause(responses: Sequence[CauseResponse], pairs: Sequence[_Pair]) -> VisibleCause:
    response = _plainest_response(responses)
    limit, stated = response.level is not None and response.level.falls, designed_size(response.candidate)
    if response.visible is None:
        return VisibleCause(response.key, None, (), implausible_size(responses), limit, stated)
    rivals = []
    for pair in pairs[:MOST_RIVALS]:
        rivals.append(Rival(pair.other.key, pair.sine, size_at(response, 1.0 / max(pair.sine, LEAST_SINE))))
    return VisibleCause(response.key, visible_size(responses), tuple(rivals), limit=limit, designed=stated)


def _clusters(
    kept: Sequence[_Pair], sines: Sequence[Array], menu: Sequence[MenuItem[AngleTrial]]
) -> tuple[InseparableCauses, ...]:
    """Groups of causes linked by mutual inseparability, with the trial that separates them most.

    ``kept`` : mutual pairs; ``sines`` (n_pair,) of each with each trial of the menu.
    """
    group: dict[Key, int] = {}
    for pair in kept:
        first, second = group.get(pair.true.key), group.get(pair.other.key)
        name = first if first is not None else second if second is not None else len(group)
        for key, old in list(group.items()):
            if old in (first, second):
                group[key] = name
        group[pair.true.key] = group[pair.other.key] = name
    linked = [[pair for pair in kept if group[pair.true.key] == name] for name in dict.fromkeys(group.values())]
    now = np.array([pair.sine for pair in kept])
    made = []
    for members in linked:
        places = [kept.index(pair) for pair in members]
        least, told = float(now[places].min()), [_mean_distinction(members, sine[places]) for sine in sines]
        best = int(np.argmax(told)) if told else -1
        better = bool(told) and told[best] > LEAST_IMPROVEMENT * _mean_distinction(members, now[places])
        keys = tuple(dict.fromkeys(key for pair in members for key in (pair.true.key, pair.other.key)))
        after = float(sines[best][places].min()) if better else least
        made.append(InseparableCauses(keys, least, menu[best].what if better else "", after))
    return tuple(sorted(made, key=lambda cluster: cluster.sine))


def _mean_distinction(pairs: Sequence[_Pair], sines: Array) -> float:
    """How well causes are told apart: mean over pairs of the smaller sine, of either taken for the other.

    ``sines`` (n_pair,), which count between ``LEAST_SINE`` and ``LEAST_IMPROVEMENT`` times ``ALIKE_SINE``.
    """
    smaller: dict[frozenset[Key], float] = {}
    for pair, sine in zip(pairs, np.clip(sines, LEAST_SINE, LEAST_IMPROVEMENT * ALIKE_SINE), strict=True):
        both = frozenset((pair.true.key, pair.other.key))
        smaller[both] = min(float(sine), smaller.get(both, np.inf))
    return float(np.mean([*smaller.values()]))


def _sines_with_each_trial(
    bench: Workbench,
    at: EvaluatedHypothesis,
    by_key: Mapping[Key, Sequence[CauseResponse]],
    made: ResponseProducts,
    pairs: Sequence[_Pair],
    menu: Sequence[MenuItem[AngleTrial]],
) -> list[Array]:
    """(n_pair,) sines per trial of the menu, with that trial added; by ``_nearest_form``, like those without it."""
    keys = dict.fromkeys(pair.true.key for pair in pairs)  # of both of each pair: they are mutual
    kept = [response for key in keys for response in by_key[key]]
    if not kept:
        return [np.zeros(0) for _ in menu]
    here, placed = made.of([column for response in kept for column in response.columns]), with_columns_numbered(kept)
    forms = {key: [response for response in placed if response.key == key] for key in keys}
    plain = {key: _plainest_response(forms[key]) for key in keys}
    found = []
    for item in menu:
        both = _products_with_trial(bench, at, placed, here, item.trial)
        gram = here.gram if both is None else both.gram
        found.append(np.array([_nearest_form(gram, plain[p.true.key], forms[p.other.key]).sine for p in pairs]))
    return found


def _products_with_trial(
    bench: Workbench,
    at: EvaluatedHypothesis,
    responses: Sequence[CauseResponse],
    here: ResponseProducts,
    trial: AngleTrial,
) -> ResponseProducts | None:
    """The products of all trials and a further one; None if the designed leg's motion diverges in it."""
    state = np.concatenate([trial.measured[0], np.zeros(trial.measured.shape[1])])
    there = replace(bench, trials=(_imagined_trial(bench, at, trial, state),))
    begun = there.evaluate([at.start_at(states=(state,))])[0]
    if not np.isfinite(begun.cost):
        return None
    begun = replace(begun, frame=there.frame(begun))
    moved = [replace(each, fit=each.fit.start_at(states=(state,))) for each in responses]
    return here + responses_for_comparison(there, begun, moved)[1]


def _imagined_trial(bench: Workbench, at: EvaluatedHypothesis, trial: AngleTrial, state: Array) -> AngleTrial:
    """An imagined trial with the motion of the designed leg from its initial state, as a recording would have it.

    The prior of its initial rate is as wide as its fastest motion. At rest, of two late channels one that is locked
    seemed to tell which it was: the other's delay is another initial rate.
    """
    recording = trial.recording
    angle, _ = bench.slopes(trial, at, state, ())
    if not np.isfinite(angle).all():
        return trial
    rate = np.gradient(angle, trial.time, axis=0)
    return replace(trial, recording=replace(recording, smoothed=replace(recording.smoothed, angle=angle, rate=rate)))

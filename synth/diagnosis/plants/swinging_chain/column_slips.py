"""Recordings compared with the designed leg: exchanged, inverted or mislabelled columns show as a much better fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array, Mask
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.column_changes import Change, ColumnChange, column_changes, input_column
from synth.diagnosis.plants.swinging_chain.far_numbers import far_numbers
from synth.diagnosis.plants.swinging_chain.lag_changes import OtherClock, lag_changes
from synth.diagnosis.plants.swinging_chain.slips import ALIKE, INTEGRATION_TOLERANCE, SAMPLES_A_TRIAL, Slip
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.diagnosis.score import score
from synth.diagnosis.workbench import Workbench
from synth.errors import UserError
from synth.files.turns import far_command, widest
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg
from synth.swing.tolerances import QUANTITIES, Tolerances
from synth.units import significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

MOST_TRIALS = 6  # trials compared, those with the largest motion
# Least factor by which a change of columns must reduce the error; as in ``recordings_together``.
LEAST_IMPROVEMENT = 3.0
NEAR_DESIGN = np.radians(15.0)  # rad RMS: a recording farther from the design has other problems than its columns
LEAST_ERROR = np.radians(2.0)  # rad RMS from the design below which columns are accepted
# Two changes fit alike, see ``slips.ALIKE``, also where their errors differ by less than this share of the error as
# recorded: what the check takes to stay unexplained anyway.
ALIKE_SHARE = 0.01
NAMED = 3  # recordings that are named
ONLY_THESE = "; of these recordings only: others fit as they are"


def slips_of(leg: Leg, trials: Sequence[Trial], bench: Workbench, given: Sequence[AngleTrial]) -> Sequence[Slip]:
    """Of columns or, where these are as the files say, of a stated number; ``given`` : the trials that are learnt."""
    return column_slips(leg, trials, bench) or far_numbers(leg, bench, given).slips


def column_slips(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> list[Slip]:
    """Columns, or what the leg file says of them, that a slip has made wrong; one each for all recordings that show it.

    The designed leg predicts each recording from the best-fitting initial state: unchanged, with two columns
    exchanged, with one inverted about its joint's zero, with a joint's inputs inverted, with angles or commands in
    the other unit, with angles that are absolute, with another zero of a joint, or with a drive's columns shifted.
    Where several changes explain a recording alike, the one is told that explains most of the others too.
    """
    bench = replace(bench, predictor=bench.predictor.coarser(INTEGRATION_TOLERANCE))
    chosen = sorted(trials, key=lambda t: -float(np.nanmax(np.nanstd(t.angles, axis=0))))[:MOST_TRIALS]
    errors = _errors_of_design(leg, chosen, bench)
    sound = bool(np.any(errors <= LEAST_ERROR))
    chosen = [trial for trial, error in zip(chosen, errors, strict=True) if error > LEAST_ERROR]
    own = errors[errors > LEAST_ERROR]
    if not chosen:
        return []
    changes = column_changes(leg, chosen)
    changes += lag_changes(leg, chosen, bench, lambda j: input_column(leg, chosen, j))
    tried = [_errors_of_change(leg, chosen, change, bench) for change in changes]
    missed = np.array([np.where(follows, error, np.inf) for error, follows in tried])
    # In a smaller unit every error is small, so only these can be compared with those of other changes.
    alike = missed / np.array([[change.scale] for change in changes])
    least = alike.min(axis=0)
    fits = alike <= np.maximum(ALIKE * least, least + ALIKE_SHARE * own)
    left = missed[np.argmin(alike, axis=0), np.arange(len(own))]
    fits &= left < np.minimum(own / LEAST_IMPROVEMENT, NEAR_DESIGN)
    fits &= ~_chance_lags(changes, fits)[:, None]
    found = []
    for k, of in _fewest_changes(alike, fits, np.array([ALIKE * error < own for error, _ in tried])):
        names = [chosen[place].name for place in of]
        slip = _slip(changes, k, fits[:, of].all(axis=1), names, own[of], missed[k, of])
        found.append(replace(slip, remedy=slip.remedy + ONLY_THESE) if sound else slip)
    return found


def _chance_lags(changes: Sequence[Change], fits: Mask) -> Mask:
    """(n_change,) lags of one recording alone where most others are as far from the leg and show none.

    ``fits`` (n_change, n_trial). Of 300 simulated projects with another fault one had such a lag; two recordings that
    agree in theirs are no chance.
    """
    clocks = np.array([isinstance(change, OtherClock) for change in changes])
    few = 2 * int(fits[clocks].any(axis=0).sum()) < fits.shape[1]
    return np.asarray(clocks & (fits.sum(axis=1) < 2) & few)


def _fewest_changes(errors: Array, fits: Mask, helps: Mask) -> Iterator[tuple[int, list[int]]]:
    """Changes that explain all recordings which any explains, and the recordings that each is told of.

    Parameters
    ----------
    errors : (n_change, n_trial) rad.
    fits : (n_change, n_trial), whether a change explains a recording as well as the best does.
    helps : (n_change, n_trial), whether it brings a recording nearer: no other one is then told of that.
    """
    fits = fits.copy()
    while fits.any():
        counts = fits.sum(axis=1)
        most = np.flatnonzero(counts == counts.max())
        totals = np.where(fits, errors, 0.0)[most].sum(axis=1)
        change = int(most[np.argmax(totals <= (1.0 + ALIKE_SHARE) * totals.min())])  # the first of equal ones
        of = np.flatnonzero(fits[change]).tolist()
        fits[:, of] = fits[:, helps[change]] = False
        yield change, of


def _slip(changes: Sequence[Change], chosen: int, fits: Mask, names: Sequence[str], own: Array, left: Array) -> Slip:
    """The chosen change as it is told; ``fits`` (n_change,) : which changes are as near in all these recordings.

    ``own``, ``left`` (n_trial,) rad RMS of the designed leg as recorded, and with the change.
    """
    change = changes[chosen]
    others = [other for other, fit in zip(changes, fits, strict=True) if fit and other is not change]
    either = change.either is not None and any(other.either == change.either for other in others)
    what, remedy = change.either if either and change.either is not None else (change.text, change.remedy)
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    text = f"{what}: the designed leg's error is {significant(np.degrees(own[0]), 2)} deg RMS as recorded"
    text += f" and {significant(np.degrees(left[0]), 2)} deg with this change"
    return Slip(text, remedy, tuple(names), float(np.sqrt(np.mean(left**2))), ", ".join(names[:NAMED]) + more)


def _errors_of_change(leg: Leg, trials: Sequence[Trial], change: Change, bench: Workbench) -> tuple[Array, Mask]:
    """(n_trial,) rad RMS error with this change, and whether it follows the motion where it must."""
    changed, new = [change.of(leg, trial) for trial in trials], change.of_leg(leg)
    if new is not leg:
        own = {id(trial.leg): change.of_leg(trial.leg) for trial in trials if trial.leg is not None}
        changed = [replace(trial, leg=own.get(id(trial.leg))) for trial in changed]
        bench = _bench_of(new, list(own.values()), bench)
    away = [False] * len(trials)
    if isinstance(change, ColumnChange) and change.factor != 1.0:
        away = _commands_are_far(leg, changed) if change.inputs else _angles_are_far(leg, changed, change.joints)
    if isinstance(change, OtherClock):
        away = [trial.name not in change.recordings for trial in trials]
    found = np.full(len(trials), np.inf)
    within = [k for k, far in enumerate(away) if not far]
    found[within] = _errors_of_design(new, [changed[k] for k in within], bench)
    if isinstance(change, OtherClock):  # it leaves out what may be the worst part
        before = _errors_of_design(leg, [change.compared(trial) for trial in trials], bench)
        moved = _motions(changed, change.joints)
        return found, (found * LEAST_IMPROVEMENT < before) & (moved < LEAST_IMPROVEMENT * before)
    if not change.must_follow:
        return found, np.isfinite(found)
    joints = change.joints if isinstance(change, ColumnChange) else range(len(leg.joints))
    return found, found * LEAST_IMPROVEMENT < _motions(changed, joints)


def _motions(trials: Sequence[Trial], joints: Sequence[int]) -> Array:
    """(n_trial,) rad RMS about the mean, of the joint of these that moves least."""
    return np.array([float(np.nanmin(np.nanstd(trial.angles[:, list(joints)], axis=0))) for trial in trials])


def _bench_of(leg: Leg, own: Sequence[Leg], bench: Workbench) -> Workbench:
    """The workbench of another leg, to the letter; ``own`` : of trials."""
    exact = Tolerances(np.zeros((len(QUANTITIES), len(leg.joints))))
    return replace(bench, predictor=Predictor(leg, exact, INTEGRATION_TOLERANCE, TrialLegs.of(leg, [None, *own])))


def _angles_are_far(leg: Leg, trials: Sequence[Trial], joints: Sequence[int]) -> list[bool]:
    """Of each trial, whether it holds an angle beyond which no recording is read."""
    most = np.array([widest(leg.joints[j]) for j in joints])
    return [bool(np.any(np.nanmax(np.abs(t.angles[:, list(joints)]), axis=0) >= most)) for t in trials]


def _commands_are_far(leg: Leg, trials: Sequence[Trial]) -> list[bool]:
    """Of each trial, whether it holds a command that no recording may hold."""
    signals = [trial.signals for trial in trials]
    return [
        each is not None
        and any(far_command(joint, each.command[:, j]) is not None for j, joint in enumerate(leg.joints))
        for each in signals
    ]


def _errors_of_design(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> Array:
    """(n_trial,) rad RMS error of the designed leg for each trial; infinite if the simulation fails."""
    found = np.full(len(trials), np.inf)
    made: dict[int, AngleTrial] = {}
    for k, trial in enumerate(trials):
        try:
            (recording,) = recordings(leg, [trial], ())
        except UserError:
            continue
        made[k] = angle_trial(recording, held_out=False).thinner(SAMPLES_A_TRIAL)
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    for k, (prediction, _) in zip(made, score(bench, fit, list(made.values())), strict=True):
        trial_made = made[k]
        away = (prediction - trial_made.measured)[trial_made.counts]
        if len(away) and np.all(np.isfinite(away)):
            found[k] = float(np.sqrt(np.mean(away**2)))
    return found

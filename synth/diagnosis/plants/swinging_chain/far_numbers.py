"""Stated numbers that are many times too large or too small: slips of the unit that the recordings show.

A servo gain per degree that is written as per radian is 57 times too large. The search of causes ends long before, at
numbers that a part may have, and what it then names, or does not find, is the slip's work.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block, state_size
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.pieces import whole_recordings
from synth.diagnosis.plants.swinging_chain.scalable_numbers import ScalableNumbers, scalable_numbers
from synth.diagnosis.plants.swinging_chain.slips import ALIKE, INTEGRATION_TOLERANCE, SAMPLES_A_TRIAL, Slip
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.diagnosis.score import first_state, score
from synth.diagnosis.workbench import Workbench
from synth.swing.leg_model import Leg
from synth.swing.tolerances import QUANTITIES, Tolerances
from synth.units import quantity, significant

MOST_TRIALS = 3  # trials compared, those with the largest motion
# Errors of the designed leg below which no number is doubted: rad RMS, and a share of the motion. The least of 32 slips
# in simulations of a free, a torque-driven and two servo-driven legs left 0.14 of it.
LEAST_ERROR, LEAST_SHARE = np.radians(2.0), 0.1
# Another number must leave less than this share of the motion and what usual tolerances shift the rest by, 0.9 deg in
# simulation. On a real servo (XL330, its friction not stated) the true gain leaves 0.23 of the motion. Where a file
# forgets a spring, a tenth of the masses left as much as the motion, and several other numbers did.
LEFT_SHARE, REST_ERROR = 0.3, np.radians(1.0)
# Least factor by which another number must reduce the error, as of exchanged columns (``column_slips``).
LEAST_IMPROVEMENT = 3.0
FOLLOWED = 8  # of the changes that leave least without a fit, those whose trials' initial states are fitted
REMEDY = "Correct the number, or its unit, in the leg file or in the header of its column"
SAID = 3  # of the numbers that fit alike, those that are named


@dataclass(frozen=True)
class FarNumber:
    """A stated number that fits far better ``factor`` times as large; errors in rad RMS over the compared trials."""

    numbers: ScalableNumbers
    factor: float
    as_stated: float
    left: float

    def words(self, leg: Leg) -> str:
        """``servo gain of arm: 143 1/rad is stated and 2.5 1/rad fits, 57 times less (...?)``."""
        times = significant(max(self.factor, 1.0 / self.factor), 2)
        less = f"{times} times {'more' if self.factor > 1.0 else 'less'}"
        value, what, slip = self.numbers.value(leg), self.numbers.words(leg), self.numbers.slip(self.factor)
        if value is None:
            return f"{what}: {less} than {self.numbers.given} fits ({slip}?)"
        stated, fits = (_written(number, value[1]) for number in (value[0], self.factor * value[0]))
        return f"{what}: {stated} is stated and {fits} fits, {less} ({slip}?)"


@dataclass(frozen=True)
class FarNumbers:
    """The numbers of a leg of which one is far off, the best first; none: empty."""

    leg: Leg
    each: tuple[FarNumber, ...] = ()
    compared: tuple[str, ...] = ()  # names of the recordings

    @property
    def text(self) -> str:
        """What is far off, and the errors of the designed leg; empty without any."""
        if not self.each:
            return ""
        best = self.each[0]
        words = " or else ".join(item.words(self.leg) for item in self.each[:SAID])
        more = f", or one of {len(self.each) - SAID} more that act alike" if len(self.each) > SAID else ""
        before, after = (significant(np.degrees(error), 2) for error in (best.as_stated, best.left))
        return f"{words}{more}: the designed leg's error is {before} deg RMS as stated and {after} deg with this change"

    @property
    def slips(self) -> tuple[Slip, ...]:
        """One, or none."""
        return (Slip(self.text, REMEDY, self.compared, self.each[0].left, number=True),) if self.each else ()

    @property
    def only_damping(self) -> bool:
        """Whether dampers alone are far off: that of a bearing is often no more than guessed."""
        return bool(self.each) and all(item.numbers.only_damping for item in self.each)


def _written(value: float, unit: str) -> str:
    """With the digits that tell what was written."""
    return f"{significant(float(quantity(value, unit)['value']), 3)} {unit}"


def far_numbers(leg: Leg, bench: Workbench, trials: Sequence[AngleTrial]) -> FarNumbers:
    """The stated numbers, or columns, of which one is off by a slip of the unit.

    Each number is tried 57.3 times as large or small, and by powers of ten, in simulations of the recordings from their
    smoothed initial states; the best from fitted ones.

    Parameters
    ----------
    leg : as designed.
    bench : the diagnosis' workbench of that leg.
    trials : recordings, or pieces of them; those with the largest motion are compared.
    """
    chosen = _compared(trials)
    stated = _fitted_error(_changed(leg, bench, chosen, ScalableNumbers(()), 1.0))
    motions = [np.var(trial.measured[:, trial.free], axis=0) for trial in chosen]
    motion = float(np.sqrt(np.mean(np.concatenate(motions))))
    if not stated > max(LEAST_ERROR, LEAST_SHARE * motion):
        return FarNumbers(leg)
    tried = [(numbers, factor) for numbers in scalable_numbers(leg, chosen) for factor in numbers.factors]
    changes = [_changed(leg, bench, chosen, numbers, factor) for numbers, factor in tried]
    rough = bench.in_parallel(lambda k: _rough_error(changes[k], stated), len(changes))
    least = min(stated / LEAST_IMPROVEMENT, REST_ERROR + LEFT_SHARE * motion)
    found: dict[ScalableNumbers, FarNumber] = {}
    for k in [k for k in np.argsort(rough)[:FOLLOWED].tolist() if np.isfinite(rough[k])]:
        numbers, factor = tried[k]
        left = _fitted_error(changes[k])
        if left < (found[numbers].left if numbers in found else least):
            found[numbers] = FarNumber(numbers, factor, stated, left)
    best = sorted(found.values(), key=lambda item: item.left)
    near = tuple(item for item in best if item.left < ALIKE * best[0].left)
    return FarNumbers(leg, near, tuple(trial.recording.name for trial in chosen))


def _compared(trials: Sequence[AngleTrial]) -> list[AngleTrial]:
    """The recordings, or pieces of them, with the largest motion, with fewer samples."""
    whole = sorted(whole_recordings(trials), key=lambda trial: -float(trial.measured.std(axis=0).max()))
    return [trial.thinner(SAMPLES_A_TRIAL) for trial in whole[:MOST_TRIALS]]


_Change = tuple[Workbench, list[AngleTrial]]


def _changed(
    leg: Leg, bench: Workbench, trials: Sequence[AngleTrial], numbers: ScalableNumbers, factor: float
) -> _Change:
    """The workbench of the leg, and the trials, with these numbers ``factor`` times as large."""
    own = {id(each): each for each in (leg, *(trial.recording.leg for trial in trials)) if each is not None}
    legs = {key: numbers.of_leg(each, factor) for key, each in own.items()}
    made = []
    for trial in trials:
        changed = numbers.of_trial(trial, factor)
        own_leg = changed.recording.leg and legs[id(changed.recording.leg)]
        made.append(replace(changed, recording=replace(changed.recording, leg=own_leg)))
    new = legs[id(leg)]
    exact = Tolerances(np.zeros((len(QUANTITIES), len(new.joints))))
    predictor = Predictor(new, exact, INTEGRATION_TOLERANCE, TrialLegs.of(new, [trial.recording.leg for trial in made]))
    return replace(bench, predictor=predictor, trials=tuple(made)), made


def _fitted_error(change: _Change) -> float:
    """Rad RMS of the leg to the letter over all trials, from the best-fitting initial states."""
    bench, trials = change
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    found = score(bench, fit, trials)
    return _rms([_away(trial, prediction) for trial, (prediction, _) in zip(trials, found, strict=True)])


def _rough_error(change: _Change, most: float) -> float:
    """Rad RMS of the leg to the letter from the smoothed initial states; infinite if it exceeds ``most``, rad."""
    bench, trials = change
    total, away = float(sum(trial.counts.sum() for trial in trials)), list[Array]()
    unknowns = np.zeros((bench.n_tolerance, 1))
    for trial in trials:
        begun = first_state(trial)
        state = np.zeros(state_size(bench.predictor, len(bench.noise), ()))
        state[: len(begun)] = begun
        (prediction,) = bench.predictor.predict([trial], [Block((), unknowns, state[None, :, None])])
        away.append(_away(trial, prediction[:, :, 0]))
        if not sum(float(each @ each) for each in away) < total * most**2:
            return np.inf
    return _rms(away)


def _away(trial: AngleTrial, prediction: Array) -> Array:
    """(k,) rad, the prediction from the samples that count."""
    return np.asarray((prediction - trial.measured)[trial.counts])


def _rms(away: Sequence[Array]) -> float:
    """Of all together; infinite if a motion diverged."""
    together = np.concatenate(away)
    found = float(np.sqrt(np.mean(together**2)))
    return found if np.isfinite(found) else np.inf

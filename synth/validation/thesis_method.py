"""The thesis' method: its cost, initial states and free angles, with its mistakes as switches.

Its cost sums, over the trials, absolute differences of features (rise time of the hip; damping ratio and damped
frequency of the knee) and squared ankle errors on a grid of 1 ms, with trial weights of 1 and 5. Two of its terms are
omitted here: heights and times of the knee's peak. They compare the first positive peak of one curve with the largest
of the other, one measured from the steady state and the other from zero.

The mistakes can be switched on separately: the foot's weight enters the free angles with the wrong sign; the initial
velocities are differences of the first two samples; at half speed the initial velocities of the fast motion are kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.fit.costs import DIVERGED
from synth.fit.methods import search_of
from synth.fit.rate_search import Search
from synth.fit.recordings import Recording
from synth.fit.starts import Start
from synth.fit.uncertainty import root_mean_square
from synth.motion.characteristics import Characteristics, characteristics
from synth.motion.rest import last_tenth
from synth.swing.leg_model import Leg
from synth.swing.mechanics import absolute, coefficients, static_torque

GRID_STEP = 1e-3  # s, step of the grid on which the thesis sums squares
HIP, KNEE, ANKLE = 0, 1, 2  # columns of the tables


@dataclass(frozen=True)
class Mistakes:
    """The thesis' mistakes that are switched on."""

    foot_weight: bool = False
    first_difference: bool = False
    double_rate: bool = False


NO_MISTAKES = Mistakes()
ALL_MISTAKES = Mistakes(True, True, True)


@dataclass(frozen=True)
class Terms:
    """Factors of the cost: ``rise`` 1/s, ``ratio`` 1, ``frequency`` s/rad, ``squares`` 1/rad^2 on the 1 ms grid.

    ``until`` : s, end of the range in which squares count. ``weights`` : (n_trial, 3) weight of a trial at each joint.
    """

    rise: float
    ratio: float
    frequency: float
    squares: float
    weights: Array
    until: float = np.inf


@dataclass(frozen=True)
class ThesisCost:
    """The cost of recordings with one term per joint: hip, knee, ankle."""

    recordings: tuple[Recording, ...]
    terms: Terms

    @cached_property
    def data(self) -> list[list[Characteristics]]:
        """Measured characteristics, by recording and joint."""
        return [features(r.smoothed.time, r.smoothed.angle, r) for r in self.recordings]

    def of(self, motions: Sequence[Array]) -> Array:
        """Costs (c, 3) of candidates from their motions (m, 3, c) rad per trial; ``DIVERGED`` if one diverges."""
        count = motions[0].shape[2]
        total, terms = np.zeros((count, 3)), self.terms
        for recording, motion, wanted, weight in zip(self.recordings, motions, self.data, terms.weights, strict=True):
            early = recording.time <= terms.until
            samples = float(np.median(np.diff(recording.time))) / GRID_STEP
            for c in range(count):
                if not np.all(np.isfinite(motion[:, :, c])):
                    total[c] = DIVERGED
                    continue
                found = features(recording.time, motion[:, :ANKLE, c], recording)
                knee = terms.ratio * _feature_difference(wanted[KNEE].damping_ratio, found[KNEE].damping_ratio, 1.0)
                knee += terms.frequency * _feature_difference(
                    wanted[KNEE].damped_frequency, found[KNEE].damped_frequency, 20.0
                )
                error = (motion[:, ANKLE, c] - recording.rotation[:, ANKLE])[early]
                squares = terms.squares * samples * float(error @ error)
                rise = terms.rise * _feature_difference(wanted[HIP].rise_time, found[HIP].rise_time, 1.0)
                total[c] += weight * np.array([rise, knee, squares])
        return total


class ThesisMethod:
    """The thesis' search on a leg's recordings. Rates are (2, 3): spring rates, then damper rates.

    ``stretched`` : factor by which the recordings were slowed down.
    """

    def __init__(
        self,
        leg: Leg,
        recordings: Sequence[Recording],
        terms: Terms,
        mistakes: Mistakes = NO_MISTAKES,
        stretched: float = 1.0,
    ) -> None:
        self.recordings, self.mistakes = tuple(recordings), mistakes
        self.cost = ThesisCost(self.recordings, terms)
        search = search_of(leg, recordings, self.cost)
        search.starts = tuple(self._start(r, s, stretched) for r, s in zip(recordings, search.starts, strict=True))
        self.search = _WrongFootSign.of(search) if mistakes.foot_weight else search

    def _start(self, recording: Recording, start: Start, stretched: float) -> Start:
        rotation, rate = start.rotation, start.rate
        if self.mistakes.first_difference:
            rotation = recording.rotation[0]
            rate = (recording.rotation[1] - rotation) / (recording.time[1] - recording.time[0])
        return replace(start, rotation=rotation, rate=rate * (stretched if self.mistakes.double_rate else 1.0))

    def motions(self, rates: Array) -> list[Array]:
        """Motions (m, 3) rad, one per trial, for rates (2, 3)."""
        return [motion[:, :, 0] for motion in self.search.motions(rates[:, :, None])]

    def features(self, rates: Array) -> list[list[Characteristics]]:
        """Simulated characteristics at these rates, by trial and joint."""
        return [features(r.time, m, r) for r, m in zip(self.recordings, self.motions(rates), strict=True)]

    def total(self, rates: Array) -> float:
        """The cost at these rates, summed over joints."""
        return float(self.search.by_joint(rates[:, :, None]).sum())

    def rms(self, rates: Array) -> Array:
        """Root-mean-square residuals (3,) rad over all trials' valid samples."""
        return root_mean_square(self.recordings, self.motions(rates))

    def mean_errors(self, rates: Array) -> Array:
        """Signed means (n_trial, 3) rad of model minus recording, in measured angles."""
        sign = self.search.model.leg.sign
        zipped = zip(self.motions(rates), self.recordings, strict=True)
        return np.array([sign * np.mean(m - r.rotation, axis=0) for m, r in zipped])


def features(time: Array, angle: Array, recording: Recording) -> list[Characteristics]:
    """Characteristics of each joint for ``time`` (m,) s and ``angle`` (m, n) rad, with the recording's noise.

    As in the thesis, a release's last samples are its rest.
    """
    noise = recording.smoothed.noise
    return [characteristics(time, column, float(noise[j]), rest=last_tenth(column)) for j, column in enumerate(angle.T)]


def _feature_difference(wanted: float | None, found: float | None, penalty: float) -> float:
    """Absolute difference; the penalty if only ``wanted`` shows the feature, 0 if ``wanted`` does not."""
    if wanted is None:
        return 0.0
    return penalty if found is None else abs(found - wanted)


class _WrongFootSign(Search):
    """A search whose free angles include the foot's weight with the thesis' wrong sign: added, not subtracted."""

    @classmethod
    def of(cls, search: Search) -> _WrongFootSign:
        return cls(search.model, search.recordings, search.cost, search.common, search.starts)

    def rests(self, spring_rate: Array) -> Array:
        """Rotations (n_trial, 3, c) rad at which the springs are unloaded."""
        leg, found = self.model.leg, []
        for recording, start in zip(self.recordings, self.starts, strict=True):
            known = coefficients(leg, recording.conditions.tip)
            tilt = leg.tilt + recording.conditions.tilt
            weight = static_torque(known, start.end, tilt)
            link = leg.joints[ANKLE].link
            foot = leg.gravity * link.mass * link.com * np.sin(absolute(start.end, tilt)[ANKLE])
            wrong = weight - 2 * foot
            found.append(start.end[:, None] + wrong[:, None] / spring_rate)
        return np.array(found)

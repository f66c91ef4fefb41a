"""Which recording starts like another: from the same angles, at the same rates, under the same conditions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.comparison.side import ComparedMotion, Side
from synth.drives.servo import ServoSignals
from synth.noise import white_noise
from synth.pace import ORDER, paces
from synth.sampling import usual_step
from synth.swing.chain import Conditions
from synth.swing.leg_model import Leg

NEAR = np.radians(10.0)  # at any joint: half of a common amplitude; a recording farther away is another motion
NEAR_SHARE = 0.5  # of the larger motion's amplitude at its widest joint, where this is less than NEAR
RELATIVE, ABSOLUTE = 1e-6, 1e-9  # of conditions and inputs, SI: results state them with ten digits
OF_PACE = 2.0  # paces, the time in which a sinusoid turns by one radian: see ``synth.pace``
# Of the polynomial at the start, over at most such a time: an angle's noise s shows as 14 s / sqrt(samples) of swing.
DEGREE, LEAST_SAMPLES = 2, 5
NARROWER = 0.7  # of the time, from one try to the next
# What the polynomial may leave, in noises and of the joint's amplitude. A stiff or overdamped joint moves at first far
# faster than over the whole recording: a polynomial over too long a time gave 2700 deg/s to a release from rest.
LEFT_NOISES, LEFT_SHARE = 1.5, 0.001
CERTAIN = 2.0  # standard deviations: a smaller difference of rates may be the sensors' noise


@dataclass(frozen=True)
class Away:
    """How far a recording starts from another.

    ``angle`` (n,) rad and ``rate`` (n,) rad/s apart, 0 of locked joints; ``swing`` (n,) rad: the rate times the joint's
    own time scale (of a sinusoid 1 / w), the swing that it makes.
    """

    angle: Array
    rate: Array
    swing: Array

    @property
    def joint(self) -> int:
        """The joint that is farthest."""
        return int(np.argmax(np.hypot(self.angle, self.swing)))

    @property
    def distance(self) -> float:
        """Rad of that joint in angle and swing: a free oscillation keeps its distance from rest in this plane."""
        return float(np.hypot(self.angle, self.swing).max(initial=0.0))


@dataclass(frozen=True)
class RecordedStart:
    """A recording and its start as its samples show it.

    ``rate`` (n,) rad/s, with the noise's ``deviation`` (n,) rad/s; ``radian`` (n,) s, in which each joint's swing turns
    by one radian, nan if no joint is seen to move; ``amplitude`` rad, of the widest joint.
    """

    motion: ComparedMotion
    rate: Array
    deviation: Array
    radian: Array
    amplitude: float

    @classmethod
    def of(cls, motion: ComparedMotion) -> RecordedStart:
        """The start, from local polynomials as wide as the motion is slow; without samples the stated one."""
        n = motion.rotation.shape[1]
        counts = np.isfinite(motion.rotation)
        counts[:, list(motion.conditions.locked)] = False
        seen = [j for j in range(n) if counts[:, j].sum() > 2 * ORDER]
        rate, deviation, radian = motion.rate.copy(), np.zeros(n), np.full(n, np.nan)
        if not seen:
            return cls(motion, rate, deviation, radian, 0.0)
        step = usual_step(motion.time, counts[:, seen])
        grid = np.arange(motion.time[0], motion.time[-1] + 0.5 * step, step)
        even = np.stack([np.interp(grid, motion.time[counts[:, j]], motion.rotation[counts[:, j], j]) for j in seen], 1)
        radian[seen] = OF_PACE * paces(step, even)
        if np.isfinite(radian).any():  # a joint that others hardly move
            radian[np.isnan(radian)] = np.nanmin(radian)
        for place, j in enumerate(seen):
            noise = white_noise(even[:, place], ORDER)
            since, angle = motion.time[counts[:, j]] - motion.time[0], motion.rotation[counts[:, j], j]
            found = _first_rate(since, angle, radian[j], noise)
            if found is not None:
                rate[j], deviation[j] = found
        return cls(motion, rate, deviation, radian, 0.5 * float(np.ptp(even, axis=0).max()))

    def away(self, like: RecordedStart) -> Away:
        """How far it starts from another."""
        radian = np.where(np.isfinite(self.radian), self.radian, np.nan_to_num(like.radian))
        angle = np.abs(self.motion.start - like.motion.start)
        noise = CERTAIN * np.hypot(self.deviation, like.deviation)
        rate = np.maximum(np.abs(self.rate - like.rate) - noise, 0.0)
        locked = list(like.motion.conditions.locked)
        angle[locked], rate[locked] = 0.0, 0.0
        return Away(angle, rate, rate * radian)

    def near(self, like: RecordedStart) -> float:
        """Rad, the largest distance at which it still starts alike: two small swings in opposite phase do not."""
        widest = max(self.amplitude, like.amplitude)
        return min(float(NEAR), NEAR_SHARE * widest) if widest else float(NEAR)


def _first_rate(since: Array, angle: Array, width: float, noise: float) -> tuple[float, float] | None:
    """Rate at time 0 and its deviation, rad/s; None if no sample is near.

    By a polynomial over ``width`` s at most, less where it does not follow the samples or the next higher one has
    another rate; the deviation is that of the higher one, infinite if it is so over the fewest samples too. ``since``
    (m,) s of the samples, ``angle`` (m,) rad with ``noise`` rad.
    """
    if not np.isfinite(width) or since[0] > width:
        return None
    allowed = max(LEFT_NOISES * noise, LEFT_SHARE * 0.5 * float(np.ptp(angle)))
    count = max(int(np.searchsorted(since, width, side="right")), LEAST_SAMPLES)
    while True:
        some, scale = angle[:count], float(since[:count][-1])
        powers = np.vander(since[:count] / scale, DEGREE + 2, increasing=True)
        solved, higher = np.linalg.pinv(powers[:, :-1]), np.linalg.pinv(powers)
        left = float(np.sqrt(np.sum((some - powers[:, :-1] @ (solved @ some)) ** 2) / max(len(some) - DEGREE - 1, 1)))
        rate, off = float(solved[1] @ some) / scale, abs(float((higher[1] - solved[1]) @ some)) / scale
        deviation = max(noise, left) * float(np.linalg.norm(higher[1])) / scale
        if left <= allowed and off <= CERTAIN * deviation:
            return rate, deviation
        if count <= LEAST_SAMPLES:
            return rate, np.inf
        count = max(int(NARROWER * count), LEAST_SAMPLES)


def recorded_starts(side: Side) -> list[RecordedStart]:
    """A side's recordings in the time scale of the comparison."""
    return [RecordedStart.of(motion) for motion in side.slowed]


def nearest(known: Sequence[RecordedStart], like: RecordedStart, leg: Leg) -> tuple[RecordedStart, Away] | None:
    """The recording that starts nearest to ``like`` in angle and rate, and how far away.

    Only recordings under the same conditions are considered: locked joints, added mass with its inertia and place on
    the last link of ``leg``, tilt, and what drives them.
    """
    alike = [each for each in known if _same_conditions(each.motion, like.motion, leg)]
    found = [(each, each.away(like)) for each in alike]
    return min(found, key=lambda pair: pair[1].distance, default=None)


def _same_conditions(motion: ComparedMotion, like: ComparedMotion, leg: Leg) -> bool:
    """Whether two recordings were made under the same conditions and driven alike."""
    if motion is like:
        return True
    if motion.not_driven or like.not_driven or motion.conditions.locked != like.conditions.locked:
        return False
    pairs = [(motion.conditions.tilt, like.conditions.tilt)]
    if motion.conditions.tip_mass or like.conditions.tip_mass:
        pairs += zip(_tip(motion.conditions, leg), _tip(like.conditions, leg), strict=True)
    known = _same_inputs(motion.known_torque, like.known_torque)
    return (
        known
        and _same_signals(motion.signals, like.signals)
        and all(np.isclose(*pair, rtol=RELATIVE, atol=ABSOLUTE) for pair in pairs)
    )


def _tip(conditions: Conditions, leg: Leg) -> tuple[float, float, float]:
    """Mass, inertia, and place from the last joint, kg, kg m^2, m."""
    at = leg.joints[-1].link.length if conditions.tip_at is None else conditions.tip_at
    return conditions.tip_mass, conditions.tip_inertia, at


def _same_inputs(one: Sequence[Array] | None, other: Sequence[Array] | None) -> bool:
    if one is None or other is None:
        return one is other
    return all(a.shape == b.shape and np.allclose(a, b, RELATIVE, ABSOLUTE) for a, b in zip(one, other, strict=True))


def _same_signals(one: ServoSignals | None, other: ServoSignals | None) -> bool:
    if one is None or other is None:
        return one is other
    parts = [(each.time, each.command, each.supply, each.enabled) for each in (one, other)]
    return one.held == other.held and _same_inputs(*parts)

"""The unknowns of a fit: numbers written into the lanes of the compiled chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.fit.search_box import LIMB, SearchBox
from synth.fit.static_points import Balance, groups, linearised, spread_at
from synth.swing.chain import Chain
from synth.swing.leg_model import Damper, Leg, Spring
from synth.swing.mechanics import outboard_inertia

# Typical limbs and models: log-normal with these 90 % ranges. So weak (a factor of 15 on k, 30 on b) that the prior
# does not affect anything that the trials determine; it only selects a point on a ridge that they leave open. In the
# recordings' unit of time; I is the inertia outboard of the joint.
FREQUENCY_PRIOR = (1.0, 15.0)  # Hz, sqrt(k/I) / 2 pi
DECAY_PRIOR = (0.5, 500.0)  # 1/s, b/I


class Unknowns(Protocol):
    """A vector of unknowns common to all trials, and its effect on the leg."""

    @property
    def names(self) -> tuple[str, ...]:
        """One name an unknown."""

    @property
    def lower(self) -> Array:
        """(n_unknown,) lower bounds."""

    @property
    def upper(self) -> Array:
        """(n_unknown,) upper bounds."""

    @property
    def prior(self) -> tuple[Array, Array]:
        """(n_unknown,) mean and (n_unknown,) precision (1 / variance, 0 for none) of a weak normal prior."""

    @property
    def weak_precision(self) -> Array:
        """(n_unknown,) the prior's precision where it says what is typical, 0 where the user stated something."""

    @property
    def rest_index(self) -> tuple[int | None, ...]:
        """For each joint the index of its rest angle, or None."""

    def measured(self, values: Array, spread: Array | None) -> tuple[float, Array, Array] | None:
        """Cost, gradient (p,) and information (p, p) of measurements other than trials; None if there are none.

        ``spread`` (n,) rad of the free angles that they have, about the common ones; None: they have these.
        """

    def write(self, lanes: Array, values: Array) -> None:
        """Write ``values`` (n_unknown, n_lane) into ``lanes`` (n_row, n_lane)."""


@dataclass(frozen=True)
class SpringsAndDampers:
    """Log spring rate, rest angle and log damper rate, in that order, of the joints where each is estimated.

    ``rates``, ``rests``, ``dampers`` : joint indices. ``beliefs`` : (unknown, mean, precision) of priors that
    replace the weak ones: the user's, or a sharp one that fixes an unknown. ``balances`` : static points. ``box`` : of
    the search.
    """

    chain: Chain
    leg: Leg
    rates: tuple[int, ...]
    rests: tuple[int, ...]
    dampers: tuple[int, ...]
    beliefs: tuple[tuple[int, float, float], ...] = ()
    balances: tuple[Balance, ...] = ()
    box: SearchBox = LIMB

    @property
    def names(self) -> tuple[str, ...]:
        """``spring_rate hip`` and so on."""
        joint = self.leg.joint_names
        named = [f"spring_rate {joint[j]}" for j in self.rates] + [f"free_angle {joint[j]}" for j in self.rests]
        return tuple(named + [f"damper_rate {joint[j]}" for j in self.dampers])

    def rate_at(self, joint: int) -> int:
        """Index of a joint's log spring rate; ValueError if it is not estimated."""
        return self.rates.index(joint)

    def rest_at(self, joint: int) -> int:
        """Index of a joint's rest angle."""
        return len(self.rates) + self.rests.index(joint)

    def damper_at(self, joint: int) -> int:
        """Index of a joint's log damper rate."""
        return len(self.rates) + len(self.rests) + self.dampers.index(joint)

    @cached_property
    def _rows(self) -> Array:
        row = self.chain.layout.row
        rows = [row("spring_rate", j) for j in self.rates] + [row("rest", j) for j in self.rests]
        return np.array(rows + [row("damper_rate", j) for j in self.dampers], dtype=int)

    @cached_property
    def logarithmic(self) -> Array:
        """(n_unknown,) True where the unknown is a logarithm."""
        return np.array([True] * len(self.rates) + [False] * len(self.rests) + [True] * len(self.dampers))

    @cached_property
    def _box(self) -> tuple[Array, Array]:
        stiff, damp = self.box.rates(self.leg)
        sides = [
            np.concatenate([s[list(self.rates)], r[list(self.rests)], d[list(self.dampers)]])
            for s, r, d in zip(stiff, self.box.rests(len(self.leg.joints)), damp, strict=True)
        ]
        return sides[0], sides[1]

    @cached_property
    def prior(self) -> tuple[Array, Array]:
        """Log-normal in natural units for the rates, none for the rest angles."""
        inertia = outboard_inertia(self.leg)
        stiff = [np.log(inertia * (2 * np.pi * f / self.box.unit) ** 2) for f in FREQUENCY_PRIOR]
        damp = [np.log(inertia * decay / self.box.unit) for decay in DECAY_PRIOR]
        mean, precision = np.zeros(len(self.names)), np.zeros(len(self.names))
        for (low, high), joints, at in ((stiff, self.rates, self.rate_at), (damp, self.dampers, self.damper_at)):
            for j in joints:
                mean[at(j)] = 0.5 * (low[j] + high[j])
                precision[at(j)] = (2 * NORMAL90 / (high[j] - low[j])) ** 2
        for place, value, sharpness in self.beliefs:
            mean[place], precision[place] = value, sharpness
        return mean, precision

    @cached_property
    def weak_precision(self) -> Array:
        """(n_unknown,) the prior's precision, 0 of the beliefs."""
        weak = self.prior[1].copy()
        weak[[place for place, _, _ in self.beliefs]] = 0.0
        return weak

    @property
    def lower(self) -> Array:
        """(n_unknown,) lower bounds."""
        return self._box[0]

    @property
    def upper(self) -> Array:
        """(n_unknown,) upper bounds."""
        return self._box[1]

    @cached_property
    def rest_index(self) -> tuple[int | None, ...]:
        """Index of each joint's rest angle."""
        n = len(self.leg.joints)
        return tuple(self.rest_at(j) if j in self.rests else None for j in range(n))

    @cached_property
    def _groups(self) -> tuple[tuple[Balance, ...], ...]:
        return tuple(tuple(self.balances[k] for k in numbers) for numbers in groups(self.balances))

    def measured(self, values: Array, spread: Array | None) -> tuple[float, Array, Array] | None:
        """The static points' term: half their squared residuals, with gradient and information."""
        if not self.balances:
            return None
        cost, gradient, information = 0.0, np.zeros(len(values)), np.zeros((len(values), len(values)))
        for group in self._groups:
            joint = group[0].joint
            places = [self.rate_at(joint), self.rest_at(joint)]
            log_rate, rest = (float(each) for each in values[places])
            residual, slope = linearised(group, log_rate, rest, spread_at(spread, joint))
            cost += 0.5 * float(residual @ residual)
            gradient[places] += residual @ slope
            information[np.ix_(places, places)] += slope.T @ slope
        return cost, gradient, information

    def write(self, lanes: Array, values: Array) -> None:
        """Write values into lanes, exponentials of those that are logarithms."""
        # exp(80) is beyond any rate, and its products are still finite.
        lanes[self._rows] = np.where(self.logarithmic[:, None], np.exp(np.minimum(values, 80.0)), values)

    def pack(self, spring_rate: Array, rest: Array, damper_rate: Array) -> Array:
        """(n_unknown,) from natural values by joint, within the bounds; non-positive rates go to the lower one."""
        tiny = 1e-300
        rates = np.log(np.maximum(spring_rate, tiny))[list(self.rates)]
        dampers = np.log(np.maximum(damper_rate, tiny))[list(self.dampers)]
        packed = np.concatenate([rates, rest[list(self.rests)], dampers])
        return np.asarray(np.clip(packed, self.lower, self.upper))

    def natural(self, values: Array) -> Array:
        """(n_unknown,) N m/rad, rad and N m s/rad."""
        return np.where(self.logarithmic, np.exp(np.where(self.logarithmic, values, 0.0)), values)

    def of_joints(self, joints: Sequence[int]) -> SpringsAndDampers:
        """Those at some of the joints; before there are beliefs and balances."""
        rates, rests, dampers = (
            tuple(j for j in each if j in joints) for each in (self.rates, self.rests, self.dampers)
        )
        return replace(self, rates=rates, rests=rests, dampers=dampers)

    def springs(self, values: Array) -> tuple[Array, Array]:
        """(n,) logarithms of the spring rates, and (n,) rad rests; nan where they are not estimated."""
        rates, rests = np.full((2, len(self.leg.joints)), np.nan)
        rates[list(self.rates)] = values[: len(self.rates)]
        rests[list(self.rests)] = values[len(self.rates) :][: len(self.rests)]
        return rates, rests

    def fitted_leg(self, values: Array) -> Leg:
        """The leg with these springs and dampers (n_unknown,); other parameters are kept."""
        natural, joints = self.natural(values), list(self.leg.joints)
        for j in self.rates:
            joint, rest = joints[j], float(natural[self.rest_at(j)])
            spring = Spring(float(natural[self.rate_at(j)]), joint.zero + joint.sign * rest)
            joints[j] = replace(joint, spring=spring)
        for j in self.dampers:
            joints[j] = replace(joints[j], damper=Damper(float(natural[self.damper_at(j)])))
        return replace(self.leg, joints=tuple(joints))


def unknowns_of_leg(
    chain: Chain, leg: Leg, *, damper_known: Sequence[int] = (), box: SearchBox = LIMB
) -> SpringsAndDampers:
    """Unknowns for a whole leg: every spring rate and rest angle, and unknown damper rates."""
    joints = tuple(range(len(leg.joints)))
    dampers = tuple(j for j in joints if j not in damper_known)
    return SpringsAndDampers(chain, leg, joints, joints, dampers, box=box)

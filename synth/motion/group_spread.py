"""Deviations of samples from the mean that stands for their group, for figures over the samples as recorded."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask


@dataclass(frozen=True)
class GroupSpread:
    """Sums over the good samples of each group, for deviations u rad from its angle, tau s from its time.

    ``sums`` (6, m, n) : of 1, u, u^2, tau, tau^2 and u tau, for m groups and n joints.
    """

    sums: Array

    @classmethod
    def of(cls, samples: tuple[Array, Array, Mask], groups: tuple[Array, Array], size: int) -> GroupSpread:
        """Of ``samples``, time (k,) s, angle (k, n) rad and lost (k, n), in ``groups`` of ``size``, time and angle."""
        kept = len(groups[0]) * size
        time, angle = (each[:kept].reshape(-1, size, *each.shape[1:]) for each in samples[:2])
        good = ~samples[2][:kept].reshape(-1, size, angle.shape[2])
        u = np.where(good, angle - groups[1][:, None], 0.0)
        tau = np.where(good, (time - groups[0][:, None])[:, :, None], 0.0)
        return cls(np.array([each.sum(axis=1) for each in (good.astype(float), u, u**2, tau, tau**2, u * tau)]))

    @classmethod
    def single(cls, rows: int, joints: int) -> GroupSpread:
        """Of samples that stand for themselves."""
        sums = np.zeros((6, rows, joints))
        sums[0] = 1.0
        return cls(sums)

    def rows(self, kept: slice | Mask) -> GroupSpread:
        """Of some of the groups."""
        return GroupSpread(self.sums[:, kept])

    def stretched(self, factor: float) -> GroupSpread:
        """Of a motion that is ``factor`` times slower."""
        powers = np.array([0, 0, 0, 1, 2, 1])
        return replace(self, sums=self.sums * (factor**powers)[:, None, None])

    def squares(self, off: Array, rate: Array) -> Array:
        """(m, n) rad^2, sum over each group's samples of their squared distance from a motion.

        ``off`` (m, n) rad, the groups' angles less the motion's; ``rate`` (m, n) rad/s, the motion's. Exact where the
        motion is straight over a group, which is why groups may be averaged.
        """
        count, u, square, tau, tau_square, both = self.sums
        spread = square - 2.0 * rate * both + rate**2 * tau_square
        return np.asarray(spread + 2.0 * off * (u - rate * tau) + count * off**2)

"""The speeds at which a joint turns in the releases, and for how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array


@dataclass(frozen=True)
class ReachedSpeeds:
    """``speed`` (m,) rad/s of a joint, without sign, and the ``time`` (m,) s for which each stands."""

    speed: Array
    time: Array

    @property
    def fastest(self) -> float:
        """Rad/s."""
        return float(self.speed.max())

    def share_below(self, speed: float) -> float:
        """Share of the time in which the joint is slower than ``speed``, rad/s."""
        return float(self.time[self.speed < speed].sum() / self.time.sum())


def reached_speeds(motions: Sequence[Array], times: Sequence[Array]) -> list[ReachedSpeeds]:
    """Those of each joint in motions (m, n) rad over times (m,) s."""
    speed = np.concatenate([np.abs(np.gradient(m, time, axis=0)) for m, time in zip(motions, times, strict=True)])
    lasting = np.concatenate([np.gradient(time) for time in times])
    return [ReachedSpeeds(each, lasting) for each in speed.T]

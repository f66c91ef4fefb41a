"""Derivatives of all trials at one point, and what turns predictions into whitened misses: what fits rest on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.gap_trials import GapTrial


@dataclass(frozen=True)
class Part:
    """One trial's share of a frame, whitened: ``tolerance`` (M, p) derivatives, ``q`` (M, l), ``r`` (l, l) of states.

    The states' columns have the weak prior of their initial rates below them, so M is the samples' number plus l.
    """

    tolerance: Array
    q: Array
    r: Array

    @cached_property
    def along(self) -> Array:
        """(l, p) what of the tolerances' derivatives the states can do."""
        return np.asarray(self.q.T @ self.tolerance)

    @cached_property
    def bare(self) -> Array:
        """(M, p) what of them the states cannot do."""
        return np.asarray(self.tolerance - self.q @ self.along)

    @cached_property
    def products(self) -> Array:
        """(p, p) of those with one another."""
        return np.asarray(self.bare.T @ self.bare)


@dataclass(frozen=True)
class Frame:
    """Derivatives by tolerances and initial states of all trials at one point."""

    parts: tuple[Part, ...]

    @cached_property
    def alike(self) -> list[tuple[list[int], Array]]:
        """Trials of as many states: their places, and their ``r`` (n_trial, l, l)."""
        places: dict[int, list[int]] = {}
        for i, part in enumerate(self.parts):
            places.setdefault(len(part.r), []).append(i)
        return [(group, np.array([self.parts[i].r for i in group])) for group in places.values()]

    def changes(
        self, explained: Sequence[tuple[Array, Array]], steps: Array, dampings: Array
    ) -> list[tuple[Array, ...]]:
        """Damped steps of the states, a trial each (l,), that go with ``steps`` (n_step, n_unknown) of the unknowns.

        ``explained`` : of each trial, as ``Normal`` has it; ``dampings`` (n_step,).
        """
        found: list[list[Array]] = [[np.zeros(0)] * len(self.parts) for _ in steps]
        for places, r in self.alike:
            here = np.array([explained[i][0] for i in places])[:, :, None]
            along = np.array([explained[i][1] for i in places])
            right = r.transpose(0, 2, 1) @ (here + along @ steps.T)
            square = r.transpose(0, 2, 1) @ r
            diagonal = np.eye(square.shape[1]) * square
            damped = square + dampings[:, None, None, None] * diagonal
            change = -np.linalg.solve(damped, right.transpose(2, 0, 1)[..., None])[..., 0]
            for made, step in zip(found, change, strict=True):
                for place, i in enumerate(places):
                    made[i] = step[place]
        return [tuple(made) for made in found]


@dataclass(frozen=True)
class Whitener:
    """What turns a trial's predictions into whitened misses of the samples that count, a row a lane.

    ``index`` places of these samples in a flat (m n,) array; ``measured`` and ``scale`` (count,) theirs.
    """

    index: NDArray[np.intp] | slice
    measured: Array
    scale: Array

    @classmethod
    def of(cls, trial: GapTrial, sigma: Array) -> Whitener:
        """``sigma`` (n,) or (m, n) rad."""
        index = slice(None) if trial.counts.all() else np.flatnonzero(trial.counts)
        scale = 1.0 / np.broadcast_to(sigma, trial.measured.shape)
        return cls(index, trial.measured.reshape(-1)[index], scale.reshape(-1)[index])

    @property
    def count(self) -> int:
        """Number of samples that count."""
        return len(self.measured)

    def lanes(self, prediction: Array, out: Array | None = None) -> Array:
        """(n_lane, count) from predictions (m, n, n_lane) rad."""
        taken = prediction.reshape(-1, prediction.shape[2])[self.index].T
        found = np.empty(taken.shape) if out is None else out
        np.subtract(taken, self.measured, out=found)
        found *= self.scale
        return found

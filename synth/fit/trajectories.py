"""Residuals of whole trajectories and their Jacobian: the nominal lane and its perturbations step together.

Internal numerical differentiation (Bock 1983; Hairer et al., *Solving ODEs I*, section II.6 and Nocedal &
Wright, *Numerical Optimization*, section 8.1): perturbed trajectories that share the nominal's steps differ from it
smoothly, so forward differences at rtol 1e-5 are good to 3e-5 of the largest. That is too little for an overdamped
joint, whose steps are at the limit of stability: the dependence of its error of 1e-5 rad on b then looks like
information that separates k from b, and the interval is up to seven times too narrow (measured: hip at 60 N m/rad and
12 N m s/rad, 0.3 deg noise). At rtol 1e-7 it is correct, and fits take no longer, because the iteration is less
disturbed by noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.fit.recordings import Recording
from synth.fit.unknowns import Unknowns
from synth.swing.chain import Chain, Conditions
from synth.swing.lane_layout import LANES
from synth.swing.leg_model import Leg
from synth.threads import shared_out

PERTURBATION = 1e-6  # of log rates, rad, and 10x that of rad/s
FIT_STEPS = 8000  # per trajectory; a second takes about 140; beyond this it is aborted
FIT_TOLERANCE = 1e-7  # of the integrator; at 1e-5 derivatives are within 2.5e-5, at 1e-4 they are too coarse
Index = NDArray[np.intp]


@dataclass(frozen=True)
class Local:
    """The own unknowns of one trial: initial rotation (n,), initial rate (n,) and shift of the rest angles (n,)."""

    rotation: Array
    rate: Array
    shift: Array


@dataclass(frozen=True)
class Evaluation:
    """Prediction (m, n) rad of one trial; Jacobians (m, n, n_unknown) and (m, n, n_local), None if not requested.

    Local columns: initial rotations of the free joints, their initial rates, then shifts of the joints whose rest is
    among the unknowns.
    """

    prediction: Array
    common: Array | None = None
    local: Array | None = None


@dataclass(frozen=True)
class LanePlan:
    """Perturbation of each lane, for one set of free joints.

    Lanes form groups of sixteen that step together, each with a nominal first. ``common`` (n_unknown, n_lane) and
    ``state`` (2 n, n_lane) are added to the nominal; ``moved`` and ``still`` (n_step,) are the lanes to
    subtract, ``width`` (n_step,) the divisors and ``area`` products of two; ``order`` sorts the steps, and those by
    the rest angles a second time as shifts, into common unknowns, then the trial's own; ``square`` the same for a
    matrix.
    """

    common: Array
    state: Array
    moved: Index
    still: Index
    width: Array
    area: Array
    order: Index
    square: tuple[Index, ...]

    @classmethod
    def of(cls, n: int, n_common: int, free: Sequence[int], rests: Sequence[int], unit: float) -> LanePlan:
        """For a chain of ``n`` links, with the joints' rest angles at these indices among the unknowns; ``unit`` s."""
        rows = [*free, *[n + j for j in free]]
        count = n_common + len(rows)
        step = np.arange(count)
        still = step // (LANES - 1) * LANES
        moved = still + 1 + step % (LANES - 1)
        n_lane = int(moved[-1]) + 1
        width = np.r_[np.full(n_common + len(free), 1.0), np.full(len(free), 10.0 / unit)] * PERTURBATION
        common, state = np.zeros((n_common, n_lane)), np.zeros((2 * n, n_lane))
        common[step[:n_common], moved[:n_common]] = width[:n_common]
        state[rows, moved[n_common:]] = width[n_common:]
        order = np.concatenate([step, np.array(rests, dtype=int)])
        return cls(common, state, moved, still, width, np.outer(width, width), order, np.ix_(order, order))


@dataclass(frozen=True)
class Sensitivity:
    """One trial's perturbed lanes ``out`` (m, n, n_lane) rad, the input of residuals and normal equations.

    ``shift`` (m, n) rad moves all lanes, after a step that was not simulated: the prediction is then linear in it, and
    the differences are those of the point before.
    """

    out: Array
    plan: LanePlan
    shift: Array | None = None

    @property
    def prediction(self) -> Array:
        """(m, n) rad."""
        return self.out[:, :, 0] if self.shift is None else self.out[:, :, 0] + self.shift

    def differences(self) -> Array:
        """(m, n, n_step) rad, differences of the moved lanes, not yet divided."""
        if len(self.plan.moved) < LANES:
            return self.out[:, :, 1:] - self.out[:, :, :1]
        return self.out[:, :, self.plan.moved] - self.out[:, :, self.plan.still]

    def after(self, step: Array) -> Sensitivity:
        """The same after a small step of the common and the trial's own unknowns, by the differences of the lanes."""
        plan, n_lane = self.plan, self.out.shape[2]
        shares = np.bincount(plan.order, weights=step, minlength=len(plan.width)) / plan.width
        by_lane = np.bincount(plan.moved, weights=shares, minlength=n_lane)
        by_lane -= np.bincount(plan.still, weights=shares, minlength=n_lane)
        shift = (self.out.reshape(-1, n_lane) @ by_lane).reshape(self.out.shape[:2])
        return Sensitivity(self.out, plan, shift if self.shift is None else self.shift + shift)


class TrajectoryModel:
    """Predicts recordings of one leg for given unknowns; stores the constant part of each trial's lane."""

    def __init__(
        self,
        chain: Chain,
        leg: Leg,
        unknowns: Unknowns,
        tolerance: float = FIT_TOLERANCE,
        max_steps: int = FIT_STEPS,
    ) -> None:
        self.chain, self.leg, self.unknowns = chain, leg, unknowns
        self.tolerance, self.max_steps = tolerance, max_steps
        self._base: dict[Conditions, Array] = {}
        self._plans: dict[tuple[tuple[int, ...], float], LanePlan] = {}

    def at_tolerance(self, tolerance: float, max_steps: int | None = None) -> TrajectoryModel:
        """The same, integrated to another relative tolerance, and in at most so many steps if given."""
        other = TrajectoryModel(self.chain, self.leg, self.unknowns, tolerance, max_steps or self.max_steps)
        other._base, other._plans = self._base, self._plans  # neither depends on it
        return other

    def shifted(self, recording: Recording) -> list[int]:
        """Joints whose rest angle may shift in this trial: free, with the rest angle among the unknowns."""
        rests = self.unknowns.rest_index
        return [j for j in recording.free if rests[j] is not None]

    def sensitivity(self, recording: Recording, values: Array, local: Local) -> Sensitivity:
        """One trial's lanes: nominal, and each unknown and each component of the state perturbed."""
        key = recording.conditions.locked, recording.unit
        if key not in self._plans:
            rests = [self.unknowns.rest_index[j] for j in self.shifted(recording)]
            places = [k for k in rests if k is not None]
            self._plans[key] = LanePlan.of(self.chain.layout.n, len(values), recording.free, places, recording.unit)
        plan = self._plans[key]
        common = values[:, None] + plan.common
        state = np.concatenate([local.rotation, local.rate])[:, None] + plan.state
        return Sensitivity(self.run(recording, common, state, local.shift[:, None]), plan)

    def predictions(self, recording: Recording, values: Array, local: Local, shifts: Array) -> Array:
        """(m, n, n_column) rad for columns of unknowns (n_unknown, n_column) and of rest shifts (n, n_column).

        Columns share their steps; if one diverges, all are simulated alone.
        """
        state = np.repeat(np.concatenate([local.rotation, local.rate])[:, None], values.shape[1], axis=1)
        out = self.run(recording, values, state, shifts)
        if values.shape[1] > 1 and not np.all(np.isfinite(out[-1])):
            alone = [slice(k, k + 1) for k in range(values.shape[1])]
            runs = [self.run(recording, values[:, k], state[:, k], shifts[:, k]) for k in alone]
            out = np.concatenate(runs, axis=2)
        return out

    def run(self, recording: Recording, values: Array, state: Array, shift: Array) -> Array:
        """(m, n, n_lane) rad, nan if a motion diverged; lanes share their steps in groups of sixteen.

        Parameters
        ----------
        values : (n_unknown, n_lane).
        state : (2 n, n_lane) rad and rad/s, rotations and rates at the start.
        shift : (n, n_lane) or (n, 1) rad of the rests.
        """
        lanes = np.repeat(self._lane(recording.conditions)[:, None], values.shape[1], axis=1)
        return self.run_lanes(recording, lanes, values, state, shift)

    def run_lanes(
        self,
        recording: Recording,
        lanes: Array,
        values: Array,
        state: Array,
        shift: Array,
        max_steps: int | None = None,
    ) -> Array:
        """Like ``run``, for ``lanes`` (n_row, n_lane) of legs whose links may differ; the array is modified."""
        layout = self.chain.layout
        self.unknowns.write(lanes, values)
        lanes[layout.rows("rest")] += shift
        lanes[layout.rows("rotation")], lanes[layout.rows("rate")] = state[: layout.n], state[layout.n :]
        return self.chain.run(
            lanes,
            recording.time,
            self.tolerance,
            known_torque=recording.known_torque,
            signals=recording.signals,
            max_steps=max_steps or self.max_steps,
            unit=recording.unit,
        )

    def before(self, recording: Recording, values: Array, local: Local, times: Array) -> Array:
        """(k, n) rad, the free motion ``times`` (k,) s before a recording's start, rising from 0; nan if it diverges.

        With time reversed rates change their sign and dampers drive. Of a leg with springs and linear dampers only.
        """
        layout, lanes = self.chain.layout, self._lane(recording.conditions)[:, None].copy()
        self.unknowns.write(lanes, values[:, None])
        lanes[layout.rows("damper_rate")] *= -1.0
        lanes[layout.rows("rest")] += local.shift[:, None]
        lanes[layout.rows("rotation")], lanes[layout.rows("rate")] = local.rotation[:, None], -local.rate[:, None]
        found = self.chain.run(lanes, times, self.tolerance, max_steps=self.max_steps, unit=recording.unit)
        return np.asarray(found[:, :, 0])

    def evaluate(self, recording: Recording, values: Array, local: Local, *, jacobian: bool = True) -> Evaluation:
        """Prediction of one trial, with Jacobians if requested; nan if the motion diverged."""
        if not jacobian:
            return Evaluation(self.predictions(recording, values[:, None], local, local.shift[:, None])[:, :, 0])
        found = self.sensitivity(recording, values, local)
        full = (found.differences() / found.plan.width)[:, :, found.plan.order]
        return Evaluation(found.prediction, full[:, :, : len(values)], full[:, :, len(values) :])

    def evaluate_all(
        self, recordings: Sequence[Recording], values: Array, locals_: Sequence[Local], *, jacobian: bool = True
    ) -> list[Evaluation]:
        """``evaluate`` for every trial, on all cores."""

        def one(t: int) -> Evaluation:
            return self.evaluate(recordings[t], values, locals_[t], jacobian=jacobian)

        return shared_out(one, len(recordings))

    def _lane(self, conditions: Conditions) -> Array:
        if conditions not in self._base:
            self._base[conditions] = self.chain.parameters(self.leg, conditions)
        return self._base[conditions]

    def step_local(self, recording: Recording, local: Local, step: Array) -> Local:
        """A trial's own unknowns after a step in the order of ``Evaluation.local``."""
        free, shifted = recording.free, self.shifted(recording)
        rotation, rate, shift = local.rotation.copy(), local.rate.copy(), local.shift.copy()
        rotation[free] += step[: len(free)]
        rate[free] += step[len(free) : 2 * len(free)]
        shift[shifted] += step[2 * len(free) :]
        return Local(rotation, rate, shift)

"""The gap: the residual after the leg without causes is fitted, in the generator's engine, within its tolerances.

The fit is Gauss-Newton with a finite-difference Jacobian at the true leg, which is not updated because parameters move
only by their tolerances. Against an updated Jacobian this changes a gap of 12 noise floors by 1-5 %. Each parameter has
a normal prior as wide as its tolerance, bounded at ``setup.WORST_TOLERANCES`` tolerances from the design: with ten
thousand samples an unbounded normal prior lets a mass move by fifty tolerances. The initial angle and speed of each
free joint and trial have no prior. A fit with a further parameter released tests whether another cause explains the gap
as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from synth.planting.model import ROWS, Array, PlantedLeg
from synth.planting.setup import WORST_TOLERANCES, Setup
from synth.planting.simulation import Motion, swing

Places = NDArray[np.integer[Any]]
SAMPLES_A_TRIAL = 160  # per trial and joint; each sample used is weighted for those left out
PARAMETER_UNITS = {"tilt": 0.01, "scale": 0.01, "offset": 0.01, "latency": 0.001}  # rad, 1, rad, s

# rad, 1, s: largest plausible values; beyond these the rig would be a different one.
LARGEST_PLAUSIBLE = {"tilt": 0.3, "scale": 0.3, "offset": 0.3, "latency": 0.1, "free_angle": 0.5}


@dataclass(frozen=True)
class Alternative:
    """Another cause: its effect and joint, and the indices ``freed`` of the parameters without prior that model it."""

    effect: str
    joint: int  # -1 for the base
    freed: tuple[int, ...]


@dataclass(frozen=True)
class PlainFit:
    """Result of a fit.

    ``change`` : (p,) of the parameters, in tolerances or in ``PARAMETER_UNITS``. ``rms`` : residual, rad. ``cost`` :
    chi-squared plus prior.
    """

    change: Array
    rms: float
    cost: float


class PlainModel:
    """The leg of one case without causes, linearised once, and fits with that Jacobian.

    Parameters: the leg's (7 n, in units of their tolerance), then tilt of the mount, then scale, offset and latency of
    each channel. The last two groups are zero unless an ``Alternative`` frees them.
    """

    def __init__(self, case: Setup, floor: float, states: Sequence[Array]) -> None:
        self.case, self.floor, self.trials = case, floor, case.trials
        n = case.true.n
        # Half of the fastest time constant, within what the engine takes.
        self.step = float(np.clip(0.5 / case.settle, 1e-4, 2.5e-3))
        self.names = [(name, j) for name in case.true.rows for j in range(n)]
        self.common_count = len(self.names)
        self.names += [("tilt", -1), *((kind, j) for kind in ("scale", "offset", "latency") for j in range(n))]
        self.times = [self._times(i) for i in range(len(self.trials))]
        counts = [self._sample_count(i) / len(x) for i, x in enumerate(self.times)]
        self.weight = np.sqrt(counts)
        self.given = [i for i, t in enumerate(self.trials) if not t.held_out]
        self.centre = np.zeros(len(self.names))  # of the prior: the nominal leg
        for k, (name, j) in enumerate(self.names[: self.common_count]):
            self.centre[k] = float(case.nominal.of(name)[j] - case.true.of(name)[j]) / self._unit(name, j)
        self.common: dict[int, Array] = {}
        self.own: list[tuple[Array, Array]] = []
        self._columns(states)

    def _sample_count(self, number: int) -> float:
        """Number of recorded samples of a trial, which the samples used represent."""
        own = self.case.own_times
        return self.trials[number].duration * self.case.sampling if own is None else float(len(own[number]))

    def _times(self, number: int) -> Array:
        times = self.case.times(number)
        return times[:: max(1, len(times) // SAMPLES_A_TRIAL)]

    def _unit(self, name: str, joint: int) -> float:
        if name in PARAMETER_UNITS:
            return PARAMETER_UNITS[name]
        return self.case.width(name, joint)

    def lower_noise(self, floor: float) -> None:
        """Rescale the Jacobian to a lower noise floor, rad."""
        ratio = self.floor / floor
        self.common = {i: c * ratio for i, c in self.common.items()}
        self.own = [(q, r * ratio) for q, r in self.own]
        self.floor = floor

    def free(self, number: int) -> list[int]:
        """Joints that move in a trial."""
        return [j for j in range(self.case.true.n) if j not in self.trials[number].locked]

    def _leg(self, change: Array) -> PlantedLeg:
        true = self.case.true
        values = true.values.copy()
        for k in np.flatnonzero(change[: self.common_count]):
            name, j = self.names[k]
            values[ROWS.index(name), j] += change[k] * self._unit(name, j)
        return true.with_values(values)

    def _motion(self, number: int, change: Array, state: Array) -> Motion:
        n = self.case.true.n
        tilt = change[self.common_count] * PARAMETER_UNITS["tilt"]
        return swing(self._leg(change), self.trials[number], state[:n], state[n:], self.step, tilt)

    def predict(self, number: int, change: Array, state: Array) -> Array:
        """Rotations (m, n) rad as the sensors read them, for the initial ``state`` (2 n,): angles, then speeds.

        Raises
        ------
        ArithmeticError : the motion diverges.
        """
        n, leg = self.case.true.n, self.case.true
        motion, times = self._motion(number, change, state), self.times[number]
        angle = motion.at(times)
        scale, offset, latency = change[self.common_count + 1 :].reshape(3, n)
        for j in np.flatnonzero(latency).tolist():
            late = times - latency[j] * PARAMETER_UNITS["latency"]
            angle[:, j] = motion.joint(j, late)
        angle = (
            angle
            + PARAMETER_UNITS["scale"] * scale * (angle + leg.sign * leg.zero)
            + PARAMETER_UNITS["offset"] * offset
        )
        return np.asarray(angle)

    def _columns(self, states: Sequence[Array]) -> None:
        """The Jacobian at the true leg: by common parameters for the given trials, by the initial state for all."""
        n, p = self.case.true.n, len(self.names)
        self.common, self.own = {}, []
        zero = np.zeros(p)
        for i, state in enumerate(states):
            motion = self._motion(i, zero, state)
            free, here = self.free(i), motion.at(self.times[i])
            size = self.weight[i] / self.floor

            def column(there: Array, free: list[int] = free, here: Array = here) -> Array:
                return np.asarray((there - here)[:, free].ravel())

            own = np.empty((here[:, free].size, 2 * len(free)))
            for c, j in enumerate([*free, *(n + f for f in free)]):
                moved, by = state.copy(), 1e-4 if j < n else 1e-3
                moved[j] += by
                own[:, c] = column(self._motion(i, zero, moved).at(self.times[i])) / by
            self.own.append(tuple(np.linalg.qr(own * size)))  # type: ignore[arg-type]
            if self.trials[i].held_out:
                continue
            common = np.empty((len(own), p))
            for c, (name, j) in enumerate(self.names):
                there = here.copy()
                if name == "scale":
                    there[:, j] += PARAMETER_UNITS["scale"] * (
                        here[:, j] + self.case.true.sign[j] * self.case.true.zero[j]
                    )
                elif name == "offset":
                    there[:, j] += PARAMETER_UNITS["offset"]
                elif name == "latency":
                    speed = Motion(motion.step, motion.speed, np.gradient(motion.speed, motion.step, axis=0))
                    there[:, j] -= PARAMETER_UNITS["latency"] * speed.joint(j, self.times[i])
                else:
                    there = self._motion(i, zero + 0.2 * (np.arange(p) == c), state).at(self.times[i])
                    there = here + (there - here) / 0.2
                common[:, c] = column(there)
            self.common[i] = common * size

    def fit(
        self, targets: Sequence[Array], states: Sequence[Array], freed: Sequence[int] = (), rounds: int = 6
    ) -> PlainFit:
        """Fit the target rotations of the given trials from the initial ``states``; ``freed`` parameters have no prior.

        At most ``rounds`` Gauss-Newton steps; a step that does not lower the cost shortens the next ones to 0.3.
        """
        used = np.array(sorted({*range(self.common_count), *freed}))
        weak = np.array([1e-3 if k in freed else 1.0 for k in used])  # root of the prior's weight
        change, state = np.zeros(len(self.names)), {i: np.array(states[i]) for i in self.given}
        reduced = {i: self.common[i][:, used] - q @ (q.T @ self.common[i][:, used]) for i, q in self._bases()}
        normal = sum(r.T @ r for r in reduced.values()) + np.diag(weak**2)
        best = self._evaluated(targets, change, state, used, weak)
        assert best is not None, "the true leg can be simulated"
        share = 1.0
        for _ in range(rounds):
            fitted, left = best
            pull = weak**2 * (self.centre - fitted.change)[used]
            slope = sum(reduced[i].T @ left[i] for i in self.given) + pull
            step = share * self._bounded(normal, slope, fitted.change, used, freed)
            moved, ahead = fitted.change.copy(), {i: s.copy() for i, s in state.items()}
            moved[used] += step
            for i in self.given:
                self._step_state(i, ahead[i], share * left[i] - self.common[i][:, used] @ step)
            found = self._evaluated(targets, moved, ahead, used, weak)
            if found is None or found[0].cost >= fitted.cost:
                share *= 0.3
                continue
            best, state = found, ahead
            if found[0].cost > 0.998 * fitted.cost and share == 1.0:  # a gain of 0.2 % ends the search
                break
        return best[0]

    def _evaluated(
        self, targets: Sequence[Array], change: Array, state: dict[int, Array], used: Places, weak: Array
    ) -> tuple[PlainFit, dict[int, Array]] | None:
        """Summary and residuals at these parameters and states; None if the leg cannot be simulated."""
        try:
            left = {i: self._residuals(i, targets[i], change, state[i]) for i in self.given}
        except (ArithmeticError, np.linalg.LinAlgError):
            return None
        return self._summary(change, left, (change - self.centre)[used] * weak), left

    def linear_costs(
        self, targets: Sequence[Array], states: Sequence[Array], freed: Sequence[Sequence[int]]
    ) -> list[float]:
        """The cost that ``fit`` would reach with each set of ``freed`` parameters, if the motion were linear in them.

        One simulation per trial for all, and one solve for each.
        """
        zero, bases = np.zeros(len(self.names)), dict(self._bases())
        left = {i: self._residuals(i, targets[i], zero, states[i]) for i in self.given}
        ends = [left[i] - q @ (q.T @ left[i]) for i, q in bases.items()]
        projected = [self.common[i] - q @ (q.T @ self.common[i]) for i, q in bases.items()]
        costs = []
        for own in freed:
            used = np.array(sorted({*range(self.common_count), *own}))
            weak = np.array([1e-3 if k in own else 1.0 for k in used])
            columns = np.concatenate([*(part[:, used] for part in projected), np.diag(weak)])
            right = np.concatenate([*ends, weak * self.centre[used]])
            solution = self._bounded(columns.T @ columns, columns.T @ right, zero, used, own)
            costs.append(float(((right - columns @ solution) ** 2).sum()))
        return costs

    def explained(self, targets: Sequence[Array], other: Sequence[Array], states: Sequence[Array]) -> float:
        """RMS residual, in noise floors, of the targets after a fit of the tolerances and of another cause's motion.

        Linear: the other cause's motion ``other`` minus the motion without causes from the same ``states`` is one
        further column of the Jacobian.
        """
        zero, used = np.zeros(len(self.names)), np.arange(self.common_count + 1)
        rows, ends, count = [], [], 0.0
        for i, q in self._bases():
            wanted, theirs = (self._residuals(i, t[i], zero, states[i]) for t in (targets, other))
            block = np.column_stack([self.common[i][:, : self.common_count], theirs])
            rows.append(block - q @ (q.T @ block))
            ends.append(wanted - q @ (q.T @ wanted))
            count += float(self.weight[i] ** 2) * wanted.size
        weak = np.append(np.ones(self.common_count), 1e-3)
        centre = np.append(self.centre[: self.common_count], 0.0)
        columns, right = np.concatenate([*rows, np.diag(weak)]), np.concatenate([*ends, weak * centre])
        solution = self._bounded(columns.T @ columns, columns.T @ right, zero, used, [])
        rest = (right - columns @ solution)[: len(right) - len(weak)]
        return float(np.sqrt(rest @ rest / count))

    def _bounded(self, normal: Array, slope: Array, change: Array, used: Places, freed: Sequence[int]) -> Array:
        """The step that minimises step' normal step / 2 - slope' step within ``WORST_TOLERANCES`` tolerances; freed:
        unbounded.
        """
        half = np.linalg.cholesky(normal)
        reach = np.array([1e6 if k in freed or k >= self.common_count else WORST_TOLERANCES for k in used])
        low = np.minimum((self.centre - change)[used] - reach, -1e-12)
        high = np.maximum((self.centre - change)[used] + reach, 1e-12)
        return np.asarray(lsq_linear(half.T, np.linalg.solve(half, slope), (low, high), method="bvls").x)

    def held_out(self, targets: Sequence[Array], states: Sequence[Array], change: Array) -> float:
        """RMS residual, rad, of the held-out trials with these parameters and their initial states fitted."""
        left, numbers = {}, [i for i in range(len(self.trials)) if i not in self.given]
        for i in numbers:
            state, last = np.array(states[i]), np.inf
            for _ in range(6):
                rest = self._residuals(i, targets[i], change, state)
                square = float(rest @ rest)
                if square > 0.999 * last:  # a gain of 0.1 % ends the search
                    break
                last = square
                left[i] = rest
                self._step_state(i, state, rest)
        return self._summary(change, left, np.zeros(1)).rms

    def _bases(self) -> list[tuple[int, Array]]:
        return [(i, self.own[i][0]) for i in self.given]

    def _residuals(self, i: int, target: Array, change: Array, state: Array) -> Array:
        """Residuals of the moving joints in noise floors, weighted for the samples left out."""
        rest = (target - self.predict(i, change, state))[:, self.free(i)].ravel()
        return np.asarray(rest * self.weight[i] / self.floor)

    def _step_state(self, i: int, state: Array, rest: Array) -> None:
        q, r = self.own[i]
        free = self.free(i)
        state[[*free, *(self.case.true.n + f for f in free)]] += np.linalg.solve(r, q.T @ rest)

    def _summary(self, change: Array, left: dict[int, Array], prior: Array) -> PlainFit:
        square = sum(float(e @ e) for e in left.values())
        count = sum(float(self.weight[i] ** 2) * e.size for i, e in left.items())
        return PlainFit(change.copy(), float(np.sqrt(square / count)) * self.floor, square + float(prior @ prior))

    def plausible(self, other: Alternative, change: Array) -> bool:
        """Whether the fitted values are physically plausible: no negative delay, no number off by more than 60 %."""
        for k in other.freed:
            name, j = self.names[k]
            value = change[k] * self._unit(name, j)
            if name == "latency" and value < 0.0:
                return False
            limit = LARGEST_PLAUSIBLE.get(name)
            if limit is None:
                limit = 0.6 * float(self.case.true.of(name)[j])
            if abs(value) > limit:
                return False
        return True

    def alternatives(self) -> list[Alternative]:
        """Causes that are only an error of a parameter or a sensor, so that the fit can test them without a law."""
        n, index = self.case.true.n, {name: k for k, name in enumerate(self.names)}
        found = [Alternative("base_tilt", -1, (index["tilt", -1],))]
        for j in range(n):
            found += [
                Alternative("spring_preload", j, (index["free_angle", j],)),
                Alternative("link_mass", j, (index["mass", j], index["inertia", j])),
                Alternative("link_inertia", j, (index["com", j], index["inertia", j])),
                Alternative("encoder_offset", j, (index["offset", j],)),
                Alternative("encoder_scale", j, (index["scale", j],)),
            ]
            if n > 1:
                found.append(Alternative("latency", j, (index["latency", j],)))
        return found

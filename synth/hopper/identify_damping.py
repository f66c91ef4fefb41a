"""Experiment C: one joint damping from inverted pull-ups of legs of several lengths.

The foot is held overhead, the body hangs from it, and the motors fold the leg. With rigid links one angle a is
sufficient; with the distance y(a) from foot to hips, the links' masses, springs and the recorded torque tau of one
motor,

    d/dt (M a') - M' a'^2 / 2 + V' = 2 tau - b D a'

(Lagrange; V holds gravity, which pulls the body away from the foot, and the flexures; M, V and D are those of
``fold``). ``least_squares``: weak form, one column, no simulation; windows in which the leg touches its stop, whose
torque the equation lacks, are left out. ``genetic``: differential evolution (Storn & Price, J. Global Optimization 11
(1997)) on simulated against recorded angles, the study's kind of search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.estimation.correlation import correlation_factors_by_step
from synth.files.hopper_recordings import HopperRecording, PullUps
from synth.hopper.fold import first_state, fold, leg_parameters, mechanics
from synth.hopper.identify_motor import SURE_DEVIATIONS, IdentifiedConstant
from synth.hopper.odd_recording import refuse_odd
from synth.hopper.windows import OVERLAP, windows
from synth.jump.hopper_leg import HopperLeg

WIDTH = 0.15  # s, width of a window
LARGEST = 0.05  # N m s/rad, upper bound of the genetic search
AT_BOUND = 0.99  # share of it from which a search has ended at the bound: its populations end within 1 % of it
UNEXPLAINED = 0.5  # share of the torque above which the design does not match; 1 % remains with MuJoCo's recordings
GRID = 2001  # points of the tables over a


@dataclass(frozen=True, eq=False)
class FoldingMechanics:
    """The leg's mechanics over its angle a: tables on ``angle`` (n,) rad of M, M', V', D and the integrals of M, D.

    ``extended`` : rad, at and below which the leg is on its stop.
    """

    angle: Array
    inertia: Array
    inertia_slope: Array
    force: Array
    joints: Array
    momentum: Array
    travel: Array
    extended: float

    def at(self, name: str, angle: Array) -> Array:
        """A table's values at angles of any shape."""
        return np.asarray(np.interp(angle, self.angle, getattr(self, name)))


@dataclass(frozen=True)
class DampingEstimate:
    """Damping of one joint, N m s/rad; for each length (m); ``angle_error`` rad: simulated minus recorded, RMS.

    ``windows`` : of the weak form, those at the leg's stop excluded, of which there are ``windows_at_stop``.
    """

    damping: IdentifiedConstant
    by_length: dict[float, IdentifiedConstant]
    angle_error: float
    method: str
    windows: int
    windows_at_stop: int


def folding_mechanics(leg: HopperLeg, body_mass: float) -> FoldingMechanics:
    """Tables for one length, from nearly straight to the locking of the lower links."""
    a = np.linspace(0.01, 0.995 * leg.largest_crouch, GRID)
    inertia, slope, force, joints = mechanics(a, leg_parameters(leg, body_mass, np.zeros(1))[:, 0])

    def summed(values: Array) -> Array:
        return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(a))])

    return FoldingMechanics(a, inertia, slope, force, joints, summed(inertia), summed(joints), leg.extended)


def identify_damping(project: PullUps) -> DampingEstimate:
    """One damping for all lengths, and each length's, both by the project's method.

    Recordings are refused by the weak form, whatever the method: it takes milliseconds.

    Raises
    ------
    UserError : a recording leaves the range in which its leg can fold, or nothing moves.
    """
    tables = [_table(project, trial) for trial in project.trials]
    rows = [_windows(table, trial) for table, trial in zip(tables, project.trials, strict=True)]
    _refuse_odd_pull_up(project.trials, rows)
    _refuse_no_leg(project.trials, _damping_by_rows(np.vstack(rows), "the legs"), np.vstack(rows))

    def estimate(trials: Sequence[HopperRecording], legs: str) -> IdentifiedConstant:
        if project.method == "genetic":
            return _genetic(replace(project, trials=tuple(trials)))
        chosen = [part for part, trial in zip(rows, project.trials, strict=True) if trial in trials]
        return _damping_by_rows(np.vstack(chosen), legs)

    found = estimate(project.trials, "the legs")
    lengths = sorted({trial.length for trial in project.trials if trial.length is not None})
    by_length = {
        length: estimate([trial for trial in project.trials if trial.length == length], f"links of {length * 1e3:g} mm")
        for length in lengths
    }
    errors = [simulate_fold(project, trial, np.array([found.value]))[:, 0] - trial["upper link"]
              for trial in project.trials]  # fmt: skip
    error = float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
    used = sum(len(part) for part in rows)
    count = sum(len(list(windows(trial["time"], WIDTH))) for trial in project.trials)
    return DampingEstimate(found, by_length, error, project.method, used, count - used)


def _refuse_odd_pull_up(trials: Sequence[HopperRecording], rows: Sequence[Array]) -> None:
    """Refuse a pull-up whose torque is poorly explained by the damping of all others."""

    def missed(index: int) -> tuple[float, float] | None:
        others = [part for k, part in enumerate(rows) if k != index and len(part)]
        if not others or not len(rows[index]):
            return None
        try:
            damping = _damping_by_rows(np.vstack(others), "the legs").value
        except UserError:
            return None
        return _unexplained_share(damping, rows[index]), max(_unexplained_share(damping, part) for part in others)

    refuse_odd([trial.name for trial in trials], missed, "torque")


def _unexplained_share(damping: float, rows: Array) -> float:
    """Share of the motors' torque not explained by the leg's mechanics with this damping (root mean square)."""
    left = rows[:, 1] - damping * rows[:, 0]
    return float(np.sqrt(np.mean(left**2) / max(float(np.mean(rows[:, 2] ** 2)), 1e-300)))


def _refuse_no_leg(trials: Sequence[HopperRecording], found: IdentifiedConstant, rows: Array) -> None:
    """Refuse pull-ups whose torque the leg's mechanics do not explain, and a negative damping."""
    names = ", ".join(trial.name for trial in trials[:5]) + (" and others" if len(trials) > 5 else "")
    left = _unexplained_share(found.value, rows)
    if left > UNEXPLAINED:
        text = f"the designed leg leaves {left:.0%} of the torque unexplained for any damping"
    elif found.value < -SURE_DEVIATIONS * found.deviation:
        text = f"no leg has a joint damping of {found.value:.2g} N*m*s/rad"
    else:
        return
    text += ". Are columns exchanged, or of the wrong sign? Angle and torque of the upper link are positive outward"
    raise UserError(Problem(f"{names}: {text}"))


def _leg(project: PullUps, trial: HopperRecording) -> HopperLeg:
    assert trial.length is not None
    return project.design.leg.with_length(trial.length)


def _table(project: PullUps, trial: HopperRecording) -> FoldingMechanics:
    leg, angle = _leg(project, trial), trial["upper link"]
    # 0.02 rad (1.2 deg) to 99 % of the locking angle: within the tables of ``folding_mechanics``.
    if angle.min() < 0.02 or angle.max() > 0.99 * leg.largest_crouch:
        text = (
            f"the angle runs from {np.degrees(angle.min()):.1f} to {np.degrees(angle.max()):.1f} deg; links of "
            f"{leg.length * 1e3:g} mm fold from 1.2 to {np.degrees(0.99 * leg.largest_crouch):.1f} deg"
        )
        raise UserError(Problem(text, trial.name, key="upper link"))
    return folding_mechanics(leg, project.body_mass)


def _windows(table: FoldingMechanics, trial: HopperRecording) -> Array:
    """(n, 3): joint travel against bumps, all other torques (their ratio is the damping), and the motors' torque.

    Of the windows in which the leg does not touch its stop.
    """
    time, angle, torque = trial["time"], trial["upper link"], trial["hip torque"]
    rate = _rate(time, angle)
    momentum, travel = table.at("momentum", angle), table.at("travel", angle)
    other = 2.0 * torque - table.at("force", angle) + 0.5 * table.at("inertia_slope", angle) * rate**2
    rows = []
    for window in windows(time, WIDTH):
        inside, t, u = window.inside, window.time, window.place
        if angle[inside].min() <= table.extended:
            continue
        psi = (1.0 - u**2) ** 4
        first = -8.0 * u * (1.0 - u**2) ** 3 * (2.0 / WIDTH)
        second = (-8.0 * (1.0 - u**2) ** 3 + 48.0 * u**2 * (1.0 - u**2) ** 2) * (2.0 / WIDTH) ** 2
        moved = -np.trapezoid(travel[inside] * first, t)
        left = np.trapezoid(other[inside] * psi, t) - np.trapezoid(momentum[inside] * second, t)
        rows.append([moved, left, np.trapezoid(2.0 * torque[inside] * psi, t)])
    return np.array(rows).reshape(-1, 3)


def _rate(time: Array, angle: Array, width: float = 0.02) -> Array:
    """Angle's rate by local straight lines of that width (s), used only for the small centrifugal term."""
    reach = max(2, round(float(width / np.median(np.diff(time)) / 2)))
    rate = np.empty_like(angle)
    for i in range(len(angle)):
        part = slice(max(0, i - reach), i + reach + 1)
        t = time[part] - time[part].mean()
        rate[i] = float(t @ (angle[part] - angle[part].mean()) / (t @ t))
    return rate


def _damping_by_rows(rows: Array, legs: str) -> IdentifiedConstant:
    """From the rows of ``_windows``; ``legs`` : whose they are, for the message.

    Raises
    ------
    UserError : the legs do not move away from their stop.
    """
    moved, other = rows[:, 0], rows[:, 1]
    power = float(moved @ moved)
    if power == 0.0 or len(rows) < 4:
        text = f"{legs} hardly move in these recordings, or only on the leg's stop (leg: extended)"
        raise UserError(Problem(f"{text}; these do not show their damping. Pull up further, or longer"))
    value = float(moved @ other) / power
    left = other - value * moved
    return IdentifiedConstant(value, float(np.sqrt(left @ left / max(1, len(rows) - 1) * OVERLAP / power)))


def simulate_fold(project: PullUps, trial: HopperRecording, damping: Array) -> Array:
    """(n_time, n) rad: the angle under the recorded torque for dampings (n,), from the recorded start."""
    time = trial["time"]
    level, slope = first_state(time, trial["upper link"])
    parameters = leg_parameters(_leg(project, trial), project.body_mass, damping)
    start, rate = np.full_like(damping, level), np.full_like(damping, slope)
    return fold(parameters, time, trial["hip torque"], start, rate)


def _genetic(project: PullUps) -> IdentifiedConstant:
    """Differential evolution over the logarithm of the damping, simulated angles against recorded ones.

    Raises
    ------
    UserError : the damping found is the search's largest.
    """
    from scipy.optimize import Bounds, differential_evolution

    def cost(points: Any, /) -> Any:
        damping = np.exp(np.atleast_2d(points)[0])
        total = np.zeros_like(damping)
        for trial in project.trials:
            error = np.abs(simulate_fold(project, trial, damping) - trial["upper link"][:, None])
            # At most 1 rad, also where a damping is too large for the steps of ``fold`` and its simulation diverges.
            total += np.mean(np.where(error < 1.0, error, 1.0) ** 2, axis=0)
        return total

    bounds = Bounds(np.log([1e-6]), np.log([LARGEST]))
    found = differential_evolution(
        cost, bounds, rng=project.seed, popsize=16, maxiter=40, tol=1e-6, vectorized=True, updating="deferred",
        polish=False,
    )  # fmt: skip
    value = float(np.exp(found.x[0]))
    if value > AT_BOUND * LARGEST:
        text = f"the genetic search ends at its largest joint damping, {LARGEST:g} N*m*s/rad; use method: least_squares"
        raise UserError(Problem(text, key="method"))
    return IdentifiedConstant(value, _deviation(project, value))


def _deviation(project: PullUps, damping: float) -> float:
    """Standard deviation of the damping that simulated angles follow best, their errors being correlated in time.

    The sandwich of the sensitivities' power and the scores' variance (Huber 1967).
    """
    step = 1e-3 * damping
    scores, steps, power = [], [], 0.0
    for trial in project.trials:
        below, here, above = simulate_fold(project, trial, damping + np.array([-step, 0.0, step])).T
        slope = (above - below) / (2.0 * step)
        power += float(slope @ slope)
        scores.append((slope * (here - trial["upper link"]))[:, None])
        steps.append(float(np.median(np.diff(trial["time"]))))
    factors = correlation_factors_by_step(scores, steps)[:, 0]
    variance = sum(factor * float(np.sum(score**2)) for factor, score in zip(factors, scores, strict=True))
    return float(np.sqrt(variance)) / power

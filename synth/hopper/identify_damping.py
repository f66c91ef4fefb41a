"""Experiment C: one joint damping from inverted pull-ups of legs of several lengths.

The foot is held overhead, the body hangs from it, and the motors fold the leg. With rigid links one angle a is
sufficient; with the distance y(a) from foot to hips, the links' masses, springs and the recorded torque tau of one
motor,

    d/dt (M a') - M' a'^2 / 2 + V' = 2 tau - b D a',   D = 2 + 2 (1 + db/da)^2 + (2 db/da)^2

(Lagrange; V holds gravity, which pulls the body away from the foot, and the flexures; D sums the squared rates of the
five joints). ``least_squares``: weak form, one column, no simulation. ``genetic``: differential evolution (Storn &
Price, J. Global Optimization 11 (1997)) on simulated against recorded angles, the study's kind of search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import HopperRecording, PullUps
from synth.hopper.identify_motor import SURE, IdentifiedConstant
from synth.hopper.odd_recording import refuse_odd
from synth.hopper.windows import OVERLAP, windows
from synth.jump.hopper_leg import HopperLeg

WIDTH = 0.15  # s, width of a window
LARGEST = 0.05  # N m s/rad, upper bound of the genetic search
UNEXPLAINED = 0.5  # share of the torque above which the design does not match; 1 % remains with MuJoCo's recordings
FASTEST = 300.0  # rad/s; keeps a diverging guess finite
GRID = 2001  # points of the tables over a


@dataclass(frozen=True, eq=False)
class Folding:
    """The leg's mechanics over its angle a: tables on ``angle`` (n,) rad of M, M', V', D and the integrals of M, D."""

    angle: Array
    inertia: Array
    inertia_slope: Array
    force: Array
    joints: Array
    momentum: Array
    travel: Array

    def at(self, name: str, angle: Array) -> Array:
        """A table's values at angles of any shape."""
        return np.asarray(np.interp(angle, self.angle, getattr(self, name)))


@dataclass(frozen=True)
class DampingEstimate:
    """Damping of one joint, N m s/rad; for each length (m); ``angle_error`` rad: simulated minus recorded, RMS."""

    damping: IdentifiedConstant
    by_length: dict[float, IdentifiedConstant]
    angle_error: float
    method: str


def folding(leg: HopperLeg, body_mass: float) -> Folding:
    """Tables for one length, from nearly straight to the locking of the lower links."""
    a = np.linspace(0.01, 0.995 * leg.largest_crouch, GRID)
    length, lower, half = leg.length, leg.lower_length, 0.5 * leg.hip_spacing
    b = np.arcsin((half + length * np.sin(a)) / lower)
    db = length * np.cos(a) / (lower * np.cos(b))
    m_upper, m_lower = leg.link_mass
    dy = -length * np.sin(a) - lower * np.sin(b) * db
    upper_dy = -0.5 * length * np.sin(a) - lower * np.sin(b) * db
    upper_dx = 0.5 * length * np.cos(a)
    inertia = body_mass * dy**2
    inertia += 2 * m_upper * (upper_dy**2 + upper_dx**2 + length**2 / 12)
    inertia += 2 * m_lower * lower**2 / 3 * db**2
    flexures = leg.flexures
    force = -leg.gravity * (body_mass * dy + 2 * m_upper * upper_dy - m_lower * lower * np.sin(b) * db)
    force += 2 * flexures.rate * (a - flexures.hip_rest + (a + b - flexures.knee_rest) * (1 + db))
    force += flexures.rate * (2 * b - flexures.foot_rest) * 2 * db
    joints = 2.0 + 2.0 * (1 + db) ** 2 + 4.0 * db**2

    def summed(values: Array) -> Array:
        return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(a))])

    return Folding(a, inertia, np.gradient(inertia, a), force, joints, summed(inertia), summed(joints))


def identify_damping(project: PullUps) -> DampingEstimate:
    """One damping for all lengths.

    Raises
    ------
    UserError : a recording leaves the range in which its leg can fold, or nothing moves.
    """
    tables = [_table(project, trial) for trial in project.trials]
    rows = [_windows(table, trial) for table, trial in zip(tables, project.trials, strict=True)]
    _refuse_odd_pull_up(project.trials, rows)
    found = _one(np.vstack(rows))
    _refuse_no_leg(project.trials, found, np.vstack(rows))
    lengths = sorted({trial.length for trial in project.trials if trial.length is not None})
    by_length = {
        length: _one(
            np.vstack([row for row, trial in zip(rows, project.trials, strict=True) if trial.length == length])
        )
        for length in lengths
    }
    if project.method == "genetic":
        found = IdentifiedConstant(_genetic(project, tables), found.deviation)
    errors = [simulate_fold(t, trial, np.array([found.value]))[:, 0] - trial["upper link"]
              for t, trial in zip(tables, project.trials, strict=True)]  # fmt: skip
    error = float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
    return DampingEstimate(found, by_length, error, project.method)


def _refuse_odd_pull_up(trials: Sequence[HopperRecording], rows: Sequence[Array]) -> None:
    """Refuse a pull-up whose torque is poorly explained by the damping of all others."""

    def missed(index: int) -> tuple[float, float] | None:
        others = [part for k, part in enumerate(rows) if k != index and len(part)]
        if not others or not len(rows[index]):
            return None
        try:
            damping = _one(np.vstack(others)).value
        except UserError:
            return None
        return _missed(damping, rows[index]), max(_missed(damping, part) for part in others)

    refuse_odd([trial.name for trial in trials], missed, "torque")


def _missed(damping: float, rows: Array) -> float:
    """Share of the motors' torque not explained by the leg's mechanics with this damping (root mean square)."""
    left = rows[:, 1] - damping * rows[:, 0]
    return float(np.sqrt(np.mean(left**2) / max(float(np.mean(rows[:, 2] ** 2)), 1e-300)))


def _refuse_no_leg(trials: Sequence[HopperRecording], found: IdentifiedConstant, rows: Array) -> None:
    """Refuse pull-ups whose torque the leg's mechanics do not explain, and a negative damping."""
    names = ", ".join(trial.name for trial in trials[:5]) + (" and others" if len(trials) > 5 else "")
    left = _missed(found.value, rows)
    if left > UNEXPLAINED:
        text = f"the designed leg leaves {left:.0%} of the torque unexplained for any damping"
    elif found.value < -SURE * found.deviation:
        text = f"no leg has a joint damping of {found.value:.2g} N*m*s/rad"
    else:
        return
    text += ". Are columns exchanged, or of the wrong sign? Angle and torque of the upper link are positive outward"
    raise UserError(Problem(f"{names}: {text}"))


def _table(project: PullUps, trial: HopperRecording) -> Folding:
    assert trial.length is not None
    leg = project.design.leg.with_length(trial.length)
    angle = trial["upper link"]
    # 0.02 rad (1.2 deg) to 99 % of the locking angle: within the tables of ``folding``.
    if angle.min() < 0.02 or angle.max() > 0.99 * leg.largest_crouch:
        text = (
            f"the angle runs from {np.degrees(angle.min()):.1f} to {np.degrees(angle.max()):.1f} deg; links of "
            f"{trial.length * 1e3:g} mm fold from 1.2 to {np.degrees(0.99 * leg.largest_crouch):.1f} deg"
        )
        raise UserError(Problem(text, trial.name, key="upper link"))
    return folding(leg, project.body_mass)


def _windows(table: Folding, trial: HopperRecording) -> Array:
    """(n, 3): joint travel against bumps, all other torques (their ratio is the damping), and the motors' torque."""
    time, angle, torque = trial["time"], trial["upper link"], trial["hip torque"]
    rate = _rate(time, angle)
    momentum, travel = table.at("momentum", angle), table.at("travel", angle)
    other = 2.0 * torque - table.at("force", angle) + 0.5 * table.at("inertia_slope", angle) * rate**2
    rows = []
    for window in windows(time, WIDTH):
        inside, t, u = window.inside, window.time, window.place
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


def _one(rows: Array) -> IdentifiedConstant:
    moved, other = rows[:, 0], rows[:, 1]
    power = float(moved @ moved)
    if power == 0.0 or len(rows) < 4:
        raise UserError(Problem("the legs hardly move in these recordings, which therefore do not show their damping"))
    value = float(moved @ other) / power
    left = other - value * moved
    return IdentifiedConstant(value, float(np.sqrt(left @ left / max(1, len(rows) - 1) * OVERLAP / power)))


def simulate_fold(table: Folding, trial: HopperRecording, damping: Array) -> Array:
    """(n_time, n) rad: the angle under the recorded torque for several dampings, from the recorded start."""
    time, angle, torque = trial["time"], trial["upper link"], trial["hip torque"]
    first = slice(0, max(4, int(np.searchsorted(time, time[0] + 0.02))))
    slope, level = np.polyfit(time[first] - time[0], angle[first], 1)
    a, w = np.full_like(damping, level), np.full_like(damping, slope)
    out = np.empty((len(time), len(damping)))
    out[0] = a
    low, high = table.angle[0], table.angle[-1]

    def acceleration(a: Array, w: Array, tau: float) -> Array:
        a = np.clip(a, low, high)
        drive = 2.0 * tau - table.at("force", a) - damping * table.at("joints", a) * w
        return np.asarray((drive - 0.5 * table.at("inertia_slope", a) * w**2) / table.at("inertia", a))

    for k, (start, end) in enumerate(pairwise(time)):
        steps = max(1, int(np.ceil((end - start) / 1e-3)))
        h = (end - start) / steps
        for s in range(steps):
            t0, t1 = start + s * h, start + (s + 1) * h
            tau0, tau1 = (float(np.interp(t, time, torque)) for t in (t0, t1))
            middle = 0.5 * (tau0 + tau1)
            k1 = acceleration(a, w, tau0)
            k2 = acceleration(a + 0.5 * h * w, w + 0.5 * h * k1, middle)
            k3 = acceleration(a + 0.5 * h * (w + 0.5 * h * k1), w + 0.5 * h * k2, middle)
            k4 = acceleration(a + h * (w + 0.5 * h * k2), w + h * k3, tau1)
            a, w = a + h * (w + h * (k1 + k2 + k3) / 6.0), w + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6.0
            w = np.clip(w, -FASTEST, FASTEST)
        out[k + 1] = a
    return out


def _genetic(project: PullUps, tables: list[Folding]) -> float:
    """Differential evolution over the logarithm of the damping, simulated angles against recorded ones."""
    from scipy.optimize import Bounds, differential_evolution

    def cost(points: Any, /) -> Any:
        damping = np.exp(np.atleast_2d(points)[0])
        total = np.zeros_like(damping)
        for table, trial in zip(tables, project.trials, strict=True):
            error = simulate_fold(table, trial, damping) - trial["upper link"][:, None]
            total += np.mean(np.minimum(np.abs(error), 1.0) ** 2, axis=0)
        return total

    bounds = Bounds(np.log([1e-6]), np.log([LARGEST]))
    found = differential_evolution(
        cost, bounds, rng=project.seed, popsize=16, maxiter=40, tol=1e-6, vectorized=True, updating="deferred",
        polish=False,
    )  # fmt: skip
    return float(np.exp(found.x[0]))

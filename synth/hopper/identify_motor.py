"""Experiment B: a gear motor's constants from run-ups and steady running.

With speeds at the output and constants at the rotor (ratio G), equations 3, 4 and 6 of Knaup & Aukes, K_t = K_v:

    V = R i + K_v G omega + L di/dt,        K_v i = f0 sign(omega) + b G omega + J G omega'

Both are multiplied by bumps psi = (1 - u^2)^3 and integrated by parts, so nothing is differentiated: each is one linear
least squares over windows of all runs (see ``windows``). Steady running at several voltages tells R from K_v and f0
from b; the run-up tells L and J.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.windows import OVERLAP, windows

SHORT, LONG = 0.03, 0.3  # s, widths: the run-up needs short ones, steady running gains from long ones
Z90 = 1.6448536


@dataclass(frozen=True)
class Estimate:
    """A number and its standard deviation."""

    value: float
    deviation: float

    @property
    def interval90(self) -> tuple[float, float]:
        """Normal 90 % interval."""
        return self.value - Z90 * self.deviation, self.value + Z90 * self.deviation


@dataclass(frozen=True)
class MotorEstimate:
    """Constants at the rotor, SI."""

    resistance: Estimate
    inductance: Estimate
    back_emf: Estimate
    friction: Estimate
    viscous: Estimate
    rotor_inertia: Estimate
    windows: int


def identify_motor(runs: tuple[HopperRecording, ...], ratio: float) -> MotorEstimate:
    """Constants from run-ups.

    Raises
    ------
    UserError : the runs cannot tell the constants apart: one steady speed only, or no run-up.
    """
    electric, voltage, mechanic, current, scale = [], [], [], [], []
    for run in runs:
        for width in (SHORT, LONG):
            rows = _windows(run, ratio, width)
            electric.append(rows[:, 1:4])
            voltage.append(rows[:, 0])
            mechanic.append(rows[:, 4:7])
            current.append(rows[:, 1])
            scale.append(np.full(len(rows), width**-0.5))  # a bump's noise grows with the root of its width
    weight = np.concatenate(scale)
    if len(weight) < 12:
        raise UserError(Problem("the runs are too short: at least a second of run-up and steady running is needed"))
    e, sigma_e = _solve(np.vstack(electric), np.concatenate(voltage), weight, "R from K_v: vary the voltage")
    back_emf = e[1]
    right = back_emf * np.concatenate(current)
    m, sigma_m = _solve(np.vstack(mechanic), right, weight, "friction from its viscous part: vary the voltage")
    # What is unknown of K_v is unknown of every torque.
    relative = sigma_e[1] / back_emf
    spread = np.hypot(sigma_m, relative * np.abs(m))
    return MotorEstimate(
        Estimate(e[0], sigma_e[0]), Estimate(e[2], sigma_e[2]), Estimate(back_emf, sigma_e[1]),
        Estimate(m[0], spread[0]), Estimate(m[1], spread[1]), Estimate(m[2], spread[2]), len(weight),
    )  # fmt: skip


def _windows(run: HopperRecording, ratio: float, width: float) -> Array:
    """Rows of window integrals: V, i, G omega, -i (for L), sign, G omega, -G omega (for J); derivatives on the bump."""
    time, voltage, current = run["time"], run["voltage"], run["current"]
    speed = ratio * run["speed"]
    rows = []
    for window in windows(time, width):
        inside, t, u = window.inside, window.time, window.place
        psi = (1.0 - u**2) ** 3
        slope = -6.0 * u * (1.0 - u**2) ** 2 * 2.0 / width

        def integral(values: Array, t: Array = t) -> float:
            return float(np.trapezoid(values, t))

        v, i, w = voltage[inside], current[inside], speed[inside]
        rows.append([
            integral(v * psi), integral(i * psi), integral(w * psi), -integral(i * slope),
            integral(np.sign(w) * psi), integral(w * psi), -integral(w * slope),
        ])  # fmt: skip
    return np.array(rows).reshape(-1, 7)


def _solve(matrix: Array, right: Array, weight: Array, remedy: str) -> tuple[Array, Array]:
    """Weighted least squares: values, standard deviations with overlapping windows counted once."""
    a, y = matrix * weight[:, None], right * weight
    size = np.linalg.norm(a, axis=0)
    if np.any(size == 0.0) or np.linalg.cond(a / size) > 1e6:
        raise UserError(Problem(f"the runs do not tell {remedy}"))
    found, *_ = np.linalg.lstsq(a / size, y, rcond=None)
    left = y - (a / size) @ found
    variance = float(left @ left) / max(1, len(y) - 3) * OVERLAP
    covariance = np.linalg.inv((a / size).T @ (a / size)) * variance
    return found / size, np.sqrt(np.diag(covariance)) / size

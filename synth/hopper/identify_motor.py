"""Experiment B: a gear motor's constants from run-ups and steady running.

With speeds at the output and constants at the rotor (ratio G), equations 3, 4 and 6 of Knaup & Aukes, K_t = K_v:

    V = R i + K_v G omega + L di/dt,        K_v i = f0 sign(omega) + b G omega + J G omega'

First both are multiplied by bumps psi = (1 - u^2)^3 and integrated by parts, so nothing is differentiated: each is one
linear least squares over windows of all runs (see ``windows``). Steady running at several voltages separates R from
K_v and f0 from b; the run-up gives L and J. Current and speed are regressors there: their noise biases the constants.
These are the start of a fit of the simulated response, which noise does not bias (see ``fit_motor_response``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.estimation.intervals import NORMAL90
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.current_zero import CurrentZero, current_zero
from synth.hopper.fit_motor_response import INDUCTANCE, moved_by_current, standard_deviations
from synth.hopper.inductance_profile import inductance_profile
from synth.hopper.motor_response import CONSTANTS
from synth.hopper.odd_recording import refuse_odd
from synth.hopper.response_runs import response_runs
from synth.hopper.speed_lag import SpeedLag, fit_with_lag
from synth.hopper.windows import OVERLAP, windows

SHORT, LONG = 0.03, 0.3  # s, widths: the run-up needs short ones, steady running benefits from long ones
UNITS = {
    "resistance": "ohm", "inductance": "H", "back_emf": "N*m/A", "friction": "N*m", "viscous": "N*m*s/rad",
    "rotor_inertia": "kg*m^2",
}  # fmt: skip
POSITIVE = ("resistance", "back_emf", "rotor_inertia")
# Standard deviation of a logarithm, above which a constant is known within less than a factor of 5
UNKNOWN_DEVIATION = 1.0
SURE_DEVIATIONS = 3.0  # standard deviations below 0 from which a constant counts as negative


@dataclass(frozen=True)
class IdentifiedConstant:
    """A number and its standard deviation; ``ends`` of its 90 % interval, None: those of a normal one."""

    value: float
    deviation: float
    ends: tuple[float, float] | None = None

    @property
    def interval90(self) -> tuple[float, float]:
        """90 % interval."""
        if self.ends is not None:
            return self.ends
        return self.value - NORMAL90 * self.deviation, self.value + NORMAL90 * self.deviation


@dataclass(frozen=True)
class MotorEstimate:
    """Constants at the rotor, SI; ``not_determined``: what the runs leave open of them, and why.

    ``current_zero`` : of the sensor, which is subtracted. ``speed_lag`` : of the speed, which is undone.
    """

    resistance: IdentifiedConstant
    inductance: IdentifiedConstant
    back_emf: IdentifiedConstant
    friction: IdentifiedConstant
    viscous: IdentifiedConstant
    rotor_inertia: IdentifiedConstant
    windows: int
    not_determined: tuple[str, ...] = ()
    current_zero: CurrentZero = field(default_factory=CurrentZero)
    speed_lag: SpeedLag = field(default_factory=SpeedLag)


def identify_motor(runs: tuple[HopperRecording, ...], ratio: float) -> MotorEstimate:
    """Constants from run-ups.

    Raises
    ------
    UserError : the runs do not determine the constants (a single steady speed, or no run-up), or some or all
        are not of a motor, or its simulation diverges near them.
    """
    zero = current_zero(runs)
    runs = tuple(map(zero.subtracted, runs))
    rows = [np.concatenate([_weighted_windows(run, ratio, width) for width in (SHORT, LONG)]) for run in runs]
    if sum(map(len, rows)) < 12:
        raise UserError(Problem("the runs are too short: at least a second of run-up and steady running is needed"))
    _refuse_odd_run([run.name for run in runs], rows)
    names, near = [run.name for run in runs], _estimate(np.concatenate(rows))
    _refuse_no_motor(names, near, POSITIVE)
    found = _by_response(runs, ratio, near, zero)
    _refuse_no_motor(names, found, ("friction", "viscous"))
    return found


def _by_response(
    runs: Sequence[HopperRecording], ratio: float, near: MotorEstimate, zero: CurrentZero
) -> MotorEstimate:
    """Constants from the simulated response, from a start near them; their intervals hold the error of ``zero``."""
    responses = [part for run in runs for part in response_runs(run, ratio)]
    fitted = fit_with_lag(responses, np.array([getattr(near, name).value for name in CONSTANTS]))
    fit, best = fitted.fit, fitted.best
    for name, deviation in zip(CONSTANTS, standard_deviations(fit, best).tolist(), strict=True):
        if name in POSITIVE and deviation > UNKNOWN_DEVIATION:
            text = f"the runs do not determine the {name.replace('_', ' ')}: record run-ups from rest"
            raise UserError(Problem(f"{text} at several voltages"))
    profile = inductance_profile(fit, best)
    best, ends = profile.best, profile.ends()
    moved = NORMAL90 * moved_by_current(fit, best, zero.deviation)[:, None]
    ends = best.unknowns[:, None] + np.array([-1.0, 1.0]) * np.hypot(ends - best.unknowns[:, None], moved)
    reach = fit.constants(np.column_stack([best.unknowns, ends]))
    reach[INDUCTANCE] = (profile.value, *profile.interval)
    found = {
        name: IdentifiedConstant(value, (high - low) / (2.0 * NORMAL90), (low, high))
        for name, (value, low, high) in zip(CONSTANTS, reach.tolist(), strict=True)
    }
    low, high = profile.interval
    text = f"inductance: the runs show only that it is below {1e3 * high:.3g} mH; record more samples a second"
    return MotorEstimate(
        **found,
        windows=near.windows,
        not_determined=() if low > 0.0 else (text,),
        current_zero=zero,
        speed_lag=fitted.lag,
    )


def _weighted_windows(run: HopperRecording, ratio: float, width: float) -> Array:
    """Rows of ``_windows``, weighted: a bump's noise grows with the root of its width."""
    return np.asarray(_windows(run, ratio, width) * width**-0.5)


def _refuse_odd_run(names: Sequence[str], rows: Sequence[Array]) -> None:
    """Refuse a run that the constants of all others do not explain."""

    def missed(index: int) -> tuple[float, float] | None:
        others = [part for k, part in enumerate(rows) if k != index and len(part)]
        if not others or not len(rows[index]):
            return None
        try:
            found = _estimate(np.concatenate(others))
        except UserError:
            return None
        return _unexplained_share(found, rows[index]), max(_unexplained_share(found, part) for part in others)

    refuse_odd(names, missed, "voltage or torque")


def _unexplained_share(found: MotorEstimate, rows: Array) -> float:
    """Share of the voltage, or of the torque, that a motor's equations leave (root mean square), the larger one."""
    electric = np.array([found.resistance.value, found.back_emf.value, found.inductance.value])
    mechanic = np.array([found.friction.value, found.viscous.value, found.rotor_inertia.value])
    torque = found.back_emf.value * rows[:, 1]
    left = (rows[:, 0] - rows[:, 1:4] @ electric, torque - rows[:, 4:7] @ mechanic)
    return max(
        float(np.sqrt(np.mean(one**2) / max(float(np.mean(whole**2)), 1e-300)))
        for one, whole in zip(left, (rows[:, 0], torque), strict=True)
    )


def _refuse_no_motor(names: Sequence[str], found: MotorEstimate, keys: Sequence[str]) -> None:
    """Refuse constants with an impossible sign: resistance or friction that supplies energy."""
    wrong = {}
    for key in keys:
        estimate: IdentifiedConstant = getattr(found, key)
        if estimate.value <= 0.0 if key in POSITIVE else estimate.value < -SURE_DEVIATIONS * estimate.deviation:
            wrong[key] = UNITS[key]
    if wrong:
        messages = ", ".join(f"{key.replace('_', ' ')} {getattr(found, key).value:.3g} {u}" for key, u in wrong.items())
        shown = ", ".join(names[:5]) + (" and others" if len(names) > 5 else "")
        text = (
            f"{shown}: no motor has {messages}. Are columns exchanged, or of the wrong sign? Voltage and current are "
        )
        raise UserError(Problem(f"{text}positive where they drive the motor forward, speed is the gear's output"))


def _estimate(rows: Array) -> MotorEstimate:
    """Constants from weighted windows (n, 7) of ``_windows``."""
    e, sigma_e = _solve(rows[:, 1:4], rows[:, 0], "R from K_v: vary the voltage")
    back_emf = e[1]
    m, sigma_m = _solve(rows[:, 4:7], back_emf * rows[:, 1], "friction from its viscous part: vary the voltage")
    # The uncertainty of K_v affects every torque.
    relative = sigma_e[1] / back_emf
    spread = np.hypot(sigma_m, relative * np.abs(m))
    resistance, inductance, emf = (IdentifiedConstant(e[i], sigma_e[i]) for i in (0, 2, 1))
    friction, viscous, inertia = (IdentifiedConstant(m[i], spread[i]) for i in range(3))
    return MotorEstimate(resistance, inductance, emf, friction, viscous, inertia, len(rows))


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


def _solve(a: Array, y: Array, remedy: str) -> tuple[Array, Array]:
    """Least squares: values, and standard deviations with overlapping windows counted once."""
    size = np.linalg.norm(a, axis=0)
    if np.any(size == 0.0) or np.linalg.cond(a / size) > 1e6:
        raise UserError(Problem(f"the runs do not separate {remedy}"))
    found, *_ = np.linalg.lstsq(a / size, y, rcond=None)
    left = y - (a / size) @ found
    variance = float(left @ left) / max(1, len(y) - 3) * OVERLAP
    covariance = np.linalg.inv((a / size).T @ (a / size)) * variance
    return found / size, np.sqrt(np.diag(covariance)) / size

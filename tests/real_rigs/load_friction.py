"""Whether a gear's friction grows with its motor's torque or with its load's: ``python -m real_rigs.load_friction``.

The owners' equations, fitted anew to the logs that ``servo_bench`` learns from and scored on those that it scores.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares

from real_rigs.servo_bench import SERVOS, SUBSTEPS, Log, logs, scored

Array = NDArray[np.float64]
# Free numbers of each model; one number may stand for two. Start, least and most of each.
COMMON = ("constant", "resistance", "armature", "offset", "dry", "viscous")
FORMS = {
    "dry and viscous": (),
    "by the motor's torque": ("motor",),
    "by the load's torque": ("load",),
    "by both, one share": ("motor=load",),
    "by both, two shares": ("motor", "load"),
}
BOUNDS = {
    "constant": (0.05, 5.0), "resistance": (0.3, 20.0), "armature": (1e-5, 0.2), "offset": (-0.1, 0.1),
    "dry": (0.0, 3.0), "viscous": (0.0, 3.0), "motor": (0.0, 0.95), "load": (0.0, 0.95),
}  # fmt: skip
STARTS, SPREAD = 6, 0.7  # fits from the stated numbers and from others, by so much in their logarithms
DIVERGED = 3.0  # rad, of a motion that ran away
ROBUST = 0.05  # rad of error beyond which a log counts less: a missed drop of the arm


@njit(cache=True)
def _followed(time, command, supply, enabled, first, gain, weight, inertia, numbers):  # type: ignore[no-untyped-def]
    """(m,) rad of one log."""
    constant, resistance, armature, offset, dry, viscous, motor_share, load_share = numbers
    q, rate, whole = first, 0.0, inertia + armature
    found = np.empty(len(time))
    found[0] = q
    for k in range(len(time) - 1):
        step = (time[k + 1] - time[k]) / SUBSTEPS
        for _ in range(SUBSTEPS):
            duty = min(max(gain * (command[k] - q), -1.0), 1.0)
            motor = constant * (supply[k] * duty - constant * rate) / resistance if enabled[k] > 0.0 else 0.0
            load = -weight * math.sin(q + offset)
            most = dry + abs(load_share * load - motor_share * motor) + viscous * abs(rate)
            stopping = whole / step * rate + motor + load
            rate += (motor + load - math.copysign(min(abs(stopping), most), stopping)) / whole * step
            q += rate * step
        found[k + 1] = q
    return found


def _errors(servo: str, log: Log, numbers: Array) -> Array:
    """(m,) rad."""
    at, kept = log.columns, ("timestamp", "goal_position", "input_volts", "torque_enable")
    columns = [np.ascontiguousarray(at[name], dtype=float) for name in kept]
    weight, inertia = log.mass * 9.81 * log.length, log.mass * log.length**2
    gain = SERVOS[servo]["gain"] * log.kp
    found = _followed(*columns, float(log.position[0]), gain, weight, inertia, numbers)
    return np.asarray(np.clip(np.nan_to_num(found - log.position, nan=DIVERGED), -DIVERGED, DIVERGED))


def _numbers(free: Sequence[str], values: Array) -> Array:
    """All numbers; those that a form does not have are 0."""
    found = dict.fromkeys(BOUNDS, 0.0)
    for names, value in zip(free, values.tolist(), strict=True):
        found |= dict.fromkeys(names.split("="), value)
    return np.array(list(found.values()))


def fitted(servo: str, free: Sequence[str], learnt: Sequence[Log]) -> Array:
    """The numbers of a form that follow the logs best."""
    low, high = np.array([BOUNDS[names.split("=")[0]] for names in free]).T
    begin = {**dict.fromkeys(BOUNDS, 0.05), "offset": 0.0, **SERVOS[servo]}
    start = np.array([begin[names.split("=")[0]] for names in free])
    rng, found = np.random.default_rng(0), []

    def away(values: Array) -> Array:
        each = [_errors(servo, log, _numbers(free, values)) for log in learnt]
        return np.concatenate([error / math.sqrt(len(error)) for error in each])

    for k in range(STARTS):
        begun = start * np.exp(SPREAD * min(k, 1) * rng.standard_normal(len(start)))
        begun = np.clip(begun, low + 1e-6, high - 1e-6)
        scale = np.maximum(np.abs(start), 0.01)
        made = least_squares(away, begun, bounds=(low, high), x_scale=scale, diff_step=1e-3, loss="soft_l1",
                             f_scale=ROBUST, max_nfev=60)  # fmt: skip
        found.append((float(made.cost), k, made.x))
    return _numbers(free, min(found)[2])


def error(servo: str, form: str) -> tuple[float, dict[str, float]]:
    """Mean absolute angle error, mrad, on the logs left out, and the numbers of a form."""
    found, out = logs(servo), scored(servo)
    numbers = fitted(servo, (*COMMON, *FORMS[form]), [log for log in found if log.name not in out])
    away = [np.abs(_errors(servo, log, numbers)).mean() for log in found if log.name in out]
    return 1e3 * float(np.mean(away)), dict(zip(BOUNDS, numbers.tolist(), strict=True))


def main() -> None:
    """Print a line for each form."""
    parser = argparse.ArgumentParser(prog="real_rigs.load_friction", description=__doc__)
    parser.add_argument("servos", nargs="*", metavar="SERVO", help="xl330, feetech (default: both)")
    for servo in parser.parse_args().servos or SERVOS:
        for form in FORMS:
            mean, numbers = error(servo, form)
            told = ", ".join(f"{name} {value:.3g}" for name, value in numbers.items())
            print(f"{servo}, {form}: {mean:.1f} mrad ({told})", flush=True)  # noqa: T201


if __name__ == "__main__":
    main()

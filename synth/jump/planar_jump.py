"""Planar jumps: the five-bar with pitch and slip (``synth.jump.planar_engine``) from leg and motor to outcome."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_integrator import LONGEST
from synth.jump.jump_lanes import JumpLanes
from synth.jump.jump_models import Model, columns
from synth.jump.jump_runs import DURATION, FALL, FIRST_STEP, MAX_STEPS, NO_END, TOLERANCE
from synth.jump.jump_step import CURRENT_WEIGHT, RATE_WEIGHT
from synth.jump.outcomes import LANDED_AGAIN, LIFTED, LIMITS, TOO_STIFF, JumpOutcome, rise_of_jump, too_stiff
from synth.jump.planar_engine import SCALARS, com_speed, integrate


@dataclass(frozen=True)
class PlanarJump:
    """A planar jump: the outcome and the quantities of this form only. Columns of ``trace``: time, state, outputs."""

    outcome: JumpOutcome
    slip: float  # m, path of the foot along the ground during the push
    pitch: float  # rad, at the end
    trace: Array


def planar_jump(
    leg: HopperLeg,
    motor: Motor,
    contact: Contact,
    model: Model,
    *,
    pitch: float = 0.0,
    tolerance: float = TOLERANCE,
    duration: float = DURATION,
) -> PlanarJump:
    """One jump by the planar form, from the crouch leaning by ``pitch`` rad."""
    jumps = columns(leg, motor, contact, model, np.array([leg.length]))
    run = _run(jumps, leg.body_inertia, contact.slip_speed, pitch, tolerance, (duration, NO_END))
    aside = run.aside
    outcome = _outcome(run.trace, aside, run.n, run.status, run.arguments, float(jumps.total_mass[0]))
    return PlanarJump(outcome, _slip(aside), float(run.trace[-1, 3]), run.trace)


def planar_record(
    jumps: JumpLanes, body_inertia: float, slip_speed: float, pitch: float, times: Array, tolerance: float
) -> dict[str, Array]:
    """Sensor readings of a jump with initial lean ``pitch`` rad, (n_time,) each at ``times`` s; before 0 at rest.

    ``angle`` : the right upper link's, from the body; ``normal`` N; ``current`` of both motors, A; ``pitch`` rad;
    ``slide`` : path of the foot along the ground, m.
    """
    last = float(times[-1])
    run = _run(jumps, body_inertia, slip_speed, pitch, tolerance, (last, last), fall=np.inf)
    t, x, aside = run.trace[:, 0], run.trace[:, 1 : 1 + 2 * run.n + 3], run.aside
    rows = {
        "angle": x[:, 3] - x[:, 2],
        "normal": aside[:, 0],
        "current": aside[:, 7],
        "pitch": x[:, 2],
        "slide": aside[:, 2] - aside[0, 2],
    }
    reached = times <= t[-1] + 1e-9
    return {name: np.where(reached, np.interp(times, t, row), np.nan) for name, row in rows.items()}


@dataclass(frozen=True)
class _Run:
    """Rows of ``trace``: time, state, asides."""

    trace: Array
    n: int
    status: int
    arguments: Any

    @property
    def aside(self) -> Array:
        """(n_step, 8): normal and friction force, the foot's x, height and vertical speed, gear torques, current."""
        return self.trace[:, 1 + 2 * self.n + 3 :]


def _run(
    jumps: JumpLanes, body_inertia: float, slip_speed: float, pitch: float, tolerance: float,
    ends: tuple[float, float], fall: float = FALL,
) -> _Run:  # fmt: skip
    """Integrate the first lane; ``ends`` s: of a push on the ground, and of everything."""
    layout = jumps.layout
    parameters = jumps.workspace()[:, 0]
    scalars = np.array([parameters[layout.row(name)] for name in SCALARS])
    lengths = parameters[layout.block("length")]
    masses = jumps.mass_per_length[0] * lengths
    count = len(lengths)
    n = 3 + 2 * count
    angles = parameters[layout.block("angle")]
    x = np.zeros(2 * n + 3)
    height = parameters[layout.row("height")]
    x[3 : 3 + count], x[3 + count : n] = angles + pitch, -angles + pitch
    x[2] = pitch
    x[0], x[1] = -height * np.sin(pitch), height * np.cos(pitch)
    weight = np.concatenate([np.ones(n), np.full(n, RATE_WEIGHT), np.full(2, CURRENT_WEIGHT), np.zeros(1)])
    body = np.array([jumps.body_mass[0], body_inertia])
    ground = np.array([jumps.ground_friction[0], slip_speed, float(layout.knee)])
    foot_mass = float(jumps.foot_mass[0])
    arguments = (lengths, masses, parameters[layout.block("beam")], body, ground, scalars, foot_mass)
    trace = np.empty((MAX_STEPS, 1 + len(x) + 8))
    steps_of, mass = (FIRST_STEP, LONGEST, MAX_STEPS), float(jumps.total_mass[0])
    rows, status = integrate(x, n, arguments, weight, tolerance, ends, fall, mass, steps_of, trace)
    return _Run(trace[:rows], n, status, arguments)


def _slip(aside: Array) -> float:
    pushing = _rows_of_push(aside)
    return float(np.abs(np.diff(aside[pushing, 2])).sum())


def _rows_of_push(aside: Array) -> slice:
    """Rows up to the last ground contact before the foot lifts."""
    lifted = np.flatnonzero(aside[:, 3] > LIFTED)
    end = int(lifted[0]) if len(lifted) else len(aside)
    touching = np.flatnonzero(aside[:end, 3] <= 0.0)
    return slice(0, int(touching[-1]) + 1 if len(touching) else 1)


def _takeoff_row(aside: Array) -> int:
    """The last row of ground contact before the foot's greatest height; that of the push if it does not lift."""
    if not (aside[:, 3] > LIFTED).any():
        return int(_rows_of_push(aside).stop) - 1
    touching = np.flatnonzero(aside[: int(np.argmax(aside[:, 3])), 3] <= 0.0)
    return int(touching[-1]) if len(touching) else 0


def _outcome(trace: Array, aside: Array, n: int, status: int, arguments: Any, mass: float) -> JumpOutcome:
    if status == TOO_STIFF:
        return too_stiff()
    size = 2 * n + 3
    last = _takeoff_row(aside)
    push = slice(0, last + 1)
    after = min(last + 1, len(aside) - 1)
    low, high = aside[last, 3], aside[after, 3]
    share = -low / (high - low) if low <= 0.0 < high else 0.0  # of the step, to the foot's passage through the ground
    speeds = [com_speed(row[1 : 1 + size], n, arguments, mass) for row in trace]
    rise = np.concatenate([[0.0], np.cumsum(np.diff(trace[:, 0]) * 0.5 * (np.array(speeds[1:]) + speeds[:-1]))])
    return JumpOutcome(
        clearance=float(aside[:, 3].max()) if status == LANDED_AGAIN else 0.0,
        rise=rise_of_jump(rise, aside[:, 3], 0.0),
        takeoff_time=float(trace[last, 0] + share * (trace[after, 0] - trace[last, 0])),
        takeoff_speed=float(speeds[last] + share * (speeds[after] - speeds[last])),
        peak_gear_torque=float(np.abs(aside[push, 5:7]).max()),
        peak_current=float(np.abs(aside[push, 7]).max()),
        energy=float(trace[last, size] + share * (trace[after, size] - trace[last, size])),
        peak_normal=float(aside[:, 0].max()),
        limit=LIMITS[status],
    )

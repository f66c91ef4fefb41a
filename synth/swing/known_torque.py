"""A known torque on the joints: linear between its samples, which may be denser than those of the angles.

Servo signals are passed to the integrator together with it, on the union of both time grids; held commands apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.drives.servo import ServoSignals
from synth.swing.driven_steps import ANY_BEND, HELD_STILL

STRAIGHT = 0.002  # of the largest known torque: the integrator resolves larger deviations from a straight line
COMMAND_STRAIGHT = 1e-3  # rad: the integrator resolves larger deviations of a command from a straight line
SUPPLY_STRAIGHT = 0.05  # of the largest supply; its ripple moves a joint far less than its command does
CLOSEST = 4.9e-4  # s, least spacing of knots; a torque sampled at 2 kHz is not averaged
KnownTorque = tuple[Array, Array]  # times (m,) s and torques on q (m, n) N m


Linear = tuple[Array, Array, Array]
HeldCommands = tuple[Array, Array]


def for_integrator(
    known: KnownTorque | None, n: int, signals: ServoSignals | None = None, stepped: Sequence[int] = ()
) -> tuple[Linear, HeldCommands]:
    """What acts on a leg, as the integrator takes it: what is linear between its knots, and the commands that are held.

    Times (m,) s, torques (m, n) N m, and tolerated deviations (n,) N m from a straight line; m = 0 for no torque.
    With ``signals`` the columns of torques are followed by n columns each of commands, supplies and switches; a held
    command's tolerance is ``HELD_STILL``, and no step needs to end at a command's knots for the joints ``stepped``,
    which read it at their control steps. Beyond its first and last sample a torque or signal is constant. Of the held
    commands times (p,) s and commands (p, n) rad.

    Raises
    ------
    ValueError : fewer than two samples, of which the integrator would know nothing.
    """
    none = np.zeros(0), np.zeros((0, n))
    if signals is not None:
        return _with_signals(known, n, signals, list(stepped))
    if known is None:
        return (np.zeros(0), np.zeros((0, n)), np.zeros(n)), none
    times, torques = (np.ascontiguousarray(array, dtype=float) for array in known)
    _refuse_single(times)
    return (times, torques, STRAIGHT * np.abs(torques).max(axis=0, initial=0.0) + 1e-300), none


def _with_signals(
    known: KnownTorque | None, n: int, signals: ServoSignals, stepped: list[int]
) -> tuple[Linear, HeldCommands]:
    """The result of ``for_integrator`` for torques and signals, on the union of their times."""
    times = signals.time if known is None else np.union1d(signals.time, known[0])
    _refuse_single(times)
    torque = np.zeros((len(times), n)) if known is None else _values_at(times, known[0], known[1])
    linear, held = signals.command, list(signals.held)
    if held:
        linear = linear.copy()
        linear[:, held] = 0.0
    inputs = [_values_at(times, signals.time, values) for values in (linear, signals.supply, signals.enabled)]
    bent = np.full(n, COMMAND_STRAIGHT)
    bent[stepped] = ANY_BEND
    bend = [STRAIGHT * np.abs(torque).max(axis=0, initial=0.0), bent]
    bend += [SUPPLY_STRAIGHT * np.abs(inputs[1]).max(axis=0, initial=0.0), np.full(n, STRAIGHT)]
    tolerated, values = np.concatenate(bend) + 1e-300, np.hstack([torque, *inputs])
    if not held:
        return (np.ascontiguousarray(times), np.ascontiguousarray(values), tolerated), (np.zeros(0), np.zeros((0, n)))
    tolerated[n + np.array(held)] = HELD_STILL
    told, changed = _changes(signals.command[:, held]), _changes(values)
    changed[[0, -1]] = True
    changed[:-1] |= changed[1:]  # a straight line to a change begins at the knot before it
    return (times[changed], values[changed], tolerated), (signals.time[told].astype(float), signals.command[told])


def _refuse_single(times: Array) -> None:
    """Refuse what is given at fewer than two times."""
    if len(times) < 2:
        raise ValueError(
            f"{len(times)} sample of a known torque or signal: give at least two, of a constant one its ends"
        )


def _changes(values: Array) -> NDArray[np.bool_]:
    """(m,) True at the first row and at each row (m, n) that differs from the one before it."""
    return np.concatenate([[True], np.any(values[1:] != values[:-1], axis=1)])


def _values_at(times: Array, known: Array, values: Array) -> Array:
    """Values (k, n) at ``times`` (k,), interpolated linearly from ``values`` (m, n) at ``known`` (m,)."""
    return np.stack([np.interp(times, known, column) for column in values.T], axis=1)


def with_least_spacing(times: Array, torques: Array, end: float, unit: float = 1.0) -> KnownTorque:
    """A known torque from 0 to ``end`` s with knots no closer than ``CLOSEST``; denser ones are averaged.

    ``unit`` : s, the motion's own unit of time, see ``time_unit``; it shortens the least spacing of a fast motion.

    The averages (see ``average_torques``) preserve impulses and their first moments. At 2000 knots per second the lost
    detail moves a joint by less than torque / inertia * ``CLOSEST``^2 / 40: 6e-6 rad at 1000 rad/s^2.
    """
    inside = int(np.count_nonzero((times >= 0.0) & (times <= end)))
    closest = CLOSEST * min(unit, 1.0)  # not longer for a slow motion
    if inside < 2 or end / (inside - 1) >= closest:
        return times, torques
    grid = np.linspace(0.0, end, max(int(end / closest), 2) + 1)
    return grid, average_torques((times, torques), grid)


def delay_torques(known: KnownTorque, delay: Array) -> KnownTorque:
    """The torques with each joint's ``delay`` (n,) s, on the union of all knots; constant before the first sample."""
    times, torques = known
    moments = np.unique(np.concatenate([times + late for late in np.unique(delay)]))
    shifted = [np.interp(moments - late, times, torque) for late, torque in zip(delay, torques.T, strict=True)]
    return moments, np.stack(shifted, axis=1)


def average_torques(known: KnownTorque, grid: Array) -> Array:
    """Torques (m, n) N m on an even ``grid`` (m,) s, averaged with a hat function that reaches to both neighbours.

    The hat functions sum to one, so the sum over the grid times its step is the integral of the torque. Sampling at the
    grid points would miss or overweight a short pulse. Closed form: the torque is piecewise linear, its second
    integral F is cubic, and the mean is (F(t - h) - 2 F(t) + F(t + h)) / h^2.
    """
    times, torques = known
    step = float(grid[1] - grid[0])
    wide = np.concatenate([[grid[0] - step], grid, [grid[-1] + step]])
    # Beyond its ends the torque is constant.
    times = np.concatenate([[min(times[0], wide[0]) - step], times, [max(times[-1], wide[-1]) + step]])
    torques = np.concatenate([torques[:1], torques, torques[-1:]])
    width = np.diff(times)[:, None]
    first = np.concatenate(
        [np.zeros((1, torques.shape[1])), np.cumsum(0.5 * (torques[1:] + torques[:-1]) * width, axis=0)]
    )
    rise = first[:-1] * width + (2.0 * torques[:-1] + torques[1:]) * width**2 / 6.0
    second = np.concatenate([np.zeros((1, torques.shape[1])), np.cumsum(rise, axis=0)])
    k = np.clip(np.searchsorted(times, wide, side="right") - 1, 0, len(times) - 2)
    u = (wide - times[k])[:, None]
    slope = (torques[k + 1] - torques[k]) / width[k]
    integral = second[k] + first[k] * u + 0.5 * torques[k] * u**2 + slope * u**3 / 6.0
    return np.asarray((integral[:-2] - 2.0 * integral[1:-1] + integral[2:]) / step**2)

"""The simulated motion of a planted leg: the engine's arrays for one trial, equilibria, releases and their motion."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from synth.planting import bodies, engine
from synth.planting.followed_commands import followed
from synth.planting.model import Array, Bend, Law, PlantedLeg, PlantedServo, PlantedTrial, ServoInputs, Truth
from synth.planting.stated_friction import all_laws
from synth.planting.torque_laws import (
    BOUC_WEN,
    DAMPER_TABLE,
    DRIVE,
    DRIVE_TABLE,
    GEAR,
    SAMPLED_SERVO,
    SERVO,
    SERVO_NUMBERS,
    SLACK,
    SLACK_ARM,
    STICK_SLIP,
)


class Assembly(NamedTuple):
    """The engine's arrays for one trial; ``joint`` (n,): the coordinate of each joint of the leg."""

    body: Array
    fixed: NDArray[np.bool_]
    law: NDArray[np.int64]
    at: NDArray[np.int64]
    par: Array
    joint: NDArray[np.int64]
    gravity: float
    table: Array  # (rows, 2), known torques over time and damper torques over speed, one table below the other


def assemble(truth: Truth, trial: PlantedTrial) -> Assembly:
    """The chain of bodies for one trial."""
    leg, rows, where = truth.leg, [], []
    root = leg.tilt + trial.tilt + truth.tilt
    if truth.base is not None:
        for kind, direction, arm, mass, inertia, rate, damping in truth.base.bodies:
            rows.append([arm, mass, 0.0, inertia, rate, damping, 0.0, kind, direction, 0.0, 0.0, 0.0])
    for i in range(leg.n):
        length, mass, com, inertia, rate, damping, free = leg.values[:7, i]
        beside = 0.0 if leg.com_across is None else float(leg.com_across[i])
        if i == leg.n - 1 and trial.tip_mass:
            whole, place = mass + trial.tip_mass, length if trial.tip_at is None else trial.tip_at
            centre = (mass * com + trial.tip_mass * place) / whole
            inertia = inertia + mass * (com - centre) ** 2 + trial.tip_mass * (place - centre) ** 2
            inertia += trial.tip_inertia + beside**2 * mass * trial.tip_mass / whole
            mass, com, beside = whole, centre, beside * mass / whole
        if i in truth.bare:
            rate = damping = 0.0
        where.append(len(rows))
        rotor = sum(size for joint, size in truth.rotors if joint == i)
        rotor += 0.0 if leg.rotors is None else float(leg.rotors[i])
        turned = root if i == 0 else 0.0
        first = [length, mass, com, inertia, rate, damping, free, bodies.HINGE, 0.0, turned, rotor, beside]
        bend = next((b for b in truth.bends if b.joint == i), None)
        rows += [first] if bend is None else _segments(first, bend)
    fixed = np.zeros(len(rows), dtype=bool)
    fixed[[where[i] for i in trial.locked]] = True
    joint = np.array(where)
    laws = all_laws(leg, truth.laws)
    if trial.drive:
        gain, offset, delay = truth.drive
        joint_driven, a_, w_, p_, b_, v_, r_ = trial.drive
        signal = ((1 + gain) * a_, w_, p_, (1 + gain) * b_, v_, r_, offset, delay)
        laws = (*laws, Law(DRIVE, int(joint_driven), signal))
    tables, more = _table_of_trial(truth, trial)
    laws = (*(_with_gear_friction(law, more, len(laws)) for law in laws), *more)
    at = np.array([[0 if w.base else joint[w.joint], joint[w.second if w.second >= 0 else w.joint]] for w in laws])
    at = at.reshape(-1, 2).astype(np.int64)
    for k, w in enumerate(laws):
        if w.base:
            at[k] = 0
    par = np.array([[*w.par, *(8 - len(w.par)) * [0.0]] for w in laws]).reshape(-1, 8)
    return Assembly(
        np.array(rows), fixed, np.array([w.law for w in laws], dtype=np.int64), at, par, joint, leg.gravity, tables
    )


def _with_gear_friction(law: Law, more: tuple[Law, ...], before: int) -> Law:
    """A gear's friction with the place of its servo's numbers; there are ``before`` laws before ``more``."""
    if law.law != GEAR:
        return law
    for index, servo in enumerate(more):
        if servo.law in (SERVO, SAMPLED_SERVO) and servo.joint == law.joint:
            place = float(before + index + 1)
            held, summed = (place if servo.law == kind else 0.0 for kind in (SAMPLED_SERVO, SERVO))
            return law._replace(par=(*law.par, *servo.par[:2], held, summed))
    # A trial without inputs has no torque to transmit.
    return law._replace(law=STICK_SLIP, par=(0.0, 0.0, 1.0, 0.0))


def _table_of_trial(truth: Truth, trial: PlantedTrial) -> tuple[Array, tuple[Law, ...]]:
    """All tables one below the other (rows, 2), and the laws that interpolate them."""
    rows, made = [np.zeros((1, 2))], []
    count = 1
    for j, curve in truth.leg.curves:
        if j not in truth.bare:
            made.append(Law(DAMPER_TABLE, j, (float(truth.leg.of("damper")[j]), float(count), float(len(curve)))))
            rows.append(curve)
            count += len(curve)
    if trial.known is not None:
        times, torques = trial.known
        for j in np.flatnonzero(np.any(torques != 0.0, axis=0)).tolist():
            gain, offset, delay = truth.drive if truth.drive_joint in (-1, j) else (0.0, 0.0, 0.0)
            factor = (1 + gain) * truth.leg.torque_factor(j)
            made.append(Law(DRIVE_TABLE, j, (factor, offset, delay, float(count), float(len(times)))))
            rows.append(np.column_stack([times, torques[:, j]]))
            count += len(times)
    if trial.inputs is not None:
        for servo in truth.servos():
            inputs = followed(trial.inputs, servo)
            law, par = SERVO, [float(count), float(len(inputs.time))]
            if servo.control_period > 0.0:
                law, par = SAMPLED_SERVO, [*par, servo.control_period, servo.first_look, servo.duty_steps]
            made.append(Law(law, servo.joint, tuple(par)))
            rows.append(_servo_table(servo.of_true_angle(), inputs))
            count += len(rows[-1])
    return np.ascontiguousarray(np.concatenate(rows)), tuple(made)


def _servo_table(servo: PlantedServo, inputs: ServoInputs) -> Array:
    """(15 + 3 k, 2): the servo's numbers in the first column, then command, supply and switch over time."""
    numbers = np.zeros((SERVO_NUMBERS, 2))
    numbers[:, 0] = servo[1 : 1 + SERVO_NUMBERS]
    columns = (values[:, servo.joint] for values in inputs[1:])
    return np.concatenate([numbers, *(np.column_stack([inputs.time, column]) for column in columns)])


def _segments(whole: list[float], bend: Bend) -> list[list[float]]:
    """The rows of a link that hinges cut into segments; the total mass, centre of mass and inertia stay the link's.

    Each segment has the share of the mass that it has of the length. All centres of mass shift by the same distance, so
    that their mean is the link's. The inertia that the segments' positions do not explain is shared in proportion to
    the cube of the segment length.
    """
    length, mass, com, inertia = whole[:4]
    cuts = [0.0, *bend.shares, 1.0]
    shift = com - 0.5 * length
    rows = []
    pieces = [(b - a) for a, b in pairwise(cuts)]
    middles = [0.5 * (a + b) * length + shift for a, b in pairwise(cuts)]
    spread = sum(p * mass * (x - com) ** 2 for p, x in zip(pieces, middles, strict=True))
    own = max(inertia - spread, 0.0)  # shared by length^3, like the inertia of uniform rods
    cubes = sum(p**3 for p in pieces)
    for k, (share, middle) in enumerate(zip(pieces, middles, strict=True)):
        # At least a ten-thousandth: positive for any link.
        row = [share * length, share * mass, middle - cuts[k] * length, max(own * share**3 / cubes, 1e-4 * inertia)]
        if k == 0:
            row += whole[4:]
        else:
            row += [bend.rates[k - 1], bend.dampings[k - 1], 0.0, bodies.HINGE, 0.0, 0.0, 0.0, whole[bodies.BESIDE]]
        rows.append(row)
    return rows


def _initial_memory(a: Assembly, pose: Array, rest: Array) -> tuple[Array, NDArray[np.int64], Array]:
    """Coordinates, contact modes and memories of a leg that was moved slowly from ``rest`` to ``pose`` and is held."""
    q = np.zeros(len(a.body))
    q[a.joint] = pose
    free = np.ones(len(q), dtype=bool)
    free[a.joint] = False
    if free.any():
        q = equilibrium(a, q, free)
    mode, z = np.zeros(len(a.law), dtype=np.int64), np.zeros((len(a.law), 2))
    for k, law in enumerate(a.law):
        i = a.at[k, 0]
        u = q[i] - a.par[k, 1]
        if law in (SLACK, SLACK_ARM):
            z[k, 0] = np.sign(u) * max(abs(u) - a.par[k, 2], 0.0)
            mode[k] = int(np.sign(z[k, 0])) if law == SLACK else 0
        elif law == BOUC_WEN:
            z[k, 0] = _bouc_wen_memory(q[i] - rest[list(a.joint).index(i)], a.par[k])
    _hold(a, q, z)
    return q, mode, z


def _hold(a: Assembly, q: Array, z: Array) -> None:
    """Set the integral of each servo to the duty that holds the coordinates ``q``: it has taken over the whole load."""
    tau = -a.body[:, bodies.RATE] * (q - a.body[:, bodies.FREE])
    acc, force = np.zeros(len(q)), np.zeros((len(q), 3))
    bodies.accelerate(
        a.body, a.gravity, np.ones(len(q), dtype=bool), tau, q, np.zeros(len(q)), acc, force, np.zeros((len(q), 15))
    )
    load = force[:, 0] - tau
    for k in np.flatnonzero(np.isin(a.law, (SERVO, SAMPLED_SERVO))).tolist():
        first, count = int(a.par[k, 0]), int(a.par[k, 1])
        numbers, i = a.table[first : first + SERVO_NUMBERS, 0], a.at[k, 0]
        gain, most = numbers[13:]
        supply = a.table[first + SERVO_NUMBERS + count, 1]
        if gain == 0.0 or supply == 0.0:
            continue
        needed, sag = load[i] / (numbers[5] * supply), numbers[8]  # of needed = d / (1 + sag d^2) the smaller d
        z[k, 1] = np.clip(2.0 * needed / (1.0 + np.sqrt(max(1.0 - 4.0 * sag * needed**2, 0.0))), -most, most)


def _bouc_wen_memory(travel: float, p: Array) -> float:
    """Memory of the Bouc-Wen law after a slow motion by ``travel`` (rad) from z = 0."""
    z, w = 0.0, travel / 200
    for _ in range(200):
        r = z / p[1]
        size = abs(r) ** (p[2] - 1)
        z += w - (1 - p[3]) * abs(w) * size * r - p[3] * w * size * abs(r)
    return z


def equilibrium(a: Assembly, q: Array, free: NDArray[np.bool_]) -> Array:
    """Static equilibrium of the free coordinates with the others held, without the laws.

    Newton's method on the accelerations with a finite-difference Jacobian.

    Raises
    ------
    ArithmeticError : it does not converge.
    """
    held, w = ~free, np.zeros(len(q))
    index = np.flatnonzero(free)

    def acceleration(x: Array) -> Array:
        tau = -a.body[:, bodies.RATE] * (x - a.body[:, bodies.FREE])
        acc, force = np.zeros(len(q)), np.zeros((len(q), 3))
        bodies.accelerate(a.body, a.gravity, held, tau, x, w, acc, force, np.zeros((len(q), 15)))
        return acc[index]

    for _ in range(50):
        f = acceleration(q)
        slope = np.empty((len(index), len(index)))
        for c, i in enumerate(index):
            x = q.copy()
            x[i] += 1e-6
            slope[:, c] = (acceleration(x) - f) / 1e-6
        step = np.linalg.solve(slope, f)
        q = q.copy()
        q[index] -= np.clip(step, -0.3, 0.3)  # rad, where sines are nearly linear
        if np.abs(step).max() < 1e-10:
            return q
    raise ArithmeticError("no static equilibrium found")


class Motion(NamedTuple):
    """Rotations ``angle`` (m, n) rad and speeds ``speed`` (m, n) rad/s of the joints every ``step`` s from release."""

    step: float
    angle: Array
    speed: Array

    def at(self, times: Array) -> Array:
        """Rotations (m, n) rad at ``times`` (m,) s from the release.

        Cubic Hermite interpolation between steps; before the release, extrapolation with the first speed.
        """
        return np.stack([self.joint(i, times) for i in range(self.angle.shape[1])], axis=1)

    def joint(self, i: int, times: Array) -> Array:
        """Rotations (m,) rad of joint ``i`` at ``times`` (m,) s; see ``at``."""
        x = np.clip(times / self.step, 0.0, len(self.angle) - 1)
        k = np.minimum(x.astype(int), len(self.angle) - 2)
        s, h = x - k, self.step
        a, b, u, v = self.angle[k, i], self.angle[k + 1, i], self.speed[k, i] * h, self.speed[k + 1, i] * h
        d = b - a
        a = a + np.minimum(times, 0.0) * self.speed[0, i]
        return np.asarray(a + s * (u + s * (3 * d - 2 * u - v + s * (u + v - 2 * d))))


def release(truth: Truth, trial: PlantedTrial, step: float, rest: Array | None = None) -> Motion:
    """Motion after a release from the trial's pose, from rest or with the trial's speed.

    ``step`` : s, of the integration. ``rest`` : (n,) rad, the pose from which the leg was moved to the release, for
    laws with memory; None: the trial's pose.

    Raises
    ------
    ArithmeticError : the motion diverges.
    """
    a = assemble(truth, trial)
    q, mode, z = _initial_memory(a, trial.pose, trial.pose if rest is None else rest)
    w = np.zeros(len(q))
    if trial.speed is not None:
        w[a.joint] = np.where(a.fixed[a.joint], 0.0, trial.speed)
    return _simulate_segments(a, mode, z, q, w, trial.start + trial.duration, step)


def _simulate_segments(
    a: Assembly, mode: NDArray[np.int64], z: Array, q: Array, w: Array, span: float, step: float, begin: float = 0.0
) -> Motion:
    count = int(np.ceil(span / step - 1e-9)) + 1
    angle, speed = engine.simulate(
        a.body, a.gravity, a.fixed, a.law, a.at, a.par, a.table, mode, z, q, w, begin, step, count
    )
    if not np.isfinite(angle).all() or np.abs(angle).max() > 50.0:  # rad: eight turns
        raise ArithmeticError("the motion diverges")
    return Motion(step, angle[:, a.joint], speed[:, a.joint])


def swing(leg: PlantedLeg, trial: PlantedTrial, angle: Array, speed: Array, step: float, tilt: float = 0.0) -> Motion:
    """Motion of the leg without causes from the state ``angle`` (n,) rad, ``speed`` (n,) rad/s at the first sample.

    Locked joints keep their ``angle``.

    Raises
    ------
    ArithmeticError : the motion diverges.
    """
    a = assemble(Truth(leg, tilt=tilt), trial)
    none = np.zeros(len(a.law), dtype=np.int64)
    w = np.where(a.fixed, 0.0, speed)
    q, still = np.array(angle, dtype=float), np.zeros((len(a.law), 2))
    _hold(a, q, still)
    return _simulate_segments(a, none, still, q, w, trial.duration, step, trial.start)


def fastest(truth: Truth, trial: PlantedTrial) -> float:
    """Largest eigenvalue magnitude of the linearised chain, 1/s; it limits the step.

    Of the laws only backlash, damper tables and servos are included.
    """
    a = assemble(truth, trial)
    n = len(a.body)
    q, w = np.zeros(n), np.zeros(n)
    q[a.joint] = trial.pose
    free = np.flatnonzero(~a.fixed)
    inverse = np.empty((len(free), len(free)))
    acc, force = np.zeros(n), np.zeros((n, 3))
    bodies.accelerate(a.body, 0.0, a.fixed, np.zeros(n), q, w, acc, force, np.zeros((n, 15)))
    for c, i in enumerate(free):
        tau = np.zeros(n)
        tau[i] = 1.0
        bodies.accelerate(a.body, 0.0, a.fixed, tau, q, w, acc, force, np.zeros((len(q), 15)))
        inverse[:, c] = acc[free]
    k, b = a.body[free, bodies.RATE], a.body[free, bodies.DAMPING]
    for law, at, par in zip(a.law, a.at, a.par, strict=True):  # stiffness and damping of the laws
        if law in (SLACK, SLACK_ARM):
            k = k + (free == at[0]) * par[0]
            b = b + (free == at[0]) * par[3]
        if law == DAMPER_TABLE:
            rows = a.table[int(par[1]) : int(par[1] + par[2])]
            slopes = np.diff(rows[:, 1]) / np.diff(rows[:, 0])
            b = b + (free == at[0]) * max(float(slopes.max()) - par[0], 0.0)
    for servo in () if trial.inputs is None else truth.servos():
        assert trial.inputs is not None
        volt = servo.strength * float(np.abs(trial.inputs.supply[:, servo.joint]).max())
        here = free == a.joint[servo.joint]
        k, b = k + here * servo.gain * volt, b + here * (servo.damping_gain * volt + servo.back_emf)
    matrix = np.block([[np.zeros_like(inverse), np.eye(len(free))], [-inverse * k, -inverse * b]])
    return float(np.abs(np.linalg.eigvals(matrix)).max())

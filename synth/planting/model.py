"""A leg as the engine takes it: parameters, what a trial changes, further bodies and laws, sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from synth.planting import bodies, engine
from synth.planting.torque_laws import BOUC_WEN, DAMPER_TABLE, DRIVE, DRIVE_TABLE, SLACK, SLACK_ARM

Array = NDArray[np.float64]
PARAMETERS = ("length", "mass", "com", "inertia", "spring", "damper", "free_angle")  # as in ``tolerance:``


@dataclass(frozen=True)
class PlantedLeg:
    """SI; ``values`` (7, n) in the order of ``PARAMETERS``, free angles as rotations (not readings)."""

    names: tuple[str, ...]
    zero: Array  # (n,) rad, reading where the link points along its parent
    sign: Array  # (n,)
    tilt: float
    values: Array
    gravity: float = 9.81
    curves: tuple[tuple[int, Array], ...] = ()  # joint, (k, 2) speed and torque of a damper from (0, 0) on
    rotors: Array | None = None  # (n,) kg m^2 that turn with each joint as designed

    @property
    def n(self) -> int:
        return len(self.names)

    def with_values(self, values: Array) -> PlantedLeg:
        """The leg with other numbers."""
        return replace(self, values=values)

    def of(self, name: str) -> Array:
        """(n,) one parameter of all joints."""
        return np.asarray(self.values[PARAMETERS.index(name)])

    def changed(self, name: str, joint: int, value: float) -> PlantedLeg:
        """The leg with one number replaced."""
        values = self.values.copy()
        values[PARAMETERS.index(name), joint] = value
        return replace(self, values=values)

    def reading(self, rotation: Array) -> Array:
        """Measured angles, rad."""
        return self.zero + self.sign * rotation

    def outboard(self, joint: int) -> float:
        """Moment of inertia about a joint of all that hangs from it, chain straight, kg m^2."""
        total, reach = 0.0, 0.0
        for i in range(joint, self.n):
            length, mass, com, inertia = self.values[:4, i]
            total += inertia + mass * (reach + com) ** 2
            reach += length
        return total + (0.0 if self.rotors is None else float(self.rotors[joint]))


class PlantedTrial(NamedTuple):
    """What a trial does to the leg; ``pose`` (n,) rad rotations at release, ``start`` s from release to recording.

    ``known`` : times (k,) s from the release and torques on the joints (k, n) N m, linear in between; ``speed`` (n,)
    rad/s where the leg is not released from rest.
    """

    pose: Array
    duration: float
    start: float = 0.0
    tip_mass: float = 0.0
    locked: tuple[int, ...] = ()
    tilt: float = 0.0
    held_out: bool = False
    outside: bool = False
    drive: tuple[float, ...] = ()  # joint, then amplitude N m, frequency 1/s and phase of each of two sines, on q

    known: tuple[Array, Array] | None = None
    speed: Array | None = None
    tip_inertia: float = 0.0
    tip_at: float | None = None

    def strongest(self, joint: int) -> float:
        """N m, the largest known torque at a joint; 0 where it is locked."""
        if joint in self.locked:
            return 0.0
        if self.known is not None:
            return float(np.abs(self.known[1][:, joint]).max())
        return self.drive[1] + self.drive[4] if self.drive and int(self.drive[0]) == joint else 0.0

    def torque(self, times: Array) -> Array:
        """(m,) N m, the known torque at times from the release."""
        a, w, p, b, v, r = self.drive[1:]
        return np.asarray(a * np.sin(w * times + p) + b * np.sin(v * times + r))


class Law(NamedTuple):
    """One law of ``planting.laws`` at a joint (index of the leg's joints), perhaps tied to a second."""

    law: int
    joint: int
    par: tuple[float, ...]
    second: int = -1
    base: bool = False  # acts on the base's first coordinate instead of a joint


class Base(NamedTuple):
    """A mount that moves: bodies from the ground up, each (hinge or slide, direction, arm, mass, inertia, k, b)."""

    bodies: tuple[tuple[float, ...], ...]


class Bend(NamedTuple):
    """A link that bends: hinges at these shares of its length, each with rate and damping."""

    joint: int
    shares: tuple[float, ...]
    rates: tuple[float, ...]
    dampings: tuple[float, ...]


@dataclass(frozen=True)
class Truth:
    """The leg as it really is: parameters, further bodies, laws, and what the mount and springs hide."""

    leg: PlantedLeg
    laws: tuple[Law, ...] = ()
    base: Base | None = None
    bends: tuple[Bend, ...] = ()
    tilt: float = 0.0  # of the mount, beside the leg's and the trial's
    bare: tuple[int, ...] = ()  # joints whose spring and damper a law replaces (backlash)
    rotors: tuple[tuple[int, float], ...] = ()  # joint, kg m^2 that turn with it
    drive: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of a known torque: share too much, N m too much, s too late
    drive_joint: int = -1  # whose torque is wrong, where several joints are driven


class Assembly(NamedTuple):
    """Arrays for the engine, and where the leg's joints are among its coordinates."""

    body: Array
    fixed: NDArray[np.bool_]
    law: NDArray[np.int64]
    at: NDArray[np.int64]
    par: Array
    joint: NDArray[np.int64]
    gravity: float
    table: Array  # (rows, 2), of known torques over time and dampers over speed


def assemble(truth: Truth, trial: PlantedTrial) -> Assembly:
    """The chain of bodies for one trial."""
    leg, rows, where = truth.leg, [], []
    root = leg.tilt + trial.tilt + truth.tilt
    if truth.base is not None:
        for kind, direction, arm, mass, inertia, rate, damping in truth.base.bodies:
            rows.append([arm, mass, 0.0, inertia, rate, damping, 0.0, kind, direction, 0.0, 0.0])
    for i in range(leg.n):
        length, mass, com, inertia, rate, damping, free = leg.values[:, i]
        if i == leg.n - 1 and trial.tip_mass:
            whole, place = mass + trial.tip_mass, length if trial.tip_at is None else trial.tip_at
            centre = (mass * com + trial.tip_mass * place) / whole
            inertia = inertia + mass * (com - centre) ** 2 + trial.tip_mass * (place - centre) ** 2
            inertia += trial.tip_inertia
            mass, com = whole, centre
        if i in truth.bare:
            rate = damping = 0.0
        where.append(len(rows))
        rotor = sum(size for joint, size in truth.rotors if joint == i)
        rotor += 0.0 if leg.rotors is None else float(leg.rotors[i])
        first = [length, mass, com, inertia, rate, damping, free, bodies.HINGE, 0.0, root if i == 0 else 0.0, rotor]
        bend = next((b for b in truth.bends if b.joint == i), None)
        rows += [first] if bend is None else _bent(first, bend)
    fixed = np.zeros(len(rows), dtype=bool)
    fixed[[where[i] for i in trial.locked]] = True
    joint = np.array(where)
    laws = truth.laws
    if trial.drive:
        gain, offset, delay = truth.drive
        joint_driven, a_, w_, p_, b_, v_, r_ = trial.drive
        signal = ((1 + gain) * a_, w_, p_, (1 + gain) * b_, v_, r_, offset, delay)
        laws = (*laws, Law(DRIVE, int(joint_driven), signal))
    tables, more = _tabled(truth, trial)
    laws = (*laws, *more)
    at = np.array([[0 if w.base else joint[w.joint], joint[w.second if w.second >= 0 else w.joint]] for w in laws])
    at = at.reshape(-1, 2).astype(np.int64)
    for k, w in enumerate(laws):
        if w.base:
            at[k] = 0
    par = np.array([[*w.par, *(8 - len(w.par)) * [0.0]] for w in laws]).reshape(-1, 8)
    return Assembly(
        np.array(rows), fixed, np.array([w.law for w in laws], dtype=np.int64), at, par, joint, leg.gravity, tables
    )


def _tabled(truth: Truth, trial: PlantedTrial) -> tuple[Array, tuple[Law, ...]]:
    """Rows of all tables one below the other, and the laws that look them up."""
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
            made.append(Law(DRIVE_TABLE, j, (1 + gain, offset, delay, float(count), float(len(times)))))
            rows.append(np.column_stack([times, torques[:, j]]))
            count += len(times)
    return np.ascontiguousarray(np.concatenate(rows)), tuple(made)


def _bent(whole: list[float], bend: Bend) -> list[list[float]]:
    """A link cut at the hinges: mass shared by length about the centre of mass, the whole's mass, com, inertia kept.

    Uniform pieces have the whole's mass; what the whole's com and inertia differ from a uniform rod's goes, as a change
    of com and inertia, to the pieces in proportion to their mass.
    """
    length, mass, com, inertia = whole[:4]
    cuts = [0.0, *bend.shares, 1.0]
    shift = com - 0.5 * length
    rows = []
    pieces = [(b - a) for a, b in pairwise(cuts)]
    middles = [0.5 * (a + b) * length + shift for a, b in pairwise(cuts)]
    spread = sum(p * mass * (x - com) ** 2 for p, x in zip(pieces, middles, strict=True))
    own = max(inertia - spread, 0.0)  # shared as piece^3, as rods have it
    cubes = sum(p**3 for p in pieces)
    for k, (share, middle) in enumerate(zip(pieces, middles, strict=True)):
        row = [share * length, share * mass, middle - cuts[k] * length, max(own * share**3 / cubes, 1e-4 * inertia)]
        if k == 0:
            row += whole[4:]
        else:
            row += [bend.rates[k - 1], bend.dampings[k - 1], 0.0, bodies.HINGE, 0.0, 0.0, 0.0]
        rows.append(row)
    return rows


def _initial(a: Assembly, pose: Array, rest: Array) -> tuple[Array, NDArray[np.int64], Array]:
    """Coordinates, contact modes and memories of a leg held still at ``pose``, having come from ``rest``."""
    q = np.zeros(len(a.body))
    q[a.joint] = pose
    free = np.ones(len(q), dtype=bool)
    free[a.joint] = False
    if free.any():
        q = _settle(a, q, free)
    mode, z = np.zeros(len(a.law), dtype=np.int64), np.zeros((len(a.law), 2))
    for k, law in enumerate(a.law):
        i = a.at[k, 0]
        u = q[i] - a.par[k, 1]
        if law in (SLACK, SLACK_ARM):
            z[k, 0] = np.sign(u) * max(abs(u) - a.par[k, 2], 0.0)
            mode[k] = int(np.sign(z[k, 0])) if law == SLACK else 0
        elif law == BOUC_WEN:
            z[k, 0] = _loaded(q[i] - rest[list(a.joint).index(i)], a.par[k])
    return q, mode, z


def _loaded(travel: float, p: Array) -> float:
    """Bouc-Wen's memory after a slow move by ``travel`` from z = 0."""
    z, w = 0.0, travel / 200
    for _ in range(200):
        r = z / p[1]
        size = abs(r) ** (p[2] - 1)
        z += w - (1 - p[3]) * abs(w) * size * r - p[3] * w * size * abs(r)
    return z


def _settle(a: Assembly, q: Array, free: NDArray[np.bool_]) -> Array:
    """Static equilibrium of the free coordinates, the others held: Newton on the accelerations, no laws."""
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
        q[index] -= np.clip(step, -0.3, 0.3)
        if np.abs(step).max() < 1e-10:
            return q
    raise ArithmeticError("no rest found")


def rest_pose(leg: PlantedLeg, trial: PlantedTrial, tilt: float = 0.0) -> Array:
    """(n,) rad where the leg comes to rest on its springs, the locked joints at the trial's pose."""
    a = assemble(Truth(leg, tilt=tilt), trial._replace(tip_mass=trial.tip_mass))
    start = leg.of("free_angle").copy()
    start[list(trial.locked)] = trial.pose[list(trial.locked)]
    return _settle(a, start, ~a.fixed)


class Motion(NamedTuple):
    """Rotations and speeds of the leg's joints, ``step`` apart, the first at release."""

    step: float
    angle: Array
    speed: Array

    def at(self, times: Array) -> Array:
        """(m,) s from the release -> (m, n) rad; cubic between steps, at its first speed before the release."""
        return np.stack([self.joint(i, times) for i in range(self.angle.shape[1])], axis=1)

    def joint(self, i: int, times: Array) -> Array:
        """The same for one joint, which may have times of its own."""
        x = np.clip(times / self.step, 0.0, len(self.angle) - 1)
        k = np.minimum(x.astype(int), len(self.angle) - 2)
        s, h = x - k, self.step
        a, b, u, v = self.angle[k, i], self.angle[k + 1, i], self.speed[k, i] * h, self.speed[k + 1, i] * h
        d = b - a
        a = a + np.minimum(times, 0.0) * self.speed[0, i]
        return np.asarray(a + s * (u + s * (3 * d - 2 * u - v + s * (u + v - 2 * d))))


def release(truth: Truth, trial: PlantedTrial, step: float, rest: Array | None = None) -> Motion:
    """Let the leg go at the trial's pose, from rest or at the trial's speed."""
    a = assemble(truth, trial)
    q, mode, z = _initial(a, trial.pose, trial.pose if rest is None else rest)
    w = np.zeros(len(q))
    if trial.speed is not None:
        w[a.joint] = np.where(a.fixed[a.joint], 0.0, trial.speed)
    return _run(a, mode, z, q, w, trial.start + trial.duration, step)


def _run(
    a: Assembly, mode: NDArray[np.int64], z: Array, q: Array, w: Array, span: float, step: float, begin: float = 0.0
) -> Motion:
    count = int(np.ceil(span / step - 1e-9)) + 1
    angle, speed = engine.simulate(
        a.body, a.gravity, a.fixed, a.law, a.at, a.par, a.table, mode, z, q, w, begin, step, count
    )
    if not np.isfinite(angle).all() or np.abs(angle).max() > 50.0:
        raise ArithmeticError("the motion has no bounds")
    return Motion(step, angle[:, a.joint], speed[:, a.joint])


def swing(leg: PlantedLeg, trial: PlantedTrial, angle: Array, speed: Array, step: float, tilt: float = 0.0) -> Motion:
    """The plain leg from a given state at the recording's start; locked joints keep ``angle``."""
    a = assemble(Truth(leg, tilt=tilt), trial)
    none = np.zeros(len(a.law), dtype=np.int64)
    w = np.where(a.fixed, 0.0, speed)
    still = np.zeros((len(a.law), 2))
    return _run(a, none, still, np.array(angle, dtype=float), w, trial.duration, step, trial.start)


def fastest(truth: Truth, trial: PlantedTrial) -> float:
    """1/s, the largest eigenvalue of the linearised chain (no laws): what the step must follow."""
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
    for law, at, par in zip(a.law, a.at, a.par, strict=True):  # what the laws add in stiffness
        if law in (SLACK, SLACK_ARM):
            k = k + (free == at[0]) * par[0]
            b = b + (free == at[0]) * par[3]
        if law == DAMPER_TABLE:
            rows = a.table[int(par[1]) : int(par[1] + par[2])]
            slopes = np.diff(rows[:, 1]) / np.diff(rows[:, 0])
            b = b + (free == at[0]) * max(float(slopes.max()) - par[0], 0.0)
    matrix = np.block([[np.zeros_like(inverse), np.eye(len(free))], [-inverse * k, -inverse * b]])
    return float(np.abs(np.linalg.eigvals(matrix)).max())

"""A torsion spring with both arms clamped, bent by the joint: shape and torque. Plain arithmetic, no solids.

Seen along the hinge axis the wire is a thin inextensible beam in a plane. It is bent by a moment about the axis and a
force, so its curvature changes by ``tau + a x + b y`` at the point (x, y), with the axis at the origin (moment of a
force about a point; Euler-Bernoulli beam of flexural rigidity EI: M = EI dkappa). One end is fixed, the other rotates
with the joint about the axis. The three unknowns follow from the angle and position of that end. ``EI tau`` is the
joint's torque.

To first order the torque is ``EI theta / L_eff`` with ``L_eff = L - S' J^-1 S``, where ``S`` and ``J``
are the first and second moments of the wire's length about the axis. The reduction of L comes from the radially rigid
axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Solution = tuple[Array, Array]  # points (n, 2) mm, and the load (3,) over EI
STEPS_A_TURN = 48  # with these the torque is within 2e-4 of the closed form (tests/cad/test_flexed_wire.py)
STEPS_AN_ARM = 8  # as fine as the coil, of an arm about as long as the coil is wide
LARGEST_STEP = 20.0  # deg, joint rotation from one solution to the next: Newton's method converges in 3 to 5 steps
ROUNDS = 30  # Newton steps; it converges in 3 to 5, else the wire cannot be bent so far
ASTRAY = 1e4  # mm, change of a round that does not converge
SETTLED = 1e-9  # mm and rad, residual of a converged solution
UNDER_WAY = 1e-2  # mm and rad, the same of one from which only the next is started


@dataclass(frozen=True)
class FlexedWire:
    """The wire seen along the axis, from the fixed end to the rotated one; right hand.

    The fixed arm's coil end is at (radius, 0), its free end at (radius, -arm). ``points`` (n, 2) mm, ``lengths`` (n,)
    mm along the wire, ``curvature`` (n - 1,) 1/mm, ``torque`` over EI, 1/mm, and the force on the axis over EI, 1/mm^2.
    """

    points: Array
    lengths: Array
    curvature: Array
    torque: float
    force: float
    first: int  # index of the point where the coil begins
    last: int  # and ends


def effective_length(radius: float, coils: float, arm: float) -> float:
    """Length (mm) of a straight beam with the stiffness of the spring with clamped arms: rate = EI / length.

    The integrals over two arms and a coil of ``coils`` turns are in closed form; ``arm`` is the free length of each.
    """
    phi = 2 * math.pi * coils
    c, s = math.cos(phi), math.sin(phi)
    length = radius * phi + 2 * arm
    # First arm: (R, -t); coil: R (cos, sin); second arm: R u + t v with u = (c, s), v = (-s, c); t from 0 to arm.
    half, third = arm**2 / 2, arm**3 / 3
    sx = radius * arm + radius**2 * s + radius * arm * c - half * s
    sy = -half + radius**2 * (1 - c) + radius * arm * s + half * c
    coil = radius**3
    jxx = radius**2 * arm + coil * (phi / 2 + s * c / 2) + radius**2 * arm * c * c - 2 * radius * half * c * s
    jxx += third * s * s
    jyy = third + coil * (phi / 2 - s * c / 2) + radius**2 * arm * s * s + 2 * radius * half * s * c + third * c * c
    jxy = -radius * half + coil * s * s / 2 + radius**2 * arm * c * s
    jxy += radius * half * (c * c - s * s) - third * s * c
    taken = (sx * sx * jyy - 2 * sx * sy * jxy + sy * sy * jxx) / (jxx * jyy - jxy * jxy)
    return length - taken


def flex_wire(radius: float, coils: float, arm: float, closing: float) -> FlexedWire | None:
    """The wire when the joint closes its arms by ``closing`` deg (negative: opens); None if there is no solution."""
    turn = 2 * math.pi * coils
    n_coil = max(16, math.ceil(STEPS_A_TURN * coils))
    steps = np.concatenate([
        np.full(STEPS_AN_ARM, arm / STEPS_AN_ARM),
        np.full(n_coil, radius * turn / n_coil),
        np.full(STEPS_AN_ARM, arm / STEPS_AN_ARM),
    ])  # fmt: skip
    free = np.zeros(len(steps))
    free[STEPS_AN_ARM : STEPS_AN_ARM + n_coil] = 1.0 / radius
    unloaded = _points(steps, free, radius, arm)
    load, points = np.zeros(3), unloaded
    way, before = _way(math.radians(closing)), (unloaded, load)
    for number, angle in enumerate(way, start=1):
        settled = SETTLED if number == len(way) else UNDER_WAY
        # It starts as far beyond the last solution as that is beyond the one before it; if that is too far, there.
        beyond = (2 * points - before[0], 2 * load - before[1])
        found = _solve_turn(steps, free, unloaded, beyond, angle, settled)
        if found is None:
            found = _solve_turn(steps, free, unloaded, (points, load), angle, settled)
        if found is None:
            return None
        before, (points, load) = (points, load), found
    middle = (points[1:] + points[:-1]) / 2
    curvature = free + load[0] + middle @ load[1:]
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    force = float(np.hypot(load[1], load[2]))
    return FlexedWire(points, lengths, curvature, float(load[0]), force, STEPS_AN_ARM, STEPS_AN_ARM + n_coil)


def _way(angle: float) -> list[float]:
    count = math.ceil(abs(math.degrees(angle)) / LARGEST_STEP)
    return [angle * (index + 1) / count for index in range(count)]


def _points(steps: Array, curvature: Array, radius: float, arm: float) -> Array:
    """Points (n, 2) mm of a wire of piecewise constant ``curvature``, exact for arcs."""
    half = 0.5 * curvature * steps
    heading = math.pi / 2 + np.cumsum(2.0 * half) - half
    chord = steps * np.divide(np.sin(half), half, out=np.ones_like(half), where=half != 0.0)
    points = np.zeros((len(steps) + 1, 2))
    np.cumsum(chord * np.cos(heading), out=points[1:, 0])
    np.cumsum(chord * np.sin(heading), out=points[1:, 1])
    points += (radius, -arm)
    return points


def _solve_turn(
    steps: Array, free: Array, unloaded: Array, start: Solution, angle: float, settled: float
) -> Solution | None:
    """Points and load (3,) for which the far end has turned by ``angle`` rad about the axis; None without a solution.

    ``settled`` mm and rad : the residual at which it is taken.

    Newton's method on the load, with the derivative for a wire that stays where it lies; where it lies follows in the
    same rounds. If that does not settle, because the wire is thin for its load, it is followed with each load.
    """
    c, s = math.cos(angle), math.sin(angle)
    x, y = unloaded[-1]
    wanted = np.array([angle, c * x - s * y, s * x + c * y])
    found = _solve_together(steps, free, unloaded, start, wanted, settled)
    return found if found is not None else _in_turn(steps, free, unloaded, *start, wanted)


def _solve_together(
    steps: Array, free: Array, unloaded: Array, start: Solution, wanted: Array, settled: float
) -> Solution | None:
    points, load = start
    radius, arm = float(unloaded[0, 0]), -float(unloaded[0, 1])
    for _ in range(ROUNDS):
        middle = (points[1:] + points[:-1]) / 2
        bent = load[0] + middle @ load[1:]
        moved = _points(steps, free + bent, radius, arm)
        residual = np.array([float(bent @ steps), *moved[-1]]) - wanted
        change, points = float(np.abs(moved - points).max()), moved
        if not change < ASTRAY:
            return None
        if max(change, float(np.abs(residual).max())) < settled:
            return points, load
        # A change of curvature at a point turns the rest of the wire about it.
        middle = (points[1:] + points[:-1]) / 2
        reach = points[-1] - middle
        by_load = np.column_stack([np.ones(len(steps)), middle]) * steps[:, None]
        by_turn = np.column_stack([np.ones(len(steps)), -reach[:, 1], reach[:, 0]])
        try:
            load = load - np.linalg.solve(by_turn.T @ by_load, residual)
        except np.linalg.LinAlgError:
            return None
    return None


def _in_turn(steps: Array, free: Array, unloaded: Array, points: Array, load: Array, wanted: Array) -> Solution | None:
    radius, arm = float(unloaded[0, 0]), -float(unloaded[0, 1])

    def shape(load: Array, points: Array) -> tuple[Array, Array]:
        for _ in range(ROUNDS):  # the curvature depends on where the wire lies
            middle = (points[1:] + points[:-1]) / 2
            bent = free + load[0] + middle @ load[1:]
            moved = _points(steps, bent, radius, arm)
            change = float(np.abs(moved - points).max())
            points = moved
            if change < SETTLED:
                break
        turned = float(np.sum((bent - free) * steps))
        return points, np.array([turned, *points[-1]]) - wanted

    scale = np.array([1.0, 1.0 / radius, 1.0 / radius]) / float(np.sum(steps))
    for _ in range(ROUNDS):
        points, residual = shape(load, points)
        if not np.isfinite(residual).all() or np.abs(points).max() > ASTRAY:
            return None
        if np.abs(residual).max() < 1e3 * SETTLED:
            return points, load
        jacobian = np.empty((3, 3))
        for index in range(3):
            step = 1e-4 * scale[index]
            nudged = load.copy()
            nudged[index] += step
            jacobian[:, index] = (shape(nudged, points)[1] - residual) / step
        try:
            load = load - np.linalg.solve(jacobian, residual)
        except np.linalg.LinAlgError:
            return None
    return None

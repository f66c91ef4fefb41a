"""Mechanics of the planar chain in numpy: inertia and gravity coefficients, momentum, rest pose.

It is written for clarity and used where speed does not matter: setup of the compiled chain, weak form,
equilibria, and as the reference with which tests compare the compiled chain. With absolute rotations
``phi_i = tilt + q_1 + ... + q_i`` measured from straight down, the kinetic energy is
``1/2 sum_ij (A_ij cos(phi_i - phi_j) + B_ij sin(phi_i - phi_j)) dphi_i dphi_j`` and the potential energy
``sum_i (H_i sin(phi_i) - G_i cos(phi_i))``; B and H are due to centres of mass beside the lines of their links
(Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 2; for a serial chain of point-hinged links A and G are
those of any n-pendulum text, and B and H follow with the direction of a link's first moment turned from its line).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Leg, Tip

FROUDE = "equal Froude numbers: the square root of the ratio of leg length over gravity"
STEPS = 100  # of a search for the rest pose
FAR = 0.3  # rad, the longest step of one joint, over which sines are nearly linear
LEVEL = 1e-9  # of the largest stiffness, below which a curvature is rounding


@dataclass(frozen=True)
class Coefficients:
    """Inertia ``inertia[i, j]`` (n, n) kg m^2, symmetric, and gravity moments ``gravity`` (n,) N m.

    ``inertia_across`` (n, n) kg m^2, antisymmetric, and ``gravity_across`` (n,) N m : the same of centres of mass
    beside the lines of their links; B and H above.
    ``armature`` (n,) kg m^2 turns with the joints: a rotor behind a gear stores ``1/2 armature dq^2``, so the armature
    is added to the diagonal of the mass matrix in joint coordinates (Featherstone 2008, section 9.6).
    """

    inertia: Array
    gravity: Array
    armature: Array
    inertia_across: Array
    gravity_across: Array

    @property
    def weight(self) -> Array:
        """(n,) N m, the largest moment of gravity on each link about its joint."""
        return np.hypot(self.gravity, self.gravity_across)

    def weight_moments(self, phi: Array) -> Array:
        """(..., n) N m, the slope of the potential energy by the absolute rotations ``phi`` (..., n) rad."""
        return np.asarray(self.gravity * np.sin(phi) + self.gravity_across * np.cos(phi))

    def weight_stiffness(self, phi: Array) -> Array:
        """(..., n) N m/rad, its curvature."""
        return np.asarray(self.gravity * np.cos(phi) - self.gravity_across * np.sin(phi))


def coefficients(leg: Leg, tip_mass: float | Tip = 0.0) -> Coefficients:
    """Inertia and gravity coefficients of a leg with a tip mass; a plain number is a point mass (kg) at the end."""
    n = len(leg.joints)
    tip = tip_mass if isinstance(tip_mass, Tip) else Tip(tip_mass)
    length = np.array([joint.link.length for joint in leg.joints])
    mass = np.array([joint.link.mass for joint in leg.joints])
    com = np.array([joint.link.com for joint in leg.joints])
    across = mass * np.array([joint.link.com_across for joint in leg.joints])
    own = np.array([joint.link.about_joint for joint in leg.joints])
    outboard = np.concatenate([np.cumsum(mass[::-1])[::-1][1:], [0.0]]) + tip.mass
    reach = np.append(length[:-1], tip.place(length[-1]))  # distance from the joint at which the outboard mass acts
    own[-1] += tip.inertia
    first_moment = mass * com + outboard * reach
    inertia, beside = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        inertia[i, i] = own[i] + outboard[i] * reach[i] ** 2
        for j in range(i + 1, n):
            inertia[i, j] = inertia[j, i] = length[i] * first_moment[j]
            beside[i, j] = length[i] * across[j]
            beside[j, i] = -beside[i, j]
    return Coefficients(inertia, leg.gravity * first_moment, leg.armature, beside, leg.gravity * across)


def absolute(rotation: Array, tilt: float) -> Array:
    """Rotations q (..., n) rad to absolute rotations phi (..., n) rad."""
    return tilt + np.cumsum(rotation, axis=-1)


def momentum_and_force(coefficient: Coefficients, rotation: Array, rate: Array, tilt: float) -> tuple[Array, Array]:
    """Generalised momentum outboard of each joint, and the force on it other than the joint's torque.

    Parameters
    ----------
    rotation, rate : (n_time, n) rad and rad/s, joint coordinates.

    Returns
    -------
    momentum, force : (n_time, n) N m s and N m; for each joint j, d(momentum_j)/dt = force_j + torque_j. This is
        Lagrange's equation in absolute rotations, summed over the links outboard of j, so that only joint j's torque
        remains in it.
    """
    # From the sines and cosines of n angles, not of n^2 differences. With C_i = sum_j A_ij cos(phi_j) w_j and S_i
    # likewise of the sines, sum_j A_ij cos(phi_i - phi_j) w_j is cos(phi_i) C_i + sin(phi_i) S_i, and with the sine of
    # the difference sin(phi_i) C_i - cos(phi_i) S_i. B's terms are those with sine and minus cosine in their place.
    phi, omega = absolute(rotation, tilt), np.cumsum(rate, axis=-1)
    sine, cosine = np.sin(phi), np.cos(phi)
    along, across = (cosine * omega) @ coefficient.inertia, (sine * omega) @ coefficient.inertia
    momentum = cosine * along + sine * across
    turning = cosine * across - sine * along
    if coefficient.inertia_across.any():
        along, across = ((part * omega) @ coefficient.inertia_across.T for part in (cosine, sine))
        momentum += sine * along - cosine * across
        turning += cosine * along + sine * across
    force = omega * turning - coefficient.weight_moments(phi)
    outboard = (np.cumsum(values[:, ::-1], axis=1)[:, ::-1] for values in (momentum, force))
    return next(outboard) + coefficient.armature * rate, next(outboard)


def mass_matrix(coefficient: Coefficients, rotation: Array, tilt: float) -> Array:
    """(n, n) kg m^2, the mass matrix in joint coordinates at one pose (n,) rad."""
    phi = absolute(rotation, tilt)
    n = len(phi)
    lower = np.tril(np.ones((n, n)))
    between = phi[:, None] - phi[None, :]
    absolute_matrix = coefficient.inertia * np.cos(between) + coefficient.inertia_across * np.sin(between)
    return np.asarray(lower.T @ absolute_matrix @ lower + np.diag(coefficient.armature))


def outboard_inertia(leg: Leg, tip_mass: float | Tip = 0.0) -> Array:
    """(n,) kg m^2, inertia about each joint of the straight leg: of all outboard links and of the joint's armature."""
    found = coefficients(leg, tip_mass)
    hanging = np.array([found.inertia[i:, i:].sum() for i in range(len(leg.joints))])
    return np.asarray(hanging + found.armature)


def static_torque(coefficient: Coefficients, rotation: Array, tilt: float) -> Array:
    """(..., n) N m, joint torques that hold the pose ``rotation`` (..., n) rad against gravity."""
    moment = coefficient.weight_moments(absolute(rotation, tilt))
    return np.asarray(np.cumsum(moment[..., ::-1], axis=-1)[..., ::-1])


def rest_pose(leg: Leg, tip_mass: float | Tip = 0.0, start: Array | None = None, held: Sequence[int] = ()) -> Array:
    """(n,) rad, rotations at which springs and gravity balance, stably; joints ``held`` stay as in ``start``.

    Newton's method from ``start`` (n,) rad, by default the springs' free angles; where it ends nowhere, or in a maximum
    or saddle of energy, such as a link that stands upright, the minimum to which the energy falls from ``start``.

    Raises
    ------
    ArithmeticError : no equilibrium is found, or there is no stiffness in some direction.
    """
    balance = _Balance(coefficients(leg, tip_mass), leg.spring_rate, leg.rest, leg.tilt, tuple(held))
    nothing = balance.nothing
    first = leg.rest.copy() if start is None else np.array(start, dtype=float)
    rotation = first
    for _ in range(STEPS):
        residual = balance.torque(rotation)
        if np.abs(residual).max() <= nothing:
            if balance.stable(rotation):
                return rotation
            break
        try:
            step = np.linalg.solve(balance.stiffness(rotation), residual)
        except np.linalg.LinAlgError:
            raise ArithmeticError(f"no rest pose of {leg.name!r}: it has no stiffness in some direction") from None
        rotation = rotation - np.clip(step, -FAR, FAR)
    return _descend_energy(balance, first, leg.name)


@dataclass(frozen=True)
class _Balance:
    """Springs and gravity on a chain at rest: ``rate`` (n,) N m/rad, ``rest`` (n,) rad, ``tilt`` rad.

    Joints ``held`` need no torque, and are stiff by themselves.
    """

    coefficient: Coefficients
    rate: Array
    rest: Array
    tilt: float
    held: tuple[int, ...] = ()

    @property
    def size(self) -> float:
        """N m/rad, of the largest stiffness."""
        return max(1e-12, float(self.coefficient.weight.max() + self.rate.max()))

    @property
    def nothing(self) -> float:
        """N m, an imbalance that is rounding."""
        return 1e-13 * self.size

    def energy(self, rotation: Array) -> float:
        """J, of gravity and springs."""
        phi = absolute(rotation, self.tilt)
        height = self.coefficient.gravity_across @ np.sin(phi) - self.coefficient.gravity @ np.cos(phi)
        return float(height + 0.5 * self.rate @ (rotation - self.rest) ** 2)

    def torque(self, rotation: Array) -> Array:
        """(n,) N m, the slope of the energy."""
        found = self.rate * (rotation - self.rest) + static_torque(self.coefficient, rotation, self.tilt)
        found[list(self.held)] = 0.0
        return np.asarray(found)

    def stiffness(self, rotation: Array) -> Array:
        """(n, n) N m/rad, the curvature of the energy."""
        lower = np.tril(np.ones((len(rotation), len(rotation))))
        weight = np.diag(self.coefficient.weight_stiffness(absolute(rotation, self.tilt)))
        found = np.diag(self.rate) + lower.T @ weight @ lower
        for j in self.held:
            found[j, :] = found[:, j] = 0.0
            found[j, j] = self.size
        return np.asarray(found)

    def stable(self, rotation: Array) -> bool:
        """Whether the energy curves down in no direction; a balanced joint without spring is indifferent."""
        return bool(np.linalg.eigvalsh(self.stiffness(rotation))[0] >= -LEVEL * self.size)


def _descend_energy(balance: _Balance, start: Array, name: str) -> Array:
    """(n,) rad, a minimum of energy below ``start``; from a maximum or saddle to the side where angles grow.

    Newton's method with the stiffness's eigenvalues made positive, halved until the energy falls (Nocedal and Wright,
    *Numerical Optimization*, 2nd ed., section 3.4).
    """
    rotation = start.copy()
    for _ in range(STEPS):
        residual = balance.torque(rotation)
        values, ways = np.linalg.eigh(balance.stiffness(rotation))
        if np.abs(residual).max() <= balance.nothing:
            if values[0] >= -LEVEL * balance.size:
                return rotation
            way = ways[:, 0] * np.sign(ways[int(np.argmax(np.abs(ways[:, 0]))), 0])
            rotation = rotation + FAR * way
            continue
        step = -ways @ ((ways.T @ residual) / np.maximum(np.abs(values), LEVEL * balance.size))
        step *= min(1.0, FAR / float(np.abs(step).max()))
        before = balance.energy(rotation)
        # Near the minimum the energy changes by less than its rounding: whole steps, as Newton's.
        while balance.energy(rotation + step) > before + 1e-15 * balance.size and np.abs(step).max() > 1e-6:
            step *= 0.5
        rotation = rotation + step
    raise ArithmeticError(f"no stable rest pose found for {name!r}: the last torque imbalance was {residual} N m")


def froude_time_scale(source: Leg, target: Leg) -> float | None:
    """How much slower ``target`` moves than ``source`` at equal Froude numbers; None if one is without gravity.

    With Fr = v^2 / (g L) and angles kept, times go as sqrt(L / g) (Alexander & Jayes, J. Zoology 201 (1983) 135).
    """
    if source.gravity == 0.0 or target.gravity == 0.0:
        return None
    return sqrt(target.total_length / target.gravity / (source.total_length / source.gravity))

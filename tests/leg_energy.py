"""Energy of a chain by its coefficients: what an undamped motion keeps."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Leg, Tip
from synth.swing.mechanics import absolute, coefficients


def energy(leg: Leg, rotation: Array, rate: Array, tip_mass: float | Tip = 0.0) -> Array:
    """Sum of kinetic, gravity and spring energy (n_time,) J for rotation (rad) and rate (rad/s), (n_time, n) each."""
    coefficient = coefficients(leg, tip_mass)
    phi = absolute(rotation, leg.tilt)
    omega = np.cumsum(rate, axis=-1)
    difference = phi[:, :, None] - phi[:, None, :]
    kinetic = 0.5 * np.einsum("ij,tij,ti,tj->t", coefficient.inertia, np.cos(difference), omega, omega)
    kinetic += 0.5 * np.einsum("ij,tij,ti,tj->t", coefficient.inertia_across, np.sin(difference), omega, omega)
    kinetic = kinetic + 0.5 * rate**2 @ coefficient.armature
    potential = np.sin(phi) @ coefficient.gravity_across - np.cos(phi) @ coefficient.gravity
    for index, joint in enumerate(leg.joints):
        if joint.spring is not None:
            potential = potential + 0.5 * joint.spring.rate * (rotation[:, index] - joint.rest) ** 2
    return np.asarray(kinetic + potential)

"""Dry friction, constant in speed (Coulomb 1785), smoothed at standstill."""

from __future__ import annotations

from math import sqrt

from numba import njit


@njit(inline="always", fastmath=True, error_model="numpy")  # type: ignore[untyped-decorator]
def torque(rotation: float, rate: float, friction: float, transition: float) -> float:
    """Torque on q: ``-friction * rate / sqrt(rate^2 + transition^2)``.

    ``friction`` N m >= 0; ``transition`` rad/s > 0 is the speed below which the sign is smoothed: under it the joint
    creeps where a real one sticks, at no more than ``transition`` times the share of the friction that would hold it.
    """
    return -friction * rate / sqrt(rate * rate + transition * transition)

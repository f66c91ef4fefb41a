"""Laws of named effects as torque against speed or deflection, for comparison with the missing torque.

Each formula is that of the effect's own file in ``synth.swing.effects``, for steady sliding. Torques are positive in
the positive direction of the measured angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

Law = Callable[[float], float]  # speed (rad/s) or deflection (rad) -> torque (N m)
Numbers = Mapping[str, float]  # an effect's parameters, SI


def _coulomb(p: Numbers) -> Law:
    creep = p.get("creep", 0.0)

    def torque(w: float) -> float:
        bend = min(abs(w) / creep, 1.0) if creep > 0.0 else 1.0
        return -math.copysign(p["torque"] * bend * (1.5 - 0.5 * bend * bend), w)

    return torque


def _stribeck(p: Numbers) -> Law:
    def torque(w: float) -> float:
        size = p["torque"] * (1.0 - p["fall"] + p["fall"] * math.exp(-((w / p["speed"]) ** 2)))
        return -math.copysign(size, w)

    return torque


def _quadratic(p: Numbers) -> Law:
    speed, exponent = p.get("speed", 1.0), p.get("exponent", 2.0)
    return lambda w: -math.copysign(p["coefficient"] * speed**2 * abs(w / speed) ** exponent, w)


def _hardening(p: Numbers) -> Law:
    onset, reach, exponent = p.get("onset", 0.0), p.get("reach", 1.0), p.get("exponent", 3.0)

    def torque(u: float) -> float:
        beyond = max(0.0, abs(u) - onset) / reach
        return -math.copysign(p["stiffening"] * beyond**exponent, u) if beyond > 0.0 else 0.0

    return torque


OF_SPEED: Mapping[str, Callable[[Numbers], Law]] = {
    "coulomb_friction": _coulomb,
    "stribeck_friction": _stribeck,
    "quadratic_damping": _quadratic,
}
OF_DEFLECTION: Mapping[str, Callable[[Numbers], Law]] = {"hardening_spring": _hardening}


def law_of(effect: str, parameters: Numbers, column: str) -> Law | None:
    """The effect's torque against ``speed`` or ``deflection``; None if it also depends on other quantities."""
    made = (OF_SPEED if column == "speed" else OF_DEFLECTION).get(effect)
    if made is None or parameters.get("softening"):
        return None
    try:
        law = made(parameters)
        law(0.1)
    except (KeyError, OverflowError, ZeroDivisionError):
        return None
    return law

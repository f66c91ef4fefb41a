"""A joint's damper in the forms of other engines' joints, with the loss of each form.

MuJoCo's joints know ``a w + b w|w| + c w^3`` and dry friction; its dry friction, given its own viscous slope, is a
clamped speed, ``slope * clamp(w, -s, s)``, and a sum of those is any curve that bends downwards, exactly.
SDF's and URDF's joints know one linear rate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isclose

import numpy as np

from synth.arrays import Array
from synth.swing.damper_curves import clamps, thin, torque_at
from synth.swing.leg_model import Joint
from synth.units import significant

DRAG = "quadratic_damping"
IN_DAMPING = ("shear_thinning_damping", DRAG)  # effects that are included in the damper's curve
LEAST = 1e-9  # of the largest torque, below which a term is dropped
WORTH_SAYING = 0.02  # of the largest torque: a smaller error of the straight line is not reported
ROUNDED = 1e-3  # of the largest torque: more than twice what rounding to four digits leaves (test_mjcf_dampers.py)
SAME_ANGLE = 1e-9  # rad: what a leg file's digits leave


@dataclass(frozen=True)
class DampingTerms:
    """Damper torque as ``sum slope_m clamp(w, +-speed_m) + a w + b w|w| + c w^3``, all positive: it always damps.

    ``error``: largest error over the speeds that matter, as a share of the largest torque there.
    """

    speed: tuple[float, ...]  # rad/s
    slope: tuple[float, ...]  # N m s/rad
    polynomial: tuple[float, float, float]
    error: float

    def torque(self, speed: Array) -> Array:
        """Torque (N m) at speeds (rad/s), any shape."""
        a, b, c = self.polynomial
        found = a * speed + b * speed * np.abs(speed) + c * speed**3
        for limit, slope in zip(self.speed, self.slope, strict=True):
            found = found + slope * np.clip(speed, -limit, limit)
        return np.asarray(found)


def damper_torque(joint: Joint, speed: Array) -> Array:
    """Torque (N m) that resists ``speed`` (rad/s, any shape): rate or curve, with the effects that belong to it."""
    damper, held = joint.damper, joint.effects
    torque = np.zeros_like(speed)
    if damper is not None and damper.curve is not None:
        torque = torque_at(thin(damper.curve), speed)
    elif damper is not None and damper.rate is not None:
        torque = damper.rate * speed
    thinning = held.get("shear_thinning_damping")
    if thinning is not None:
        loss, scale, knee = (thinning.get(name, off) for name, off in (("loss", 0.5), ("speed", 1.0), ("knee", 2.0)))
        torque = torque * (1.0 + (np.abs(speed / scale) + 1e-9) ** knee) ** (-loss / knee)
    drag = held.get(DRAG)
    if drag is not None:
        scale, exponent = drag.get("speed", 1.0), drag.get("exponent", 2.0)
        torque = torque + drag["coefficient"] * scale**2 * np.abs(speed / scale) ** exponent * np.sign(speed)
    return np.asarray(torque)


def damping_terms(joint: Joint, fastest: float) -> DampingTerms:
    """The damper in MuJoCo's terms over 0 to ``fastest`` rad/s, by least squares with positive coefficients.

    A table that bends downwards but for the rounding of its numbers is represented up to its end.
    """
    exact = _exact_terms(joint)
    if exact is not None:
        return exact
    damper = joint.damper
    corners = np.geomspace(fastest / 300.0, fastest, 14)
    if damper is not None and damper.curve is not None:
        table = thin(damper.curve)
        corners = clamps(table)[0][:-1]
        if not any(name in joint.effects for name in IN_DAMPING):
            found = _fitted_terms(joint, fastest, corners, max(fastest, table.speed[-1]), (1,))
            if found.error <= ROUNDED:
                return found
    # Up to the fastest speed a clamp at or above it is the linear term, and beyond it would hold the torque.
    return _fitted_terms(joint, fastest, corners[corners < fastest], fastest, (1, 2, 3))


def _fitted_terms(joint: Joint, fastest: float, corners: Array, upto: float, powers: tuple[int, ...]) -> DampingTerms:
    """Clamps at ``corners`` (rad/s) and powers of the speed, fitted up to ``upto``; their error up to ``fastest``."""
    from scipy.optimize import nnls  # only here: its import takes longer than everything else written

    even, near_zero = np.linspace(0.0, upto, 120)[1:], np.geomspace(fastest / 1e3, upto, 80)
    grid = np.unique(np.concatenate([corners, even, near_zero, [fastest]]))
    wanted = damper_torque(joint, grid)
    terms = np.column_stack([np.minimum(grid[:, None], corners), *(grid**power for power in powers)])
    scale = terms.max(axis=0)
    found = nnls(terms / scale, wanted)[0] / scale
    found[found * scale < LEAST * wanted.max()] = 0.0
    slope = found[: len(corners)]
    kept, within = slope > 0.0, grid <= fastest
    error = float(np.abs(terms @ found - wanted)[within].max() / wanted[within].max())
    a, b, c = (*(float(value) for value in found[len(corners) :]), 0.0, 0.0)[:3]
    return DampingTerms(tuple(corners[kept].tolist()), tuple(slope[kept].tolist()), (a, b, c), error)


def _exact_terms(joint: Joint) -> DampingTerms | None:
    """The damper where MuJoCo's terms hold it at every speed: a rate or a concave curve, drag of power 2 or 3."""
    damper, drag = joint.damper, joint.effects.get(DRAG, {"coefficient": 0.0})
    exponent = drag.get("exponent", 2.0)
    if "shear_thinning_damping" in joint.effects or exponent not in (2.0, 3.0):
        return None
    speed, slope = np.empty(0), np.empty(0)
    rate = 0.0 if damper is None else damper.rate or 0.0
    if damper is not None and damper.curve is not None:
        speed, slope = clamps(thin(damper.curve))
        # Of the steepest piece: of a straight line the others, all but one, are nothing but rounding.
        slope[np.abs(slope) <= LEAST * float(np.cumsum(slope[::-1]).max())] = 0.0
        speed, slope, rate = speed[:-1], slope[:-1], float(slope[-1])
        if (slope < 0.0).any() or rate < 0.0:
            return None
    size = drag["coefficient"] * drag.get("speed", 1.0) ** (2.0 - exponent)
    terms = (rate, size, 0.0) if exponent == 2.0 else (rate, 0.0, size)
    kept = slope > 0.0
    return DampingTerms(tuple(speed[kept].tolist()), tuple(slope[kept].tolist()), terms, 0.0)


def without_drag(joint: Joint) -> Joint:
    """The joint with its damper alone: drag acts on the link, on the other side of a backlash."""
    return replace(joint, effects={name: given for name, given in joint.effects.items() if name != DRAG})


def drag_terms(joint: Joint, fastest: float) -> DampingTerms:
    """The joint's drag without its damper, in powers of the speed, fitted over 0 to ``fastest`` rad/s where inexact."""
    alone = replace(joint, damper=None, effects={DRAG: joint.effects[DRAG]} if DRAG in joint.effects else {})
    return _exact_terms(alone) or _fitted_terms(alone, fastest, np.empty(0), fastest, (1, 2, 3))


def linear_damping(joint: Joint, fastest: float) -> tuple[float, str]:
    """The straight line (N m s/rad) nearest to the damper up to ``fastest`` rad/s, and its error in words.

    The words are empty for a damper that is a line itself.
    """
    speed = np.linspace(0.0, fastest, 200)[1:]
    torque = damper_torque(joint, speed)
    rate = float(speed @ torque / (speed @ speed))
    largest = float(np.abs(torque).max())
    error = float(np.abs(rate * speed - torque).max()) / largest if largest > 0.0 else 0.0
    if error <= WORTH_SAYING:
        return rate, ""
    slow = rate * speed[0] / float(torque[0]) if torque[0] > 0.0 else np.inf
    return rate, (
        f"the damper's torque-speed curve is a straight line here, off by at most {error:.0%} of its largest torque up "
        f"to {significant(fastest * 30.0 / np.pi, 3)} rpm; in slow motion its torque is {slow:.2g} times the damper's"
    )


def without_held(joint: Joint, names: tuple[str, ...]) -> list[str]:
    """The joint's effects that are not in ``names``, sorted; a stop at the ends of its range is that range."""
    held = {*names, "joint_stop"} if stops_at_range(joint) else {*names}
    return sorted(set(joint.effects) - held)


def stops_at_range(joint: Joint) -> bool:
    """Whether the joint's stops are at both ends of its range, which every format states as limits."""
    stop = joint.effects.get("joint_stop")
    if stop is None or joint.range is None:
        return False
    ends = (stop.get("lower", -inf), stop.get("upper", inf))
    return all(isclose(a, b, abs_tol=SAME_ANGLE) for a, b in zip(ends, joint.range, strict=True))

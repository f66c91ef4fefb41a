"""Springs of MuJoCo's fixed tendons on one hinge, as what a leg knows of a spring: hardening, or a rate on each side.

The other direction of ``synth.files.mjcf_springs``. Such a tendon is a polynomial of what the hinge's angle exceeds a
dead band by. A leg has one power of the deflection beyond an onset, alike on both sides (``hardening_spring``), and
another rate on either side (``one_sided_spring``); a hinge whose tendons are anything else keeps none of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from synth.files.robots.robot_tree import RobotJoint

FAR = 1e3  # rad, from where a bound of a dead band is none: no joint turns as far
NONE: dict[int, tuple[float, float]] = defaultdict(lambda: (0.0, 0.0))  # coefficients by tendon
YIELDS: dict[int, float] = defaultdict(float)  # by tendon, of older versions of MuJoCo
SAME = 1e-9  # rad, or relative: numbers of a file that differ by rounding
Side = Literal["above", "below", "both"]


@dataclass(frozen=True)
class SpringTendon:
    """A tendon's spring; ``low``, ``high`` rad, its dead band, ``terms`` N m/rad, N m/rad^2, N m/rad^3 beyond."""

    tendon: int
    low: float
    high: float
    terms: tuple[float, float, float]

    @property
    def side(self) -> Side:
        """Where it acts."""
        if self.low <= -FAR:
            return "above"
        return "below" if self.high >= FAR else "both"

    @property
    def power(self) -> int:
        """Power of the single term; 0 if there are several."""
        held = [power for power, value in enumerate(self.terms, 1) if value]
        return held[0] if len(held) == 1 else 0

    @property
    def strength(self) -> float:
        """Coefficient of the single term."""
        return self.terms[self.power - 1]


def spring_of(model: Any, tendon: int) -> SpringTendon | None:
    """The tendon's spring, if it has one and nothing else."""
    if model.tendon_limited[tendon] or model.tendon_frictionloss[tendon] or model.tendon_damping[tendon]:
        return None
    if getattr(model, "tendon_springyield", YIELDS)[tendon]:
        return None
    # Older versions of MuJoCo have linear terms only.
    square, cube = (float(value) for value in getattr(model, "tendon_stiffnesspoly", NONE)[tendon])
    damped = any(getattr(model, "tendon_dampingpoly", NONE)[tendon])
    terms = (float(model.tendon_stiffness[tendon]), square, cube)
    low, high = (float(value) for value in model.tendon_lengthspring[tendon])
    return SpringTendon(tendon, low, high, terms) if any(terms) and not damped else None


def with_springs(joint: RobotJoint, tendons: Sequence[SpringTendon]) -> RobotJoint | None:
    """The joint with the springs of its tendons; None if a leg does not know such a spring."""
    if not tendons or not joint.stiffness:
        return None
    sides = [item for item in tendons if item.power == 1 and item.side != "both"]
    rest = [item for item in tendons if item not in sides]
    found = joint
    if sides:
        losses = _losses(joint, sides)
        if losses is None:
            return None
        found = replace(found, losses=losses)
    if rest:
        hardening = _hardening(joint, rest)
        if hardening is None or joint.hardening is not None:
            return None
        found = replace(found, hardening=hardening[:2], onset=hardening[2])
    return found


def _losses(joint: RobotJoint, sides: Sequence[SpringTendon]) -> tuple[float, float, float] | None:
    """Shares of the rate that are lost above and below, and the changeover's distance (rad) from the free angle."""
    above = [item for item in sides if item.side == "above"]
    below = [item for item in sides if item.side == "below"]
    places = [item.high - joint.rest for item in above] + [item.low - joint.rest for item in below]
    if len(above) > 1 or len(below) > 1 or max(places) - min(places) > SAME:
        return None
    lost = [-sum(item.strength for item in each) / joint.stiffness for each in (above, below)]
    return lost[0], lost[1], 0.0 if abs(places[0]) <= SAME else places[0]


def _hardening(joint: RobotJoint, tendons: Sequence[SpringTendon]) -> tuple[float, float, float] | None:
    """Stiffening (N m at a radian), exponent and onset (rad) of one law that is odd about the free angle."""
    powers = {item.power for item in tendons}
    if len(powers) != 1 or 0 in powers:
        return None
    (power,) = powers
    first = tendons[0]
    if len(tendons) == 1 and first.side == "both" and power in (1, 3):
        onset = first.high - joint.rest
        even = abs(joint.rest - first.low - onset) <= SAME
        return (first.strength, float(power), max(onset, 0.0)) if even and onset >= -SAME else None
    by_side = {item.side: item for item in tendons}
    if len(tendons) != 2 or set(by_side) != {"above", "below"} or power == 1:
        return None
    above, below = by_side["above"], by_side["below"]
    onset, other = above.high - joint.rest, joint.rest - below.low
    # Below its dead band MuJoCo's excess is negative: a quadratic term of the same sign there would not resist.
    pulled = below.strength if power == 3 else -below.strength
    odd = abs(onset - other) <= SAME and abs(above.strength - pulled) <= SAME * abs(above.strength)
    return (above.strength, float(power), max(onset, 0.0)) if odd and onset >= -SAME else None

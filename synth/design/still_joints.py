"""Joints that hardly move as built, and joints for which even the weakest damper is far too strong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.design.choose_dampers import DamperOption
from synth.estimation.intervals import Estimate
from synth.remarks import decisive
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import Damper
from synth.units import quantity

STILL = 0.25  # of the wanted motion's width: what moves less shows nothing of it; a good choice is within a tenth
LEAST_MOTION = 1.0  # deg; a joint that is wanted to move less is wanted to stay
# Times the wanted rate: a damping ratio of 0.1 then becomes 1, so that no swing is left; no spring makes up for it.
TOO_STRONG = 10.0
WEAKER = (
    "Let a gear turn the damper slower (ratios below 1: the rate at the joint falls with their square), add a weaker "
    "damper to a table under select.catalogs, or build the leg larger or heavier."
)
ANOTHER = "Choose another damper or spring for it, or want another motion."


@dataclass(frozen=True)
class JointSwing:
    """How far a joint turns, rad, from end to end of its widest release: as wanted and as built.

    ``weakest``: of its dampers, with ``times`` the wanted rate at the wanted motion's fastest speed; 0: not known.
    """

    joint: str
    wanted: float
    built: float
    weakest: str = ""
    times: float = 0.0

    @property
    def still(self) -> bool:
        """Whether it hardly moves as built."""
        return degrees(self.wanted) >= LEAST_MOTION and not self.built >= STILL * self.wanted

    @property
    def too_strong(self) -> bool:
        """Whether even its weakest damper damps far too strongly."""
        return self.times > TOO_STRONG

    @property
    def warnings(self) -> list[str]:
        """What is told of it; nothing of a joint that moves with a damper of the right size."""
        strong = (
            f"no damper that meets its constraints is weak enough: the weakest, {self.weakest}, damps "
            f"{self.times:.2g} times as strongly as wanted"
        )
        if not self.still:
            return [decisive(f"{self.joint}: {strong}", WEAKER)] if self.too_strong else []
        moved = f"as built it turns by {degrees(self.built):.2g} deg, where the wanted motion turns by "
        text = f"{self.joint}: {moved}{degrees(self.wanted):.3g} deg"
        return [decisive(f"{text}; {strong}", WEAKER)] if self.too_strong else [decisive(text, ANOTHER)]

    def as_json(self) -> dict[str, Any]:
        """Both widths, and whether the joint hardly moves."""
        return {"wanted": quantity(self.wanted, "deg"), "built": quantity(self.built, "deg"), "still": self.still}


def widths(motions: Sequence[Array]) -> Array:
    """(n,) rad, how far each joint turns in the widest of the motions, (m, n) rad."""
    return np.asarray(np.max([np.ptp(motion, axis=0) for motion in motions], axis=0))


def secant(damper: Damper, speed: float) -> float:
    """The damper's torque over speed, N m s/rad, at ``speed`` rad/s."""
    if damper.curve is None:
        return damper.rate or 0.0
    return float(torque_at(damper.curve, np.array([speed]))[0]) / speed


def swing_of(
    joint: str, turned: tuple[float, float], wanted_rate: Estimate | None, speed: float, dampers: Sequence[DamperOption]
) -> JointSwing:
    """A joint's swing.

    Parameters
    ----------
    turned
        rad, as wanted and as built.
    wanted_rate
        of its damper, N m s/rad. The upper end of its interval counts: a small one may be uncertain.
    speed
        rad/s, the highest of the wanted motion. There the torque of a damper whose curve flattens is least above that
        of a straight line.
    dampers
        those that were tried.
    """
    if wanted_rate is None or not dampers or speed <= 0.0:
        return JointSwing(joint, *turned)
    rates = [secant(option.damper, speed) for option in dampers]
    most = max(wanted_rate.value, wanted_rate.high or 0.0)
    weakest = int(np.argmin(rates))
    times = rates[weakest] / most if most > 0.0 else 0.0
    return JointSwing(joint, *turned, dampers[weakest].label, times)

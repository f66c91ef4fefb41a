"""The requirements on a torsion spring to design, and the check that they are possible."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import get_args

from synth.errors import UserError, did_you_mean
from synth.files.spring_words import Hand, Objective, System
from synth.parts.coil_angle import Convention
from synth.parts.coil_rate import RateForm
from synth.spring.calibration import UNCALIBRATED, WindingCalibration
from synth.spring.spring_task import FreeArm, SpringLimits, SpringTask

_WORDS = {
    "convention": get_args(Convention),
    "system": (None, *get_args(System)),
    "objective": get_args(Objective),
    "hand": get_args(Hand),
    "rate_form": get_args(RateForm),
}


@dataclass(frozen=True)
class SpringRequirements:
    """The requirements on a spring; SI units, angles in rad.

    Parameters
    ----------
    rate
        N m/rad.
    travel
        largest angle from the free position in the direction that winds the coil.
    opening_travel
        largest angle from the free position in the other direction.
    included_angle, convention
        angle between the legs of the free spring; it determines the fraction of the coils.
    leg_lengths
        of each straight leg, from the coil to where the load acts, m.
    material, system
        wire material; ``inch``, ``metric`` or None for both.
    wire_range
        thinnest and thickest wire, m.
    hand
        ``right`` or ``left``, see ``winding.hand_for``.
    rate_form
        formula of the rate: ``bending`` (64) or ``friction`` (10.8 per turn).
    calibration
        factors measured on wound samples of this wire and winder.
    objective
        ``mass``: of the springs that are nearly as light as the lightest, the one with the smallest larger dimension
        (diameter or length). ``space``: the smallest cylinder, then the lightest. ``life``: the highest fatigue
        strength, then the lightest.
    held_wire
        m; a spring of this wire is preferred if one keeps all limits and lasts, and is not much heavier (larger, less
        enduring) than the best.
    free_arm
        free length of arms that the joint clamps, m, which makes the wire's moment uneven; a function of wire and mean
        diameter (m) and coils where it depends on them. None: they are not clamped.
    pitch
        axial advance per coil over the wire diameter; 1: touching coils.
    """

    rate: float
    travel: float
    opening_travel: float = 0.0
    included_angle: float = math.radians(90.0)
    convention: Convention = "tangent"
    leg_lengths: tuple[float, float] = (0.025, 0.025)
    material: str = "music wire"
    system: System | None = None
    objective: Objective = "mass"
    limits: SpringLimits = field(default_factory=SpringLimits)
    hand: Hand = "right"
    rate_form: RateForm = "bending"
    calibration: WindingCalibration = UNCALIBRATED
    held_wire: float | None = None
    wire_range: tuple[float, float] = (0.0, math.inf)
    free_arm: FreeArm | None = None
    pitch: float = 1.0

    @property
    def task(self) -> SpringTask:
        """The requirements that are the same for every candidate."""
        return SpringTask(
            self.travel,
            self.opening_travel,
            self.leg_lengths,
            self.convention,
            self.limits,
            self.hand,
            self.rate_form,
            self.calibration,
            self.free_arm,
            self.pitch,
        )


def require_possible(wish: SpringRequirements) -> None:
    """Refuse requirements that no spring can have.

    Raises
    ------
    UserError : with every such requirement and its allowed range.
    """
    wrong: list[str] = []
    if not (math.isfinite(wish.rate) and wish.rate > 0.0):
        wrong.append(f"the rate must be above 0, not {wish.rate:.4g} N*m/rad")
    if not (math.isfinite(wish.travel) and wish.travel > 0.0):
        wrong.append(f"the travel must be above 0, not {math.degrees(wish.travel):.4g} deg")
    if not (math.isfinite(wish.opening_travel) and wish.opening_travel >= 0.0):
        wrong.append(f"the opening travel must be 0 or more, not {math.degrees(wish.opening_travel):.4g} deg")
    if min(wish.leg_lengths) < 0.0:
        wrong.append("a leg's length must be 0 or more")
    for name, allowed in _WORDS.items():
        value = getattr(wish, name)
        if value not in allowed:
            words = [str(word) for word in allowed]
            near = did_you_mean(str(value), words) or f"; choose one of {', '.join(words)}"
            wrong.append(f'{name}: "{value}" is not allowed{near}')
    if wish.limits.cycles is not None and not 1.0 <= wish.limits.cycles <= 1e6:
        wrong.append(f"fatigue limits are known for 1 to 1e6 cycles, not for {wish.limits.cycles:.4g}")
    if wish.limits.safety < 1.0:
        wrong.append(f"the safety factor must be 1 or more, not {wish.limits.safety:.4g}: the spring would yield")
    if not 0.0 <= wish.limits.arbor_gap < 1.0:
        wrong.append(
            "the arbor gap is a fraction of the inside diameter and must be 0 or more and below 1, not "
            f"{wish.limits.arbor_gap:.4g}"
        )
    if wrong:
        raise UserError("; ".join(wrong))

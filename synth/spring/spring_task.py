"""What is asked of a torsion spring, the limits that it keeps, and a limit that it violates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from synth.files.spring_words import Hand
from synth.parts.coil_angle import Convention
from synth.parts.coil_rate import RateForm
from synth.spring.calibration import UNCALIBRATED, WindingCalibration

FreeArm = Callable[[float, float, float], float]  # of wire and mean diameter (m) and coils: an arm's free length, m


@dataclass(frozen=True)
class SameArm:
    """A free length of arms, m, that does not depend on the coil; a ``FreeArm``."""

    length: float

    def __call__(self, wire: float, mean: float, coils: float) -> float:
        """The length, m."""
        return self.length


@dataclass(frozen=True)
class SpringLimits:
    """The limits on a spring; lengths in m, None: no limit.

    Parameters
    ----------
    arbor_diameter
        diameter of the shaft inside the coil.
    arbor_gap
        diametral clearance to the arbor at full travel, as a fraction of the wound inside diameter; vendors ask for
        about 10 %.
    min_inside_diameter, min_outer_diameter
        of the free coil.
    max_outer_diameter
        of the coil at its widest: free, or opened by ``opening_travel``.
    max_body_length
        of the coil at its longest: at full travel.
    min_body_length
        of the free coil.
    index_range
        D/d: below 4 the wire cracks when wound, above 20 the coil does not hold its diameter (EN 13906-3).
    min_coils, max_coils
        of the body. With fewer than 2 coils the theory does not hold (EN 13906-3). Designs have at least
        ``FEWEST_COILS`` if any such spring keeps the limits.
    safety
        yield stress over the allowable stress at full travel.
    cycles, fatigue_safety
        required number of full-travel cycles, at most 1e6, and the fatigue safety factor (strength over stress) for it.
        None: no life is required, and ``DESIGN_LIFE`` is preferred if a spring reaches it.
    bend_radius
        inside radius of the bend where a radial or axial arm leaves the coil; None: equal to the wire diameter.
    """

    arbor_diameter: float | None = None
    arbor_gap: float = 0.10
    min_inside_diameter: float | None = None
    max_outer_diameter: float | None = None
    max_body_length: float | None = None
    index_range: tuple[float, float] = (4.0, 20.0)
    min_coils: float = 2.0
    max_coils: float = 30.0
    safety: float = 1.1
    cycles: float | None = None
    fatigue_safety: float = 1.0
    bend_radius: float | None = None
    min_outer_diameter: float | None = None
    min_body_length: float | None = None

    def least_wound_inside(self) -> float | None:
        """Smallest wound inside diameter that keeps the clearance ``arbor_gap`` to the arbor, m."""
        return None if self.arbor_diameter is None else self.arbor_diameter / (1.0 - self.arbor_gap)


@dataclass(frozen=True)
class Violation:
    """A limit that a spring violates; ``excess`` is the ratio of value and limit, above 1.

    ``text`` with quantities is a ``UnitText``.
    """

    limit: str
    excess: float
    text: str


@dataclass(frozen=True)
class SpringTask:
    """The requirements that are the same for every candidate: travel, legs, limits, hand, rate formula, calibration.

    ``free_arm`` gives the free length of arms that the joint clamps; None: they are not clamped. ``pitch`` as in
    ``SpringDesign``.
    """

    travel: float
    opening_travel: float = 0.0
    leg_lengths: tuple[float, float] = (0.0, 0.0)
    convention: Convention = "tangent"
    limits: SpringLimits = field(default_factory=SpringLimits)
    hand: Hand = "right"
    rate_form: RateForm = "bending"
    calibration: WindingCalibration = UNCALIBRATED
    free_arm: FreeArm | None = None
    pitch: float = 1.0

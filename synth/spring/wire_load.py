"""Bending moment and stress in a spring's wire at any angle, with arms that the joint clamps or that are free to turn.

With free arms, as makers test a spring, the moment in the coil is the torque. Clamped arms add a force that keeps the
coil on the axis, and the moment has a peak in the coil (``cad.wire_moments``). The peak in the straight arms is nowhere
above it by more than 2 %, and there the curvature factor, 1.03 or more up to an index of 25, does not act: the coil's
inner fibre decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.spring import stress

SETTLED = 1e-7  # relative, of an angle that is found in rounds; each takes a third or less of the error
ROUNDS = 20  # of it; 4 to 10 are needed
LEAST_RATIO = 0.9  # of peak and torque: 0.92 is the least of 2 to 10 coils over 90 deg opened to 180 deg closed


@dataclass(frozen=True)
class PeakRatios:
    """Largest bending moments over the torque ``rate * angle``: in the ``coil`` and in the straight ``arms``."""

    coil: float = 1.0
    arms: float = 1.0


@dataclass(frozen=True)
class WireLoad:
    """A spring whose wire is loaded; ``rate`` N m/rad, lengths in m.

    ``arm`` : free length of each of two clamped arms; None: the arms are not clamped.
    """

    rate: float
    wire_diameter: float
    mean_diameter: float
    body_coils: float
    arm: float | None = None

    def ratios(self, angle: float) -> PeakRatios:
        """The peaks at ``angle`` rad (positive: winds the coil); beyond half of the coils opened those of the half."""
        if self.arm is None:
            return PeakRatios()
        from synth.cad.wire_moments import peak_moments

        turned = math.degrees(max(angle, -math.pi * self.body_coils))
        found = peak_moments(self.mean_diameter * 5e2, self.body_coils, self.arm * 1e3, turned)
        return PeakRatios(found.coil, found.arms)

    def axis_force(self, winding: float, opening: float) -> float | None:
        """Largest force on the joint's axis, N, at the ends of two travels; None if the arms are not clamped.

        ``winding``, ``opening`` : rad, from the free angle. At an end to which the wire cannot be bent there is none.
        """
        if self.arm is None:
            return None
        from synth.cad.flexed_wire import effective_length, flex_wire

        radius, arm = self.mean_diameter * 5e2, self.arm * 1e3
        rigidity = self.rate * 1e3 * effective_length(radius, self.body_coils, arm)  # N mm^2
        ends = (math.degrees(winding), -math.degrees(opening))
        found = [flex_wire(radius, self.body_coils, arm, end) for end in ends if end]
        return max((rigidity * wire.force for wire in found if wire is not None), default=None)

    def stress(self, angle: float, ratios: PeakRatios | None = None) -> float:
        """Largest bending stress at ``angle`` rad, Pa, not negative; ``ratios`` if they are known."""
        peak = (self.ratios(angle) if ratios is None else ratios).coil
        return stress.bending_stress(self.rate * abs(angle) * peak, self.wire_diameter, self.mean_diameter)

    def angle(self, reached: float, sense: int = 1) -> float:
        """Angle (rad, positive) at which the stress is ``reached`` Pa; ``sense`` -1: towards opening."""
        uniform = stress.free_travel(reached, self.rate, self.wire_diameter, self.mean_diameter)
        found = uniform
        for _ in range(1 if self.arm is None else ROUNDS):
            before, found = found, uniform / self.ratios(sense * found).coil
            if abs(found / before - 1.0) < SETTLED:
                break
        return found

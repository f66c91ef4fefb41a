"""The motor of a driven joint and of the jumping leg's hips: one record, for both plants."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GearedMotor:
    """A brushed or equivalent direct-current motor behind a gear.

    All on the rotor's side: ``resistance`` ohm of the winding, ``torque_constant`` N m/A, ``rotor_inertia`` kg m^2,
    ``inductance`` H. ``gear_ratio`` rotor turns per joint turn; ``efficiency`` of the gear when the motor drives.
    ``back_emf_constant`` V s/rad where it was measured by itself; None: that of the torque, the same number in SI. A
    ``torque_constant`` smaller than it holds the gear's loss, as those of catalogues do, from stall and free run.
    """

    resistance: float
    torque_constant: float
    gear_ratio: float = 1.0
    efficiency: float = 1.0
    rotor_inertia: float = 0.0
    inductance: float = 0.0
    back_emf_constant: float | None = None

    @property
    def induced(self) -> float:
        """V s/rad of the rotor, the back-EMF constant."""
        return self.torque_constant if self.back_emf_constant is None else self.back_emf_constant

    @property
    def lag(self) -> float:
        """Electrical time constant of the winding, s."""
        return self.inductance / self.resistance

    @property
    def reflected_inertia(self) -> float:
        """Rotor inertia times the ratio squared, kg m^2."""
        return self.rotor_inertia * self.gear_ratio**2

    @property
    def torque_a_current(self) -> float:
        """N m at the joint per ampere."""
        return self.torque_constant * self.gear_ratio * self.efficiency

    @property
    def strength(self) -> float:
        """N m at the joint per volt at standstill."""
        return self.torque_a_current / self.resistance

    @property
    def short_circuit_damping(self) -> float:
        """N m s/rad, damping at the joint with a short-circuited winding."""
        return self.strength * self.induced * self.gear_ratio

    @property
    def driving_efficiency(self) -> float:
        """Of the gear when the motor drives, with the loss that the torque constant holds; at most 1."""
        return min(1.0, self.efficiency * self.torque_constant / self.induced)

    @property
    def back_efficiency(self) -> float:
        """Of the gear when the load drives it: 2 - 1/efficiency, at least 0.1.

        For friction that is the same either way (Shigley, Mechanical Engineering Design, eq. 8-4 with 8-1: lowering
        torque turns zero where efficiency is one half); 0.1 keeps a self-locking gear finite, also one that passes
        no torque at all.
        """
        driving = self.driving_efficiency
        return 0.1 if driving <= 0.5 else max(0.1, 2.0 - 1.0 / driving)

"""Tolerances of manufacturing and measurement: the nominal leg's parameters as whitened unknowns with priors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from synth.arrays import Array
from synth.swing.lane_layout import DRIVE, SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg

LINK_QUANTITIES = ("length", "mass", "com", "inertia")
QUANTITIES = (*LINK_QUANTITIES, "spring_rate", "damper_rate", "rest", "torque_constant", "resistance")
# For each motor constant: the parameters of a servo that change with it, and the power. What its lag does to the
# controller and to the inertia follows from these (``LegLanes.servo_numbers``, ``own_inertia``), as in the leg. The
# braking is torque constant times back-EMF constant: its power is 1 more where these are one number (``own_emf``).
MOTOR_POWERS = {
    "torque_constant": {"servo_strength": 1, "servo_torque_limit": 1, "servo_back_emf": 1},
    "resistance": {"servo_strength": -1, "servo_back_emf": -1, "servo_sag": -1, "servo_conductance": -1, "lag": -1},
}


class Widths(Protocol):
    """The tolerances of a project."""

    def widths(self, leg: Leg, by_current: Sequence[int]) -> Array:
        """(9, n) standard deviation of each of ``QUANTITIES`` at each joint, relative (rests: rad).

        Rows of motor constants are 0 at joints without a motor, see ``Tolerances`` for ``by_current``.
        """


@dataclass(frozen=True)
class Tolerances:
    """Unknowns ``x`` (9 n,), standard normal: each of ``QUANTITIES`` for all joints.

    ``width`` (9, n) : standard deviation, relative (rests: rad); 0 fixes a parameter at its nominal value.
    ``by_current`` : joints whose torque is known by a motor's recorded current; with its constant the torque is scaled.
    """

    width: Array
    by_current: tuple[int, ...] = ()

    @classmethod
    def of(cls, leg: Leg, tolerance: Widths, by_current: Sequence[int] = ()) -> Tolerances:
        """From the project's tolerances."""
        return cls(tolerance.widths(leg, by_current), tuple(by_current))

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.width.size

    def apply(self, legs: LegLanes, x: Array) -> None:
        """Change the columns of a leg's lanes by ``x`` (9 n, n_lane).

        Relative errors enter as exponentials, so that no mass becomes negative; to first order this is the same.
        """
        n = self.width.shape[1]
        shift = x.reshape(len(QUANTITIES), n, -1) * self.width[:, :, None]
        for q, name in enumerate(QUANTITIES):
            if name in MOTOR_POWERS:
                if self.width[q].any():
                    for number, power in MOTOR_POWERS[name].items():
                        values = legs.lag if number == "lag" else legs.servo[SERVO.index(number)]
                        values *= np.exp(power * shift[q])
                if name == "torque_constant":
                    one_number = ~legs.own_emf
                    legs.servo[SERVO.index("servo_back_emf"), one_number] *= np.exp(shift[q, one_number])
                    for joint in self.by_current:
                        gain = legs.drive[DRIVE.index("torque_gain"), joint]
                        gain += np.expm1(shift[q, joint]) * (1.0 + gain)  # beside that which the leg states
                continue
            values = getattr(legs, name)
            if name == "rest":
                values += shift[q]
            else:
                values *= np.exp(shift[q])
            if name == "com":  # its whole distance from the joint
                legs.com_across *= np.exp(shift[q])

    def leg(self, leg: Leg, x: Array) -> Leg:
        """The nominal leg with these errors."""
        n = self.width.shape[1]
        shift = x.reshape(len(QUANTITIES), n) * self.width
        factor = np.exp(shift)
        joints = []
        for j, joint in enumerate(leg.joints):
            link = replace(
                joint.link,
                length=joint.link.length * factor[0, j],
                mass=joint.link.mass * factor[1, j],
                com=joint.link.com * factor[2, j],
                com_across=joint.link.com_across * factor[2, j],
                inertia=joint.link.inertia * factor[3, j],
            )
            spring, damper = joint.spring, joint.damper
            if spring is not None:
                angle = spring.free_angle + joint.sign * shift[6, j]
                spring = replace(spring, rate=spring.rate * factor[4, j], free_angle=angle)
            if damper is not None and damper.rate is not None:
                damper = replace(damper, rate=damper.rate * factor[5, j])
            drive, effects = joint.drive, joint.effects
            if j in self.by_current:
                # The torque of the recordings was made with the nominal constant.
                if shift[7, j] != 0.0:
                    stated = effects.get("torque_gain", {}).get("share", 0.0)
                    share = float(factor[7, j]) * (1.0 + stated) - 1.0
                    effects = {**effects, "torque_gain": {"share": share}}
            elif drive is not None and drive.motor is not None:
                constant = drive.motor.torque_constant * factor[7, j]
                motor = replace(drive.motor, torque_constant=constant, resistance=drive.motor.resistance * factor[8, j])
                drive = replace(drive, motor=motor)
                if "voltage_sag" in effects:  # which is a share of the winding's, and the same in ohm
                    share = effects["voltage_sag"].get("share", 0.0) / float(factor[8, j])
                    effects = {**effects, "voltage_sag": {"share": share}}
            joints.append(replace(joint, link=link, spring=spring, damper=damper, drive=drive, effects=effects))
        return replace(leg, joints=tuple(joints))

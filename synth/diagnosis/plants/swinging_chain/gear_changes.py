"""Columns of the motor's side of a gear where the joint's are meant: off by the stated ratio."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from synth.drives.servo import Servo
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

LEAST_RATIO = 1.5  # of a gear: with a smaller one, ``torque_gain`` or ``encoder_scale`` is a cause that does the same


@dataclass(frozen=True)
class MotorSide:
    """Columns of a ``joint`` that hold the rotor's; see ``column_changes.Change``.

    ``angle``, ``inputs`` : whether its angles, and its commands or known torques, do. ``ratio`` : rotor turns a turn.
    """

    joint: int
    ratio: float
    angle: bool
    inputs: bool
    text: str
    remedy: str
    either: tuple[str, str] | None = None

    @property
    def scale(self) -> float:
        """Factor by which the angles are larger than as recorded."""
        return 1.0 / self.ratio if self.angle else 1.0

    @property
    def must_follow(self) -> bool:
        """Of angles, which it makes small."""
        return self.angle

    def of_leg(self, leg: Leg) -> Leg:
        """The leg file is not concerned."""
        return leg

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """With the columns of the joint's side."""
        angles, torques, signals, j = trial.angles.copy(), trial.torques, trial.signals, self.joint
        if self.angle:
            angles[:, j] /= self.ratio
        if self.inputs and signals is not None and isinstance(leg.joints[j].drive, Servo):
            command = signals.command.copy()
            command[:, j] /= self.ratio
            signals = replace(signals, command=command)
        elif self.inputs and torques is not None:
            torques = torques.copy()
            torques[:, j] *= self.ratio
        velocities = None if self.angle else trial.velocities
        return replace(trial, angles=angles, velocities=velocities, torques=torques, signals=signals)


def gear_changes(leg: Leg, columns: Sequence[str]) -> list[MotorSide]:
    """Of each joint with a stated gear; ``columns`` : that drive the joints, empty of one without."""
    made = []
    for j, (joint, column) in enumerate(zip(leg.joints, columns, strict=True)):
        motor = None if joint.drive is None else joint.drive.motor
        if motor is None or max(motor.gear_ratio, 1.0 / motor.gear_ratio) < LEAST_RATIO:
            continue
        ratio, has_side = f"{motor.gear_ratio:g}", column.endswith((" command", " torque"))
        by_torque = column.endswith(" torque")
        turn = f"{'multiply' if by_torque else 'divide'} {column} by {ratio}"
        ways = [(True, False, joint.name, f"divide {joint.name} by {ratio}")]
        if has_side:
            ways += [(False, True, column, turn)]
            ways += [(True, True, f"{joint.name} and {column}", f"divide {joint.name} by {ratio} and {turn}")]
        for angle, inputs, names, remedy in ways:
            look = "columns {} look" if angle and inputs else "column {} looks"
            text = f"the {look.format(names)} recorded on the motor's side of the gear, of ratio {ratio}"
            made.append(MotorSide(j, motor.gear_ratio, angle, inputs, text, remedy))
    return made

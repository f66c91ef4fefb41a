"""Meaning of each section and key of a leg file."""

from __future__ import annotations

from synth.files.reference.shared_texts import KIND

SECTIONS: dict[str, str] = {
    "joint": "One item under `joints:`, proximal to distal.",
    "link": "The link that hangs from the joint.",
    "spring": "The torsion spring of the joint; torque is minus rate times the angle from the free angle.",
    "damper": "The rotary damper of the joint; one of `rate`, `curve` and `part`.",
    "drive": "The joint's drive: a position servo, or a motor with known voltage or known current.",
    "motor": "A direct-current motor, rotor side, behind its gear.",
}

KEYS: dict[str, str] = {
    "leg_file.kind": KIND,
    "leg_file.name": "Name of the leg in reports.",
    "leg_file.gravity": "Gravity, downward.",
    "leg_file.tilt": "Rotation of the whole base in the plane, counter-clockwise seen with x right and z up.",
    "leg_file.joints": "1 to 6 joints, proximal to distal, each with the link that hangs from it.",
    "leg_file.effects": "Effects of the base, such as a mount that moves.",
    "joint.name": "The joint's name, as in the headers of recordings.",
    "joint.zero": "Reading of the measured angle when this link points along its parent (the first: straight down).",
    "joint.sign": "+1 where the measured angle grows counter-clockwise (x right, z up), -1 where clockwise.",
    "joint.range": "The joint's travel in measured angle, the smaller end first.",
    "joint.link": "The link that hangs from the joint.",
    "joint.armature": "Inertia that turns with the joint itself, about its axis: rotor times gear ratio squared, gear.",
    "joint.spring": "The torsion spring; omitted if there is none, or if it is estimated.",
    "joint.damper": "The rotary damper; omitted if there is none, or if it is estimated.",
    "joint.drive": "The joint's drive, if there is one.",
    "joint.effects": "Further effects in the model beside spring and damper, each a name with its parameters.",
    "link.length": "Distance to the next joint; for the last link to its end.",
    "link.mass": "The link's mass.",
    "link.com": "Centre of mass: its distance from this joint along the link; negative on the other side of the joint.",
    "link.com_across": "How far the centre of mass lies beside the line from this joint to the next (the last link's: "
    "to its end), positive on the side to which the link turns counter-clockwise: the right of a link that hangs down.",
    "link.inertia": "Moment of inertia about the centre of mass, about an axis normal to the plane.",
    "link.includes": "Whether mass and inertia include the joint's own parts: `joint` yes, `none` no.",
    "spring.rate": "Torque per angle.",
    "spring.free_angle": "Measured angle at which the spring is unloaded.",
    "spring.part": "A catalogue part, whose rate is used if none is given.",
    "damper.rate": "Torque per speed of a linear damper.",
    "damper.curve": "A CSV with `speed [rpm],torque [N*m]`, straight from (0, 0) to its first point; one that falls at "
    "its end keeps its last torque beyond.",
    "damper.part": "A catalogue part, whose law is used if neither rate nor curve is given.",
    "drive.kind": "`servo` follows a commanded angle, `voltage` a known voltage, `torque` a known current or torque.",
    "drive.gain": "Torque (with a motor: duty) per angle from the command.",
    "drive.damping_gain": "Torque (with a motor: duty) per speed.",
    "drive.integral_gain": "Torque (with a motor: duty) per angle from the command and time, summed up. It "
    "begins with the sum that holds the first angle; of a log, `synth gap` estimates it.",
    "drive.integral_limit": "Largest torque (with a motor: duty) of the integral, which then stops to grow; without it "
    "that of the whole controller.",
    "drive.delay": "Time from the recorded command to its effect.",
    "drive.dead_band": "Error of angle within which the servo does nothing.",
    "drive.limit": "One of the three limits below, by its unit: of the torque, the current or the duty.",
    "drive.duty_limit": "Largest share of the supply that the servo applies.",
    "drive.torque_limit": "Largest torque that the drive gives at the joint.",
    "drive.current_limit": "Current limit of the driver.",
    "drive.supply": "Supply voltage, needed by a servo with a motor; recordings with `supply [V]` use theirs instead.",
    "drive.command_rate_limit": "Rate at which the servo's own command approaches the given one, its profile velocity; "
    "0: at once.",
    "drive.source_resistance": "Resistance of battery and leads, which causes voltage sag.",
    "drive.control_period": "Sampling period of the controller, which samples at its multiples from the trial's start; "
    "the duty (without a motor: the torque) is held in between.",
    "drive.commands": "What the controller follows between two commands: each held until the next, or a straight line.",
    "drive.duty_steps": "Number of steps of the duty from 0 to 1, to which it is rounded at each sample.",
    "drive.motor": "The motor, if its physics are modelled.",
    "motor.torque_constant": "Rotor's torque per current, and its back-EMF per speed.",
    "motor.resistance": "Resistance of the winding with brushes and leads.",
    "motor.gear_ratio": "Turns of the rotor per turn of the joint.",
    "motor.efficiency": "Of the gear.",
    "motor.rotor_inertia": "Of the rotor about its own axis.",
    "motor.inductance": "Of the winding: it delays the torque by inductance over resistance, at most 2 ms.",
}

"""The ladder of models: what each has switched on, and the laws of motor, gear and ground that they share.

Motor. ``linear``: T = T_stall (1 - omega/omega_free) at the output, no dynamics (equation 1 of Knaup & Aukes).
``electric``: L di/dt = V - i R - K_e G omega (their equation 3); output torque G (K_t i - f0 sign omega) - G^2 b omega
(their equations 4 and 6) and rotor inertia J G^2. R = V/I_stall, K_e = (V - I_free R)/(G omega_free) (equation 5) and
K_t = T_stall/(G (I_stall - I_free)), friction f0 = K_e I_free: at rest and at free speed that is the maker's own
line, so
``linear`` and ``electric`` differ by what takes time (L, J) and nothing else.

Gear. Torque on the link T = e (T_motor - J G^2 omega'), e = efficiency where the motor drives the link, 1/back
efficiency
where the link drives the motor; e = 1 without ``gear_loss``, where the loss is in K_t. Between the two directions e is
smoothed over ``REVERSE_SPEED``, so a gear that locks creeps at that speed.

Ground. ``linear``: N = k p + c p' while p > 0, which pulls when the foot leaves fast (the lab's own penalty law).
``hunt_crossley``: N = k p (1 + d p') and never below 0 (Hunt & Crossley, J. Applied Mechanics 42 (1975) 440-445, with
exponent 1). In the planar form friction is Coulomb's, regularised: F = -mu N v / sqrt(v^2 + v_s^2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.hopper.layout import LAYOUTS, JumpLayout
from synth.hopper.leg import Array, Contact, HopperLeg, Motor

LOCKED = 80.0 * np.pi / 180.0  # lower links flatter than this in the crouch lock
REVERSE_SPEED = 0.05  # rad/s at the output


@dataclass(frozen=True)
class Model:
    """One rung: its name, what is on, and in words what it is."""

    name: str
    electric: bool
    joint_damping: bool
    gear_loss: bool
    hunt_crossley: bool
    what: str
    engine: str = "lanes"  # or "mujoco", "point"


MODELS: dict[str, Model] = {
    model.name: model
    for model in (
        Model("point_mass", False, False, False, False,
              "a point mass on one link, F = T cos(theta)/l - m g, then ballistic", "point"),
        Model("A", False, False, False, False, "multibody, linear torque-speed motor, linear contact"),
        Model("B", True, False, False, False, "A with winding, rotor inertia and gear friction"),
        Model("C", False, False, False, False, "A in MuJoCo, with a real closed loop", "mujoco"),
        Model("D", False, True, False, False, "A with joint damping"),
        Model("full", True, True, True, True,
              "B and D together, gear efficiency by ratio, ground that never pulls"),
    )
}  # fmt: skip


def lane(leg: HopperLeg, motor: Motor, contact: Contact, model: Model) -> Array:
    """(n_row,) one lane of the workspace: parameters, and the crouch at rest with the weight on the foot."""
    return lanes(leg, motor, contact, model, np.array([leg.length]))[:, 0]


def lanes(leg: HopperLeg, motor: Motor, contact: Contact, model: Model, length: Array) -> Array:
    """(n_row, n_lane) lanes of one leg with these upper links' lengths (n_lane,) m; the crouch must be in reach."""
    layout = LAYOUTS[leg.bending]
    z = np.zeros((layout.n_row, len(length)))
    lower = length * leg.lower_ratio
    mass = _geometry(z, layout, leg, motor, length, lower)
    _drive(z, layout, motor, model)
    _ground(z, layout, contact, model)
    flexures = leg.flexures
    z[layout.row("flexure")] = flexures.rate
    z[layout.row("joint_damping")] = flexures.damping if model.joint_damping else 0.0
    for name in ("hip_rest", "knee_rest", "foot_rest"):
        z[layout.row(name)] = getattr(flexures, name)
    for i in range(layout.n - 1):
        if i != layout.knee - 1:
            whole = length if i < layout.knee else lower
            z[layout.row("beam", i)] = leg.laminate.beam_rate(1.0) / whole
    z[layout.row("stop")] = leg.extended
    z[layout.row("stop_rate")] = leg.stop_rate
    z[layout.row("stop_dissipation")] = leg.stop_dissipation
    a = leg.crouch_angle(length)
    b = np.arcsin((0.5 * leg.hip_spacing + length * np.sin(a)) / lower)
    z[layout.block("angle")][: layout.knee] = a
    z[layout.block("angle")][layout.knee :] = -b
    sag = mass * leg.gravity / contact.stiffness
    z[layout.row("height")] = length * np.cos(a) + lower * np.cos(b) - sag
    return z


def in_reach(leg: HopperLeg, length: Array) -> NDArray[np.bool_]:
    """Lengths whose lower links reach the foot in the crouch and do not lock there."""
    a = leg.crouch_angle(length)
    share = (0.5 * leg.hip_spacing + length * np.sin(a)) / (length * leg.lower_ratio)
    return np.asarray((share < np.sin(LOCKED)) & (a > leg.extended))


def _geometry(z: Array, layout: JumpLayout, leg: HopperLeg, motor: Motor, length: Array, lower: Array) -> Array:
    """Lengths, and the coefficients A_ij and G_i of one side; rods with their mass spread evenly. The whole mass."""
    n, knee = layout.n, layout.knee
    pieces = [length / knee] * knee + [lower / (n - knee)] * (n - knee)
    masses = [leg.laminate.mass_per_length * piece for piece in pieces]
    outboard = [sum(masses[i + 1 :], np.zeros_like(length)) + 0.5 * leg.foot_mass for i in range(n)]
    moment = [(0.5 * masses[i] + outboard[i]) * pieces[i] for i in range(n)]
    for i in range(n):
        z[layout.inertia_row(i, i)] = (masses[i] / 3.0 + outboard[i]) * pieces[i] ** 2
        for j in range(i + 1, n):
            z[layout.inertia_row(i, j)] = pieces[i] * moment[j]
    z[layout.block("length")] = pieces
    z[layout.block("moment")] = moment
    mass: Array = leg.structure_mass + 2 * motor.mass + leg.foot_mass + 2 * sum(masses, np.zeros_like(length))
    z[layout.row("mass")] = 0.5 * mass
    z[layout.row("half_spacing")] = 0.5 * leg.hip_spacing
    z[layout.row("gravity")] = leg.gravity
    return mass


def _drive(z: Array, layout: JumpLayout, motor: Motor, model: Model) -> None:
    """One motor at full voltage, all at the output."""
    values: dict[str, float] = {
        "driving": 1.0,
        "braking": 1.0,
        "reverse_speed": REVERSE_SPEED,
        "voltage": motor.voltage,
    }
    ratio = motor.ratio
    if model.electric:
        constant = motor.back_emf if model.gear_loss else motor.torque_constant
        loss = constant / motor.back_emf  # where the gear's loss is in the torque constant, it is in friction too
        values |= {
            "resistance": motor.resistance,
            "inverse_inductance": 1.0 / motor.inductance,
            "back_emf": ratio * motor.back_emf,
            "torque_constant": ratio * constant,
            "rotor_inertia": motor.reflected_inertia,
            "friction": ratio * motor.friction * loss,
            "viscous": ratio**2 * motor.viscous * loss,
        }
        if model.gear_loss:
            values |= {"driving": motor.efficiency, "braking": 1.0 / motor.back_efficiency}
    else:
        drop = (motor.stall_current - motor.no_load_current) / motor.no_load_speed
        values |= {
            "linear_torque": motor.stall_torque,
            "torque_slope": motor.stall_torque / motor.no_load_speed,
            "linear_current": motor.stall_current,
            "current_slope": drop,
        }
    for name, value in values.items():
        z[layout.row(name)] = value


def _ground(z: Array, layout: JumpLayout, contact: Contact, model: Model) -> None:
    z[layout.row("contact_stiffness")] = contact.stiffness
    if model.hunt_crossley:
        z[layout.row("contact_dissipation")] = contact.dissipation
    else:
        z[layout.row("contact_damping")] = contact.damping
        z[layout.row("may_pull")] = 1.0


def layout_of(leg: HopperLeg) -> JumpLayout:
    """The compiled layout for this leg's pieces."""
    return LAYOUTS[leg.bending]

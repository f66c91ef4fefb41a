"""The models with increasing detail: what each includes, and their common laws of motor, gear and ground.

Motor. ``linear``: T = T_stall (1 - omega/omega_free) at the output, no dynamics (equation 1 of Knaup & Aukes).
``electric``: L di/dt = V - i R - K_e G omega (their equation 3); output torque G (K_t i - f0 sign omega) - G^2 b omega
(their equations 4 and 6) and rotor inertia J G^2. R = V/I_stall, K_e = (V - I_free R)/(G omega_free) (equation 5) and
K_t = T_stall/(G (I_stall - I_free)), friction f0 = K_e I_free: at rest and at free speed this is the maker's own line,
so ``linear`` and ``electric`` differ only by dynamics (L, J).

Gear. Torque on the link T = e (T_motor - J G^2 omega'), e = efficiency when the motor drives the link, 1/back
efficiency when the link drives the motor; e = 1 without ``gear_loss``, when the loss is in K_t. Between the two
directions e is smoothed over ``jump_lanes.REVERSE_SPEED``, so a gear that locks creeps at that speed.

Ground. ``linear``: N = k p + c p' for p > 0, which pulls when the foot lifts fast (the lab's own penalty law).
``hunt_crossley``: N = k p (1 + d p') limited to N >= 0 (Hunt & Crossley, J. Applied Mechanics 42 (1975) 440-445, with
exponent 1). In the planar form friction is Coulomb's, regularised: F = -mu N v / sqrt(v^2 + v_s^2).
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from synth.arrays import Array
from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_lanes import JumpLanes
from synth.jump.jump_layout import LAYOUTS, JumpLayout


@dataclass(frozen=True)
class Model:
    """One model: its name, a description, and what it includes.

    ``electric`` : winding, rotor and friction, else the maker's line; ``hunt_crossley`` : ground by that law, else the
    linear one, which may pull.
    """

    name: str
    what: str
    engine: str = "lanes"  # or "mujoco", "point"
    _: KW_ONLY
    electric: bool = False
    joint_damping: bool = False
    gear_loss: bool = False
    hunt_crossley: bool = False


MODELS: dict[str, Model] = {
    model.name: model
    for model in (
        Model("point_mass", "a point mass on one link, F = T cos(theta)/l - m g, then ballistic", "point"),
        Model("A", "multibody, linear torque-speed motor, linear contact"),
        Model("B", "A with winding, rotor inertia and gear friction", electric=True),
        Model("C", "A in MuJoCo, with a real closed loop", "mujoco"),
        Model("D", "A with joint damping", joint_damping=True),
        Model("full", "B and D together, gear efficiency by ratio, ground that never pulls",
              electric=True, joint_damping=True, gear_loss=True, hunt_crossley=True),
    )
}  # fmt: skip


def lane(leg: HopperLeg, motor: Motor, contact: Contact, model: Model) -> Array:
    """(n_row,) one lane of the workspace: parameters, and the crouch at rest with the weight on the foot."""
    return lanes(leg, motor, contact, model, np.array([leg.length]))[:, 0]


def lanes(leg: HopperLeg, motor: Motor, contact: Contact, model: Model, length: Array) -> Array:
    """(n_row, n_lane) lanes of one leg with upper links of lengths (n_lane,) m; the crouch must be in reach."""
    return columns(leg, motor, contact, model, length).workspace()


def columns(leg: HopperLeg, motor: Motor, contact: Contact, model: Model, length: Array) -> JumpLanes:
    """The columns of ``lanes``, which can be modified first."""
    constant = motor.back_emf_constant if model.gear_loss else motor.torque_constant
    loss = constant / motor.back_emf_constant  # a gear loss in the torque constant also applies to friction
    laminate, flexures = leg.laminate, leg.flexures
    values = {
        "hip_spacing": leg.hip_spacing, "body_mass": leg.structure_mass + 2 * motor.mass, "foot_mass": leg.foot_mass,
        "mass_per_length": laminate.mass_per_length, "bending_stiffness": laminate.bending_stiffness,
        "flexure_rate": flexures.rate, "joint_damping": flexures.damping if model.joint_damping else 0.0,
        "hip_rest": flexures.hip_rest, "knee_rest": flexures.knee_rest, "foot_rest": flexures.foot_rest,
        "extended": leg.extended, "stop_rate": leg.stop_rate, "stop_dissipation": leg.stop_dissipation,
        "gravity": leg.gravity, "ratio": motor.gear_ratio, "voltage": motor.voltage, "supply_resistance": 0.0,
        "resistance": motor.resistance, "inductance": motor.inductance if model.electric else 0.0,
        "back_emf": motor.back_emf_constant, "torque_constant": constant, "rotor_inertia": motor.rotor_inertia,
        "friction": motor.friction * loss, "viscous": motor.viscous * loss, "gear_friction": 0.0,
        "driving": motor.driving_efficiency if model.gear_loss else 1.0,
        "braking": 1.0 / motor.back_efficiency if model.gear_loss else 1.0,
        "stall_torque": motor.stall_torque, "no_load_speed": motor.no_load_speed,
        "stall_current": motor.stall_current, "no_load_current": motor.no_load_current,
        "contact_stiffness": contact.stiffness, "contact_damping": 0.0 if model.hunt_crossley else contact.damping,
        "contact_dissipation": contact.dissipation if model.hunt_crossley else 0.0, "ground_friction": contact.friction,
    }  # fmt: skip
    columns = {name: np.full(len(length), value, dtype=float) for name, value in values.items()}
    return JumpLanes(
        LAYOUTS[leg.bending], model.electric, not model.hunt_crossley, length=np.array(length, dtype=float),
        lower_length=length * leg.lower_ratio, start=leg.crouch_angle(length), **columns,
    )  # fmt: skip


def layout_of(leg: HopperLeg) -> JumpLayout:
    """The compiled layout for this leg's pieces."""
    return LAYOUTS[leg.bending]

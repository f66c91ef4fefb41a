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

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_lanes import JumpLanes, jump_lanes
from synth.jump.jump_layout import LAYOUTS, JumpLayout


@dataclass(frozen=True)
class Model:
    """One model: its name, what it includes, and a description."""

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
    """(n_row, n_lane) lanes of one leg with upper links of lengths (n_lane,) m; the crouch must be in reach."""
    return columns(leg, motor, contact, model, length).workspace()


def columns(leg: HopperLeg, motor: Motor, contact: Contact, model: Model, length: Array) -> JumpLanes:
    """The columns of ``lanes``, which can be modified first."""
    switches = (model.electric, model.joint_damping, model.gear_loss, model.hunt_crossley)
    return jump_lanes(leg, motor, contact, *switches, length)


def layout_of(leg: HopperLeg) -> JumpLayout:
    """The compiled layout for this leg's pieces."""
    return LAYOUTS[leg.bending]

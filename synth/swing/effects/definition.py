"""What an effect is: parameters with units, defaults and priors, and how it changes torque, leg, reading or structure.

An effect acts in exactly one of five ways, each a function of its module that ``Effect.function`` finds by name:

``torque``
    compiled, ``torque(rotation, rate, deflection, spring_rate, damper_rate, damper_torque, bearing_force, memory,
    *parameters) -> (torque on q, rate of change of memory)``, added to the joint's linear spring and damper. All SI
    floats; ``deflection`` is the rotation less the spring's rest, ``damper_torque`` resists positive rates. With
    memory, ``start(deflection, *parameters)`` gives its value at the release (arrays). Where a parameter is meant in
    measured angle, ``to_rotation(sign, zero, *parameters)`` turns all of them to the sense of q.
``leg``
    ``change(legs, joint, sign, *parameters)`` changes the columns of a ``LegLanes`` in place.
``drive``
    ``drive(legs, joint, sign, *parameters)`` changes in place what a ``LegLanes`` holds of a known torque's errors.
``reading``
    ``read(time, rotation, rate, sign, zero, *parameters)`` gives the rotation as the encoder tells it; arrays
    (n_time, n_lane), parameters (n_lane,).
``structure``
    ``extend(legs, joint, *parameters)`` gives a ``LegLanes`` with one more link.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from synth.estimation.parameters import Parameter, PlantEffect, Prior, Shape, positive, signed, size, stiff

__all__ = ["Effect", "Parameter", "Prior", "Shape", "positive", "signed", "size", "stiff"]

Way = Literal["torque", "leg", "drive", "reading", "structure"]
Need = Literal["spring", "no spring", "damper", "torque", "servo", "motor", "stated supply"]
FUNCTIONS: dict[str, str] = {
    "torque": "torque",
    "leg": "change",
    "drive": "drive",
    "reading": "read",
    "structure": "extend",
}
ARGUMENTS: dict[str, int] = {"torque": 8, "leg": 3, "drive": 3, "reading": 5, "structure": 2}  # before the parameters


@dataclass(frozen=True, kw_only=True)
class Effect(PlantEffect):
    """An effect of the swinging chain: how it acts, and what the engine needs to know of it.

    ``where`` : acts at a joint or at the base.
    ``uses_drive`` : its function is given the drive's torque on q, N m, in place of the bearing force.
    ``uses_load`` : the bearing force must be computed for it; ``by_load``: only where one of these strengths is on (no
    name: any). ``bristle`` : the parameter that is the presliding of ``compiled.bristle``, its memory, which the
    integrator keeps in -1..1 and turns over with the joint. ``play`` : the parameter that is the width of a gap, its
    memory being the deflection of what lies behind it; the integrator finds the contacts. ``linear`` : its torque is a
    sum of its strengths, each times what does not depend on any (see ``along``). ``kin`` : effects that share this word
    turn over at the same moments at a joint, so that legs with the one and with the other may step together; and one
    joint has no two of them.
    ``belongs_to`` : the part that takes the effect with it when a design replaces it; what belongs to the joint stays.
    ``needs`` : what a joint must have, one of these, for the effect to act there: a spring or damper with a rate, or a
    known torque in some trial.
    ``shows_locked`` : it shows though its joint is locked: by where the links stand, or by what the link carries along.
    """

    way: Way
    where: Literal["joint", "base"] = "joint"
    memory: bool = False
    bristle: str = ""
    play: str = ""
    uses_drive: bool = False
    uses_load: bool = False
    by_load: tuple[str, ...] = ()
    linear: bool = False
    belongs_to: Literal["joint", "spring", "damper"] = "joint"
    kin: str = ""
    needs: tuple[Need, ...] = ()
    shows_locked: bool = False

    def function(self, name: str = "") -> Callable[..., Any]:
        """The function of its module that computes it."""
        return super().function(name or FUNCTIONS[self.way])

"""Definition of an effect: parameters with units, defaults and priors, and the function that applies it.

An effect acts in exactly one of five ways. Each is a function of its module, which ``Effect.function`` finds by name:

``torque``
    compiled, ``torque(rotation, rate, deflection, spring_rate, damper_rate, damper_torque, bearing_force, memory,
    *parameters) -> (torque on q, rate of change of memory)``, added to the joint's linear spring and damper. All
    arguments are SI floats; ``deflection`` is the rotation minus the spring's rest, ``damper_torque`` resists positive
    rates. With a memory, ``start(deflection, *parameters)`` returns its value at the release (arrays). If a parameter
    refers to the measured angle, ``to_rotation(sign, zero, *parameters)`` converts all of them to the sense of q.
``leg``
    ``change(legs, joint, sign, *parameters)`` changes the columns of a ``LegLanes`` in place.
``drive``
    ``drive(legs, joint, sign, *parameters)`` changes the drive or servo columns of a ``LegLanes`` in place.
``reading``
    ``read(time, rotation, rate, sign, zero, *parameters)`` returns the rotation that the encoder reads; arrays
    (n_time, n_lane), parameters (n_lane,).
``structure``
    ``extend(legs, joint, *parameters)`` returns a ``LegLanes`` with one additional link.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from synth.estimation.parameters import (
    Parameter,
    PlantEffect,
    Prior,
    Shape,
    SimplerEffect,
    positive,
    signed,
    size,
    stiff,
)
from synth.swing.lane_layout import UsesDrive

__all__ = ["Effect", "Parameter", "Prior", "Shape", "SimplerEffect", "positive", "signed", "size", "stiff"]

Way = Literal["torque", "leg", "drive", "reading", "structure"]
Need = Literal[
    "spring", "no spring", "damper", "armature", "no armature", "torque", "servo", "held commands", "motor",
    "stated supply", "shared supply", "time to warm", "driven rotor",
    "recorded current",
]  # fmt: skip
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
    """An effect of the swinging chain: how it acts, and the information that the engine needs.

    ``where`` : it acts at a joint or at the base.
    ``uses_drive`` : the argument ``bearing_force`` of its function is the drive's torque on q, N m; "warms its
    winding": the memory is the relative growth of the winding's resistance, by which the drive's torque falls.
    ``by_drive`` : of one that uses the drive, the strengths that act by its torque alone; empty: all.
    ``uses_load`` : it needs the bearing force; ``by_load`` : only if one of these strengths is on (empty: any).
    ``bristle`` : the parameter that is the presliding of ``inlined.bristle``; the memory is the bend of the bristle,
    which the integrator keeps in -1..1 and reverses with the joint.
    ``play`` : the parameter that is the width of a gap; the memory is the deflection behind the gap, and the integrator
    locates the contacts.
    ``linear`` : its torque is the sum of its strengths, each times a factor independent of all strengths (see
    ``torque_along_motion``).
    ``kin`` : effects with the same word reverse at the same times at a joint, so legs with either may share their
    steps; a joint cannot have two of them.
    ``belongs_to`` : the part with which a design replaces the effect; an effect of the joint itself remains.
    ``needs`` : the joint, or the leg, must have one of these: a spring or damper with a rate, an armature, a known
    torque in some trial. A driven rotor has an inertia, and neither spring nor damper beside it.
    ``changes`` : of the way "leg", the keys of the leg file that hold the numbers it changes, in words.
    ``shows_locked`` : it is visible although its joint is locked, by the pose of the links or by their mass.
    ``bounds`` : name of its function ``(leg, joint, slowest, values)`` that keeps estimated parameters plausible for a
    leg whose slowest joint swings at a given rate, 1/s.
    ``deviation`` : of the way "structure", name of its function ``(legs, link, acceleration)`` that returns how far,
    rad, and how fast, rad/s, an added link without a spring may be off where ``start`` puts it; empty: it has a spring,
    see ``LegLanes.initial_deviation``.
    ``tolerance`` : of the way "structure", rad, the finest to which a diagnosis integrates legs with it.
    ``controls`` : of the way "reading", name of its function ``(controlled, joint, sign, zero, *parameters)`` that
    changes what a servo controls (``LegLanes.controlled``) if that is the reading; empty: it is not.
    ``parts_drive`` : of the way "structure", it parts the drive from the joint's link.
    ``ascending`` : parameters whose values in a file must not fall from each to the next, such as two ends.
    ``any_of`` : parameters with defaults of which a file must give one; empty: none of them need be given.
    """

    way: Way
    where: Literal["joint", "base"] = "joint"
    memory: bool = False
    bristle: str = ""
    play: str = ""
    uses_drive: UsesDrive = ""
    by_drive: tuple[str, ...] = ()
    uses_load: bool = False
    by_load: tuple[str, ...] = ()
    linear: bool = False
    belongs_to: Literal["joint", "spring", "damper"] = "joint"
    kin: str = ""
    needs: tuple[Need, ...] = ()
    changes: str = ""
    shows_locked: bool = False
    bounds: str = ""
    deviation: str = ""
    tolerance: float = 0.0
    controls: str = ""
    parts_drive: bool = False
    ascending: tuple[str, ...] = ()
    any_of: tuple[str, ...] = ()

    def function(self, name: str = "") -> Callable[..., Any]:
        """The function of its module that applies it."""
        return super().function(name or FUNCTIONS[self.way])

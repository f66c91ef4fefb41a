"""The effects of a target leg in a design: which belong to the joint, and which to a part that is replaced.

A diagnosis (``synth gap``) gives the estimated leg: its links, and effects beyond linear springs and dampers. A design
chooses new springs and dampers, so effects of the old ones do not apply (``Effect.belongs_to``). Torques that belong to
a joint are simulated with every candidate spring and damper. Other effects are left out, with a note: a moving base or
a bending link would add degrees of freedom to the chain of the fit and the choice, and an encoder error does not change
the leg's motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from synth.swing.effects import Effect, effect_named
from synth.swing.leg_model import Leg
from synth.units import quantity, shown_unit


@dataclass(frozen=True)
class TargetEffect:
    """One effect of the target: ``joint`` (None for the base), parameters in SI, whether it is kept, and why."""

    effect: Effect
    joint: str | None
    parameters: Mapping[str, float]
    stays: bool
    why: str

    @property
    def sentence(self) -> str:
        """The note on the effect."""
        done = "is in every simulated leg" if self.stays else "is left out"
        return f"{self.effect.name} of the {self.joint or 'base'} {done}: {self.why}"

    def as_json(self) -> dict[str, Any]:
        """The entry under ``target_effects``."""
        unit = {parameter.name: parameter.unit for parameter in self.effect.parameters}
        return {
            "effect": self.effect.name,
            "joint": self.joint or "base",
            "parameters": {n: quantity(v, shown_unit(unit[n])) for n, v in self.parameters.items()},
            "carried_over": self.stays,
            "why": self.why,
        }


@dataclass(frozen=True)
class TargetLeg:
    """The target of a design: ``ideal`` without effects, ``real`` with the effects that are kept."""

    ideal: Leg
    real: Leg
    effects: tuple[TargetEffect, ...]


def target_of(leg: Leg) -> TargetLeg:
    """Sort a target's effects into kept and left-out ones; its springs and dampers are not changed."""
    found = [_target_effect(name, joint.name, given) for joint in leg.joints for name, given in joint.effects.items()]
    found += [_target_effect(name, None, given) for name, given in leg.effects.items()]
    stay = {
        joint.name: {e.effect.name: e.parameters for e in found if e.joint == joint.name and e.stays}
        for joint in leg.joints
    }
    ideal = replace(leg, effects={}, joints=tuple(replace(joint, effects={}) for joint in leg.joints))
    return TargetLeg(ideal, with_effects(ideal, stay), tuple(found))


def with_effects(leg: Leg, effects: Mapping[str, Mapping[str, Mapping[str, float]]]) -> Leg:
    """The leg with these effects at its joints, by joint name."""
    return leg.with_joints(**{name: {"effects": given} for name, given in effects.items()})


def notes(effects: Sequence[TargetEffect]) -> list[tuple[str | None, str]]:
    """Joint (None for the base) and note of each effect."""
    return [(e.joint, f"{e.joint}: {e.sentence}" if e.joint else e.sentence) for e in effects]


def _target_effect(name: str, joint: str | None, parameters: Mapping[str, float]) -> TargetEffect:
    effect = effect_named(name)
    stays, why = _stays(effect)
    return TargetEffect(effect, joint, dict(parameters), stays, why)


def _stays(effect: Effect) -> tuple[bool, str]:
    """Whether the effect is kept and simulated, and why."""
    if effect.belongs_to != "joint":
        return False, f"it belongs to the {effect.belongs_to}, which is replaced"
    if effect.way == "reading":
        return False, "it is an encoder error, and does not change how the leg moves"
    if effect.way == "drive":
        return False, "it is an error of a recording's torque column, and does not change the leg"
    if effect.way == "structure":
        return False, "parts are chosen for a leg of rigid links on a fixed base; look at the built leg's gap again"
    return True, "it belongs to the joint, whatever spring and damper are there"

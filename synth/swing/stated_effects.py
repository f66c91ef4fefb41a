"""The effects that a leg states, in the order in which they act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from synth.swing.effects import registered
from synth.swing.effects.definition import Effect, Way
from synth.swing.leg_model import Leg

COUNTS = "encoder_quantisation"  # which a diagnosis finds from the readings themselves, stated or not
# Ways of effects of which a cause takes the place of the stated one; another way changes a number that the file states.
REPLACED_WAYS: tuple[Way, ...] = ("torque", "reading", "structure")
Place = tuple[str, int]  # name of an effect, and index of its joint


@dataclass(frozen=True)
class StatedEffect:
    """An effect that a leg states, at a ``joint`` (0 for the base); ``given`` : its parameters without the defaults."""

    effect: Effect
    joint: int
    given: Mapping[str, float]

    @property
    def place(self) -> Place:
        """The effect's name and its joint."""
        return self.effect.name, self.joint

    @property
    def values(self) -> list[float]:
        """Its parameters in order, with defaults."""
        return [self.given.get(p.name, self.effect.defaults[p.name]) for p in self.effect.parameters]


def in_order_of_action(effect: Effect) -> tuple[bool, str]:
    """Sort key of effects of one joint: by name, those that part a drive from its link last.

    The link that a rotor drives is then whatever the others have left of it at the joint, and a reading is shifted
    before it is scaled.
    """
    return effect.parts_drive, effect.name


def stated_effects(leg: Leg, way: Way) -> list[StatedEffect]:
    """All effects of one way that a leg states, in the order in which they act."""
    at_joints = [(j, joint.effects) for j, joint in enumerate(leg.joints)]
    return [
        StatedEffect(effect, j, held[effect.name])
        for effect in sorted(registered(), key=in_order_of_action)
        if effect.way == way
        for j, held in [*at_joints, (0, leg.effects)]
        if effect.name in held
    ]


def given_at(leg: Leg, place: Place) -> Mapping[str, float]:
    """What a leg states, without the defaults, of an effect that a cause at this place replaces; empty if nothing."""
    every = [each for way in REPLACED_WAYS for each in stated_effects(leg, way)]
    return next((each.given for each in every if each.place == place and each.effect.name != COUNTS), {})

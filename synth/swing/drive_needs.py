"""Whether an effect that acts through a joint's drive has one there: by the leg file, and by the trials.

Of what an effect ``needs``, only drives and known torques count here. A diagnosis looks for an effect of a spring where
there is one; a leg file may state it before the spring.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet

from synth.drives.servo import Servo, TorqueDrive, fed_together
from synth.swing.effects.definition import Effect, Need

_MOTOR = "a voltage-driven motor"  # by a servo's duty too
# Needs that are of a drive, in words; a driven rotor is not one: ``gear_play`` parts any joint.
WORDS: dict[Need, str] = {
    "servo": "a servo",
    "held commands": "a servo that holds its commands",
    "motor": _MOTOR,
    "stated supply": _MOTOR,
    "time to warm": _MOTOR,
    "shared supply": "several servos with motors on one supply",
    "torque": "a known torque",
    "recorded current": "a recorded current",
}
BY_TRIALS: frozenset[Need] = frozenset({"torque", "recorded current"})  # a column may give them to any joint


def drive_needs(effect: Effect, given: Mapping[str, float]) -> tuple[Need, ...]:
    """Of a drive, what the effect needs one of to be one at all; empty if it acts without.

    ``given`` : its parameters, without the defaults.
    """
    on = [name for name in effect.strengths if given.get(name, effect.defaults[name]) != 0.0]
    if (effect.way != "drive" and not effect.uses_drive) or not set(on) <= {*(effect.by_drive or on)}:
        return ()
    if not set(effect.needs) <= set(WORDS):
        return ()
    # In the engine a torque of any drive is one that its gear rubs by.
    more: tuple[Need, ...] = ("torque",) if effect.needs and effect.uses_drive == "as it is" else ()
    return tuple(dict.fromkeys((*effect.needs, *more)))


def needs_by_file(drives: Sequence[Servo | TorqueDrive | None], joint: int) -> set[Need]:
    """What a leg's ``drives`` give an effect at a joint, whatever the trials are."""
    drive, found = drives[joint], set[Need]()
    if isinstance(drive, Servo):
        controls = not drive.open_duty
        found |= {"servo"} if controls else set()
        found |= {"held commands"} if controls and not drive.linear_commands else set()
        found |= {"motor", "stated supply", "time to warm"} if drive.motor is not None else set()
        found |= {"shared supply"} if joint in fed_together(drives) else set()
    return found


def lacking(needs: Sequence[Need], there: AbstractSet[Need]) -> str:
    """What is needed in words, if none of it is ``there``; else empty."""
    if not needs or not there.isdisjoint(needs):
        return ""
    *others, last = dict.fromkeys(WORDS[need] for need in needs)
    return f"{', '.join(others)} or {last}" if others else last

"""Parameters of effects with a direction, from the sense of a measured angle to that of the rotation q."""

from __future__ import annotations

from collections.abc import Mapping

from synth.swing.effects import Effect


def has_direction(effect: Effect) -> bool:
    """Whether a parameter refers to the measured angle and must be converted to the sense of q."""
    return hasattr(effect.loaded, "to_rotation")


def in_rotation(effect: Effect, sign: int, zero: float, given: Mapping[str, float]) -> list[float]:
    """Parameters of a torque effect in order, with defaults, converted to the sense of q if direction matters."""
    values = [given.get(p.name, effect.defaults[p.name]) for p in effect.parameters]
    return turned_to_rotation(effect, sign, zero, values) if has_direction(effect) else values


def turned_to_rotation(effect: Effect, sign: int, zero: float, values: list[float]) -> list[float]:
    """All parameters, in order, of an effect with directions in measured angle, converted to the sense of q."""
    turn = effect.function("to_rotation")
    taken = turn.__code__.co_argcount - 2
    return [*turn(sign, zero, *values[:taken]), *values[taken:]]

"""Effects of a jumping leg with gear motors beyond its design: one file each, discovered automatically.

The effects of swinging legs are in ``synth.swing.effects``. Names are those of the file formats.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import replace
from functools import lru_cache

from synth.jump.effects.jump_effect import MotorEffect

__all__ = ["MotorEffect", "motor_effect_named", "motor_effects"]

_NOT_EFFECTS = ("jump_effect",)


@lru_cache(maxsize=1)
def _installed_effects() -> dict[str, MotorEffect]:
    names = sorted(m.name for m in pkgutil.iter_modules(__path__) if m.name not in _NOT_EFFECTS)
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    return {module.EFFECT.name: replace(module.EFFECT, module=module.__name__) for module in modules}


def motor_effects() -> tuple[MotorEffect, ...]:
    """All effects by name."""
    return tuple(_installed_effects().values())


def motor_effect_named(name: str) -> MotorEffect:
    """The effect of that name; KeyError if there is none."""
    return _installed_effects()[name]

"""Effects of the swinging leg beyond linear springs and dampers: one file each, discovered automatically.

Each module of this package contains one ``EFFECT``, except those in ``_NOT_EFFECTS``. Further effects come from
installed packages by the entry point group ``synth.effects`` (a module with an ``EFFECT``), or from a file that the
user names (``--effect``, ``synth.load_effect``). The effects of the jumping leg are in ``synth.jump.effects``.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import entry_points

from synth.errors import UserError
from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

__all__ = [
    "OWN_EFFECTS", "Effect", "Parameter", "Prior", "Shape", "any_foreign", "effect_named", "from_files", "installed",
    "registered",
]  # fmt: skip

_NOT_EFFECTS = ("definition", "inlined", "torque_along_motion", "torque_along_motion_loop", "users_own")
GROUP = "synth.effects"  # of entry points
# Added to the message about a name that no effect has.
OWN_EFFECTS = (
    "one of your own: give its file with --effect FILE.py, in Python with synth.load_effect, or install a package with "
    f"the entry point {GROUP}"
)
from_files: dict[str, Effect] = {}  # name -> effect that ``users_own.load_file`` read


@lru_cache(maxsize=1)
def installed() -> dict[str, Effect]:
    """Name -> effect, of this package and of installed packages."""
    names = sorted(m.name for m in pkgutil.iter_modules(__path__) if not m.ispkg and m.name not in _NOT_EFFECTS)
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    modules += [point.load() for point in sorted(entry_points(group=GROUP), key=lambda p: p.name)]
    found: dict[str, Effect] = {}
    for module in modules:
        effect = replace(module.EFFECT, module=module.__name__)
        if effect.name in found:
            raise UserError(
                f"two effects are called {effect.name!r}: {found[effect.name].module} and {module.__name__}"
            )
        found[effect.name] = effect
    return found


def any_foreign() -> bool:
    """Whether there are effects from outside this package; it imports none."""
    return bool(from_files) or bool(entry_points(group=GROUP))


def registered() -> tuple[Effect, ...]:
    """All effects: those of this package, of installed packages, and of files that the user named; by name."""
    return tuple((installed() | from_files).values())


def effect_named(name: str) -> Effect:
    """The effect of that name; KeyError if there is none."""
    return (installed() | from_files)[name]

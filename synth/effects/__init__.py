"""What a leg may do beyond linear springs and dampers: one file an effect, found by looking, listed nowhere.

Each module of this package but ``effect`` and ``compiled`` holds one ``EFFECT``. Others come from installed packages by
the entry point group ``synth.effects`` (a module with an ``EFFECT``), or from a file that the user names.
"""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
import sys
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path

from synth.effects.effect import Effect, Parameter, Prior, Shape
from synth.errors import Problem, UserError

__all__ = ["Effect", "Parameter", "Prior", "Shape", "effect_named", "load_file", "registered"]

_NOT_EFFECTS = ("effect", "compiled")
_from_files: dict[str, Effect] = {}


@lru_cache(maxsize=1)
def _installed() -> dict[str, Effect]:
    names = sorted(m.name for m in pkgutil.iter_modules(__path__) if m.name not in _NOT_EFFECTS)
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    modules += [point.load() for point in sorted(entry_points(group="synth.effects"), key=lambda p: p.name)]
    found: dict[str, Effect] = {}
    for module in modules:
        effect = replace(module.EFFECT, module=module.__name__)
        if effect.name in found:
            raise UserError(
                f"two effects are called {effect.name!r}: {found[effect.name].module} and {module.__name__}"
            )
        found[effect.name] = effect
    return found


def registered() -> tuple[Effect, ...]:
    """All effects: those of this package, of installed packages, and of files that the user named; by name."""
    return tuple((_installed() | _from_files).values())


def effect_named(name: str) -> Effect:
    """The effect of that name; KeyError if there is none."""
    return (_installed() | _from_files)[name]


def load_file(path: str | Path) -> Effect:
    """Take part of a user's own effect: a Python file with an ``EFFECT``, run because its user named it.

    Raises
    ------
    UserError : no such file, it cannot be run, it holds no EFFECT, or its name is taken.
    """
    path = Path(path).resolve()
    if not path.is_file():
        raise UserError(Problem("no such file; name a Python file that holds an EFFECT", file=str(path)))
    name = f"synth_user_effect_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise UserError(Problem("is no Python file (.py) with an EFFECT", file=str(path)))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise UserError(Problem(f"cannot be run: {type(error).__name__}: {error}", file=str(path))) from error
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise UserError(Problem("holds no EFFECT = Effect(...) (from synth.effects)", file=str(path)))
    if effect.name in _installed():
        raise UserError(Problem(f'"{effect.name}" is the name of a built-in effect; choose another', file=str(path)))
    _from_files[effect.name] = replace(effect, module=name)
    return _from_files[effect.name]

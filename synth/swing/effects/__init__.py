"""What a leg may do beyond linear springs and dampers: one file an effect, found by looking, listed nowhere.

Each module of this package but those in ``_NOT_EFFECTS`` holds one ``EFFECT``. Others come from installed packages by
the entry point group ``synth.effects`` (a module with an ``EFFECT``), or from a file that the user names. Those of the
jumping leg are in ``synth.jump.effects``.
"""

from __future__ import annotations

import hashlib
import importlib
import pkgutil
import sys
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from synth.errors import Problem, UserError
from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.effects.users_own import WrongEffect, line_of, require, said_by, source_of

__all__ = ["Effect", "Parameter", "Prior", "Shape", "effect_named", "load_file", "registered"]

_NOT_EFFECTS = ("definition", "inlined", "torque_along_motion", "torque_along_motion_loop", "users_own")
_from_files: dict[str, Effect] = {}


@lru_cache(maxsize=1)
def _installed() -> dict[str, Effect]:
    names = sorted(m.name for m in pkgutil.iter_modules(__path__) if not m.ispkg and m.name not in _NOT_EFFECTS)
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

    Loading the same file again replaces what it held before.

    Raises
    ------
    UserError : no such file, it cannot be run, it holds no EFFECT that works, or its name is taken.
    """
    given, path = Path(path), Path(path).resolve()
    text = source_of(path, str(given))
    name = f"synth_user_effect_{hashlib.sha256(text).hexdigest()[:16]}"  # the same text is compiled once
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    try:
        exec(compile(text, str(path), "exec"), module.__dict__)
        effect = getattr(module, "EFFECT", None)
        if not isinstance(effect, Effect):
            raise UserError(Problem("holds no EFFECT = Effect(...) (from synth.effects)", file=str(given)))
        _require_free_name(effect, path)
        require(effect, module)
    except WrongEffect as error:
        raise UserError(Problem(str(error), file=str(given), key=str(getattr(effect, "name", "")))) from error
    except SystemExit as error:
        text_ = "calls exit; an effect's file only defines it"
        raise UserError(Problem(text_, file=str(given), line=line_of(error, path))) from error
    except UserError:
        raise
    except Exception as error:
        said = f"cannot be run: {said_by(error)}"
        raise UserError(Problem(said, file=str(given), line=line_of(error, path))) from error
    _from_files[effect.name] = replace(effect, module=name)
    return _from_files[effect.name]


def _require_free_name(effect: Effect, path: Path) -> None:
    """Refuse the name of another effect."""
    if effect.name in _installed():
        raise WrongEffect("is the name of a built-in effect; choose another")
    if effect.name in _from_files:
        other = sys.modules[_from_files[effect.name].module].__file__
        if other != str(path):
            raise WrongEffect(f"is the name of an effect in {other}; choose another")

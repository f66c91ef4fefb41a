"""What a leg may do beyond linear springs and dampers: one file an effect, found by looking, listed nowhere.

Each module of this package but those in ``_NOT_EFFECTS`` holds one ``EFFECT``. Others come from installed packages by
the entry point group ``synth.effects`` (a module with an ``EFFECT``), or from a file that the user names. Those of the
jumping leg are in ``synth.jump.effects``.
"""

from __future__ import annotations

import hashlib
import importlib
import keyword
import pkgutil
import sys
import traceback
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from synth.errors import Problem, UserError
from synth.swing.effects.definition import ARGUMENTS, FUNCTIONS, Effect, Parameter, Prior, Shape

__all__ = ["Effect", "Parameter", "Prior", "Shape", "effect_named", "load_file", "registered"]

_NOT_EFFECTS = ("definition", "inlined", "torque_along_motion", "torque_along_motion_loop")
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
    path = Path(path).resolve()
    if not path.is_file():
        raise UserError(Problem("no such file; name a Python file that holds an EFFECT", file=str(path)))
    text = path.read_bytes()
    name = f"synth_user_effect_{hashlib.sha256(text).hexdigest()[:16]}"  # the same text is compiled once
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    try:
        exec(compile(text, str(path), "exec"), module.__dict__)
    except Exception as error:
        line = error.lineno if isinstance(error, SyntaxError) else _line_of(error, path)
        said = f"cannot be run: {type(error).__name__}: {error.args[0] if error.args else error}"
        raise UserError(Problem(said, file=str(path), line=line)) from error
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise UserError(Problem("holds no EFFECT = Effect(...) (from synth.effects)", file=str(path)))
    wrong = _wrong_with(effect, module)
    if wrong:
        raise UserError(Problem(wrong, file=str(path), key=effect.name))
    _from_files[effect.name] = replace(effect, module=name)
    return _from_files[effect.name]


def _line_of(error: Exception, path: Path) -> int | None:
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return frames[-1].lineno if frames else None


def _wrong_with(effect: Effect, module: ModuleType) -> str:
    """What keeps a user's effect from taking part, empty if nothing does."""
    if effect.name in _installed():
        return "is the name of a built-in effect; choose another"
    if effect.name in _from_files:
        other = sys.modules[_from_files[effect.name].module].__file__
        if other != module.__file__:
            return f"is the name of an effect in {other}; choose another"
    if not effect.name.isidentifier() or keyword.iskeyword(effect.name):
        return "cannot be an effect's name: write letters, digits and underscores"
    names = [parameter.name for parameter in effect.parameters]
    missing = [name for name in effect.strengths if name not in names]
    if missing or not effect.strengths:
        return f"strengths must name some of its parameters ({', '.join(names)})" + "".join(
            f", not {m}" for m in missing
        )
    needed = {FUNCTIONS[effect.way]: ARGUMENTS[effect.way]} | ({"start": 1} if effect.memory else {})
    for name, before in needed.items():
        function = getattr(module, name, None)
        if not callable(function):
            return f"the file holds no function {name}"
        if name == "torque" and not hasattr(function, "py_func"):
            return "torque must be compiled: write @inlined above it (from synth.effects)"
        taken = getattr(function, "py_func", function).__code__.co_argcount
        if taken != before + len(names):
            return f"{name} takes {taken} arguments, not {before} and then {', '.join(names)}"
    return ""

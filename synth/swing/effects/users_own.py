"""Loading and validation of a user's own effect, so that mistakes show when its file is read, not during a diagnosis.

Any field of a definition may have the wrong type, and any function may fail at its first call. Therefore every field is
checked, and every function is called once with two legs of two joints in parallel.
"""

from __future__ import annotations

import hashlib
import keyword
import math
import os
import stat
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import numpy as np

from synth.compiling.modules import module_from_text
from synth.errors import Problem, UserError
from synth.swing import effects
from synth.swing.effects.definition import ARGUMENTS, FUNCTIONS, Effect, Need, Parameter, Prior, Shape

SIZE_LIMIT = 1_000_000  # bytes, a thousand times the size of an effect's file
LANES = 2  # legs in parallel in a trial call


@dataclass(frozen=True)
class OwnFile:
    """A file of the user's that was executed, and the SHA-256 of its content then."""

    path: Path
    sha256: str


executed: dict[str, OwnFile] = {}  # module of an effect -> its file


class WrongEffect(Exception):
    """An invalid definition; the text is the message to the user."""


def source_of(path: Path, name: str) -> bytes:
    """The content of a user's file; ``name`` : as the user gave it.

    Raises
    ------
    UserError : the file is missing, not a regular file (a pipe would block), too large or unreadable.
    """
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode) or status.st_size > SIZE_LIMIT:
            text = f"is no regular file of at most {SIZE_LIMIT / 1e6:g} MB; name a Python file that holds an EFFECT"
            raise UserError(Problem(text, file=name))
        return path.read_bytes()
    except FileNotFoundError:
        raise UserError(Problem("no such file; name a Python file that holds an EFFECT", file=name)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(Problem(f"cannot be read: {reason}", file=name)) from None


def load_file(path: str | Path) -> Effect:
    """Load and register a user's own effect: a Python file with an ``EFFECT``, executed because the user named it.

    Loading the same file again replaces its earlier effect.

    Raises
    ------
    UserError : the file is missing or cannot be executed, it has no valid EFFECT, or the effect's name is taken.
    """
    given, path = Path(path), Path(os.path.realpath(path))
    text = source_of(path, str(given))
    digest = hashlib.sha256(text).hexdigest()
    name = f"synth_user_effect_{digest[:16]}"  # the same text is compiled once
    try:
        module = module_from_text(name, text, str(path))
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
        messages = f"cannot be run: {one_line(error)}"
        raise UserError(Problem(messages, file=str(given), line=line_of(error, path))) from error
    executed[name] = OwnFile(path, digest)
    effects.from_files[effect.name] = replace(effect, module=name)
    return effects.from_files[effect.name]


def _require_free_name(effect: Effect, path: Path) -> None:
    """Raise WrongEffect if another effect has this name."""
    if effect.name in effects.installed():
        raise WrongEffect("is the name of a built-in effect; choose another")
    if effect.name in effects.from_files:
        other = effects.from_files[effect.name].loaded.__file__
        if other != str(path):
            raise WrongEffect(f"is the name of an effect in {other}; choose another")


def require(effect: Effect, module: ModuleType) -> None:
    """Validate a user's effect and call each of its functions once.

    Raises
    ------
    WrongEffect : names the mistake and what is allowed.
    """
    _require_fields(effect)
    _require_parameters(effect)
    _require_functions(effect, module)
    function = getattr(module, FUNCTIONS[effect.way])
    with _as_wrong_effect(FUNCTIONS[effect.way], str(module.__file__)):
        {
            "torque": _try_torque,
            "leg": _try_change,
            "drive": _try_change,
            "reading": _try_reading,
            "structure": _try_extension,
        }[effect.way](effect, function)


def line_of(error: BaseException, path: str | Path) -> int | None:
    """The line of the user's file in which an error arose; None if it arose elsewhere."""
    if isinstance(error, SyntaxError):
        return error.lineno
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return frames[-1].lineno if frames else None


def one_line(error: BaseException) -> str:
    """An error in one short line."""
    text = str(error.args[0] if error.args else "").strip()
    first = text.splitlines()[0] if text else ""
    first = first if len(first) <= 200 else first[:197] + "..."  # characters: one or two lines of a terminal
    return f"{type(error).__name__}: {first}" if first else type(error).__name__


@contextmanager
def blamed_on(files: Mapping[str, str]) -> Iterator[None]:
    """Convert errors in the code of a user's effect to UserError; ``files`` : path -> name given by the user.

    Raises
    ------
    UserError : names the file, the line and Python's message.
    """
    try:
        yield
    except UserError:
        raise
    except Exception as error:
        for path, name in files.items():
            line = line_of(error, path)
            if line is not None and not isinstance(error, SyntaxError):
                raise UserError(Problem(f"stopped while it was used: {one_line(error)}", name, line)) from error
        raise


def _require_fields(effect: Effect) -> None:
    """Every field has the right type, and an allowed value if it is a choice."""
    if not isinstance(effect.name, str) or not effect.name.isidentifier() or keyword.iskeyword(effect.name):
        raise WrongEffect("cannot be an effect's name: write letters, digits and underscores")
    allowed = {"way": tuple(FUNCTIONS), "where": ("joint", "base"), "belongs_to": ("joint", "spring", "damper")}
    for key, choices in allowed.items():
        value = getattr(effect, key)
        if value not in choices:
            raise WrongEffect(f"{key}={value!r} is not allowed; write one of {', '.join(map(repr, choices))}")
    names = [(key, str) for key in ("strengths", "by_load", "by_drive", "ascending", "any_of")]
    for key, kind in (("parameters", Parameter), ("shapes", Shape), *names):
        value = getattr(effect, key)
        if not isinstance(value, tuple) or not all(isinstance(item, kind) for item in value):
            raise WrongEffect(f"{key} must be a tuple of {kind.__name__}, such as ({_example(key)},)")
    given: list[object] = [effect.needs, *(shape.needs for shape in effect.shapes)]
    for group in given:
        unknown = [need for need in group if need not in get_args(Need)] if isinstance(group, tuple) else [group]
        if unknown:
            known = ", ".join(map(repr, get_args(Need)))
            raise WrongEffect(f"needs holds {unknown[0]!r}; write a tuple of some of {known}")
    for key in ("meaning", "formula", "source", "kin", "phrase", "bristle", "play"):
        if not isinstance(getattr(effect, key), str):
            raise WrongEffect(f"{key} must be text")
    if effect.memory and effect.way != "torque":
        raise WrongEffect('memory is of way="torque" alone')


def _example(key: str) -> str:
    return {"parameters": 'Parameter("strength", "N*m")', "shapes": 'Shape(("strength",), {})'}.get(key, '"strength"')


def _require_parameters(effect: Effect) -> None:
    """Parameters have unique names and known units; strengths and shapes name only existing parameters."""
    from synth.units import factor

    names = [parameter.name for parameter in effect.parameters]
    for parameter in effect.parameters:
        name = parameter.name
        if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name) or names.count(name) > 1:
            raise WrongEffect(f"{name!r} cannot be a parameter's name, or two have it: letters, digits, underscores")
        try:
            factor(parameter.unit, parameter.unit)
        except (UserError, TypeError, AttributeError):
            raise WrongEffect(f"{name}: {parameter.unit!r} is no unit; write one such as N*m, rad, 1") from None
        for key in ("default", "off"):
            value = getattr(parameter, key)
            if not (value is None and key == "default") and not _is_number(value):
                raise WrongEffect(f"{name}: {key}={value!r} must be a number")
        if not isinstance(parameter.choices, tuple) or not all(isinstance(word, str) for word in parameter.choices):
            raise WrongEffect(f'{name}: choices must be a tuple of words for 0 and 1, such as ("before", "behind")')
        if not (parameter.prior is None or isinstance(parameter.prior, Prior)):
            raise WrongEffect(f"{name}: prior must be a Prior, such as size(0.2) (from synth.effects)")
    missing = [name for name in effect.strengths if name not in names]
    if missing or not effect.strengths:
        text = f"strengths must name some of its parameters ({', '.join(names)})"
        raise WrongEffect(text + "".join(f", not {name}" for name in missing))
    for key, named in _fields_with_names(effect):
        if named not in names:
            raise WrongEffect(f"{key} must name one of its parameters ({', '.join(names)}), not {named!r}")
    for shape in effect.shapes:
        for name in shape.free:
            if effect.parameters[names.index(name)].prior is None:
                raise WrongEffect(f"a shape frees {name}, which has no prior; give it one, such as size(0.2)")
    if not effect.shapes:
        raise WrongEffect("shapes is empty; write at least one, which frees a parameter")


def _fields_with_names(effect: Effect) -> Iterator[tuple[str, str]]:
    """Every field that refers to a parameter, with the parameter's name."""
    for key in ("bristle", "play"):
        if getattr(effect, key):
            yield key, getattr(effect, key)
    for key in ("by_load", "by_drive", "ascending", "any_of"):
        yield from ((key, name) for name in getattr(effect, key))
    for shape in effect.shapes:
        yield from (("a shape", name) for name in (*shape.free, *shape.held, *(n for s in shape.starts for n in s)))


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and not math.isnan(value)


def _require_functions(effect: Effect, module: ModuleType) -> None:
    """The functions exist, are compiled if they must be, and take the right number of arguments."""
    names = [parameter.name for parameter in effect.parameters]
    needed = {FUNCTIONS[effect.way]: ARGUMENTS[effect.way]} | ({"start": 1} if effect.memory else {})
    for name, before in needed.items():
        function = getattr(module, name, None)
        if not callable(function):
            raise WrongEffect(f"the file holds no function {name}")
        if name == "torque" and not hasattr(function, "py_func"):
            raise WrongEffect("torque must be compiled: write @inlined above it (from synth.effects)")
        code = getattr(getattr(function, "py_func", function), "__code__", None)
        if code is None or code.co_argcount != before + len(names):
            taken = "an unknown number of" if code is None else code.co_argcount
            raise WrongEffect(f"{name} takes {taken} arguments, not {before} and then {', '.join(names)}")


@contextmanager
def _as_wrong_effect(name: str, path: str) -> Iterator[None]:
    """Convert an error in a trial call to WrongEffect."""
    try:
        yield
    except WrongEffect:
        raise
    except Exception as error:
        line = line_of(error, path)
        place = "" if line is None else f" in line {line}"
        raise WrongEffect(f"{name} fails{place} when it is called: {one_line(error)}") from error


def _off_values(effect: Effect) -> list[float]:
    return [float(parameter.off) for parameter in effect.parameters]


def _trial_values(effect: Effect) -> list[float]:
    """A value of each parameter, as a diagnosis would try it."""
    values = []
    for parameter in effect.parameters:
        tried = parameter.default
        if tried is None:
            tried = parameter.prior.value(0.5) if parameter.prior else parameter.off
        values.append(float(tried))
    return values


def _try_torque(effect: Effect, function: Callable[..., Any]) -> None:
    """The torque compiles, returns two numbers, and is zero if the effect is off."""
    state = (0.3, -0.7, 0.2, 4.0, 0.1, -0.07, 5.0, 0.0)
    for values in (_trial_values(effect), _off_values(effect)):
        found = function(*state, *values)
        if not isinstance(found, tuple) or len(found) != 2 or not all(_is_real(item) for item in found):
            raise WrongEffect("torque must give two numbers: the torque on q, and the rate of change of its memory")
    if float(found[0]) != 0.0:
        text = f"torque must be 0 where every parameter is off; it is {float(found[0]):g} N m: a joint without the"
        raise WrongEffect(f"{text} effect would have it all the same")


def _is_real(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True


def _try_change(effect: Effect, function: Callable[..., Any]) -> None:
    """The function changes nothing if the effect is off."""
    before, legs = _legs(), _legs()
    for values in (_off_values(effect), _trial_values(effect)):
        function(legs, 1, 1, *_columns(values))
        if values == _off_values(effect):
            names = [key for key, value in vars(legs).items() if isinstance(value, np.ndarray)]
            changed = [key for key in names if not np.array_equal(getattr(before, key), getattr(legs, key))]
            if changed:
                raise WrongEffect(
                    f"{FUNCTIONS[effect.way]} must change nothing where every parameter is off; it changes {changed[0]}"
                )


def _try_reading(effect: Effect, function: Callable[..., Any]) -> None:
    """The function returns an array of the rotation's shape."""
    rotation = np.linspace(-0.4, 0.6, 6 * LANES).reshape(6, LANES)
    for values in (_off_values(effect), _trial_values(effect)):
        found = function(np.linspace(0.0, 0.5, 6), rotation.copy(), np.ones_like(rotation), 1, 0.2, *_columns(values))
        if not isinstance(found, np.ndarray) or found.shape != rotation.shape:
            raise WrongEffect(f"read must give an array of the rotation's shape {rotation.shape}")


def _try_extension(effect: Effect, function: Callable[..., Any]) -> None:
    """The function returns a leg with at least one additional link."""
    legs = _legs()
    made = function(legs, 1, *_columns(_trial_values(effect)))
    if not isinstance(made, type(legs)) or made.n <= legs.n:
        raise WrongEffect("extend must give a LegLanes of one more link")


def _columns(values: list[float]) -> list[Any]:
    return [np.full(LANES, value) for value in values]


def _legs() -> Any:
    from synth.swing.leg_lanes import LegLanes
    from synth.swing.leg_model import Joint, Leg, Link, Spring

    link = Link(0.2, 0.5, 0.1, 2e-3)
    joints = tuple(Joint(name, link, 0.0, spring=Spring(5.0, 0.1)) for name in ("first", "second"))
    return LegLanes.of(Leg("trial", joints), LANES)

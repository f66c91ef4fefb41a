"""What a compiled function reaches, as one hash: code that is stored under it never becomes outdated.

numba puts the code of the called functions and the values of their globals into machine code, as they are while it
compiles. Neither the function's text nor the files of its folder tell them: a constant may stand in another module, or
in a table that is read when a module is imported.
"""

from __future__ import annotations

import hashlib
import importlib
import types
import uuid
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.extending import is_jitted

PLAIN = (type(None), bool, int, float, complex, str, bytes, type(...))  # their ``repr`` is their value
# Packages whose functions and types are known by their names: their versions are part of every key.
KNOWN = ("builtins", "math", "cmath", "operator", "numpy", "numba")
OURS = __name__.partition(".")[0]


@dataclass(frozen=True)
class Reached:
    """What a compiled function reaches.

    ``digest`` : hash of it. ``obstacle`` : what has no value that could be hashed, in words; the digest is then one
    that no other function, and no other process, has. Empty: there is none.
    """

    digest: str
    obstacle: str = ""


def reached_by(function: Callable[..., Any]) -> Reached:
    """Hash of a compiled function or of its plain form: its code, all it calls, and the values of all their globals.

    Each function counts with its bytecode, its defaults, the variables that it encloses, its options and the source
    file of its module, as it is in memory and not as its file may be by now. Numbers, text, arrays and tuples count by
    their values; a module by those of its attributes that a function names. Functions and types of ``KNOWN`` count by
    their names. Everything else is an obstacle: a plain function of another package, for example, may stand for any
    compiled one (``numba.extending.overload``).
    """
    try:
        return Reached(_Walk().of(function))
    except _Obstacle as found:
        if function not in _unknown:
            _unknown[function] = f"unknown {uuid.uuid4().hex}"
        return Reached(_unknown[function], str(found))


class _Obstacle(Exception):
    """Something cannot be hashed; the text names it."""


_unknown: weakref.WeakKeyDictionary[Any, str] = weakref.WeakKeyDictionary()
# Compiled function -> hash of its own part. Its machine code keeps the globals of its first compilation.
_parts: weakref.WeakKeyDictionary[Any, str] = weakref.WeakKeyDictionary()


class _Walk:
    """Hashes one function after the other, each once, in the order in which they are named."""

    def __init__(self) -> None:
        self.waiting: list[tuple[types.FunctionType, Any]] = []
        self.numbers: dict[int, int] = {}  # of each function by its id; ``waiting`` keeps all of them
        self.files: set[str] = set()
        self.edges: list[int] = []

    def of(self, function: Any) -> str:
        """Hash of this function and of all that it reaches."""
        whole = hashlib.sha256()
        made = function if is_jitted(function) else None
        self.called(function.py_func if made is not None else function, made)
        for each, its_form in self.waiting:  # grows meanwhile
            part = self.part(each, its_form)
            whole.update(f"{part} {self.edges}\n".encode())
            self.edges.clear()
        for name in sorted(self.files):
            whole.update(_source_hash(name).encode())
        return whole.hexdigest()

    def called(self, function: types.FunctionType, made: Any) -> None:
        """Note a function, ``made`` its compiled form, to be hashed in its turn."""
        if id(function) not in self.numbers:
            self.numbers[id(function)] = len(self.waiting)
            self.waiting.append((function, made))
        self.edges.append(self.numbers[id(function)])

    def part(self, function: types.FunctionType, made: Any) -> str:
        """Hash of one function without those that it calls."""
        code, part = function.__code__, _Words()
        part.add(function.__module__, function.__qualname__)
        self.code(code, function.__globals__, part)
        for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
            self.value(cell.cell_contents, name, code.co_names, part)
        self.value(function.__defaults__, "its defaults", (), part)
        self.value(tuple(sorted((function.__kwdefaults__ or {}).items())), "its defaults", (), part)
        if made is not None:
            options = options_text(made.targetoptions)
            if " at 0x" in options:
                raise _Obstacle(f"an option of {function.__qualname__}, which is a function")
            part.add(options, str(made.locals))
        self.files.add(code.co_filename)
        found = part.digest()
        # One that is inlined is compiled anew with each of its callers.
        stays = made is not None and made.overloads and made.targetoptions.get("inline") != "always"
        if stays and _parts.setdefault(made, found) != found:
            raise _Obstacle(f"{function.__qualname__}, of which a global was changed after it was compiled")
        return found

    def code(self, code: types.CodeType, given: dict[str, Any], part: _Words) -> None:
        """Add code, also of functions within, and the globals that it names.

        A name may be that of an attribute; if a global is called so too, that one counts as well.
        """
        part.add(code.co_code, code.co_names, code.co_varnames, code.co_argcount, code.co_kwonlyargcount, code.co_flags)
        self.value(code.co_consts, "its constants", code.co_names, part, given)
        for name in code.co_names:
            if name in given:
                self.value(given[name], name, code.co_names, part)

    def value(
        self, value: Any, name: str, names: Sequence[str], part: _Words, given: dict[str, Any] | None = None
    ) -> None:
        """Add a value; ``names`` : those of the code that has it; ``given`` : globals of functions within that code.

        Raises
        ------
        _Obstacle : it cannot be hashed.
        """
        kind = type(value)
        if kind in PLAIN:
            part.add(name, kind.__name__, value)
        elif isinstance(value, tuple):
            part.add(name, kind.__module__, kind.__qualname__, getattr(value, "_fields", ()), len(value))
            for item in value:
                self.value(item, name, names, part, given)
        elif isinstance(value, frozenset):
            part.add(name, sorted(map(repr, value)))
        elif isinstance(value, types.CodeType):
            self.code(value, given or {}, part)
        elif isinstance(value, np.generic) or kind is np.ndarray:
            if value.dtype.hasobject:
                raise _Obstacle(f"{name}, an array of Python objects")
            content = hashlib.sha256(value.tobytes()).hexdigest()
            part.add(name, kind.__name__, str(value.dtype.descr), value.shape, value.strides, content)
        elif is_jitted(value):
            part.add(name, value.py_func.__module__, value.py_func.__qualname__)
            self.called(value.py_func, value)
        elif isinstance(value, types.ModuleType):
            self.module(value, names, part)
        elif isinstance(value, numba.types.Type) and " at 0x" not in repr(value):
            part.add(name, repr(value))
        elif (own := _own_function(value)) is not None:
            part.add(name)
            self.called(own, None)
        elif (known := _known(value)) is not None:
            part.add(name, known)
        else:
            raise _Obstacle(f"{name}, which is {_in_words(value)}")

    def module(self, module: types.ModuleType, names: Sequence[str], part: _Words) -> None:
        """Add those attributes of a module that are named."""
        part.add(module.__name__)
        if module.__name__.partition(".")[0] not in KNOWN:
            for name in names:
                if name in vars(module):
                    self.value(vars(module)[name], f"{module.__name__}.{name}", names, part)


class _Words:
    """A hash of values whose ``repr`` is the same in every process, kept apart."""

    def __init__(self) -> None:
        self._words: list[object] = []

    def add(self, *words: object) -> None:
        """Add values."""
        self._words.append(words)

    def digest(self) -> str:
        """The hash."""
        return hashlib.sha256(repr(self._words).encode()).hexdigest()


def options_text(options: dict[str, Any]) -> str:
    """Options of numba as text that is the same in every process: the order of a set of words is not."""
    ordered = {key: sorted(value) if isinstance(value, (set, frozenset)) else value for key, value in options.items()}
    return repr(sorted(ordered.items()))


def _own_function(value: Any) -> types.FunctionType | None:
    """The plain function of an intrinsic or an overloaded function of this package; None for any other value.

    What numba makes of either depends on the same module alone, whose source counts.
    """
    function = getattr(value, "_defn", value)
    ours = isinstance(function, types.FunctionType) and function.__module__.partition(".")[0] == OURS
    return function if ours else None


def _known(value: Any) -> str | None:
    """The name of a function or type of a known package; None if it is none."""
    module = "numpy" if isinstance(value, np.ufunc) else getattr(value, "__module__", None)
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
    if not isinstance(module, str) or not isinstance(name, str) or module.partition(".")[0] not in KNOWN:
        return None
    try:
        found = attrgetter(name)(importlib.import_module(module))
    except (AttributeError, ImportError):
        return None
    return f"{module}.{name}" if found is value else None


def _in_words(value: Any) -> str:
    if isinstance(value, types.FunctionType):
        return "a function that is not compiled"
    return f"a {type(value).__name__}"


def _source_hash(name: str) -> str:
    """Hash of a source file; empty if there is none, as of a text that was made here."""
    try:
        status = Path(name).stat()
        return _hash_of_file(name, status.st_mtime_ns, status.st_size)
    except OSError:
        return ""


@cache
def _hash_of_file(name: str, changed: int, size: int) -> str:
    return hashlib.sha256(Path(name).read_bytes()).hexdigest()

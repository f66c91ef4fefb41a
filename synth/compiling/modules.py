"""Python modules made of text; the only place that accesses ``sys.modules``."""

from __future__ import annotations

import importlib.util
import linecache
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType, ModuleType


def is_loaded(name: str) -> bool:
    """Whether a module has been imported."""
    return name in sys.modules


def set_class(name: str, kind: type[ModuleType]) -> None:
    """Give a loaded module its own class (language reference, "Customizing module attribute access")."""
    sys.modules[name].__class__ = kind


def stands_for_package(function: FunctionType, name: str) -> None:
    """Give a function the name of the package in whose place it stands.

    For ``import synth.fit.methods as methods`` Python asks ``synth.fit`` for ``methods``, and if it has none, looks in
    ``sys.modules`` for that name behind the ``__name__`` of what it asked (Python reference, import statement).
    """
    function.__name__ = name


@contextmanager
def left_empty(name: str) -> Iterator[None]:
    """Within the block an ``import`` of a module that is not loaded yet gives an empty one, unknown afterwards."""
    if name in sys.modules:
        yield
        return
    sys.modules[name] = ModuleType(name)
    try:
        yield
    finally:
        del sys.modules[name]


def module_from_text(name: str, text: str | bytes, file: str | None = None) -> ModuleType:
    """Execute a text as a new module of this name, replacing an earlier one; ``file`` : its source file, if any.

    A loaded module is executed again; a module whose text raises is removed.
    """
    module = ModuleType(name)
    if file is None:
        file = f"<{name}>"
        lines = str(text).splitlines(keepends=True)
        linecache.cache[file] = (len(text), None, lines, file)  # for a traceback
    else:
        module.__file__ = file
    sys.modules[name] = module
    try:
        exec(compile(text, file, "exec"), module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def made_module(name: str, text: str) -> ModuleType:
    """The module of this name, created from the text if not loaded."""
    return sys.modules[name] if name in sys.modules else module_from_text(name, text)


def source_file(name: str) -> Path:
    """The file of a module, loaded or not.

    Raises
    ------
    ImportError : the module does not exist or has no file.
    """
    loaded = getattr(sys.modules.get(name), "__file__", None)
    if loaded:
        return Path(loaded)
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        raise ImportError(f"no source file for {name}")
    return Path(spec.origin)


def with_constant(text: str, name: str, value: object) -> str:
    """A module's text with one constant changed; exactly one line must set that constant.

    Raises
    ------
    ValueError : no line or several lines set it.
    """
    lines = text.splitlines()
    places = [k for k, line in enumerate(lines) if line.startswith(f"{name} = ")]
    if len(places) != 1:
        raise ValueError(f"{len(places)} lines that set {name}; one is needed")
    lines[places[0]] = f"{name} = {value!r}"
    return "\n".join(lines) + "\n"


@contextmanager
def absent(name: str) -> Iterator[None]:
    """A module that cannot be imported in the block."""
    before = sys.modules.get(name)
    sys.modules[name] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[name]
        if before is not None:
            sys.modules[name] = before

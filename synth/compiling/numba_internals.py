"""All that we use of numba beyond its public interface, with a plain way where a release has no such thing any more.

What each buys: code on disk that is taken only whole and unchanged (``KeptCode``), a tenth of a step's time
(``UNCOUNTED``), ten steps' time at each start of an integration (``entry_point``) and 0.1 s of a process' start
(``without_products``). Without them everything is compiled in each process, a little slower, with the same results.
``pyproject.toml`` bounds numba from above: raise the bound after ``tests/compiling`` has passed with the new release.
"""

from __future__ import annotations

import hashlib
import inspect
import pickle
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import njit
from numba.types import WrapperAddressProtocol

from synth.cache import own_folder, read_sealed, write_sealed
from synth.compiling.modules import absent, is_loaded

FOLDER = "code"

try:
    from numba.core.caching import NullCache
    from numba.core.compiler import CompileResult
    from numba.core.options import DefaultOptions
    from numba.core.serialize import dumps
except ImportError:  # a release that has moved them
    NullCache, CompileResult, DefaultOptions, dumps = object, object, object, None


def _is_known() -> bool:
    """Whether this numba has all that ``KeptCode`` needs."""
    needed = ((CompileResult, "_rebuild"), (CompileResult, "_reduce"), (NullCache, "load_overload"))
    return dumps is not None and all(hasattr(owner, name) for owner, name in needed)


KEEPS_CODE = _is_known()
# Where nothing is allocated, arrays need not be counted: counts are locked operations, a tenth of a step's time.
UNCOUNTED: dict[str, Any] = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}


def keep_code(made: Any, function: Callable[..., Any], options: dict[str, Any]) -> None:
    """Let a dispatcher of numba's take its code from disk and keep it there."""
    if KEEPS_CODE and hasattr(made, "_cache"):
        made._cache = KeptCode(function, options)


def entry_point(made: Any) -> Any:
    """The one compiled form of a function: to ask numba each time which would do costs as much as ten steps.

    It takes what it is given for what it was compiled for: arrays must be contiguous and of the right type.
    """
    try:
        return made.get_compile_result(made.nopython_signatures[0]).entry_point
    except AttributeError:
        return made


class AsArgument(WrapperAddressProtocol):  # type: ignore[misc]
    """A compiled function as an argument of another; numba would look a plain one's address up at every call."""

    def __init__(self, function: Any) -> None:
        self._function = function  # keeps the code alive
        self._signature = function.nopython_signatures[0]
        compiled = function.get_compile_result(self._signature)
        self._address = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name)

    def __wrapper_address__(self) -> int:
        """Where the code lies."""
        return int(self._address)

    def signature(self) -> Any:
        """What it takes and gives."""
        return self._signature


def as_argument(function: Any) -> Any:
    """A compiled function to be handed to another: with its address, or as it is where numba tells none."""
    try:
        return AsArgument(function)
    except AttributeError:
        return function


def without_products() -> None:
    """Keep numba from importing ``scipy.linalg``, 0.1 s, for matrix products in compiled code: there are none here.

    For a process of our own only: numba's ``np.dot`` is gone from it, unless scipy was loaded before.
    """
    if is_loaded("scipy.linalg") or is_loaded("numba.np.arraymath"):
        return
    with absent("scipy.linalg.cython_blas"):
        import numba.np.arraymath  # noqa: F401


class KeptCode(NullCache):  # type: ignore[misc]
    """One function's compiled code on disk, in the form in which numba asks for it.

    numba's own cache reads whatever lies in its folder: a file cut short stops every command with a traceback, and a
    changed one is run. Here each function is one file, whose name holds a hash of all that the machine code depends
    on; so there is no index, and nothing is ever out of date.

    The content is machine code with its description as numba pickles it, the only pickle in this package. It is
    looked at only after ``synth.cache`` has made sure of the file: a regular one, no link, in a folder that is the
    user's alone, written by the user, not writable by others, its SHA-256 right. Who could forge that could as well
    change the machine code, or the user's Python.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        code = function.__code__.co_code
        self._depends = (numba.__version__, sys.version, _sources(function), code, sorted(options.items()))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The function's code for the signature and this processor; None where it must be compiled."""
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        data = None if path is None else read_sealed(path)
        return None if data is None else CompileResult._rebuild(target_context, *pickle.loads(data))

    def save_overload(self, sig: Any, cres: Any) -> None:
        """Keep the code, unless it holds addresses of this process."""
        path = self._path(sig, cres.codegen)
        if path is not None and not cres.library.has_dynamic_globals:
            write_sealed(path, dumps(cres._reduce()))

    def _path(self, sig: Any, codegen: Any) -> Path | None:
        folder = own_folder(FOLDER)
        digest = hashlib.sha256(repr((self._depends, sig, codegen.magic_tuple())).encode()).hexdigest()
        return None if folder is None else folder / f"{self._name}.{digest[:20]}"


def _sources(function: Callable[..., Any]) -> str:
    """Hash of the source files beside a function's, which it may call; a generated module's name holds its own."""
    file = Path(inspect.getfile(function))
    return _folder_hash(file.parent) if file.is_absolute() and file.exists() else ""


@cache
def _folder_hash(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def compiles(options: dict[str, Any]) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit`` with code that is kept on disk."""

    def decorate(function: Callable[..., Any]) -> Any:
        made = njit(**options)(function)
        keep_code(made, function, options)
        return made

    return decorate

"""Every use of numba beyond its public interface, each with a plain fallback; ``reached_code`` reads its functions too.

Benefits: stored code is used only if complete and unchanged (``KeptCode``); a step takes a tenth less time
(``UNCOUNTED``); each start of an integration saves the time of ten steps (``entry_point``); a process starts 0.1 s
faster (``without_products``); a result does not depend on what was compiled in its process
(``link_privately``). Without them every process compiles again, with results equal but for the last bits.
``pyproject.toml`` bounds numba from above: raise the bound once ``tests/compiling`` passes with a new release.
"""

from __future__ import annotations

import hashlib
import pickle
import re
import sys
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import njit
from numba.types import WrapperAddressProtocol

from synth.cache import own_folder, read_sealed, write_sealed
from synth.compiling.modules import absent, is_loaded
from synth.compiling.reached_code import options_text, reached_by

FOLDER = "code"

try:
    from numba.core.caching import NullCache
    from numba.core.codegen import CPUCodeLibrary
    from numba.core.compiler import CompileResult
    from numba.core.options import DefaultOptions
    from numba.core.runtime import rtsys as RUNTIME
    from numba.core.serialize import dumps
except ImportError:  # a release that has moved them
    NullCache, CompileResult, DefaultOptions, dumps = object, object, object, None
    RUNTIME = None
    CPUCodeLibrary = object


def _is_known() -> bool:
    """Whether this numba provides everything that ``KeptCode`` needs."""
    needed = ((CompileResult, "_rebuild"), (CompileResult, "_reduce"), (NullCache, "load_overload"))
    return dumps is not None and all(hasattr(owner, name) for owner, name in needed)


KEEPS_CODE = _is_known()
# Without allocations, arrays need no reference counts: these are locked operations, a tenth of a step's time.
UNCOUNTED: dict[str, Any] = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}

_OURS = re.compile(r"_ZN\d+synth[_\d]")  # the mangled name of a function of this package or of a generated module


def link_privately() -> None:
    """Let each compiled function call its own copies of our other functions.

    numba links such copies under one name, and the loader uses the first copy in the process for all callers. Copies
    were optimised for their callers and round differently, so a result would depend on whether code was compiled or
    loaded. Functions of other packages are linked as before.
    """
    optimise = getattr(CPUCodeLibrary, "_optimize_final_module", None)
    if optimise is None:
        return

    def private_and_optimised(library: Any) -> None:
        for function in library._final_module.functions:
            if not function.is_declaration and function.linkage.name == "linkonce_odr" and _OURS.match(function.name):
                function.linkage = "internal"
        optimise(library)

    CPUCodeLibrary._optimize_final_module = private_and_optimised


link_privately()


def keep_code(made: Any, function: Callable[..., Any], options: dict[str, Any]) -> None:
    """Let a numba dispatcher load its code from disk and store it there."""
    if KEEPS_CODE and hasattr(made, "_cache"):
        made._cache = KeptCode(function, options)


def entry_point(made: Any) -> Any:
    """The only compiled form of a function; looking it up through numba costs as much as ten steps.

    It does not check its arguments: arrays must be contiguous and of the compiled type.
    """
    try:
        return made.get_compile_result(made.nopython_signatures[0]).entry_point
    except AttributeError:
        return made


class AsArgument(WrapperAddressProtocol):  # type: ignore[misc]
    """A compiled function as an argument of another; numba would look up a plain one's address at every call."""

    def __init__(self, function: Any) -> None:
        self._function = function  # keeps the code alive
        self._signature = function.nopython_signatures[0]
        compiled = function.get_compile_result(self._signature)
        self._address = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name)

    def __wrapper_address__(self) -> int:
        """The address of the code."""
        return int(self._address)

    def signature(self) -> Any:
        """The signature."""
        return self._signature


def as_argument(function: Any) -> Any:
    """A compiled function to pass to another: with its address, or unchanged if numba gives none."""
    try:
        return AsArgument(function)
    except AttributeError:
        return function


def without_products() -> None:
    """Keep numba from importing ``scipy.linalg`` (0.1 s) for matrix products, which our compiled code does not use.

    Only for our own processes: numba's ``np.dot`` is then unavailable unless scipy was loaded before.
    """
    if is_loaded("scipy.linalg") or is_loaded("numba.np.arraymath"):
        return
    with absent("scipy.linalg.cython_blas"):
        import numba.np.arraymath  # noqa: F401


class KeptCode(NullCache):  # type: ignore[misc]
    """One function's compiled code on disk, with the interface that numba expects of a cache.

    numba's own cache reads any file in its folder: a truncated file stops every command with a traceback, and a
    modified one is executed. Here each function is one file whose name contains a hash of everything that the code
    depends on (``reached_code``). No index is needed, and nothing becomes outdated. A function that reaches what cannot
    be hashed is not stored; each process compiles it.

    The content is machine code with its description pickled by numba, the only pickle in this package. It is
    read only after ``synth.cache`` has verified the file: a regular file, not a link, in a folder of
    the user's, written by the user, not writable by others, with the right SHA-256. Anyone who could forge that could
    also change the machine code or the user's Python.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        self._function, self._options = function, options

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The function's code for the signature and this processor; None if it must be compiled."""
        _ready_to_link(target_context)
        path = self._path(sig, target_context.codegen())
        data = None if path is None else read_sealed(path)
        return None if data is None else CompileResult._rebuild(target_context, *pickle.loads(data))

    def save_overload(self, sig: Any, cres: Any) -> None:
        """Store the code, unless it contains addresses of this process."""
        path = self._path(sig, cres.codegen)
        if path is not None and not cres.library.has_dynamic_globals:
            write_sealed(path, dumps(cres._reduce()))

    @cached_property
    def _depends(self) -> tuple[str, ...] | None:
        """Found when the function is compiled, as all that it names is then defined; None: it cannot be hashed."""
        reached = reached_by(self._function)
        versions = numba.__version__, np.__version__, sys.version, _folder_hash(Path(__file__).parent)
        return None if reached.obstacle else (*versions, reached.digest, options_text(self._options))

    def _path(self, sig: Any, codegen: Any) -> Path | None:
        folder = own_folder(FOLDER)
        if folder is None or self._depends is None:
            return None
        digest = hashlib.sha256(repr((self._depends, sig, codegen.magic_tuple())).encode()).hexdigest()
        return folder / f"{self._name}.{digest[:20]}"


def _ready_to_link(target_context: Any) -> None:
    """What stored code calls is there; numba's libraries of functions to compile with are loaded when it compiles.

    They are two fifths of a second of a process that compiles nothing.
    """
    if RUNTIME is None:
        target_context.refresh()
    else:
        RUNTIME.initialize(target_context)


@cache
def _folder_hash(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def compiles(options: dict[str, Any]) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit`` with code stored on disk."""

    def decorate(function: Callable[..., Any]) -> Any:
        made = njit(**options)(function)
        keep_code(made, function, options)
        return made

    return decorate

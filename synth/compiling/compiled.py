"""Compiled functions, kept on disk in the user's cache folder and taken from there only whole and unchanged.

numba's own cache reads whatever lies in its folder: a file cut short stops every command with a traceback, and a
changed one is run. Here each function is one file, sealed by ``synth.cache``, whose name holds a hash of all that the
machine code depends on; so there is no index, and nothing is ever out of date.
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
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from synth.cache import own_folder, read_sealed, write_sealed

FOLDER = "code"


def compiled(signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function for one signature, or take its code from disk; ``options`` are ``numba.njit``'s."""

    def decorate(function: Callable[..., Any]) -> Any:
        made = njit(**options)(function)
        made._cache = KeptCode(function, options)
        made.compile(signature)
        made.disable_compile()
        return made

    return decorate


def kept_code(module: str) -> bool:
    """Whether compiled code of a generated module, by its name, is on disk."""
    folder = own_folder(FOLDER)
    return folder is not None and any(folder.glob(f"{module}.*"))


class KeptCode(NullCache):  # type: ignore[misc]
    """One function's compiled code on disk, in the form in which numba asks for it."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        code = function.__code__.co_code
        self._depends = (numba.__version__, sys.version, _sources(function), code, sorted(options.items()))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The function's code for the signature and this processor; None where it must be compiled."""
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        data = None if path is None else read_sealed(path)
        # The seal holds and the file is the user's own: these are the bytes that this program wrote, as numba has them.
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

"""Compiled functions with machine code stored in the user's cache folder (see ``numba_internals``)."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

from numba.extending import is_jitted

from synth.cache import own_folder
from synth.compiling.numba_internals import FOLDER, compiles, keep_code


def compiled(signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function for one signature, or load its code from disk; ``options`` are those of ``numba.njit``."""

    def decorate(function: Callable[..., Any]) -> Any:
        made = compiles(options)(function)
        made.compile(signature)
        made.disable_compile()
        return made

    return decorate


def compiled_when_called(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Like ``compiled``, for the argument types of each first call."""
    return compiles(options)


def keep_code_of(*modules: ModuleType) -> None:
    """Store the code of modules that use plain ``numba.njit``. Call this before their functions.

    For modules that may not import from ours, such as the engine of ``synth.planting``.
    """
    for module in modules:
        for made in vars(module).values():
            if is_jitted(made) and made.__module__ == module.__name__:
                keep_code(made, made.py_func, {})


def kept_code(module: str) -> bool:
    """Whether compiled code of the generated module of this name is on disk."""
    folder = own_folder(FOLDER)
    return folder is not None and any(folder.glob(f"{module}.*"))

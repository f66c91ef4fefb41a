"""Modules made of generated source text, with compiled code cached on disk.

The text is executed as a module in memory; only its compiled code is stored (``synth.compiling.compiled``). The
module's name contains a hash of the text and its dependencies, so a change recompiles.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from types import ModuleType

from synth.compiling.compiled import kept_code
from synth.compiling.modules import is_loaded, made_module
from synth.threads import core_count


def _module_name(name: str, text: str, depends_on: tuple[Path, ...]) -> str:
    import numba

    digest = hashlib.sha256(text.encode())
    digest.update(numba.__version__.encode())
    for path in depends_on:
        digest.update(path.read_bytes())
    return f"synth_{name}_{digest.hexdigest()[:16]}"


def on_disk(name: str, text: str, depends_on: tuple[Path, ...] = ()) -> bool:
    """Whether compiled code for this text and its dependencies is stored, or in this process."""
    module_name = _module_name(name, text, depends_on)
    return is_loaded(module_name) or kept_code(module_name)


_loading = threading.RLock()  # a second thread must not receive a half-executed module


def load(name: str, text: str, depends_on: tuple[Path, ...] = ()) -> ModuleType:
    """Import generated source ``text`` as a module whose compiled functions are cached on disk.

    ``depends_on`` : files whose functions are inlined into it; editing them recompiles it.
    """
    module_name = _module_name(name, text, depends_on)
    with _loading:
        return made_module(module_name, text)


def compile_aside(name: str, text: str, depends_on: tuple[Path, ...] = ()) -> subprocess.Popen[bytes] | None:
    """Start a process that compiles the source and stores it on disk; None on a single core."""
    if core_count() < 2:
        return None
    program = f"import sys; sys.path[:0] = {[entry or str(Path.cwd()) for entry in sys.path]!r}; "
    program += f"from {made_module.__module__} import made_module; "
    program += f"made_module({_module_name(name, text, depends_on)!r}, sys.stdin.read())"
    helper = subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    assert helper.stdin is not None
    with suppress(OSError), helper.stdin as stream:  # if the helper has already exited, compile here
        stream.write(text.encode())
    return helper

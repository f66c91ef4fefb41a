"""Generated source text as modules whose compiled code is kept on disk.

The text becomes a module of its own, never read from disk, whose compiled code is kept there
(``synth.compiling.compiled``); the module's name holds a hash of the text and of what it calls: a change compiles anew.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from types import ModuleType

from synth.compiling.compiled import kept_code
from synth.compiling.modules import made_module


def _module_name(name: str, text: str, depends_on: tuple[Path, ...]) -> str:
    import numba

    digest = hashlib.sha256(text.encode())
    digest.update(numba.__version__.encode())
    for path in depends_on:
        digest.update(path.read_bytes())
    return f"synth_{name}_{digest.hexdigest()[:16]}"


def on_disk(name: str, text: str, depends_on: tuple[Path, ...] = ()) -> bool:
    """Whether the compiled code of this very text and of what it depends on is kept already."""
    return kept_code(_module_name(name, text, depends_on))


_loading = threading.RLock()  # two threads that want the same module: the second must not get it half-executed


def load(name: str, text: str, depends_on: tuple[Path, ...] = ()) -> ModuleType:
    """Import generated source ``text`` as a module whose compiled functions are cached on disk.

    ``depends_on`` : files whose functions are inlined into it, so that editing them compiles anew.
    """
    module_name = _module_name(name, text, depends_on)
    with _loading:
        return made_module(module_name, text)


def compile_aside(name: str, text: str, depends_on: tuple[Path, ...] = ()) -> subprocess.Popen[bytes] | None:
    """Start a process that compiles the source and keeps it on disk; None on a single core."""
    if (os.cpu_count() or 1) < 2:
        return None
    program = f"import sys; sys.path[:0] = {[entry or str(Path.cwd()) for entry in sys.path]!r}; "
    program += f"from {made_module.__module__} import made_module; "
    program += f"made_module({_module_name(name, text, depends_on)!r}, sys.stdin.read())"
    helper = subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    assert helper.stdin is not None
    with suppress(OSError), helper.stdin as stream:  # one that has ended already: compiled here after all
        stream.write(text.encode())
    return helper

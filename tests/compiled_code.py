"""Cache folders that hold the program's compiled code already, so that a test compiles only what it is about."""

from __future__ import annotations

import shutil
from pathlib import Path

from synth.cache import own_folder
from synth.compiling.code_cache import _module_name
from synth.compiling.numba_internals import FOLDER
from synth.swing.chain import compiled_chain


def with_code(cache: Path, links: int, *, but: str) -> Path:
    """The new cache folder ``cache`` with the code of a chain of ``links`` links, without its module ``but``."""
    chain = compiled_chain(links)
    chain.load()
    target, kept = cache / FOLDER, own_folder(FOLDER)
    assert kept is not None
    target.mkdir(mode=0o700, parents=True)
    for name, source in chain.sources.items():
        files = list(kept.glob(f"{_module_name(*source.parts)}.*")) if name != but else []
        assert files or name == but
        for path in files:
            shutil.copy2(path, target)
    return cache

"""Modules from files outside any package, such as the programs in ``tools/``."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[1]


def loaded(name: str, path: Path) -> ModuleType:
    """The module of a file, registered under ``name``."""
    specification = importlib.util.spec_from_file_location(name, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # dataclasses look their module up there
    specification.loader.exec_module(module)
    return module


@cache
def tool(name: str) -> ModuleType:
    """``tools/NAME.py``."""
    return loaded(name, ROOT / "tools" / f"{name}.py")

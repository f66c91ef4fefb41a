"""What a result depends on beside its input files: this program's source, its libraries, and effects from outside it.

The cache of stages, the finished results of an interrupted run, and the workers of a cluster ask this one list.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from contextlib import suppress
from functools import cache
from pathlib import Path

import synth
from synth.swing.foreign_effects import digests

LIBRARIES = (
    "numpy", "scipy", "numba", "cadquery", "cadquery-ocp", "vtk", "trimesh", "manifold3d", "ezdxf", "jinja2",
)  # fmt: skip
BESIDE = ("cad", "reports", "_catalogs")  # folders of the package, links to folders beside it where it is developed
SHOWN = 16  # digits of the source's hash, in messages too; by chance two are equal once in 2**64


def versions() -> dict[str, str]:
    """The versions that must be equal for identical output: Python, this program, its source, libraries, effects."""
    python = ".".join(platform.python_version_tuple()[:2])
    found = {"python": python, "synth": synth.__version__, "synth's source": _own_source()}
    return found | {name: _version(name) for name in LIBRARIES} | digests()


@cache
def _own_source() -> str:
    return source_hash(Path(synth.__file__).parent)


def source_hash(root: Path) -> str:
    """Hash of a package's source, data and templates, the same of an installed one as where it is developed.

    Compiled code is left out, and what another process may be writing beside it.
    """
    digest = hashlib.sha256()
    for package in (root, *(root / name for name in BESIDE)):
        for path in sorted(package.rglob("*")):
            parts = path.relative_to(package).parts
            twice = package == root and parts[0] in BESIDE
            passing = any(part == "__pycache__" or part.startswith(".") for part in parts)
            if not twice and not passing and path.is_file():
                content = path.read_bytes()
                digest.update(f"{package.name}/{'/'.join(parts)} {len(content)}\n".encode())
                digest.update(content)
    return digest.hexdigest()[:SHOWN]


@cache
def _version(library: str) -> str:
    """A library's version; older cadquery-ocp brings VTK within itself, so that it has none."""
    with suppress(importlib.metadata.PackageNotFoundError):
        return importlib.metadata.version(library)
    return "absent"

"""The points of a mesh that a URDF names, which must lie in the URDF's folder, or in the ROS package that holds it."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path, PurePosixPath

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.files.paths import inside, read_bytes

FORMATS = (".stl", ".obj", ".ply")  # that hold all their points; DAE and glTF may name further files
LARGEST_DESCRIPTION = 1_000_000  # bytes of a package.xml; one has some kB
LARGEST = 100_000_000  # bytes; a link's mesh seldom has over 10 MB
PACKAGE = "package://"
# Folders above a URDF's own in which its package is sought: `robots/a1/a1.urdf` lies two below it.
FOLDERS_ABOVE = 3


def mesh_points(folder: Path, name: str) -> Array:
    """The mesh's points (m, 3) in its own units.

    ``name`` : as in the file. That of a ROS package is sought in this package, if it holds the folder, else below the
    folder, with the package's name and without.

    Raises
    ------
    UserError
        If it is no such file in the folder's tree, of another format, or cannot be read.
    """
    if not name.strip():
        raise UserError("no file is named")
    if PurePosixPath(name).suffix.lower() not in FORMATS:
        raise UserError(f'"{name}" is none of {", ".join(FORMATS)}')
    path = _found(folder, name)
    return _points(read_bytes(path, LARGEST, "a mesh of this size is not read"), path)


def _found(folder: Path, name: str) -> Path:
    if not name.startswith(PACKAGE):
        if "://" in name:
            raise UserError(f'"{name}" is no file in the folder of the URDF')
        return inside(folder, name)
    whole = name.removeprefix(PACKAGE)
    package, _, within = whole.partition("/")
    for root in (folder.resolve(), *folder.resolve().parents[:FOLDERS_ABOVE]):
        if _is_package(root, package):
            return inside(root, within)
    try:
        return inside(folder, whole)
    except UserError:
        return inside(folder, within)


def _is_package(folder: Path, name: str) -> bool:
    """Whether a folder is the ROS package of this name: with its own `package.xml`."""
    described = folder / "package.xml"
    if not described.is_file() or described.stat().st_size > LARGEST_DESCRIPTION:
        return False
    found = re.search(r"<name>\s*([^<]*?)\s*</name>", described.read_text(encoding="utf-8", errors="replace"))
    return found is not None and found.group(1) == name


def _points(data: bytes, path: Path) -> Array:
    import trimesh  # local: 0.2 s, and most legs come from files without meshes

    try:
        # From bytes and without a resolver, it opens no file that the mesh names.
        mesh = trimesh.load(BytesIO(data), file_type=path.suffix.lower()[1:], force="mesh", process=False)
        points = np.asarray(mesh.vertices, float)
    except Exception as error:  # its readers raise whatever a damaged file brings about
        raise UserError(f'"{path.name}" cannot be read as a mesh: {type(error).__name__}') from None
    if points.ndim != 2 or points.shape[1:] != (3,) or not len(points) or not np.isfinite(points).all():
        raise UserError(f'"{path.name}" cannot be read as a mesh: it has no points, or some are not finite')
    return points

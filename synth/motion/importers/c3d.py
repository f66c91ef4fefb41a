"""C3D: points in space, as motion capture systems write them (www.c3d.org), read by ``ezc3d``.

ezc3d: Michaud & Begon, *J. Open Source Software* 6 (2021) 2911.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.files.paths import read_bytes
from synth.model.leg import Array
from synth.motion.importers.source import Markers

SIZE_LIMIT = 1_000_000_000
INSTALL = 'reading C3D needs the package ezc3d: pip install "limb-synth[c3d]", or pip install ezc3d'


def read_c3d(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own rate.

    Raises
    ------
    UserError : ezc3d is not installed, the file is no C3D, or it holds no point or no rate.
    """
    if not read_bytes(path, SIZE_LIMIT, "cut it in the capture software")[1:2] == b"\x50":
        raise UserError(Problem("is no C3D file: its second byte is not the mark 50h", name))
    try:
        import ezc3d
    except ImportError:
        raise UserError(Problem(INSTALL, name)) from None
    try:
        content = ezc3d.c3d(str(path))
    except (OSError, RuntimeError, ValueError, IndexError, KeyError) as error:
        raise UserError(Problem(f"cannot be read as C3D: {error}", name)) from None
    parameters = content["parameters"].get("POINT", {})
    names = tuple(str(label).strip() for label in _values(parameters, "LABELS"))
    rates = _values(parameters, "RATE")
    positions: Array = np.asarray(content["data"]["points"], dtype=np.float64)[:3].transpose(2, 1, 0).copy()
    if not names or positions.shape[0] < 2:
        raise UserError(Problem("holds no points over time", name))
    if len(names) < positions.shape[1]:
        raise UserError(Problem(f"names {len(names)} of its {positions.shape[1]} points", name))
    if not rates or not float(rates[0]) > 0:
        raise UserError(Problem("says no rate of its points (POINT:RATE)", name))
    residual = np.asarray(content["data"]["meta_points"]["residuals"])[0].T
    positions[residual < 0] = np.nan  # the format's mark of a point that was not seen
    unit = _values(parameters, "UNITS")
    first = float(content["header"]["points"]["first_frame"])
    frames: Array = np.asarray(first + np.arange(positions.shape[0]), dtype=np.float64)
    shown = str(unit[0]) if unit else ""
    return Markers(name, names[: positions.shape[1]], positions, frames, float(rates[0]), shown)


def _values(parameters: Any, key: str) -> list[Any]:
    """A parameter's values, empty where the file has none."""
    return list(parameters[key]["value"]) if key in parameters else []

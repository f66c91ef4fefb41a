"""C3D: points in space, as motion capture systems write them (www.c3d.org), read by ``ezc3d``.

ezc3d: Michaud & Begon, *J. Open Source Software* 6 (2021) 2911. A damaged file can crash its process, so
it is read in a separate one, which costs half a second per file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.paths import read_bytes
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Markers, cut_off
from synth.motion.importers.registry import loader

SIZE_LIMIT = 1_000_000_000  # bytes; the whole file is read into memory

_READ = """
import ezc3d
content = ezc3d.c3d(path)
point = content["parameters"]["POINT"]
values = lambda key: list(point[key]["value"]) if key in point else []
labels = [str(label) for key in ["LABELS", *LONGER] for label in values(key)]
arrays = {
    "points": numpy.asarray(content["data"]["points"], dtype=float)[:3],
    "residuals": numpy.asarray(content["data"]["meta_points"]["residuals"], dtype=float)[0],
    "labels": numpy.array(labels, dtype=str),
    "rate": numpy.array(values("RATE"), dtype=float),
    "unit": numpy.array([str(unit) for unit in values("UNITS")], dtype=str),
    "first": float(content["header"]["points"]["first_frame"]),
}
"""
MIPS = b"\x56"  # of the processor: 86; the others, 84 and 85, write the low byte first
# More than 255 points have their names in further parameters (C3D file format, user guide, POINT:LABELS2).
_LONGER = [f"LABELS{number}" for number in range(2, 10)]


def is_c3d(start: bytes, path: Path) -> bool:
    """Whether the second byte is C3D's mark and the first points into the file (C3D file format, user guide)."""
    return len(start) > 512 and start[1:2] == b"\x50" and 2 <= start[0] <= 10  # bytes of a block, the smallest file


def _high_byte_first(path: Path) -> bool:
    """Whether its bytes are in the order of SGI machines; the parameters' fourth byte tells (same guide)."""
    with path.open("rb") as file:
        file.seek(512 * max(file.read(1)[0] - 1, 0))
        return file.read(4)[3:] == MIPS


def _stated_frames(path: Path) -> int:
    """Frames by the file's own header, of which ``ezc3d`` reads those that are there.

    Words 4 and 5 of the header are the first and last frame, at most 65535, which longer files hold (C3D file format,
    user guide).
    """
    with path.open("rb") as file:
        head = file.read(512)
    order = ">u2" if _high_byte_first(path) else "<u2"
    first, last = (int(word) for word in np.frombuffer(head[6:10], order))
    return last - first + 1


@loader("c3d", "C3D", is_c3d, "points", space=True, needs=("ezc3d", "c3d"))
def read_c3d(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own rate.

    Raises
    ------
    UserError : the file is not C3D, damaged or cut off, or it has no points or no rate.
    """
    if not read_bytes(path, SIZE_LIMIT, "cut it in the capture software", first=2)[1:2] == b"\x50":
        raise UserError(Problem("is not a C3D file: its second byte is not the mark 50h", name))
    try:
        content = read_in_child(f"LONGER = {_LONGER!r}\n{_READ}", path, name, "C3D")
    except UserError:
        if _high_byte_first(path):
            text = "is C3D in the byte order of SGI machines (processor 86), which ezc3d does not read; "
            raise UserError(Problem(f"{text}export it for Intel", name)) from None
        raise
    stated = _stated_frames(path)
    if content["points"].shape[2] < stated:
        raise UserError(cut_off(stated, content["points"].shape[2], "frames", name))
    names = tuple(str(label).strip() for label in content["labels"])
    positions: Array = content["points"].transpose(2, 1, 0).copy()
    if not names or positions.shape[0] < 2:
        raise UserError(Problem("contains no points over time", name))
    if len(names) < positions.shape[1]:
        raise UserError(Problem(f"names only {len(names)} of its {positions.shape[1]} points", name))
    rate = content["rate"]
    if not len(rate) or not 0 < rate[0] < np.inf:
        raise UserError(Problem("states no rate of its points (POINT:RATE)", name))
    positions[(content["residuals"].T < 0) | ~np.isfinite(positions).all(axis=2)] = np.nan  # < 0: point not visible
    frames: Array = np.asarray(float(content["first"]) + np.arange(positions.shape[0]), dtype=np.float64)
    unit = str(content["unit"][0]) if len(content["unit"]) else ""
    return Markers(name, names[: positions.shape[1]], positions, frames, float(rate[0]), unit)

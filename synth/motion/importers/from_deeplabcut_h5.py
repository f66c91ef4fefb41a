"""DeepLabCut's HDF5, written by pandas with PyTables: one table with columns scorer, body part, coordinate.

Read by ``h5py``; the column names are pickled in it, and are read without unpickling (``plain_pickle``).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.child import read_in_child
from synth.motion.importers.deeplabcut import LEVELS, markers_of
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.plain_pickle import plain_values
from synth.motion.importers.registry import HDF5, hdf5_names, loader

_READ = """
import h5py
with h5py.File(path, "r") as file:
    tables = [name for name in file if "table" in file[name]]
    found = [name for name in tables if "values_block_0" in (file[name]["table"].dtype.names or ())]
    table = held(file[found[0]]["table"])
    axes = file[found[0]].attrs["non_index_axes"]
    arrays = {
        "tables": numpy.array(found, dtype=str),
        "values": numpy.asarray(table["values_block_0"], dtype=float),
        "frames": numpy.asarray(table["index"], dtype=float),
        "axes": numpy.frombuffer(bytes(axes), dtype=numpy.uint8),
    }
"""


def is_deeplabcut_h5(start: bytes, path: Path) -> bool:
    """Whether an HDF5 file contains a table in pandas' format with DeepLabCut's column level ``coords``."""
    return start.startswith(HDF5) and hdf5_names(path, b"pandas_type", b"likelihood", b"values_block_0")


@loader(
    "deeplabcut-h5",
    "DeepLabCut HDF5",
    is_deeplabcut_h5,
    "points",
    keys=frozenset({"likelihood", "individual"}),
    needs=("h5py", "hdf5"),
)
def read_deeplabcut_h5(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one animal, as ``read_deeplabcut`` gives them of the CSV.

    Raises
    ------
    UserError : the table is not as DeepLabCut writes it, or several animals and none chosen.
    """
    content = read_in_child(_READ, path, name, "DeepLabCut HDF5")
    try:
        axes = plain_values(content["axes"].tobytes())
        columns = [tuple(str(level) for level in column) for column in axes[0][1]]
    except (ValueError, IndexError, TypeError) as error:
        text = f"has column names that cannot be read ({error}); write it as CSV: analyze_videos(..., save_as_csv=True)"
        raise UserError(Problem(text, name)) from None
    width = len(columns[0]) if columns else 0
    levels = LEVELS if width == len(LEVELS) else tuple(level for level in LEVELS if level != "individuals")
    if len(columns) != content["values"].shape[1] or any(len(column) != len(levels) for column in columns):
        raise UserError(Problem("has a table that DeepLabCut does not write", name))
    header = {level: [column[k] for column in columns] for k, level in enumerate(levels)}
    return markers_of(header, np.asarray(content["frames"]), np.asarray(content["values"]), mapping, name)

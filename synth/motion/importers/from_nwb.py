"""NWB with pose estimates of the extension ndx-pose: one series per body part, with clock and confidence.

NWB is HDF5 whose groups state their type (``neurodata_type``), so ``h5py`` reads it without its namespaces. The tests
read a file written by ``pynwb`` with ``ndx-pose``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.likelihood import without_unlikely
from synth.motion.importers.registry import HDF5, hdf5_names, loader

_READ = """
import h5py
series = {}
def look(place, item):
    if isinstance(item, h5py.Group) and item.attrs.get("neurodata_type") == "PoseEstimationSeries":
        series[place] = item
with h5py.File(path, "r") as file:
    file.visititems(look)
    names = sorted(series)
    arrays = {"names": numpy.array([name.split("/")[-1] for name in names], dtype=str),
              "groups": numpy.array(sorted({name.rsplit("/", 1)[0] for name in names}), dtype=str)}
    for k, name in enumerate(names):
        item = series[name]
        arrays[f"data{k}"] = numpy.asarray(held(item["data"]), dtype=float)
        if "confidence" in item:
            arrays[f"confidence{k}"] = numpy.asarray(held(item["confidence"]), dtype=float)
        if "timestamps" in item:
            arrays[f"time{k}"] = numpy.asarray(held(item["timestamps"]), dtype=float)
        else:
            start = item["starting_time"]
            arrays[f"rate{k}"] = float(start.attrs["rate"])
        unit = item["data"].attrs.get("unit", "")
        arrays[f"unit{k}"] = numpy.array(unit.decode() if isinstance(unit, bytes) else str(unit))
"""


def is_nwb_pose(start: bytes, path: Path) -> bool:
    """Whether an HDF5 file names NWB and a pose series."""
    return start.startswith(HDF5) and hdf5_names(path, b"neurodata_type", b"PoseEstimationSeries")


@loader("nwb-pose", "NWB pose (ndx-pose)", is_nwb_pose, "points", space=True, keys=frozenset({"likelihood"}),
        needs=("h5py", "hdf5"))  # fmt: skip
def read_nwb(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one pose estimation with its clock.

    Raises
    ------
    UserError : several poses or clocks in one file, or series of different lengths.
    """
    content = read_in_child(_READ, path, name, "NWB")
    parts = [str(part).removesuffix("PoseEstimationSeries") or str(part) for part in content["names"]]
    if len(content["groups"]) > 1:
        raise UserError(Problem(f"contains {len(content['groups'])} pose estimations; keep one per file", name))
    if not parts:
        raise UserError(Problem("contains no PoseEstimationSeries", name))
    data = [content[f"data{k}"] for k in range(len(parts))]
    shape = data[0].shape
    if len(shape) != 2 or shape[0] < 2 or shape[1] not in (2, 3):
        text = f"contains a series of shape {' x '.join(map(str, shape))}, where frames x 2 or 3 coordinates are needed"
        raise UserError(Problem(text, name, key=parts[0]))
    if len({item.shape for item in data}) != 1:
        raise UserError(Problem("contains series of different lengths", name))
    positions = np.stack(data, axis=1)
    frames, rate = _clock(content, len(parts), len(positions), name)
    found = [content.get(f"confidence{k}") for k in range(len(parts))]
    scores = [item for item in found if item is not None and item.shape == (len(positions),)]
    both = np.stack(scores, axis=1) if len(scores) == len(parts) else None
    notes = without_unlikely(positions, both, mapping.likelihood, "confidence", name)
    if positions.shape[2] == 2:
        positions[..., 1] *= -1.0  # pixels count downward
    return Markers(name, tuple(parts), positions, frames, rate, str(content["unit0"]), notes, up="z")


def _clock(content: dict[str, Any], parts: int, count: int, name: str) -> tuple[Array, float]:
    """The frames (n,) and their rate, Hz, from the series' times or their rate."""
    times = [content[f"time{k}"] for k in range(parts) if f"time{k}" in content]
    if not times:
        rate = float(content["rate0"])
        if not 0.0 < rate < np.inf:
            raise UserError(Problem(f"states a rate of {rate:g} Hz", name))
        return np.arange(count, dtype=float), rate
    time = times[0]
    if any(other.shape != (count,) or np.abs(other - time).max() > 1e-9 for other in times):
        raise UserError(Problem("its body parts have different clocks, or not one time for each frame", name))
    step = float(np.median(np.diff(time)))
    if not 0.0 < step < np.inf:
        raise UserError(Problem("has times that are missing, or do not increase", name))
    return time / step, 1.0 / step

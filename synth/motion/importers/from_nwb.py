"""NWB with pose estimates of the extension ndx-pose: one series per body part, with clock and confidence.

NWB is HDF5 whose groups state their type (``neurodata_type``), so ``h5py`` reads it without its namespaces. The tests
read a file written by ``pynwb`` with ``ndx-pose``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.registry import HDF5, loader

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
        arrays[f"data{k}"] = numpy.asarray(item["data"], dtype=float)
        if "confidence" in item:
            arrays[f"confidence{k}"] = numpy.asarray(item["confidence"], dtype=float)
        if "timestamps" in item:
            arrays[f"time{k}"] = numpy.asarray(item["timestamps"], dtype=float)
        else:
            start = item["starting_time"]
            arrays[f"rate{k}"] = float(start.attrs["rate"])
        unit = item["data"].attrs.get("unit", "")
        arrays[f"unit{k}"] = numpy.array(unit.decode() if isinstance(unit, bytes) else str(unit))
"""


def is_nwb_pose(start: bytes, path: Path) -> bool:
    """Whether an HDF5 file names NWB and a pose series."""
    if not start.startswith(HDF5):
        return False
    data = path.read_bytes()[:50_000_000]
    return b"neurodata_type" in data and b"PoseEstimationSeries" in data


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
    data = [content[f"data{k}"] for k in range(len(parts))]
    if len({item.shape for item in data}) != 1:
        raise UserError(Problem("contains series of different lengths", name))
    positions = np.stack(data, axis=1)
    times = [content[f"time{k}"] for k in range(len(parts)) if f"time{k}" in content]
    if times:
        time = times[0]
        if any(len(other) != len(time) or np.abs(other - time).max() > 1e-9 for other in times):
            raise UserError(Problem("its body parts have different clocks", name))
        rate = 1.0 / float(np.median(np.diff(time)))
        frames = time * rate
    else:
        rate = float(content["rate0"])
        frames = np.arange(len(positions), dtype=float)
    notes = []
    if mapping.likelihood is not None:
        scores = np.stack([content[f"confidence{k}"] for k in range(len(parts))], axis=1)
        positions[~(scores >= mapping.likelihood)] = np.nan
        notes = [f"points of a confidence below {mapping.likelihood:g} are taken as missing"]
    if positions.shape[2] == 2:
        positions[..., 1] *= -1.0  # pixels count downward
    return Markers(name, tuple(parts), positions, frames, rate, str(content["unit0"]), tuple(notes), up="z")

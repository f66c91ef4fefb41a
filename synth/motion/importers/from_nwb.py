"""NWB with pose estimates of the extension ndx-pose: one series per body part, with clock and confidence.

NWB is HDF5 whose groups state their type (``neurodata_type``), so ``h5py`` reads it without its namespaces. The tests
read a file written by ``pynwb`` with ``ndx-pose``.

The series' ``reference_frame`` is a sentence on the origin. "(0,0) corresponds to the bottom left corner of the video"
is what exporters of DeepLabCut's positions write, which count from the top (DLC2NWB, NeuroConv), and what others may
mean: they are read as counted from the top, and a warning asks for the axes.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.likelihood import without_unlikely
from synth.motion.importers.nwb_poses import chosen_pose
from synth.motion.importers.registry import HDF5, hdf5_names, loader
from synth.remarks import decisive

# Reads the pose at ``wanted``, or the only one; of several without ``wanted`` the names alone.
_READ = """
import h5py
series, poses = {}, {}
text = lambda value: value.decode() if isinstance(value, bytes) else str(value)
def look(place, item):
    if isinstance(item, h5py.Group) and item.attrs.get("neurodata_type") == "PoseEstimationSeries":
        series[place] = item
def links(group):
    for key in group:
        link = group.get(key, getlink=True)
        if isinstance(link, h5py.SoftLink) and isinstance(group.get(key), h5py.Group):
            target = group[key]
            if text(target.attrs.get("neurodata_type", "")) in ("Skeleton", "Subject", "Device", "CalibratedCamera"):
                yield link.path.rsplit("/", 1)[-1]
                yield from links(target)
            if "subject_id" in target:
                yield text(held(target["subject_id"])[()])
with h5py.File(path, "r") as file:
    file.visititems(look)
    for name in sorted(series):
        poses.setdefault(name.rpartition("/")[0], []).append(name)
    of = {}
    for place in poses if len(poses) > 1 else ():
        group = file[place] if place else file
        videos = held(group["original_videos"])[()] if "original_videos" in group else []
        of[place] = [*links(group), *map(text, numpy.atleast_1d(videos))]
    chosen = wanted if wanted is not None else next(iter(poses)) if len(poses) == 1 else None
    names = poses.get(chosen, [])
    arrays = {"names": numpy.array([name.split("/")[-1] for name in names], dtype=str),
              "poses": numpy.array(list(poses), dtype=str),
              "of": numpy.array(["\\n".join(of.get(place, [])) for place in poses], dtype=str)}
    for k, name in enumerate(names):
        item = series[name]
        arrays[f"data{k}"] = numpy.asarray(held(item["data"]), dtype=float)
        if "confidence" in item:
            arrays[f"confidence{k}"] = numpy.asarray(held(item["confidence"]), dtype=float)
        if "timestamps" in item:
            arrays[f"time{k}"] = numpy.asarray(held(item["timestamps"]), dtype=float)
        else:
            start = item["starting_time"]
            arrays[f"start{k}"] = float(start[()])
            arrays[f"rate{k}"] = float(start.attrs["rate"])
        arrays[f"unit{k}"] = numpy.array(text(item["data"].attrs.get("unit", "")))
        arrays[f"frame{k}"] = numpy.array(text(held(item["reference_frame"])[()] if "reference_frame" in item else ""))
"""

SAME_TIME = 1e-9  # s, between the body parts' times of one frame
PICTURE = ("x", "-y")  # to the right and up: pixels count downward
LONGEST = 200  # characters of a sentence in a message
FROM_BELOW = re.compile(r"\b(bottom|lower)\b", re.IGNORECASE)


def is_nwb_pose(start: bytes, path: Path) -> bool:
    """Whether an HDF5 file names NWB and a pose series."""
    return start.startswith(HDF5) and hdf5_names(path, b"neurodata_type", b"PoseEstimationSeries")


@loader(
    "nwb-pose",
    "NWB pose (ndx-pose)",
    is_nwb_pose,
    "points",
    space=True,
    keys=frozenset({"individual", "likelihood"}),
    needs=("h5py", "hdf5"),
)
def read_nwb(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one pose estimation with its clock.

    Raises
    ------
    UserError : several poses of which none is chosen, several clocks in one, or series of different lengths.
    """
    content = _content(path, mapping.individual, name)
    parts = [str(part).removesuffix("PoseEstimationSeries") or str(part) for part in content["names"]]
    data = [content[f"data{k}"] for k in range(len(parts))]
    shape = data[0].shape
    if len(shape) != 2 or shape[0] < 2 or shape[1] not in (2, 3):
        text = f"contains a series of shape {' x '.join(map(str, shape))}, where frames x 2 or 3 coordinates are needed"
        raise UserError(Problem(text, name, key=parts[0]))
    if len({item.shape for item in data}) != 1:
        raise UserError(Problem("contains series of different lengths", name))
    positions = np.stack(data, axis=1)
    time, rate = _clock(content, len(parts), len(positions), name)
    found = [content.get(f"confidence{k}") for k in range(len(parts))]
    scores = [item for item in found if item is not None and item.shape == (len(positions),)]
    both = np.stack(scores, axis=1) if len(scores) == len(parts) else None
    notes = without_unlikely(positions, both, mapping.likelihood, "confidence", name)
    if positions.shape[2] == 2 and mapping.plane is None:
        notes += _unclear_axes([str(content[f"frame{k}"]) for k in range(len(parts))], name)
    return Markers(
        name, tuple(parts), positions, time * rate, rate, str(content["unit0"]), notes, up="z", time=time,
        picture=PICTURE,
    )  # fmt: skip


def _content(path: Path, individual: str | None, name: str) -> dict[str, Any]:
    """The arrays of the pose that is meant."""
    content = read_in_child("wanted = None\n" + _READ, path, name, "NWB")
    poses = {str(place): str(of).split("\n") if str(of) else [] for place, of in
             zip(content["poses"], content["of"], strict=True)}  # fmt: skip
    if not poses:
        raise UserError(Problem("contains no PoseEstimationSeries", name))
    chosen = chosen_pose(poses, individual, name)
    if len(poses) > 1:
        content = read_in_child(f"wanted = {chosen!r}\n{_READ}", path, name, "NWB")
    return content


def _unclear_axes(sentences: list[str], name: str) -> tuple[str, ...]:
    """A warning where a series' ``reference_frame`` tells of an origin below."""
    below = next((sentence for sentence in sentences if FROM_BELOW.search(sentence)), None)
    if below is None:
        return ()
    text = f'{name}: reference_frame says "{below[:LONGEST]}", which exporters also write of positions that count from '
    text += "the top. The positions are read as counted from the top, as DeepLabCut's and SLEAP's are"
    remedy = "State the axes: plane: [x, y] (--plane=x,y) if y grows upward, plane: [x, -y] (--plane=x,-y) if downward."
    return (decisive(text, remedy),)


def _clock(content: dict[str, Any], parts: int, count: int, name: str) -> tuple[Array, float]:
    """The file's own times (n,) s and their rate, Hz, from the series' times, or their first time and rate."""
    times = [_series_times(content, k, count, name) for k in range(parts)]
    time = times[0]
    if any(other.shape != (count,) or np.abs(other - time).max() > SAME_TIME for other in times):
        raise UserError(Problem("its body parts have different clocks, or not one time for each frame", name))
    step = float(np.median(np.diff(time)))
    if not 0.0 < step < np.inf:
        raise UserError(Problem("has times that are missing, or do not increase", name))
    return time, float(content.get("rate0", 1.0 / step))


def _series_times(content: dict[str, Any], k: int, count: int, name: str) -> Array:
    """The times of one series, s; ``count`` of them if it states a first time and a rate."""
    if f"time{k}" in content:
        return np.asarray(content[f"time{k}"])
    rate, start = float(content[f"rate{k}"]), float(content[f"start{k}"])
    if not 0.0 < rate < np.inf or not np.isfinite(start):
        raise UserError(Problem(f"states a rate of {rate:g} Hz from {start:g} s", name))
    return np.asarray(start + np.arange(count) / rate)

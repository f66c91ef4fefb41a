"""SLEAP: predictions as ``.slp`` (read by ``sleap-io``) and the analysis HDF5 that it exports (read by ``h5py``).

Both are HDF5. x and y are pixels from the picture's upper left corner, y downward (Pereira et al., *Nature Methods* 19
(2022) 486). Frames without an instance are missing.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Markers, name_list
from synth.motion.importers.registry import HDF5, hdf5_names, loader
from synth.motion.importers.sleap_instances import (
    Instances,
    chosen_track,
    markers_of_instances,
    tracked_markers,
    visible_instances,
)

_ANALYSIS = """
import h5py
with h5py.File(path, "r") as file:
    texts = lambda name: numpy.array([bytes(item).decode() for item in held(file[name])[...].ravel()], dtype=str)
    stated = lambda name: str(file[name].attrs.get("dims", ""))
    arrays = {"points": numpy.asarray(held(file["tracks"]), dtype=float), "nodes": texts("node_names"),
              "order": stated("tracks"), "transpose": bool(file.attrs.get("transpose", True)),
              "tracks": texts("track_names") if "track_names" in file else numpy.array([], dtype=str)}
    if "point_scores" in file:
        arrays["scores"] = numpy.asarray(held(file["point_scores"]), dtype=float)
        arrays["score_order"] = stated("point_scores")
"""
_SLP = """
import sleap_io
labels = sleap_io.load_slp(path, open_videos=False)
nodes = list(dict.fromkeys(name for skeleton in labels.skeletons for name in skeleton.node_names))
frames, tracks, by_hand, points = [], [], [], []
for frame in labels.labeled_frames:
    own = [each for each in frame.instances if not isinstance(each, sleap_io.PredictedInstance)]
    replaced = {id(of) for each in own for of in (each.from_predicted, each.track) if of is not None}
    for each in frame.instances:
        predicted = isinstance(each, sleap_io.PredictedInstance)
        if predicted and (id(each) in replaced or id(each.track) in replaced):
            continue
        row = numpy.full((len(nodes), 3), numpy.nan)
        at = [nodes.index(name) for name in each.skeleton.node_names]
        row[at, :2], row[at, 2] = each.numpy(), each.numpy(scores=True)[:, 2] if predicted else 1.0
        frames.append(frame.frame_idx)
        tracks.append(-1 if each.track is None else labels.tracks.index(each.track))
        by_hand.append(not predicted)
        points.append(row)
arrays = {"frames": numpy.array(frames, dtype=int), "track": numpy.array(tracks, dtype=int),
          "by_hand": numpy.array(by_hand, dtype=bool), "videos": float(len(labels.videos)),
          "points": numpy.array(points, dtype=float).reshape(len(points), len(nodes), 3),
          "nodes": numpy.array(nodes, dtype=str),
          "tracks": numpy.array([track.name for track in labels.tracks], dtype=str)}
"""
# Axes of a file that does not state them: as SLEAP writes it for MATLAB, and as it wrote it with transpose=False.
_FOR_MATLAB, _NOT_TRANSPOSED = ("track", "xy", "node", "frame"), ("frame", "node", "xy", "track")
_READ = ("frame", "track", "node", "xy")


def is_sleap_analysis(start: bytes, path: Path) -> bool:
    """Whether an HDF5 file has the datasets of SLEAP's analysis export."""
    return start.startswith(HDF5) and hdf5_names(path, b"track_occupancy", b"node_names")


def is_slp(start: bytes, path: Path) -> bool:
    """Whether an HDF5 file has the datasets of a SLEAP project."""
    return start.startswith(HDF5) and hdf5_names(path, b"pred_points", b"instances", b"tracks_json")


@loader("sleap-analysis", "SLEAP analysis HDF5", is_sleap_analysis, "points",
        keys=frozenset({"individual", "likelihood"}), needs=("h5py", "hdf5"))  # fmt: skip
def read_sleap_analysis(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one track; the file has no clock."""
    content = read_in_child(_ANALYSIS, path, name, "SLEAP analysis HDF5")
    nodes, tracks = ([str(each) for each in content[key]] for key in ("nodes", "tracks"))
    found, order = content["points"], _stated_order(str(content["order"]), _READ, "tracks", name)
    if order is None:
        fitting = [each for each in ((_FOR_MATLAB, _READ) if content["transpose"] else (_NOT_TRANSPOSED,))
                   if _fits(found.shape, each, nodes, tracks)]  # fmt: skip
        order = fitting[0] if fitting else None
    if order is None or not _fits(found.shape, order, nodes, tracks):
        text = f"has points of shape {found.shape} for {len(nodes)} nodes and {len(tracks)} named tracks"
        raise UserError(Problem(text, name))
    points = found.transpose([order.index(axis) for axis in _READ])
    scores = content.get("scores")
    if scores is not None:
        order = _stated_order(str(content["score_order"]), _READ[:3], "point_scores", name) or tuple(
            axis for axis in order if axis != "xy"
        )
        in_order = scores.transpose([order.index(axis) for axis in _READ[:3]]) if scores.ndim == 3 else scores
        if in_order.shape != points.shape[:3]:
            text = f"has scores of shape {scores.shape} for points of shape {found.shape}"
            raise UserError(Problem(text, name))
        points = np.concatenate([points, in_order[..., None]], axis=3)
    return _of_tracks(points, nodes, tracks, mapping, name)


def _stated_order(dims: str, axes: tuple[str, ...], dataset: str, name: str) -> tuple[str, ...] | None:
    """The axes of a dataset in the order that its attribute ``dims`` (JSON) states; None if it has none."""
    if not dims:
        return None
    try:
        stated = json.loads(dims)
    except (json.JSONDecodeError, RecursionError):
        stated = None
    if not isinstance(stated, list) or sorted(map(str, stated)) != sorted(axes):
        text = f'the attribute dims of "{dataset}" is {dims[:80]}, and not the names {name_list(axes)} in some order'
        raise UserError(Problem(text, name))
    return tuple(map(str, stated))


def _fits(shape: tuple[int, ...], order: tuple[str, ...], nodes: list[str], tracks: list[str]) -> bool:
    """Whether points of that shape may have their axes in that order."""
    size = dict(zip(order, shape, strict=False))
    named = not tracks or size.get("track") == len(tracks)
    return len(shape) == 4 and size["xy"] == 2 and size["node"] == len(nodes) and named


def _of_tracks(points: Array, nodes: list[str], tracks: list[str], mapping: Mapping, name: str) -> Markers:
    """The chosen track of points (n, n_track, n_node, 2 or 3); the third is a score."""
    visible = visible_instances(points)
    names = tracks or [f"track {k}" for k in range(points.shape[1])]
    if not visible.any():
        raise UserError(Problem("contains no visible point", name))
    met = bool((visible.sum(axis=1) > 1).any())
    chosen = points[:, chosen_track(names, np.flatnonzero(visible.any(axis=0)).tolist(), mapping, name, met=met)]
    return tracked_markers(chosen, 0, nodes, [], mapping, name)


@loader("sleap", "SLEAP .slp", is_slp, "points", keys=frozenset({"individual", "likelihood"}),
        needs=("sleap_io", "sleap"))  # fmt: skip
def read_slp(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one track; the file has no clock."""
    content = read_in_child(_SLP, path, name, "SLEAP")
    if content["videos"] > 1:
        text = f"contains {int(content['videos'])} videos; save each separately: sio split or labels.extract"
        raise UserError(Problem(text, name))
    found = Instances(content["frames"], content["track"], content["by_hand"], content["points"])
    nodes, tracks = ([str(each) for each in content[key]] for key in ("nodes", "tracks"))
    return markers_of_instances(found, nodes, tracks, mapping, name)

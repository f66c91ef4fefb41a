"""SLEAP: predictions as ``.slp`` (read by ``sleap-io``) and the analysis HDF5 that it exports (read by ``h5py``).

Both are HDF5. x and y are pixels from the picture's upper left corner, y downward (Pereira et al., *Nature Methods* 19
(2022) 486). Frames without an instance are missing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.files.validate import near
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Markers, name_list
from synth.motion.importers.likelihood import without_unlikely
from synth.motion.importers.registry import HDF5, hdf5_names, loader

_ANALYSIS = """
import h5py
with h5py.File(path, "r") as file:
    texts = lambda name: numpy.array([bytes(item).decode() for item in held(file[name])[...].ravel()], dtype=str)
    arrays = {"points": numpy.asarray(held(file["tracks"]), dtype=float), "nodes": texts("node_names"),
              "tracks": texts("track_names") if "track_names" in file else numpy.array([], dtype=str)}
    if "point_scores" in file:
        arrays["scores"] = numpy.asarray(held(file["point_scores"]), dtype=float)
"""
_SLP = """
import sleap_io
labels = sleap_io.load_slp(path, open_videos=False)
video = labels.videos[0]
points = labels.numpy(video=video, return_confidence=True)
arrays = {"points": numpy.asarray(points, dtype=float), "videos": float(len(labels.videos)),
          "nodes": numpy.array([node.name for node in labels.skeletons[0].nodes], dtype=str),
          "tracks": numpy.array([track.name for track in labels.tracks], dtype=str)}
"""


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
    points, nodes = content["points"], [str(node) for node in content["nodes"]]
    if points.ndim == 4 and points.shape[1] == 2:  # as SLEAP writes it for MATLAB: tracks, 2, nodes, frames
        points = points.transpose(3, 0, 2, 1)
    if points.ndim != 4 or points.shape[2] != len(nodes) or points.shape[3] != 2:
        raise UserError(Problem(f"has points of shape {points.shape} for {len(nodes)} nodes", name))
    scores = content.get("scores")
    if scores is not None and scores.shape == (points.shape[1], points.shape[2], points.shape[0]):
        points = np.concatenate([points, scores.transpose(2, 0, 1)[..., None]], axis=3)
    return _markers(points, nodes, [str(track) for track in content["tracks"]], mapping, name)


@loader("sleap", "SLEAP .slp", is_slp, "points", keys=frozenset({"individual", "likelihood"}),
        needs=("sleap_io", "sleap"))  # fmt: skip
def read_slp(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one track of the first video; the file has no clock."""
    content = read_in_child(_SLP, path, name, "SLEAP")
    if content["videos"] > 1:
        text = f"contains {int(content['videos'])} videos; save each separately: sio split or labels.extract"
        raise UserError(Problem(text, name))
    nodes = [str(node) for node in content["nodes"]]
    return _markers(content["points"], nodes, [str(track) for track in content["tracks"]], mapping, name)


def _markers(points: Any, nodes: list[str], tracks: list[str], mapping: Mapping, name: str) -> Markers:
    """Points (n, n_track, n_node, 2 or 3) of the chosen track; the third is a confidence."""
    seen = [k for k in range(points.shape[1]) if np.isfinite(points[:, k]).any()]
    names = [tracks[k] if k < len(tracks) else f"track {k}" for k in range(points.shape[1])]
    wanted = mapping.individual
    if wanted is not None and wanted not in names:
        raise UserError(Problem(f'there is no track "{wanted}"{near(wanted, names)}', name))
    if wanted is None and len(seen) > 1:
        text = f"contains {len(seen)} tracks; choose one: individual: {names[seen[0]]}, or one of "
        raise UserError(Problem(f"{text}{name_list(names[k] for k in seen[1:])}", name))
    if not seen and wanted is None:
        raise UserError(Problem("contains no visible point", name))
    chosen = points[:, names.index(wanted) if wanted is not None else seen[0]]
    positions = chosen[..., :2].copy()
    scores = chosen[..., 2] if chosen.shape[-1] == 3 else None
    notes = without_unlikely(positions, scores, mapping.likelihood, "score", name)
    positions[..., 1] *= -1.0  # pixels count downward
    frames = np.arange(len(positions), dtype=float)
    return Markers(name, tuple(nodes), positions, frames, None, "pixel", notes)

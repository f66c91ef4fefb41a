"""SLEAP: predictions as ``.slp`` (read by ``sleap-io``) and the analysis HDF5 that it exports (read by ``h5py``).

Both are HDF5. x and y are pixels from the picture's upper left corner, y downward (Pereira et al., *Nature Methods* 19
(2022) 486). Frames without an instance are missing.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import Problem, UserError
from synth.files.csv_table import ROW_LIMIT
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
    visible = _visible(points)
    names = tracks or [f"track {k}" for k in range(points.shape[1])]
    if not visible.any():
        raise UserError(Problem("contains no visible point", name))
    met = bool((visible.sum(axis=1) > 1).any())
    chosen = points[:, _chosen_track(names, np.flatnonzero(visible.any(axis=0)).tolist(), mapping, name, met=met)]
    return _markers(chosen, 0, nodes, [], mapping, name)


@dataclass(frozen=True, eq=False)
class _Instances:
    """Animals of single frames: ``frame`` (m,), ``track`` (m,) index, -1 without one, ``by_hand`` (m,) placed by a
    person, ``points`` (m, n_node, 3) x, y, score.
    """

    frame: Array
    track: Array
    by_hand: Mask
    points: Array

    def several(self, which: Mask) -> int:
        """The number of frames in which more than one of the instances ``which`` (m,) is."""
        return int((np.unique(self.frame[which], return_counts=True)[1] > 1).sum())


@loader("sleap", "SLEAP .slp", is_slp, "points", keys=frozenset({"individual", "likelihood"}),
        needs=("sleap_io", "sleap"))  # fmt: skip
def read_slp(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one track; the file has no clock."""
    content = read_in_child(_SLP, path, name, "SLEAP")
    if content["videos"] > 1:
        text = f"contains {int(content['videos'])} videos; save each separately: sio split or labels.extract"
        raise UserError(Problem(text, name))
    found = _Instances(content["frames"], content["track"], content["by_hand"], content["points"])
    visible = _visible(found.points)
    if not visible.any():
        raise UserError(Problem("contains no visible point", name))
    notes: list[str] = []
    if (found.track[visible] >= 0).any():
        chosen = _instances_of_track(found, visible, [str(track) for track in content["tracks"]], mapping, notes, name)
    else:
        chosen = _instances_without_track(found, visible, mapping, notes, name)
    first, last = min(0, int(found.frame.min())), int(found.frame.max())
    if last - first >= ROW_LIMIT:
        text = f"is too large: it has a frame {last}, and at most {ROW_LIMIT} rows are read; export the recording alone"
        raise UserError(Problem(text, name))
    points = np.full((last - first + 1, *found.points.shape[1:]), np.nan)
    points[found.frame[chosen] - first] = found.points[chosen]
    return _markers(points, first, [str(node) for node in content["nodes"]], notes, mapping, name)


def _instances_of_track(
    found: _Instances, visible: Mask, names: list[str], mapping: Mapping, notes: list[str], name: str
) -> Mask:
    """(m,) the instances of the chosen track; those without a track too, if no other animal can be meant."""
    seen = np.unique(found.track[visible & (found.track >= 0)]).tolist()
    tracked, loose = visible & (found.track >= 0), visible & (found.track < 0)
    index = _chosen_track(names, seen, mapping, name, met=found.several(tracked) > 0)
    if not loose.any():
        return np.asarray(found.track == index)
    if len(seen) > 1 or found.several(visible):
        notes.append(f"{int(loose.sum())} instances without a track are left out")
        return np.asarray(found.track == index)
    notes.append(f"{int(loose.sum())} instances have no track; each is alone in its frame and taken as {names[index]}")
    return np.asarray((found.track == index) | loose)


def _instances_without_track(found: _Instances, visible: Mask, mapping: Mapping, notes: list[str], name: str) -> Mask:
    """(m,) the instances of the only animal of a file without tracks."""
    if mapping.individual is not None:
        raise UserError(Problem("no instance has a track; leave it out", name, key="individual"))
    # What a person has placed replaces the prediction.
    kept = visible & (found.by_hand | ~np.isin(found.frame, found.frame[visible & found.by_hand]))
    least = mapping.likelihood
    if found.several(kept) and least is not None:
        likely = kept & (found.points[..., 2] >= least).any(axis=1)
        notes.append(f"{int((kept & ~likely).sum())} instances without a point of a score of {least:g} are left out")
        kept = likely
    if found.several(kept):
        text = f"has no tracks, and {found.several(kept)} of its {len(np.unique(found.frame[kept]))} frames have "
        text += "several instances: which is the animal's is not known. Delete the others in SLEAP, or track them there"
        text += "" if least is not None else "; a bound, likelihood: 0.6, leaves out those without a point above it"
        raise UserError(Problem(text, name))
    return kept


def _visible(points: Array) -> Mask:
    """(...) whether a point of points (..., n_node, 2 or 3) has both coordinates."""
    known = np.isfinite(points)
    return np.asarray((known[..., 0] & known[..., 1]).any(axis=-1))


def _chosen_track(names: list[str], seen: list[int], mapping: Mapping, name: str, *, met: bool) -> int:
    """The index of the track that is asked for, or of the only one; ``met`` : a frame has several."""
    wanted, known = mapping.individual, [names[k] for k in seen]
    if wanted is not None and wanted not in known:
        what = f'the track "{wanted}" has no visible point' if wanted in names else f'there is no track "{wanted}"'
        raise UserError(Problem(f"{what}{near(wanted, known)}", name))
    if wanted is None and len(seen) > 1:
        text = f"contains {len(seen)} tracks; choose one: individual: {known[0]}, or one of {name_list(known[1:])}"
        text += "" if met else ". No frame has two of them: if they are one animal, join them in SLEAP"
        raise UserError(Problem(text, name))
    return seen[0] if wanted is None else seen[known.index(wanted)]


def _markers(points: Array, first: int, nodes: list[str], notes: list[str], mapping: Mapping, name: str) -> Markers:
    """Points (n, n_node, 2 or 3) from the frame ``first`` on; the third is a score."""
    positions = points[..., :2].copy()
    scores = points[..., 2] if points.shape[-1] == 3 else None
    notes = [*notes, *without_unlikely(positions, scores, mapping.likelihood, "score", name)]
    positions[..., 1] *= -1.0  # pixels count downward
    frames = np.arange(first, first + len(positions), dtype=float)
    return Markers(name, tuple(nodes), positions, frames, None, "pixel", tuple(notes))

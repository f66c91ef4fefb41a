"""The animals that SLEAP found, a frame each, and the choice of one: shared by its project file and its CSV."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import Problem, UserError
from synth.files.csv_table import ROW_LIMIT
from synth.files.import_mapping import Mapping
from synth.files.validate import near
from synth.motion.importers.foreign_data import Markers, name_list
from synth.motion.importers.likelihood import without_unlikely


@dataclass(frozen=True, eq=False)
class Instances:
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


def markers_of_instances(found: Instances, nodes: list[str], tracks: list[str], mapping: Mapping, name: str) -> Markers:
    """Points of one animal, from the frame 0 on; a frame without it is missing.

    Raises
    ------
    UserError : no visible point, several animals without a choice, or more frames than are read.
    """
    visible = visible_instances(found.points)
    if not visible.any():
        raise UserError(Problem("contains no visible point", name))
    notes: list[str] = []
    if (found.track[visible] >= 0).any():
        chosen = _instances_of_track(found, visible, tracks, mapping, notes, name)
    else:
        chosen = _instances_without_track(found, visible, mapping, notes, name)
    first, last = min(0, int(found.frame.min())), int(found.frame.max())
    if last - first >= ROW_LIMIT:
        text = f"is too large: it has a frame {last}, and at most {ROW_LIMIT} rows are read; export the recording alone"
        raise UserError(Problem(text, name))
    points = np.full((last - first + 1, *found.points.shape[1:]), np.nan)
    points[found.frame[chosen] - first] = found.points[chosen]
    return tracked_markers(points, first, nodes, notes, mapping, name)


def _instances_of_track(
    found: Instances, visible: Mask, names: list[str], mapping: Mapping, notes: list[str], name: str
) -> Mask:
    """(m,) the instances of the chosen track; those without a track too, if no other animal can be meant."""
    seen = np.unique(found.track[visible & (found.track >= 0)]).tolist()
    tracked, loose = visible & (found.track >= 0), visible & (found.track < 0)
    index = chosen_track(names, seen, mapping, name, met=found.several(tracked) > 0)
    if not loose.any():
        return np.asarray(found.track == index)
    if len(seen) > 1 or found.several(visible):
        notes.append(f"{int(loose.sum())} instances without a track are left out")
        return np.asarray(found.track == index)
    notes.append(f"{int(loose.sum())} instances have no track; each is alone in its frame and taken as {names[index]}")
    return np.asarray((found.track == index) | loose)


def _instances_without_track(found: Instances, visible: Mask, mapping: Mapping, notes: list[str], name: str) -> Mask:
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


def visible_instances(points: Array) -> Mask:
    """(...) whether a point of points (..., n_node, 2 or 3) has both coordinates."""
    known = np.isfinite(points)
    return np.asarray((known[..., 0] & known[..., 1]).any(axis=-1))


def chosen_track(names: list[str], seen: list[int], mapping: Mapping, name: str, *, met: bool) -> int:
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


def tracked_markers(
    points: Array, first: int, nodes: list[str], notes: list[str], mapping: Mapping, name: str
) -> Markers:
    """Points (n, n_node, 2 or 3) from the frame ``first`` on; the third is a score."""
    positions = points[..., :2].copy()
    scores = points[..., 2] if points.shape[-1] == 3 else None
    notes = [*notes, *without_unlikely(positions, scores, mapping.likelihood, "score", name)]
    positions[..., 1] *= -1.0  # pixels count downward
    frames = np.arange(first, first + len(positions), dtype=float)
    return Markers(name, tuple(nodes), positions, frames, None, "pixel", tuple(notes))

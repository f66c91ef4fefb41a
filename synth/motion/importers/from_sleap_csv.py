"""SLEAP: its analysis CSV, a row an animal of a frame, as SLEAP and ``sleap-io`` export it.

Columns ``track``, ``frame_idx``, ``instance.score`` and of each point ``NAME.x``, ``NAME.y``, ``NAME.score``; pixels
from the picture's upper left corner, y downward. An empty ``instance.score`` tells of an animal that a person placed
(sleap-io documentation, *CSV Format*).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.marker_tables import Line, column_numbers, require_points, table_lines, table_text
from synth.motion.importers.registry import loader, text_start
from synth.motion.importers.sleap_instances import Instances, markers_of_instances

TRACK, FRAME, SCORE = "track", "frame_idx", "instance.score"


def is_sleap_csv(start: bytes, path: Path) -> bool:
    """Whether the first line has the columns of an animal."""
    return {TRACK, FRAME, SCORE} <= {cell.strip() for cell in text_start(start).partition("\n")[0].split(",")}


@loader("sleap-csv", "SLEAP analysis CSV", is_sleap_csv, "points", keys=frozenset({"individual", "likelihood"}))
def read_sleap_csv(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one track; the file has no clock.

    Raises
    ------
    UserError : no points, a cell that is no number, a frame without a number or with a track twice, or several animals
        without a choice.
    """
    (_, titles), *rows = [each for each in table_lines(table_text(path), name, ",") if any(each[1])]
    nodes = [title.removesuffix(".x") for title in titles if title.endswith(".x")]
    require_points([node for node in nodes if f"{node}.y" in titles], "no columns NAME.x and NAME.y", name)
    missing = [f"{node}.{axis}" for node in nodes for axis in ("y", "score") if f"{node}.{axis}" not in titles]
    if missing:
        raise UserError(Problem(f'has no column "{missing[0]}"; export it again', name, 1))
    if not rows:
        raise UserError(Problem("has no rows below its header", name))
    columns = [titles.index(f"{node}.{part}") for node in nodes for part in ("x", "y", "score")]
    points = column_numbers(rows, columns, ",", name).reshape(len(rows), len(nodes), 3)
    frame, score = column_numbers(rows, [titles.index(FRAME), titles.index(SCORE)], ",", name).T
    wrong = ~(np.isfinite(frame) & (frame == np.round(frame)) & (frame >= 0.0))
    if wrong.any():
        raise UserError(Problem("has no whole number of its frame", name, rows[int(np.argmax(wrong))][0], FRAME))
    by_hand = np.isnan(score)
    points[by_hand, :, 2] = 1.0  # as SLEAP's project file has them
    at = titles.index(TRACK)
    named = [row[at] if at < len(row) else "" for _, row in rows]
    tracks = list(dict.fromkeys(track for track in named if track))
    track = np.array([tracks.index(each) if each else -1 for each in named])
    kept = _placed_again(frame, track, by_hand)
    _refuse_two(frame[kept], track[kept], tracks, [row for row, keep in zip(rows, kept, strict=True) if keep], name)
    found = Instances(frame[kept].astype(int), track[kept], by_hand[kept], points[kept])
    return markers_of_instances(found, nodes, tracks, mapping, name)


def _placed_again(frame: Array, track: Array, by_hand: Mask) -> Mask:
    """(m,) False for a prediction of a frame and track that a person placed too."""
    placed = {(f, k) for f, k, hand in zip(frame.tolist(), track.tolist(), by_hand.tolist(), strict=True) if hand}
    return np.array(
        [
            hand or k < 0 or (f, k) not in placed
            for f, k, hand in zip(frame.tolist(), track.tolist(), by_hand.tolist(), strict=True)
        ]
    )


def _refuse_two(frame: Array, track: Array, tracks: list[str], rows: list[Line], name: str) -> None:
    """Refuse two rows (m,) of one track in one frame: which of them is the animal is not known."""
    seen: set[tuple[float, int]] = set()
    for f, k, (line, _) in zip(frame.tolist(), track.tolist(), rows, strict=True):
        if k >= 0 and (f, k) in seen:
            text = f'has the track "{tracks[k]}" twice in frame {f:g}; delete one in SLEAP, or export one video a file'
            raise UserError(Problem(text, name, line))
        seen.add((f, k))

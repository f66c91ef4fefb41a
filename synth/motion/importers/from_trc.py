"""TRC: points in space as text, written by Motion Analysis' systems, OpenSim and Pose2Sim.

Three lines of header (``PathFileType``, names of settings, settings), two of labels (markers, X1 Y1 Z1 ...), then a row
a frame: number, time, coordinates (OpenSim documentation, *Marker (.trc) Files*). OpenSim's y is up, and its clock is
the column ``Time``; ``DataRate`` in the header must agree with it.
"""

from __future__ import annotations

from math import ceil
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.log_clock import exact_number
from synth.files.paths import read_bytes
from synth.motion.importers.foreign_data import Markers, cut_off, states_otherwise
from synth.motion.importers.marker_tables import SAME_RATE
from synth.motion.importers.registry import loader, text_start

SIZE_LIMIT = 400_000_000  # bytes; the whole file is read into memory
UP = "y"
MOST_DIGITS = 100  # of a time before or after its point; beyond 308 a double has none


def is_trc(start: bytes, path: Path) -> bool:
    """Whether the first line is TRC's."""
    return text_start(start).startswith("PathFileType")


@loader("trc", "TRC", is_trc, "points", space=True)
def read_trc(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own clock.

    Raises
    ------
    UserError : an invalid header, another number of markers or frames, a cell that is no number, or clocks that differ.
    """
    lines = text_start(read_bytes(path, SIZE_LIMIT, "cut it in the capture software")).splitlines()
    if len(lines) < 7:
        raise UserError(Problem("ends within its header", name, len(lines)))
    settings = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=False))
    rate, count = _number(settings.get("DataRate"), "DataRate", name), settings.get("NumMarkers", "").strip()
    labels = [cell.strip() for cell in lines[3].rstrip("\r\n\t ").split("\t")]
    names = [label for label in labels[2:] if label]
    if labels[:1] != ["Frame#"] or not names:
        raise UserError(Problem('has no row of markers that begins with "Frame#"', name, 4))
    if states_otherwise(count, len(names)):
        raise UserError(Problem(f"states {count} markers but names {len(names)}", name, 4))
    rows: list[list[str]] = []
    numbers = []
    for number, line in enumerate(lines[5:], start=6):
        if not line.strip():
            continue
        cells = line.rstrip("\r\n").split("\t")
        rows.append((cells + [""] * (2 + 3 * len(names)))[: 2 + 3 * len(names)])
        numbers.append(number)
    values = np.full((len(rows), 2 + 3 * len(names)), np.nan)
    for k, row in enumerate(rows):
        for c, cell in enumerate(row):
            if cell.strip():
                try:
                    values[k, c] = float(cell)
                except ValueError:
                    raise UserError(Problem(f'"{cell[:40]}" is not a number', name, numbers[k])) from None
    if states_otherwise(stated := settings.get("NumFrames", "").strip(), len(values)):
        raise UserError(cut_off(stated, len(values), "frames", name))
    if len(values) < 2 or not np.isfinite(values[:, 0]).all() or (np.diff(values[:, 0]) <= 0).any():
        raise UserError(Problem("has frames without a number, or not in order", name))
    positions = values[:, 2:].reshape(len(values), len(names), 3).copy()
    unit = settings.get("Units", "").strip()
    time, rate, notes = _clock(values[:, 1], _resolution(rows), values[:, 0], rate, mapping.frame_rate, name)
    return Markers(name, tuple(names), positions, values[:, 0], rate, unit, notes, up=UP, time=time)


def _resolution(rows: list[list[str]]) -> float:
    """The last digit of the times as written, s."""
    times = [number for row in rows if (number := exact_number(row[1])) is not None and number.is_finite()]
    powers = [power for number in times if isinstance(power := number.as_tuple().exponent, int)]
    return float(10.0 ** np.clip(min(powers, default=0), -MOST_DIGITS, MOST_DIGITS))


def _clock(
    time: Array, resolution: float, frames: Array, rate: float, stated: float | None, name: str
) -> tuple[Array | None, float, tuple[str, ...]]:
    """The clock (n,) s, None if it is frames over rate; that rate, Hz; notes.

    Parameters
    ----------
    time, frames : (n,) the columns; ``resolution`` s, of the times as written.
    rate, stated : Hz, of the header and of the project.
    """
    if np.isnan(time).all():
        return None, rate, (f"its column Time is empty: the clock is Frame# over the DataRate of {rate:g} Hz",)
    if not np.isfinite(time).all() or (np.diff(time) <= 0).any():
        if stated is not None:
            return None, rate, ("its column Time does not increase: the clock is Frame# over the frame rate given",)
        text = "has empty or repeated times, or times that run backwards, in its column Time; correct them, or state "
        raise UserError(Problem(f"{text}the frame rate, frame_rate: {rate:g} Hz (--frame-rate '{rate:g} Hz')", name))
    by_row, by_frame = (_pace(time, count, resolution, rate) for count in (np.arange(float(len(time))), frames))
    if _same_rate(by_frame, rate):
        even = time[0] + (frames - frames[0]) / rate
        return (even if (np.abs(even - time) <= resolution).all() else time), rate, ()  # the same, but for rounding
    if _same_rate(by_row, rate):
        step = float(np.median(np.diff(frames)))
        return (
            time,
            rate,
            (f"Frame# counts {step:g} a row; Time and DataRate agree on {rate:g} Hz a row: Time is used",),
        )
    if stated is not None and _same_rate(by_row, stated):
        return time, stated, (f"the header's DataRate of {rate:g} Hz is wrong; its column Time is used",)
    if stated is not None and _same_rate(rate, stated):
        return None, rate, (f"its column Time runs at {by_row:.5g} Hz; the clock is Frame# over the {rate:g} Hz given",)
    text = f"has two clocks: the column Time has {by_row:.5g} rows a second, and the header says DataRate {rate:g}; "
    text += "state the right one, for example frame_rate: "
    raise UserError(Problem(f"{text}{by_row:.5g} Hz (--frame-rate '{by_row:.5g} Hz')", name))


def _pace(time: Array, count: Array, resolution: float, rate: float) -> float:
    """The usual counts a second, over so many rows that the rounding of the times does not matter; Hz."""
    rows = min(len(time) - 1, max(1, ceil(2.0 * resolution * rate / SAME_RATE)))
    return float(np.median((count[rows:] - count[:-rows]) / (time[rows:] - time[:-rows])))


def _same_rate(one: float, other: float) -> bool:
    return abs(one / other - 1.0) < SAME_RATE


def _number(text: str | None, what: str, name: str) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e6:
        raise UserError(Problem(f'states no {what} above 0 in its third line: "{text}"', name, 3))
    return value

"""The clock of a file of channels: a column of times, its frames' numbers over the frame rate, or its rows over it.

A frame rate never replaces times that the file itself has: both must agree, as in files of points.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.log_clock import LogClock, log_clock
from synth.files.recordings_together import ANOTHER_UNIT, clock_fault, fitting_unit
from synth.motion.importers.foreign_data import Channels, ColumnProblem, name_list, same_name
from synth.motion.importers.repeated_rows import repeated_rows
from synth.units import factor

CLOCKS = ("time", "t", "timestamp")
FRAMES = ("frame", "frames", "frame#", "frame number", "frame no", "frame no.", "frame nr", "frame index", "frame id",
          "fnum")  # fmt: skip
SAME_RATE = 5e-3  # relative, as of a TRC's two clocks
WINDOW = 100  # rows over which a pace is taken: times rounded to a quarter of a step are within SAME_RATE / 2
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # s, of a clock's column without a unit


def channel_clock(source: Channels, mapping: Mapping, notes: list[str]) -> LogClock:
    """The clock of a file of channels; ``notes`` are added to.

    Raises
    ------
    UserError : no column, or several, can be the clock, one contradicts the frame rate, or frames do not count up.
    """
    if source.time is not None:
        return LogClock(source.time, source.begins) if source.begins else log_clock(source.time, 1.0)
    if mapping.time is not None:
        return _of_column(source, source.find(mapping.time, "time"), mapping.time_unit)
    found = [k for k, name in enumerate(source.names) if any(same_name(name, clock) for clock in CLOCKS)]
    if mapping.frame_rate is None:
        if len(found) != 1:
            text = "say which column is the clock, time: {column: NAME, unit: s}, or the rate, frame_rate: 250 Hz"
            raise UserError(
                ColumnProblem(f"{text}; the file has {source.contents or name_list(source.names)}", source.name)
            )
        return _of_column(source, found[0], None)
    told = [k for k in found if not source.units[k] or _is_time(source.units[k])]
    counting = [k for k in told if _increases(source.values[:, k])]
    if counting:
        return _clock_by_rate(source, counting, mapping.frame_rate, notes)
    notes += [f"its column {source.names[k]} does not increase: it is not the clock" for k in told]
    return _of_frames(source, mapping.frame_rate, notes)


def _of_column(source: Channels, index: int, stated: str | None) -> LogClock:
    unit = source.unit(index, stated, "time", "s")
    clock = _clock_of_column(source, index, factor(unit, "s"))
    if np.isfinite(clock.time).all() and (np.diff(clock.time) <= 0.0).any():
        _refuse_other_rows(source, clock)
    fault = clock_fault(clock.time) if _increases(clock.time) else ""  # any other clock is refused for that
    if fault:
        place = "Then say so in the header" if source.units[index] else "Then state that one"
        text = f"{fault}. {ANOTHER_UNIT} {place}{fitting_unit(clock.time, unit)}"
        raise UserError(Problem(text, source.name, key=f"{source.names[index]} [{unit}]"))
    return clock


def _refuse_other_rows(source: Channels, clock: LogClock) -> None:
    """Refuse a row whose time is not above that of the row before, unless it is that row again; with what to do."""
    step = np.diff(clock.time)
    wrong = (step <= 0.0) & ~repeated_rows(clock.time, source.values)[1:]
    if not wrong.any():
        return
    row = int(np.argmax(wrong))
    then = f"at sample {row + 2}: {clock.time[row]:g} s, then {clock.time[row + 1]:g} s"
    if step[row] < 0.0:
        text = f"time runs backwards {then}; if two recordings follow one another, put each in a file of its own"
        raise UserError(Problem(text, source.name))
    text = f"time repeats {then}; if the times are rounded and the samples even, state their rate in a project or with "
    raise UserError(Problem(f"{text}--frame-rate, such as 250 Hz; else correct one of the two", source.name))


def _clock_of_column(source: Channels, index: int, scale: float) -> LogClock:
    numbers = source.numbers
    if len(source.values) and not np.isfinite(source.values[:, index]).any():
        text = f'its column "{source.names[index]}" is no clock: write numbers with a unit, dates with times '
        raise UserError(Problem(f"{text}(2024-03-05 11:59:59.5) or times of day (11:59:59.5)", source.name))
    return log_clock(source.values[:, index], scale, None if numbers is None else lambda: numbers(index))


def _is_time(unit: str) -> bool:
    try:
        factor(unit, "s")
    except UserError:
        return False
    return True


def _increases(values: Array) -> bool:
    return bool(len(values) > 1 and np.isfinite(values).all() and (np.diff(values) > 0).all())


def _clock_by_rate(source: Channels, columns: list[int], rate: float, notes: list[str]) -> LogClock:
    """The column of times that agrees with the frame rate, Hz; one without a unit has that in which it does."""
    for k in columns:
        unit = source.units[k]
        scales = {unit: factor(unit, "s")} if unit else UNITS | {"samples": 1.0 / rate}
        for name, scale in scales.items():
            if any(abs(rate * scale * step - 1.0) < SAME_RATE for step in _steps(source.values[:, k])):
                if not unit:
                    notes.append(f"the clock is the column {source.names[k]}, in {name}, as the frame rate tells")
                return _clock_of_column(source, k, scale)
    title, unit, step = source.names[columns[0]], source.units[columns[0]], _steps(source.values[:, columns[0]])[0]
    if unit:
        text = f'its column "{title}" has {1.0 / (step * factor(unit, "s")):.5g} rows a second, and {rate:g} Hz is '
        text += "stated; leave that out, or remove the column if it does not tell when the samples were taken"
    else:
        text = f'its column "{title}", without a unit, steps by {step:.5g}, which is {rate:g} Hz in none of '
        text += f"{', '.join(UNITS)}; state its unit in the place of the rate: time: {{column: {title}, unit: s}}"
    raise UserError(Problem(text, source.name, key="frame_rate"))


def _steps(time: Array) -> tuple[float, float]:
    """The usual step, and the usual one over many rows, where rounding of the times does not matter."""
    rows = min(WINDOW, len(time) - 1)
    return float(np.median(np.diff(time))), float(np.median(time[rows:] - time[:-rows])) / rows


def _of_frames(source: Channels, rate: float, notes: list[str]) -> LogClock:
    """The frames' own numbers over the rate, Hz, so that lost ones leave a gap; without such a column the rows."""
    known = [bool(np.isfinite(column).any()) for column in source.values.T]
    found = [k for k, name in enumerate(source.names)
             if known[k] and not source.units[k] and any(same_name(name, each) for each in FRAMES)]  # fmt: skip
    if not found:
        return LogClock(np.arange(len(source.values)) / rate)
    title, frames = source.names[found[0]], source.values[:, found[0]]
    if len(found) > 1:
        text = f"has several columns of frames: {name_list(source.names[k] for k in found)}; keep one"
        raise UserError(Problem(text, source.name))
    step = np.diff(frames, prepend=frames[0] - 1.0)
    wrong = ~(np.isfinite(frames) & (frames == np.round(frames)) & (step > 0))
    if wrong.any():
        row = int(np.argmax(wrong))
        text = f'its column "{title}" does not count the frames: sample {row + 1} has {frames[row]:g}'
        text += f" after {frames[row - 1]:g}" if row else ""
        raise UserError(Problem(f"{text}; correct it, or remove the column", source.name))
    notes.append(f"the clock is the column {title} over {rate:g} Hz")
    return log_clock(frames / rate, 1.0)

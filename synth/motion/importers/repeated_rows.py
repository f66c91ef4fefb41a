"""Rows of a log that are no samples: there twice, as a logger writes whose loop ran ahead, or without any number."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synth.arrays import Array, Mask
from synth.files.log_clock import LogClock
from synth.motion.importers.foreign_data import Channels

HOLE = 1.5  # usual steps; a longer one after a repeated time tells that the clock stood still, and a sample was taken


def repeated_rows(time: Array, values: Array) -> Mask:
    """(n,) True where a row has the time and all values of the row before, and no sample is missing after it.

    Parameters
    ----------
    time : (n,) s; values : (n, n_channel), nan where missing.
    """
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    again = np.concatenate([[False], (np.diff(time) == 0.0) & same.all(axis=1)])
    if not again.any():
        return again
    kept = np.flatnonzero(~again)
    step = np.diff(time[kept])
    usual = float(np.median(step[step > 0.0])) if (step > 0.0).any() else 0.0
    held = np.append(step, 0.0) > HOLE * usual  # of each row kept
    again &= ~held[np.searchsorted(kept, np.arange(len(time)), side="right") - 1]
    return again


def without_repeated_rows(source: Channels, clock: LogClock, notes: list[str]) -> tuple[Channels, LogClock]:
    """The file and its clock without ``repeated_rows``; a note tells how many went."""
    again = repeated_rows(clock.time, source.values)
    if not again.any():
        return source, clock
    first = float(clock.time[int(np.argmax(again))])
    many = f"{int(again.sum())} rows repeat the time and all values of the row before, the first"
    what = "1 row repeats the time and all values of the row before," if again.sum() == 1 else many
    notes.append(f"{what} at {first:.3f} s: left out")
    return _only(~again, source, clock)


def without_empty_rows(source: Channels, clock: LogClock, notes: list[str]) -> tuple[Channels, LogClock]:
    """The file and its clock without rows that have neither a time nor a number; a note tells how many went.

    pandas writes such rows where tables were joined. A row that has a time is a missing sample, and stays.
    """
    empty = ~np.isfinite(clock.time) & ~np.isfinite(source.values).any(axis=1)
    if not empty.any():
        return source, clock
    count = int(empty.sum())
    what = "1 row has" if count == 1 else f"{count} rows have"
    notes.append(f"{what} neither a time nor a number: left out")
    return _only(~empty, source, clock)


def _only(kept: Mask, source: Channels, clock: LogClock) -> tuple[Channels, LogClock]:
    """The rows (n,) that are True."""
    own = None if source.time is None else source.time[kept]
    return replace(source, values=source.values[kept], time=own), replace(clock, time=clock.time[kept])

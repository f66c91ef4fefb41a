"""What ``synth.compare`` takes besides paths: results, legs and recordings that are in memory.

A result is compared by the files that it would write: the numbers are those of its saved folder.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from synth.api.report import IN_CODE, Report
from synth.comparison.side_source import VIEWS, Source, read_source
from synth.errors import UserError
from synth.files.leg_file import write_leg
from synth.files.leg_in_code import check_leg
from synth.files.made_in_code import in_code
from synth.files.names import NAME_LENGTH, name_fault, written_name
from synth.files.trial_list import Trial
from synth.swing.leg_model import Leg

Comparable = str | Path | Report | Leg | Trial | Sequence[Trial]
ALLOWED = (
    "compare takes a Fit, a Gap or a Design, a Leg, Trials, and paths of their folders, of projects, leg files and "
    'recordings, each alone or with a name: {"new": fit}'
)


def sources_of(given: Sequence[Comparable | Mapping[str, Comparable]], folder: Path) -> list[Source]:
    """The sources in order; objects are written into ``folder``, which must last until they are opened.

    Raises
    ------
    UserError
        If something cannot be compared, or two sides have one name.
    """
    named: list[tuple[str, object]] = []
    for item in given:
        named += item.items() if isinstance(item, Mapping) else [("", item)]
    found = [_source(label, item, folder / str(number)) for number, (label, item) in enumerate(named)]
    sides = [source.named(view) for source in found for view in source.views]
    for source in found:
        twice = [name for name in map(source.named, source.views) if sides.count(name) > 1]
        if twice and source.in_code:
            raise UserError(f'two sides are called "{twice[0]}"; name them: synth.compare({{"new": ..., "old": ...}})')
    return found


def _source(label: str, given: object, folder: Path) -> Source:
    """One source; its files go to ``folder``."""
    if label and (fault := name_fault(label)) is not None:
        raise UserError(f'the name "{label}" of a side {fault}')
    if isinstance(given, (str, Path)):
        found = read_source(str(given))
        return replace(found, label=label) if label else found
    if isinstance(given, (Trial, Iterable)):
        trials = (given,) if isinstance(given, Trial) else tuple(given)
        if not trials or not all(isinstance(trial, Trial) for trial in trials):
            raise UserError(f"{given!r:.80} are no recordings that were read; {ALLOWED}")
        return Source(label or "recorded", folder, "trials", VIEWS["trials"], f"{len(trials)} recordings", True, trials)
    kind, title = _write_object(given, folder)
    name = label or written_name(title)[:NAME_LENGTH].strip(" .-") or kind
    return Source(name, folder if kind != "leg" else folder / "leg.yaml", kind, VIEWS[kind], f"{kind} {title}", True)


def _write_object(given: object, folder: Path) -> tuple[str, str]:
    """Kind and title of an object, whose files are written."""
    folder.mkdir(parents=True)
    if isinstance(given, Leg):
        check_leg(given, in_code(IN_CODE))
        write_leg(given, folder / "leg.yaml")
        return "leg", given.name
    found = given.write_compared(folder) if isinstance(given, Report) else None
    if found is None:
        raise UserError(f"{given!r:.80} is of type {type(given).__name__}, which cannot be compared; {ALLOWED}")
    return found

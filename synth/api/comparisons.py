"""``synth.compare``: fits, designs, gaps, legs and recordings side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.api.report import Cell, Panel, Report, Stage, silent
from synth.comparison.compare_sides import Comparison, response_columns, table_columns
from synth.comparison.compare_sides import compare as _compare
from synth.comparison.opened import open_sides
from synth.comparison.side import ComparedMotion, Side
from synth.comparison.side_source import RESULTS, Source, read_source
from synth.files.output import sha256_file
from synth.parts.resolver import resolver
from synth.swing.leg_model import Leg


@dataclass(frozen=True, eq=False)
class Compared(Report):
    """Sides beside each other: ``result`` has all of it, see ``Comparison``."""

    result: Comparison

    @property
    def headline(self) -> str:
        """The sides and which of them the others are held against."""
        names = [side.name for side in self.result.sides]
        return f"{', '.join(names)}: held against {names[self.result.reference]}"

    def columns(self) -> dict[str, list[Cell]]:
        """The table of ``compare.csv``."""
        return {head: list(cells) for head, cells in table_columns(self.result).items()}

    def panels(self) -> Sequence[Panel]:
        """A panel a start: every side's angles."""
        found = []
        for overlay in self.result.overlays:
            columns = {head: np.asarray(cells, float) for head, cells in response_columns(self.result, overlay).items()}
            heads = list(columns)
            time = columns[heads[0]]
            curves = {head.partition(" [")[0]: (time, columns[head]) for head in heads[1:]}
            found.append(Panel(overlay.start.name, heads[0], "angle [deg]", curves))
        return found

    def write(self, folder: Path) -> None:
        """``compare.json``, ``compare.csv``, responses and a report."""
        from synth.files.output import place, stems, write_csv, write_json
        from synth.files.page_outline import outline_json
        from synth.reports.comparison_page import write_comparison_report

        found = self.result
        write_json(folder / "compare.json", found.as_json())
        write_csv(folder / "compare.csv", table_columns(found))
        responses = folder / "responses"
        responses.mkdir()
        for name, overlay in zip(stems([o.start.name for o in found.overlays]), found.overlays, strict=True):
            write_csv(place(responses, f"{name}.csv"), response_columns(found, overlay))
        write_json(folder / "page.json", outline_json(found.leg))
        write_comparison_report(folder)


def open_compared(
    sources: Sequence[Source], *, leg: Leg | None = None, time_scales: Sequence[float] = ()
) -> list[Side]:
    """The sides of what was named; ``leg`` is that of recordings that come without one."""
    return open_sides(list(sources), resolver(), leg=leg, time_scales=tuple(time_scales))


def compare(
    *sources: str | Path,
    reference: str | None = None,
    stretch: Mapping[str, float] | None = None,
    leg: Leg | None = None,
) -> Compared:
    """Put results, projects, legs and recordings beside each other, all moved from the same starts.

    Parameters
    ----------
    sources
        as on the command line: ``PATH``, ``NAME=PATH``, ``PATH#built,wanted``.
    reference
        the side to hold the others against; without it the first recorded one.
    stretch
        side -> factor by which its motion is slowed.
    leg
        of recordings that come without one.

    Raises
    ------
    UserError
        For what cannot be opened or compared.
    """
    named = [read_source(str(source)) for source in sources]
    return compared(open_compared(named, leg=leg), named, reference=reference, stretch=stretch or {})


def compared(
    sides: Sequence[Side],
    sources: Sequence[Source],
    *,
    reference: str | None = None,
    stretch: Mapping[str, float],
    starts: Sequence[ComparedMotion] = (),
    stage: Stage = silent,
) -> Compared:
    """Compare sides that are open; ``starts`` : from which all are moved, without them the first recorded side's."""
    with stage("moving every leg from the same starts"):
        inputs = _inputs(sources)
        found = _compare(list(sides), reference=reference, stretch=dict(stretch), starts=list(starts), inputs=inputs)
    return Compared(found)


def _inputs(sources: Sequence[Source]) -> dict[str, str]:
    """The files that were named, or a result folder's JSON, with their SHA-256."""
    found: dict[str, str] = {}
    for source in sources:
        if source.path.is_file():
            files = [source.path]
        elif source.kind in RESULTS.values():
            files = [source.path / name for name, kind in RESULTS.items() if kind == source.kind]
        else:
            files = sorted(source.path.glob("*.csv"))
        found |= {file.as_posix(): sha256_file(file) for file in files}
    return found

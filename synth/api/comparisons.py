"""``synth.compare``: compare fits, designs, gaps, legs and recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from synth.api.compared_objects import Comparable, sources_of
from synth.api.report import Cell, Panel, Report, Stage, silent
from synth.comparison.compare_sides import Comparison, response_columns, table_columns
from synth.comparison.compare_sides import compare as _compare
from synth.comparison.opened import open_sides
from synth.comparison.side import ComparedMotion, Side
from synth.comparison.side_source import RESULTS, Source
from synth.files.run_manifest import sha256_file
from synth.parts.resolver import resolver
from synth.swing.foreign_effects import own_hashes
from synth.swing.leg_model import Leg


@dataclass(frozen=True, eq=False, repr=False)
class Compared(Report):
    """Compared sides; ``result`` holds everything, see ``Comparison``."""

    result: Comparison

    @property
    def headline(self) -> str:
        """The sides, and the one that the others are compared with."""
        names = [side.name for side in self.result.sides]
        return f"{', '.join(names)}: compared with {names[self.result.reference]}"

    def columns(self) -> dict[str, list[Cell]]:
        """The table of ``compare.csv``."""
        return {head: list(cells) for head, cells in table_columns(self.result).items()}

    def panels(self) -> Sequence[Panel]:
        """One panel per start: the angles of every side."""
        found = []
        for overlay in self.result.overlays:
            columns = {head: np.asarray(cells, float) for head, cells in response_columns(self.result, overlay).items()}
            heads = list(columns)
            time = columns[heads[0]]
            curves = {head.partition(" [")[0]: (time, columns[head]) for head in heads[1:]}
            found.append(Panel(overlay.start.name, f"{self.result.clock} [s]", "angle [deg]", curves))
        return found

    def inputs(self) -> tuple[list[Path], list[str]]:
        """What was compared, by its content."""
        return [], list(self.result.inputs.values())

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
    """The sides of the given sources; ``leg`` belongs to recordings that name none."""
    return open_sides(list(sources), resolver(), leg=leg, time_scales=tuple(time_scales))


def compare(
    *sources: Comparable | Mapping[str, Comparable],
    reference: str | None = None,
    stretch: Mapping[str, float] | None = None,
    leg: Leg | None = None,
) -> Compared:
    """Compare results, projects, legs and recordings, all simulated from the same starts.

    Parameters
    ----------
    sources
        a ``Fit``, ``Gap`` or ``Design``, a ``Leg``, recordings (``Trial``), or as on the command line ``PATH``,
        ``NAME=PATH``, ``PATH#built,wanted``; ``{"new": fit, "old": other}`` names them. A ``Design`` is compared as its
        ``leg``; its saved folder has the friction of the drawn bearings too.
    reference
        the side to compare with; default: the first recorded one.
    stretch
        side -> factor by which its motion is slowed down.
    leg
        for recordings that name none.

    Raises
    ------
    UserError
        If a source cannot be opened or compared.
    """
    with TemporaryDirectory(prefix="synth-compare-") as folder:
        named = sources_of(sources, Path(folder))
        return compare_opened(open_compared(named, leg=leg), named, reference=reference, stretch=stretch or {})


def compare_opened(
    sides: Sequence[Side],
    sources: Sequence[Source],
    *,
    reference: str | None = None,
    stretch: Mapping[str, float],
    starts: Sequence[ComparedMotion] = (),
    stage: Stage = silent,
) -> Compared:
    """Compare opened sides; ``starts`` : the common starts, by default those of the first recorded side."""
    with stage("simulating every leg from the same starts"):
        inputs = _inputs(sources) | own_hashes(*(side.leg for side in sides))
        found = _compare(list(sides), reference=reference, stretch=dict(stretch), starts=list(starts), inputs=inputs)
    return Compared(found)


def _inputs(sources: Sequence[Source]) -> dict[str, str]:
    """The named files, or a result folder's JSON, with their SHA-256; of an object the files that it is written as."""
    found: dict[str, str] = {}
    for source in sources:
        found |= {trial.name: trial.sha256 for trial in source.trials}
        if source.path.is_file():
            files = [source.path]
        elif source.kind in RESULTS.values():
            files = [source.path / name for name, kind in RESULTS.items() if kind == source.kind]
        else:
            files = sorted(source.path.glob("*.csv"))
        names = [f"{source.label}/{file.name}" if source.in_code else file.as_posix() for file in files]
        found |= {name: sha256_file(file) for name, file in zip(names, files, strict=True)}
    return found

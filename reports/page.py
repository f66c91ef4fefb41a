"""A page from a result folder: sections in order, one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemBytecodeCache, PackageLoader
from markupsafe import Markup

from reports import quantities, stick_figure
from reports.reading import Result, read_result
from reports.section import Missing, Section, sequence
from reports.sections import (
    built,
    checks,
    damper_curves,
    equations,
    estimates,
    files,
    gap_how_far,
    gap_next,
    gap_terms,
    gap_where,
    gap_which,
    inputs,
    motion,
    parts,
    pictures,
    sets,
    spring_sheet,
    summary,
    warnings,
)

LEG_SECTIONS: tuple[Section, ...] = (
    warnings.SECTION,
    summary.SECTION,
    inputs.SECTION,
    estimates.SECTION,
    motion.SECTION,
    parts.SECTION,
    sets.SECTION,
    damper_curves.SECTION,
    built.SECTION,
    spring_sheet.SECTION,
    checks.SECTION,
    pictures.SECTION,
    files.SECTION,
    equations.SECTION,
)
FIT_SECTIONS: tuple[Section, ...] = (
    warnings.SECTION,
    inputs.SECTION,
    estimates.SECTION,
    motion.SECTION,
    equations.SECTION,
)
GAP_SECTIONS: tuple[Section, ...] = (
    gap_where.SECTION,
    gap_which.SECTION,
    gap_how_far.SECTION,
    gap_next.SECTION,
    warnings.SECTION,
    inputs.SECTION,
    gap_terms.SECTION,
)


@dataclass(frozen=True)
class Shown:
    """A section as it stands on the page."""

    number: int
    name: str
    title: str
    html: Markup


def write_leg_report(folder: Path) -> Path:
    """Write ``report.html`` from ``design.json`` and the files that it names.

    Parameters
    ----------
    folder
        of a leg design; only files inside it are read.

    Returns
    -------
    The page's path. The same folder content gives the same bytes.

    Raises
    ------
    ReportError
        If ``design.json`` is missing or no leg design, or a file that it names is damaged.
    """
    return write_page(read_result(folder, "design.json", "leg-design"), "Leg design", LEG_SECTIONS)


def write_fit_report(folder: Path) -> Path:
    """Write ``report.html`` from ``fit.json`` and ``responses/source/*.csv``; see ``write_leg_report``."""
    return write_page(read_result(folder, "fit.json", "fit"), "Fit to recorded motion", FIT_SECTIONS)


def write_import_report(folder: Path) -> Path:
    """Write ``report.html``, the imported leg as a stick figure, from ``import.json``; see ``write_leg_report``."""
    return write_page(read_result(folder, "import.json", "import"), "Imported motion", (stick_figure.SECTION,))


def write_gap_report(folder: Path) -> Path:
    """Write ``report.html`` from ``gap.json``, ``predicted/*.csv`` and ``where/*.csv``; see ``write_leg_report``."""
    result = read_result(folder, "gap.json", "gap")
    return write_page(result, "Gap between model and measurement", GAP_SECTIONS, gap_opening(result))


def gap_opening(result: Result) -> Markup:
    """The diagnosis in a sentence, and what it was scored on."""
    trials = [trial for trial in sequence(result.content, "trials") if isinstance(trial, Mapping)]
    scored = [trial for trial in trials if trial.get("scored")]
    return Markup(
        environment()
        .get_template("gap-opening.html")
        .render(
            sentence=result.content.get("sentence") or "",
            verdict=result.content.get("verdict") or "–",
            scored=len(scored),
            held_out=all(trial.get("held_out") for trial in scored),
            warnings=len(sequence(result.content, "warnings")),
        )
    )


def write_page(result: Result, kind: str, sections: Sequence[Section], opening: Markup | None = None) -> Path:
    """Write ``report.html`` of these sections beside the result; those without content are listed as left out."""
    shown: list[Shown] = []
    left_out: list[tuple[str, str]] = []
    templates = environment()
    for section in sections:
        content = section.content(result)
        if isinstance(content, Missing):
            left_out.append((section.title, content.why))
            continue
        html = templates.get_template(f"{section.template or section.name}.html").render(**content, file=result.name)
        shown.append(Shown(len(shown) + 1, section.name, section.title, Markup(html)))
    page = templates.get_template("page.html").render(
        kind=kind,
        name=result.content.get("name") or "",
        opening=opening or "",
        file=result.name,
        versions=result.content.get("versions") or {},
        sections=shown,
        left_out=left_out,
        style=Markup(resources.files("reports").joinpath("templates/style.css").read_text(encoding="utf-8")),
    )
    target = result.folder / "report.html"
    target.write_text(page, encoding="utf-8", newline="\n")
    return target


def _compiled_templates() -> FileSystemBytecodeCache | None:
    """Templates as compiled before, in a folder of the user's own among the temporary files, if there can be one.

    To compile them costs more than to fill them; a template that has changed is compiled anew.
    """
    try:
        return FileSystemBytecodeCache()
    except (OSError, RuntimeError):  # nowhere to write, or no folder that is the user's alone
        return None


@cache
def environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("reports", "templates"),
        bytecode_cache=_compiled_templates(),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    filters: dict[str, Any] = {
        "quantity": quantities.text,
        "brief": quantities.brief,
        "interval": quantities.interval_text,
        "number": quantities.number,
        "unit": quantities.unit_text,
        "signed": quantities.signed,
        "percent": quantities.whole_percent,
        "percent_interval": quantities.percent_interval,
    }
    environment.filters.update(filters)
    return environment

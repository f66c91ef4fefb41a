"""A page from a result folder: sections in order, one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemBytecodeCache, PackageLoader
from markupsafe import Markup

from reports import quantities, stick_figure
from reports.opening import Opening, marked, shortly, told
from reports.openings.fit import fit_opening
from reports.openings.gap import gap_opening
from reports.openings.imported import import_opening
from reports.openings.leg import leg_opening
from reports.reading import Result, read_result
from reports.scripts import policy, script
from reports.section import Missing, Section
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
)
from reports.sections.warnings import warnings_of

LEG_SECTIONS: tuple[Section, ...] = (
    built.SECTION,
    summary.SECTION,
    parts.SECTION,
    sets.SECTION,
    spring_sheet.SECTION,
    damper_curves.SECTION,
    estimates.SECTION,
    motion.SECTION,
    checks.SECTION,
    pictures.SECTION,
    inputs.SECTION,
    files.SECTION,
    equations.SECTION,
)
FIT_SECTIONS: tuple[Section, ...] = (
    motion.SECTION,
    estimates.SECTION,
    inputs.SECTION,
    equations.SECTION,
)
GAP_SECTIONS: tuple[Section, ...] = (
    gap_which.SECTION,
    gap_how_far.SECTION,
    gap_where.SECTION,
    gap_next.SECTION,
    gap_terms.SECTION,
    inputs.SECTION,
)
SCRIPTS = ("page.js",)
UNFOLDED = 1  # sections; what lies beyond the second screen is folded


@dataclass(frozen=True)
class Shown:
    """A section as it stands on the page."""

    name: str
    title: str
    html: Markup
    open: bool


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
    result = read_result(folder, "design.json", "leg-design")
    return write_page(result, "Leg design", LEG_SECTIONS, leg_opening(result))


def write_fit_report(folder: Path) -> Path:
    """Write ``report.html`` from ``fit.json`` and ``responses/source/*.csv``; see ``write_leg_report``."""
    result = read_result(folder, "fit.json", "fit")
    return write_page(result, "Fit to recorded motion", FIT_SECTIONS, fit_opening(result))


def write_import_report(folder: Path) -> Path:
    """Write ``report.html``, the imported leg as a stick figure, from ``import.json``; see ``write_leg_report``."""
    result = read_result(folder, "import.json", "import")
    return write_page(result, "Imported motion", (stick_figure.SECTION,), import_opening(result))


def write_gap_report(folder: Path) -> Path:
    """Write ``report.html`` from ``gap.json``, ``predicted/*.csv`` and ``where/*.csv``; see ``write_leg_report``."""
    result = read_result(folder, "gap.json", "gap")
    return write_page(result, "Gap between model and measurement", GAP_SECTIONS, gap_opening(result))


def write_page(
    result: Result, kind: str, sections: Sequence[Section], opening: Opening, scripts: Sequence[str] = SCRIPTS
) -> Path:
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
        shown.append(Shown(section.name, section.title, Markup(html), len(shown) < UNFOLDED))
    used = [script(name) for name in scripts]
    page = templates.get_template("page.html").render(
        kind=kind,
        name=result.content.get("name") or "",
        opening=opening,
        told=told(warnings_of(result)),
        file=result.name,
        versions=result.content.get("versions") or {},
        sections=shown,
        left_out=left_out,
        equations=any(section.name == "equations" for section in shown),
        style=Markup(resources.files("reports").joinpath("templates/style.css").read_text(encoding="utf-8")),
        scripts=used,
        policy=Markup(policy(used)),
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
        "shortly": shortly,
        "marked": marked,
    }
    environment.filters.update(filters)
    return environment

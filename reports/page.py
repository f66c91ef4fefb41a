"""A page from a result folder: sections in order, one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import BytecodeCache, Environment, PackageLoader
from markupsafe import Markup

from synth.reports import quantities, stick_figure
from synth.reports.opening import Opening, as_markup, cut_short, opening_warnings
from synth.reports.openings.check_opening import check_opening
from synth.reports.openings.fit_opening import fit_opening
from synth.reports.openings.gap_opening import gap_opening
from synth.reports.openings.import_opening import import_opening
from synth.reports.openings.leg_opening import leg_opening
from synth.reports.openings.rehearsal_opening import rehearsal_opening
from synth.reports.reading import Result, read_result
from synth.reports.scripts import policy, script
from synth.reports.section import AbsentResult, ReportSection, mapping
from synth.reports.sections import (
    built,
    check_apart,
    check_found,
    check_sizes,
    damper_laws_measured,
    equations,
    estimates,
    files,
    gap_evidence,
    gap_how_far,
    gap_next,
    gap_terms,
    gap_where,
    gap_which,
    inputs,
    joint_checks,
    links,
    live_leg,
    motion,
    parts_list,
    pictures,
    rehearsal_confusion,
    rehearsal_sizes,
    sets,
    spring_sheet,
    summary,
    swap,
)
from synth.reports.sections.warnings import warnings_of

LEG_SECTIONS: tuple[ReportSection, ...] = (
    built.SECTION,
    swap.SECTION,
    summary.SECTION,
    parts_list.SECTION,
    sets.SECTION,
    links.SECTION,
    spring_sheet.SECTION,
    damper_laws_measured.SECTION,
    estimates.SECTION,
    motion.SECTION,
    joint_checks.SECTION,
    pictures.SECTION,
    inputs.SECTION,
    files.SECTION,
    equations.SECTION,
)
FIT_SECTIONS: tuple[ReportSection, ...] = (
    motion.SECTION,
    estimates.SECTION,
    inputs.SECTION,
    equations.SECTION,
)
GAP_SECTIONS: tuple[ReportSection, ...] = (
    gap_which.SECTION,
    gap_evidence.SECTION,
    gap_how_far.SECTION,
    gap_where.SECTION,
    gap_next.SECTION,
    gap_terms.SECTION,
    inputs.SECTION,
)
CHECK_SECTIONS: tuple[ReportSection, ...] = (check_sizes.SECTION, check_apart.SECTION, check_found.SECTION)
REHEARSAL_SECTIONS: tuple[ReportSection, ...] = (rehearsal_sizes.SECTION, rehearsal_confusion.SECTION)
SCRIPTS = ("page.js", "plots.js")
UNFOLDED = 1  # sections shown open; the sections below the second screen are folded


@dataclass(frozen=True)
class RenderedSection:
    """A rendered section of the page."""

    name: str
    title: str
    html: Markup
    open: bool


def write_leg_report(folder: Path, compiled: BytecodeCache | None = None) -> Path:
    """Write ``report.html`` from ``design.json`` and the files that it names.

    Parameters
    ----------
    folder
        of a leg design; only files inside it are read.
    compiled
        store of compiled templates; without one they are compiled in every process.

    Returns
    -------
    The page's path. The same folder content gives the same bytes.

    Raises
    ------
    ReportError
        If ``design.json`` is missing or not a leg design, or a file that it names is damaged.
    """
    result = read_result(folder, "design.json", "leg-design")
    opening = leg_opening(result)
    live = live_leg.live_data(result)
    if live is None:
        still = [section for section in LEG_SECTIONS if section is not swap.SECTION]
        return write_page(result, "Leg design", still, opening, compiled=compiled)
    scripts, blocks = [*SCRIPTS, "integrator.js", "swap.js"], [live_leg.block("leg-data", live)]
    if live["has_solids"]:
        scripts += ["three.js", "leg3d.js"]
        blocks.append(live_leg.block("leg-glb", live_leg.glb_text(result)))
    return write_page(result, "Leg design", LEG_SECTIONS, opening, scripts, blocks, compiled)


def write_fit_report(folder: Path, compiled: BytecodeCache | None = None) -> Path:
    """Write ``report.html`` from ``fit.json`` and ``responses/source/*.csv``; see ``write_leg_report``."""
    result = read_result(folder, "fit.json", "fit")
    title = "Fit to wanted motion" if mapping(result.content, "wanted") else "Fit to recorded motion"
    return write_page(result, title, FIT_SECTIONS, fit_opening(result), compiled=compiled)


def write_check_report(folder: Path) -> Path:
    """Write ``report.html`` from ``check.json``; see ``write_leg_report``."""
    result = read_result(folder, "check.json", "gap-check")
    return write_page(result, "Check of recordings", CHECK_SECTIONS, check_opening(result))


def write_rehearsal_report(folder: Path) -> Path:
    """Write ``report.html`` from ``rehearsal.json``; see ``write_leg_report``."""
    result = read_result(folder, "rehearsal.json", "rehearsal")
    return write_page(result, "Rehearsal of a diagnosis", REHEARSAL_SECTIONS, rehearsal_opening(result))


def write_import_report(folder: Path) -> Path:
    """Write ``report.html``, the imported leg as a stick figure, from ``import.json``; see ``write_leg_report``."""
    result = read_result(folder, "import.json", "import")
    return write_page(result, "Imported motion", (stick_figure.SECTION,), import_opening(result))


def write_gap_report(folder: Path, compiled: BytecodeCache | None = None) -> Path:
    """Write ``report.html`` from ``gap.json``, ``predicted/*.csv`` and ``where/*.csv``; see ``write_leg_report``."""
    result = read_result(folder, "gap.json", "gap")
    return write_page(result, "Gap between model and measurement", GAP_SECTIONS, gap_opening(result), compiled=compiled)


def write_page(
    result: Result,
    kind: str,
    sections: Sequence[ReportSection],
    opening: Opening,
    scripts: Sequence[str] = SCRIPTS,
    blocks: Sequence[Markup] = (),
    compiled: BytecodeCache | None = None,
) -> Path:
    """Write ``report.html`` of these sections beside the result; those without content are listed as left out."""
    shown: list[RenderedSection] = []
    left_out: list[tuple[str, str]] = []
    templates = environment(compiled)
    for section in sections:
        content = section.content(result)
        if isinstance(content, AbsentResult):
            left_out.append((section.title, content.why))
            continue
        html = templates.get_template(f"{section.template or section.name}.html").render(**content, file=result.name)
        title = str(content.get("section_title", section.title))
        shown.append(RenderedSection(section.name, title, Markup(html), len(shown) < UNFOLDED))
    used = [script(name) for name in scripts]
    page = templates.get_template("page.html").render(
        kind=kind,
        name=result.content.get("name") or "",
        opening=opening,
        warnings=opening_warnings(warnings_of(result)),
        file=result.name,
        versions=result.content.get("versions") or {},
        sections=shown,
        left_out=left_out,
        equations=any(section.name == "equations" for section in shown),
        style=Markup(resources.files("synth.reports").joinpath("templates/style.css").read_text(encoding="utf-8")),
        scripts=used,
        blocks=blocks,
        script_names=scripts,
        policy=Markup(policy(used)),
    )
    target = result.folder / "report.html"
    target.write_text(page, encoding="utf-8", newline="\n")
    return target


@cache
def environment(compiled: BytecodeCache | None = None) -> Environment:
    """The templates and their filters; ``compiled``: where the compiled ones are kept, none if not given."""
    environment = Environment(
        loader=PackageLoader("synth.reports", "templates"),
        # Not jinja's own cache of compiled templates: it unpickles and runs files in the temporary folder.
        bytecode_cache=compiled,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    filters: dict[str, Any] = {
        "quantity": quantities.text,
        "cm": partial(quantities.in_length_unit, unit="cm"),
        "mm": partial(quantities.in_length_unit, unit="mm"),
        "brief": quantities.brief,
        "interval": quantities.interval_text,
        "number": quantities.number,
        "unit": quantities.unit_text,
        "signed": quantities.signed,
        "percent": quantities.whole_percent,
        "probability": quantities.share_text,
        "percent_interval": quantities.percent_interval,
        "shortly": cut_short,
        "marked": as_markup,
    }
    environment.filters.update(filters)
    return environment

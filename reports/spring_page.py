"""The winding sheet: one page for the bench, from ``spring.json``."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from markupsafe import Markup

from reports.page import environment
from reports.reading import read_result
from reports.section import mapping
from reports.sections.spring_sheet import drawing_of, groups_of
from reports.sections.winding import sheet_content


def write_winding_sheet(folder: Path) -> Path:
    """Write ``winding_sheet.html`` from ``spring.json``: drawing, steps, what to measure, all numbers.

    Raises
    ------
    ReportError
        If ``spring.json`` is missing or no result of ``synth spring``.
    """
    content = read_result(folder, "spring.json", "spring").content
    make = mapping(content, "make") or mapping(content, "checked")
    shown = sheet_content(content, drawing_of("the spring to wind", make), groups_of(make))
    style = Markup(resources.files("reports").joinpath("templates/style.css").read_text(encoding="utf-8"))
    target = folder / "winding_sheet.html"
    page = environment().get_template("winding-sheet.html").render(**shown, style=style)
    target.write_text(page, encoding="utf-8", newline="\n")
    return target

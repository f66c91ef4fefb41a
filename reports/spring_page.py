"""The winding sheet: one page for the bench, from ``spring.json``."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, opening_warnings
from synth.reports.page import environment
from synth.reports.quantities import in_si, number, text
from synth.reports.reading import Json, read_result, value_of
from synth.reports.scripts import policy, script
from synth.reports.section import mapping, sequence
from synth.reports.sections.spring_sheet import drawing_of, groups_of
from synth.reports.sections.warnings import text_of
from synth.reports.sections.winding_plan import sheet_content
from synth.reports.severity import warning_of


def write_winding_sheet(folder: Path, shown_in: Json | None = None) -> Path:
    """Write ``winding_sheet.html`` from ``spring.json``: drawing, steps, quantities to measure, all numbers.

    ``shown_in`` : the same content in other units, such as inches.

    Raises
    ------
    ReportError
        If ``spring.json`` is missing or not a result of ``synth spring``.
    """
    content = shown_in or read_result(folder, "spring.json", "spring").content
    make = mapping(content, "make") or mapping(content, "checked")
    shown = sheet_content(content, drawing_of("the spring to wind", make), groups_of(make))
    warned = sequence(make, "remarks") or sequence(make, "warnings")
    warnings = opening_warnings([
        *(warning_of("", str(text), "violations", {"severity": "decide"}) for text in sequence(make, "violations")),
        *(warning_of("", text_of(item), "warnings", item) for item in warned),
    ])  # fmt: skip
    scripts = [script("page.js")]
    page = (
        environment()
        .get_template("winding-sheet.html")
        .render(
            **shown,
            opening=_opening(make, shown),
            warnings=warnings,
            style=Markup(resources.files("synth.reports").joinpath("templates/style.css").read_text(encoding="utf-8")),
            scripts=scripts,
            policy=Markup(policy(scripts)),
        )
    )
    target = folder / "winding_sheet.html"
    target.write_text(page, encoding="utf-8", newline="\n")
    return target


def _opening(make: Json, shown: Json) -> Opening:
    """The spring to wind, its stress, and the first steps."""
    count = make.get("count") or 1
    many = f"{count} springs, each of " if isinstance(count, int) and count > 1 else ""
    verdict = (
        f"Wind {many}{text(make.get('body_coils'))} coils of {text(make.get('wire_diameter'))} "
        f"{make.get('material') or 'wire'}, {text(make.get('mean_diameter'))} mean diameter, "
        f"for {text(make.get('rate'))}."
    )
    stress, allowed, safety = in_si_text(make, "stress"), in_si_text(make, "allowed_stress"), make.get("safety")
    violated = sequence(make, "violations")
    trust = f"At full travel the stress is {stress}; {allowed} is allowed." if stress and allowed else ""
    opened, less = in_si_text(make, "opening_stress"), in_si_text(make, "allowed_opening_stress")
    if (value_of(make.get("opening_travel")) or 0.0) > 0.0 and opened and less:
        trust += f" At the opening travel it is {opened}; {less} is allowed there."
    if mapping(make, "arms").get("bend_radius"):
        trust += f" In the bends of the arms it is {in_si_text(mapping(make, 'arms'), 'stress')}; {allowed} is allowed."
    steps = [str(shown["winding"]["steps"][0])] if shown["winding"].get("steps") else []
    rows = [
        [Cell(words), Cell(text(make.get(key)))]
        for key, words in (
            ("rate", "Spring rate"), ("travel", "Travel, winding"), ("moment", "Moment at full travel"),
            ("opening_travel", "Travel, opening"), ("opening_moment", "Moment at the opening travel"),
            ("included_angle", "Angle of the free arms"), ("body_length", "Body length, free"),
            ("widest_outer_diameter", "Outside diameter, widest"), ("safety_1e5", "Strength over stress, 10⁵ cycles"),
        )
        if make.get(key)
    ]  # fmt: skip
    if isinstance(safety, dict):
        rows.append([Cell("Yield over stress, least"), Cell(text(safety))])
    figure = Markup('<div class="whole">{}</div>').format(shown["drawing"]) if shown["drawing"] else Markup("")
    caption = "Both views at one scale, free spring, close wound." if figure else ""
    return Opening(verdict, trust, steps, figure, caption, Figures(("The spring", ""), rows), not violated)


def in_si_text(make: Json, key: str) -> str:
    """A stress in MPa, empty without one."""
    value = mapping(make, key).get("value")
    if not isinstance(value, (int, float)):
        return ""
    return text(make[key]) if in_si(make[key]) is None else f"{number(value, 4)} {make[key].get('unit')}"

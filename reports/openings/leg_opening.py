"""The opening of the leg's page: the distance of the built leg from the wanted motion, and what prevents it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, listed
from synth.reports.quantities import brief, interval_text, percent, text, whole_percent
from synth.reports.reading import Json, Result, png_uri, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections import live_leg, pictures

CERTAIN, UNLIKELY = 0.9, 0.5  # chances from which a leg counts as certain, or as unlikely
GAIN = 0.2  # of the chance, from which measuring the springs first is recommended


def leg_opening(result: Result) -> Opening:
    """Verdict, the leg's picture, and a row of figures a joint."""
    document = result.content
    without, failed = _without_part(document), _failed(document)
    chance = value_of(mapping(document, "response", "forecast").get("chance"))
    good = None if chance is None else (True if chance >= CERTAIN else False if chance < UNLIKELY else None)
    figure, caption = _picture(result)
    return Opening(
        _verdict(document, without, failed),
        _trust(document),
        _steps(document, without, failed),
        figure,
        caption,
        _figures(document),
        False if without or failed else good,
    )


def _without_part(document: Json) -> list[str]:
    """Joints without a spring."""
    found = []
    for name, joint in mapping(document, "joints").items():
        spring = mapping(joint, "spring")
        if spring and not spring.get("part") and not mapping(spring, "make"):
            found.append(f"no spring for the {name}")
    return found


def _failed(document: Json) -> list[Mapping[str, Any]]:
    checks = sequence(document, "solids", "checks")
    return [check for check in checks if isinstance(check, Mapping) and not check.get("passed")]


def _verdict(document: Json, without: list[str], failed: list[Mapping[str, Any]]) -> str:
    rms = mapping(document, "response", "wanted_to_built").get("rms")
    near = f"with nominal parts its motion is {brief(rms)} (RMS) from the wanted one" if rms else ""
    if without:
        start = f"Not ready to build: {listed(without)}"
    elif failed:
        count = len(sequence(document, "solids", "checks"))
        start = f"Not ready to build: {len(failed)} of {count} checks of the joints failed, so no part is exported"
    elif mapping(document, "solids").get("drawn"):
        start = "The leg can be built"
    elif mapping(document, "joints"):
        start = "The parts of the leg are chosen; its solids are not drawn"
    else:
        return "This design names no joint."
    return f"{start}; {near}." if near else f"{start}."


def _trust(document: Json) -> str:
    forecast = mapping(document, "response", "forecast")
    if not forecast:
        return ""
    chance, within = forecast.get("chance"), forecast.get("within")
    expected = f"{brief(forecast.get('expected'))}, 90 %: {interval_text(forecast.get('expected'))}°"
    return (
        f"With parts within their tolerances, {whole_percent(chance)} of such legs stay within the allowed "
        f"{brief(within)} (expected {expected})."
    )


def _steps(document: Json, without: list[str], failed: list[Mapping[str, Any]]) -> list[str]:
    if without:
        return [
            "Relax that spring's requirements under `select:`; the section on springs to make shows the nearest ones."
        ]
    if failed:
        return [f"{failed[0].get('text')}. Change `cad:` or `select:` in the project."]
    response = mapping(document, "response")
    chance = value_of(mapping(response, "forecast").get("chance"))
    measured = value_of(mapping(response, "forecast_free_angles_measured").get("chance"))
    steps = []
    if chance is not None and measured is not None and measured - chance > GAIN:
        steps.append(
            f"Get the springs, measure each one's free angle to a degree, enter it under `measured:` and run again: "
            f"the chance of staying within {brief(mapping(response, 'forecast').get('within'))} changes from "
            f"{whole_percent(chance)} to {whole_percent(measured)}."
        )
    if mapping(document, "solids").get("drawn"):
        steps.append("Order the parts in `bom.csv` and print the plates `parts/leg_print_*.3mf`.")
    elif mapping(document, "joints"):
        steps.append("Run without --no-cad to get parts to print.")
    return steps


def _picture(result: Result) -> tuple[Markup, str]:
    """The whole leg."""
    named = [item for item in sequence(result.content, "pictures") if isinstance(item, Mapping)]
    for item in [item for item in named if PurePosixPath(str(item.get("path"))).stem in pictures.WHOLE]:
        path = result.path(str(item.get("path")))
        if path is not None and path.suffix.lower() == ".png":
            picture = Markup('<img src="{}" alt="{}">').format(png_uri(path), str(item.get("caption") or ""))
            return Markup('<div id="leg3d">{}</div>').format(picture), str(item.get("caption") or "")
    return (Markup('<div id="leg3d"></div>'), "") if result.path(live_leg.GLB) else (Markup(""), "")


def _figures(document: Json) -> Figures | None:
    joints = mapping(document, "joints")
    if not joints:
        return None
    errors = mapping(document, "response", "wanted_to_built", "joints")
    rows = [_row(name, mapping(joint), errors.get(name)) for name, joint in joints.items()]
    heads = ("Joint", "Spring", "Damper", "Free angle, built", "From wanted, RMS")
    words = "Spring rate, and its deviation from the rate that suits the chosen damper. Free angle of built.leg.yaml."
    return Figures(heads, rows, words)


def _row(name: str, joint: Json, error: object) -> list[Cell]:
    spring, damper = mapping(joint, "spring"), mapping(joint, "damper")
    make = mapping(spring, "make")
    count = make.get("count") or spring.get("count") or 1
    rate = make.get("rate") or spring.get("rate")
    wanted = mapping(joint, "refit").get("spring_rate") or mapping(joint, "wanted").get("spring_rate")
    what = str(spring.get("part") or (f"wind, {text(make.get('wire_diameter'))} wire" if make else "none"))
    if isinstance(count, int) and count > 1:
        what = f"{count} × {what}"
    each = value_of(rate)
    off = percent(None if each is None else each * (count if isinstance(count, int) else 1), value_of(wanted))
    return [
        Cell(name),
        Cell(what, f"{text(rate)}, {off}" if rate else ""),
        Cell(str(damper.get("arrangement") or damper.get("part") or "–"), _law(damper)),
        Cell(text(spring.get("free_angle"))),
        Cell(brief(error)),
    ]


def _law(damper: Json) -> str:
    """Whether the damper's law was measured or is assumed."""
    why = str(damper.get("law_why") or "")
    return f"law {why.split(':')[0]}" if ":" in why else str(damper.get("law") or "")

"""The opening of the leg's page: the distance of the built leg from the wanted motion, and what prevents it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from markupsafe import Markup

from synth.reports.forecast_condition import assumed_laws_words
from synth.reports.opening import Cell, Figures, Opening, joined_names
from synth.reports.openings.leg_steps import left_out, measured_joints, slipping_dampers, steps, still_joints
from synth.reports.quantities import brief, interval_text, share_text, text
from synth.reports.reading import Json, Result, png_uri, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections import live_leg, pictures
from synth.reports.wanted_rate import off_wanted, wanted_rate

CERTAIN, UNLIKELY = 0.9, 0.5  # chances from which a leg counts as certain, or as unlikely


def leg_opening(result: Result) -> Opening:
    """Verdict, the leg's picture, and a row of figures a joint."""
    document = result.content
    without, failed, slipping = _without_part(document), _failed_checks(document), slipping_dampers(document)
    chance = value_of(mapping(document, "response", "forecast").get("chance"))
    good = None if chance is None else (True if chance >= CERTAIN else False if chance < UNLIKELY else None)
    if good and _another_motion(document):
        good = None
    figure, caption = _picture(result)
    return Opening(
        _verdict(document, without, failed, slipping),
        _trust(document),
        steps(document, without, failed, slipping),
        figure,
        caption,
        _figures(document),
        False if without or failed or slipping or left_out(document) or still_joints(document) else good,
    )


def _without_part(document: Json) -> list[str]:
    """Joints without a spring."""
    found = []
    for name, joint in mapping(document, "joints").items():
        spring = mapping(joint, "spring")
        if spring and not spring.get("part") and not mapping(spring, "make"):
            found.append(f"no spring for the {name}")
    return found


def _failed_checks(document: Json) -> list[Mapping[str, Any]]:
    checks = sequence(document, "solids", "checks")
    return [check for check in checks if isinstance(check, Mapping) and not check.get("passed")]


def _verdict(document: Json, without: list[str], failed: list[Mapping[str, Any]], slipping: list[str]) -> str:
    rms = mapping(document, "response", "wanted_to_built").get("rms")
    near = f"with nominal parts the leg's motion is {brief(rms)} (RMS) from the wanted one" if rms else ""
    near += _another_motion(document) if rms else ""
    if without:
        start = f"Not ready to build: {joined_names(without)}"
    elif failed:
        count = len(sequence(document, "solids", "checks"))
        start = f"Not ready to build: {len(failed)} of {count} checks of the joints failed, so no part is exported"
    elif slipping or left_out(document) or still_joints(document):
        start = f"Not ready to build: {'; '.join(_undecided(document, slipping))}"
    elif mapping(document, "solids").get("drawn"):
        start = "The leg can be built"
    elif mapping(document, "joints"):
        start = "Parts are chosen for the links as stated, without the masses of drawn joints: not final"
    else:
        return "This design names no joint."
    return f"{start}; {near}." if near else f"{start}."


def _another_motion(document: Json) -> str:
    """Where the wanted motion is not the animal's, which the robot's links do not make; empty if nowhere."""
    found = mapping(document, "response", "animal_to_wanted")
    off = mapping(found, "joints")
    at = [f"{brief(off.get(str(name)))} at the {name}" for name in sequence(found, "another_motion")]
    if not at:
        return ""
    return f", but that is not the animal's, which the robot's links do not make ({joined_names(at)} off it)"


def _undecided(document: Json, slipping: list[str]) -> list[str]:
    """What keeps a leg of checked joints from being built as it is."""
    found, still = [], still_joints(document)
    if still:
        found.append(f"as built, {joined_names(still)} hardly {'turns' if len(still) == 1 else 'turn'}")
    if slipping:
        many = "s" if len(slipping) > 1 else ""
        found.append(f"as drawn, the damper{many} of {joined_names(slipping)} would slip on the shaft{many}")
    if left_out(document):
        found.append(f"the ranges that the target states leave out the {joined_names(left_out(document))}")
    return found


def _trust(document: Json) -> str:
    forecast = mapping(document, "response", "forecast")
    if not forecast:
        return ""
    chance, within = forecast.get("chance"), forecast.get("within")
    expected = f"{brief(forecast.get('expected'))}, 90 %: {interval_text(forecast.get('expected'))}°"
    known = [name for name in mapping(document, "joints") if name in measured_joints(document)]
    start = f"With the free angle measured at {joined_names(known)}, and other parts" if known else "With parts"
    return (
        f"{start} within their tolerances, {share_text(chance)} of such legs stay within the allowed "
        f"{brief(within)} (expected {expected}).{assumed_laws_words(forecast)}"
    )


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
    words = (
        "Spring rate in the joint; per cent: of a bought one, as sold, from the wanted rate. "
        if any(mapping(joint, "spring").get("part") for joint in joints.values())
        else "Spring rate in the joint. "
    )
    if any(mapping(joint, "spring", "make") for joint in joints.values()):
        words += "One to wind has the rate with the least expected error. "
    words += "Free angle: of the assembled joint, not of the loose spring."
    return Figures(heads, rows, words)


def _row(name: str, joint: Json, error: object) -> list[Cell]:
    spring, damper = mapping(joint, "spring"), mapping(joint, "damper")
    make = mapping(spring, "make")
    count = make.get("count") or spring.get("count") or 1
    measured = spring.get("measured_rate")
    rate = measured or make.get("rate") or spring.get("rate")
    wanted = wanted_rate(joint)
    what = str(spring.get("part") or (f"wind, {text(make.get('wire_diameter'))} wire" if make else "none"))
    if isinstance(count, int) and count > 1:
        what = f"{count} × {what}"
    off = "measured" if measured else "" if make else off_wanted(spring, wanted)
    return [
        Cell(name),
        Cell(what, ", ".join(words for words in (text(rate), off) if words) if rate else ""),
        Cell(str(damper.get("arrangement") or damper.get("part") or "–"), _law(damper)),
        Cell(text(spring.get("free_angle"))),
        Cell(brief(error)),
    ]


def _law(damper: Json) -> str:
    """Whether the damper's law was measured or is assumed."""
    why = str(damper.get("law_why") or "")
    return f"law {why.split(':')[0]}" if ":" in why else str(damper.get("law") or "")

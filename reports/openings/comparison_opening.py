"""The opening of a comparison's page: the side nearest to the reference, its motion, and a row per side."""

from __future__ import annotations

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, joined_names
from synth.reports.quantities import brief, interval_text, number, text
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections import compared

MOST_JOINTS = 4  # whose columns a screen holds
UNEQUAL = 1.0  # deg, distance of two starts from which they are called nearly the same, as in the notes
SHORT = (("rise_time", "rise"), ("damping_ratio", "ζ"), ("damped_frequency", "ω"))


def comparison_opening(result: Result) -> Opening:
    """Verdict, one start's motions overlaid, and a row of figures per side."""
    document = result.content
    figure = compared.telling_figure(result)
    return Opening(
        _verdict(document),
        _trust(document),
        _steps(document),
        figure.drawing if figure else Markup(""),
        figure.caption if figure else "",
        _figures(document),
        wide=True,
        beside=figure.pose if figure else Markup(""),
    )


def _verdict(document: Json) -> str:
    """The others by their difference from the reference."""
    reference = document.get("reference")
    family = [side for side in compared.sides_of(document) if side.get("pace") and side.get("kind") == "model"]
    if len(family) > 1:
        return _family_verdict(document, family)
    known = [(value_of(mapping(side, "off_reference").get("overall")), side) for side in compared.sides_of(document)]
    ranked = sorted(((value, side) for value, side in known if value is not None), key=lambda item: item[0])
    apart = [str(side.get("name")) for value, side in known if value is None and side.get("name") != reference]
    if not ranked:
        names = joined_names([str(side.get("name")) for side in compared.sides_of(document)])
        return f"{names} share no start: only figures are compared."
    words = [f"{side.get('name')} {brief(mapping(side, 'off_reference').get('overall'))}" for _, side in ranked]
    without = f" {joined_names(apart)} share{'s' if len(apart) == 1 else ''} no start with it." if apart else ""
    if len(words) == 1:
        name, _, away = words[0].rpartition(" ")
        return f"From {_same_start(document, name)} {name} moves {away} (RMS) from {reference}.{without}"
    nearest, _, away = words[0].rpartition(" ")
    return f"{nearest} comes nearest to {reference}, {away} off (RMS); {joined_names(words[1:])}.{without}"


def _same_start(document: Json, name: str) -> str:
    """The common start in words: a recording's is another one's only nearly."""
    apart = [
        value_of(mapping(start, "recordings", side).get("starts_away_together")) or 0.0
        for start in sequence(document, "starts")
        for side in (name, str(document.get("reference")))
    ]
    return "nearly the same start" if max(apart, default=0.0) > UNEQUAL else "the same start"


def _followed(document: Json) -> str:
    """How far the legs of a family are off the reference, each in its own time."""
    pairs = [(mapping(side, "off_reference").get("overall"), side) for side in compared.sides_of(document)]
    known = [(value, brief(item)) for item, side in pairs if side.get("pace") and (value := value_of(item)) is not None]
    if not known:
        return ""
    (_, least), (_, most) = min(known), max(known)
    span = least if least == most else f"{least} to {most}"
    return f", each {span} (RMS) off {document.get('reference')} at its own scale"


def _family_verdict(document: Json, family: list[Json]) -> str:
    """Change of rate and damping ratio over a family of time scales, for the joint that changes most."""
    first, last = family[0], family[-1]
    names = list(mapping(first, "alone"))
    known = []
    for name in names:
        a, b = (value_of(mapping(side, "alone", name).get("damping_ratio")) for side in (first, last))
        if a and b:
            known.append((max(a, b) / min(a, b), name, (a, b)))
    words = f"One motion at {len(family)} time scales, from {first.get('name')} to {last.get('name')}"
    words += _followed(document)
    if not known:
        return f"{words}."
    _, name, pair = max(known)
    rates = [brief(mapping(side, "joints", name).get("spring_rate")) for side in (first, last)]
    return (
        f"{words}: the {name}'s spring goes from {rates[0]} to {rates[1]}, its own damping ratio from "
        f"{number(pair[0], 2)} to {number(pair[1], 2)}."
    )


def _trust(document: Json) -> str:
    starts = len(sequence(document, "starts"))
    offs = [mapping(side, "off_reference") for side in compared.sides_of(document)]
    shared = sorted({count for off in offs if off.get("overall") and isinstance(count := off.get("starts"), int)})
    whose = str(document.get("starts_of"))
    from_where = {"standard": "a standard release", "given": "the given start"}.get(
        whose, f"the recorded starts of {whose}"
    )
    bases = {str(off.get("basis")) for off in offs if off.get("overall")}
    how = {
        frozenset({"measured"}): "all differences are between recordings",
        frozenset({"predicted"}): "each difference has at least one simulated leg",
    }.get(frozenset(bases), "differences between two recordings are measured, all others predicted")
    count = f"{starts} starts" if starts != 1 else "one start"
    if shared and shared != [starts]:  # what some sides lack is in no figure
        count = f"{' to '.join(str(shared[k]) for k in sorted({0, len(shared) - 1}))} of {count}"
    return f"Over {count} ({from_where}); {how}." if bases else f"Over {count}: {from_where}."


def _steps(document: Json) -> list[str]:
    kinds = {str(side.get("kind")) for side in compared.sides_of(document)}
    if any(side.get("pace") for side in compared.sides_of(document)):
        return ["Choose a time scale, write it under `scale:` of the project, and run `synth leg`."]
    if kinds == {"model"}:
        return ["Record one of these legs from such a start and include the recording, to measure a difference."]
    return ["If a built leg differs from its design, find the reason with `synth gap`."]


def _figures(document: Json) -> Figures:
    joints = [str(name) for name in sequence(document, "joints")][:MOST_JOINTS]
    rows = []
    for side in compared.sides_of(document):
        off = mapping(side, "off_reference")
        shown = "reference" if side.get("name") == document.get("reference") else brief(off.get("overall"))
        overlaid = compared.overlaid_in(side)
        kind = str(side.get("kind")) + (f", {overlaid}" if overlaid != "–" else "")
        row = [Cell(str(side.get("name")), kind), Cell(shown, str(off.get("basis") or ""))]
        for name in joints:
            seen = mapping(side, "characteristics", name)
            row.append(_joint_cell(mapping(side, "joints", name), seen, both=compared.is_family(document)))
        rows.append(row)
    heads = ("Side", "From reference, RMS", *joints)
    note = "For each joint: spring rate k, damper rate b, free angle; for recordings, medians of characteristics."
    if compared.is_family(document):
        note += " Motions are overlaid in the starts' time: each leg's own over its time scale."
    return Figures(heads, rows, note)


def _joint_cell(joint: Json, shown: Json, *, both: bool) -> Cell:
    """The joint's parameters; what it shows where there are none, or ``both``."""
    words = [f"{label} {brief(shown[key])}" for key, label in SHORT if shown.get(key)]
    if not joint:
        return Cell("–" if not words else words[0], ", ".join(words[1:]))
    rate = f"k {text(joint['spring_rate'])}" if joint.get("spring_rate") else "no spring"
    damper = (
        f"b {text(joint['damper_rate'])}" if joint.get("damper_rate") else str(joint.get("damper_law") or "no damper")
    )
    free = f", free {text(joint['free_angle'])}" if joint.get("free_angle") else ""
    known = interval_text(joint.get("spring_rate"))
    moves = f"; {', '.join(words)}" if both and words else ""
    return Cell(rate, f"{f'{known}; ' if known else ''}{damper}{free}{moves}")

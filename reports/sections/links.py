"""Masses of the links: as assumed in the target's file, as drawn, and as simulated with all parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

HOLDS = {"none": "no joint parts", "joint": "its joints' parts"}
KINDS = (("assumed", "assumed"), ("drawn", "drawn parts"), ("built", "simulated"))


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A row a link and kind of figure; parts whose mass is assumed; how parts and masses came to agree."""
    links = {name: link for name, link in mapping(result.content, "links").items() if isinstance(link, Mapping)}
    if not links:
        return AbsentResult("no joints were drawn, so the links are those of the target's file")
    rows = [
        {"link": name, "holds": HOLDS.get(str(link.get("includes")), ""), "kind": words, **mapping(link, kind)}
        for name, link in links.items()
        for kind, words in KINDS
    ]
    return {
        "rows": rows,
        "span": len(KINDS),
        "offsets": [{"link": n, "across": mapping(k, "built").get("com_across"), "torque": k.get("offset_torque")}
                    for n, k in links.items()],
        "assumed": _assumed_masses(links),
        "rounds": mapping(result.content, "mass_rounds"),
        "seats": _seats(result),
    }  # fmt: skip


def _assumed_masses(links: Mapping[str, Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Parts without a weighed or computed mass, heaviest first."""
    parts = [
        {"link": name, **part}
        for name, link in links.items()
        for part in sequence(link, "parts")
        if isinstance(part, Mapping) and str(part.get("basis")).startswith("assumed")
    ]
    return sorted(parts, key=lambda part: -(value_of(part.get("mass")) or 0.0))


def _seats(result: Result) -> list[Mapping[str, Any]]:
    """The seat setting for each measured spring."""
    found: list[Mapping[str, Any]] = []
    for name, joint in mapping(result.content, "joints").items():
        setting = mapping(joint, "seat", "setting") if isinstance(joint, Mapping) else {}
        if setting:
            found.append({"joint": name, **setting})
    return found


SECTION = ReportSection("links", "Links and their parts", content)

"""Every warning of a result, once each, with its level, for the page's opening."""

from __future__ import annotations

from collections.abc import Mapping

from synth.reports.reading import Json, Result
from synth.reports.section import mapping, sequence
from synth.reports.severity import ShownWarning, warning_of

_STAGES = {"source": "fit to the source", "target": "fit to the target", "refit": "fit with the chosen dampers"}


def warnings_of(result: Result) -> list[ShownWarning]:
    """Every warning once: the design's own, the joints', the dampers' and the fits', each with its key."""
    found: dict[tuple[str, str], tuple[str, object]] = {}
    joints = joint_names(result.content)
    for joint, text, key, entry in _all_warnings(result.content):
        named = joint or next((name for name in joints if text.startswith(f"{name}: ")), "")
        found.setdefault((_without_joint(named, text), named), (key, entry))
    texts = {text for text, joint in found if joint}
    return [
        warning_of(joint, text, key, entry)
        for (text, joint), (key, entry) in found.items()
        if joint or text not in texts
    ]


def joint_names(document: Json) -> list[str]:
    """The joints of a design or a fit."""
    return list(mapping(document, "joints")) or list(mapping(document, "stages", "source", "joints"))


def _all_warnings(document: Json) -> list[tuple[str, str, str, object]]:
    """(joint or empty, text, key, the entry itself)."""
    rows: list[tuple[str, str, str, object]] = []
    for index, item in enumerate(sequence(document, "remarks") or sequence(document, "warnings")):
        rows.append((str(mapping(item).get("joint") or ""), text_of(item), f"warnings[{index}]", item))
    for index, item in enumerate(sequence(document, "not_separable")):
        rows.append(("", text_of(item), f"not_separable[{index}]", item))
    for name, joint in mapping(document, "joints").items():
        rows += [(name, text_of(item), f"joints.{name}.warnings", item) for item in sequence(joint, "warnings")]
    for name, law in mapping(document, "damper_laws").items():
        rows += [(name, text_of(item), f"damper_laws.{name}.warnings", item) for item in sequence(law, "warnings")]
    for stage in _STAGES:
        fit = mapping(document, "stages", stage)
        rows += [("", text_of(item), f"stages.{stage}.warnings", item) for item in sequence(fit, "warnings")]
    return rows


def of_leg(leg: object) -> list[str]:
    """The texts of a leg in a folder's summary, as its own page has them: warnings and what is not separable."""
    return [text_of(item) for key in ("warnings", "not_separable") for item in sequence(leg, key)]


def text_of(item: object) -> str:
    """A warning's text; an older result has the text only."""
    return str(item.get("text")) if isinstance(item, Mapping) else str(item)


def _without_joint(joint: str, text: str) -> str:
    """The text without its prefix, the joint's name, which the page shows separately."""
    return text.removeprefix(f"{joint}: ") if joint else text

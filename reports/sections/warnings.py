"""What to know before anything else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.reading import Json, Result
from reports.section import Section, mapping, sequence

_STAGES = {"source": "fit to the source", "target": "fit to the target", "refit": "fit with the chosen dampers"}


def content(result: Result) -> dict[str, Any]:
    """Every warning once: the design's own, the joints', the dampers' and the fits', each with its key."""
    found: dict[tuple[str, str], str] = {}
    joints = joint_names(result.content)
    for joint, text, key in _all(result.content):
        named = joint or next((name for name in joints if text.startswith(f"{name}: ")), "")
        found.setdefault((_bare(named, text), named), key)
    texts = {text for text, joint in found if joint}
    rows = [
        {"joint": joint, "text": text, "key": key} for (text, joint), key in found.items() if joint or text not in texts
    ]
    return {"warnings": rows}


def joint_names(document: Json) -> list[str]:
    """The joints of a design or a fit."""
    return list(mapping(document, "joints")) or list(mapping(document, "stages", "source", "joints"))


def _all(document: Json) -> list[tuple[str, str, str]]:
    """(joint or empty, text, key)."""
    rows: list[tuple[str, str, str]] = []
    for index, item in enumerate(sequence(document, "warnings")):
        joint, text = ("", item) if not isinstance(item, Mapping) else (item.get("joint") or "", item.get("text"))
        rows.append((str(joint), str(text), f"warnings[{index}]"))
    for name, joint in mapping(document, "joints").items():
        rows += [(name, str(text), f"joints.{name}.warnings") for text in sequence(joint, "warnings")]
    for name, law in mapping(document, "damper_laws").items():
        rows += [(name, str(text), f"damper_laws.{name}.warnings") for text in sequence(law, "warnings")]
    for stage in _STAGES:
        fit = mapping(document, "stages", stage)
        rows += [("", str(text), f"stages.{stage}.warnings") for text in sequence(fit, "warnings")]
    return rows


def _bare(joint: str, text: str) -> str:
    """The text without the joint's name before it, which stands beside it."""
    return text.removeprefix(f"{joint}: ") if joint else text


SECTION = Section("warnings", "Warnings", content)

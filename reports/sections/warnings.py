"""Every warning of a result, once each, with its level; the page's opening tells them."""

from __future__ import annotations

from collections.abc import Mapping

from synth.reports.reading import Json, Result
from synth.reports.section import mapping, sequence
from synth.reports.severity import Warned, judged

_STAGES = {"source": "fit to the source", "target": "fit to the target", "refit": "fit with the chosen dampers"}


def warnings_of(result: Result) -> list[Warned]:
    """Every warning once: the design's own, the joints', the dampers' and the fits', each with its key."""
    found: dict[tuple[str, str], tuple[str, object]] = {}
    joints = joint_names(result.content)
    for joint, text, key, level in _all(result.content):
        named = joint or next((name for name in joints if text.startswith(f"{name}: ")), "")
        found.setdefault((_bare(named, text), named), (key, level))
    texts = {text for text, joint in found if joint}
    return [
        judged(joint, text, key, level) for (text, joint), (key, level) in found.items() if joint or text not in texts
    ]


def joint_names(document: Json) -> list[str]:
    """The joints of a design or a fit."""
    return list(mapping(document, "joints")) or list(mapping(document, "stages", "source", "joints"))


def _all(document: Json) -> list[tuple[str, str, str, object]]:
    """(joint or empty, text, key, stated level)."""
    rows: list[tuple[str, str, str, object]] = []
    for index, item in enumerate(sequence(document, "warnings")):
        stated = mapping(item)
        joint, text = (stated.get("joint") or "", stated.get("text")) if isinstance(item, Mapping) else ("", item)
        rows.append((str(joint), str(text), f"warnings[{index}]", stated.get("severity")))
    for name, joint in mapping(document, "joints").items():
        rows += [(name, str(text), f"joints.{name}.warnings", None) for text in sequence(joint, "warnings")]
    for name, law in mapping(document, "damper_laws").items():
        rows += [(name, str(text), f"damper_laws.{name}.warnings", None) for text in sequence(law, "warnings")]
    for stage in _STAGES:
        fit = mapping(document, "stages", stage)
        rows += [("", str(text), f"stages.{stage}.warnings", None) for text in sequence(fit, "warnings")]
    return rows


def _bare(joint: str, text: str) -> str:
    """The text without the joint's name before it, which stands beside it."""
    return text.removeprefix(f"{joint}: ") if joint else text

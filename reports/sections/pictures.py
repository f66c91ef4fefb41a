"""Pictures of the parts, with the arm offset that they were made for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from synth.reports.reading import Result, png_uri
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

WHOLE = ("assembly", "leg")  # names of pictures of the whole leg


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """PNG pictures as data URIs; that of the whole leg is in the opening."""
    named = [item for item in sequence(result.content, "pictures") if isinstance(item, Mapping)]
    if not named:
        return AbsentResult("design.json names no picture")
    named = [item for item in named if PurePosixPath(str(item.get("path"))).stem not in WHOLE]
    shown, absent = [], []
    for item in named:
        name = str(item.get("path"))
        path = result.path(name)
        if path is None or path.suffix.lower() != ".png":
            absent.append(name)
        else:
            shown.append({"path": name, "caption": item.get("caption") or name, "uri": png_uri(path)})
    joints = mapping(result.content, "joints")
    offsets = {name: joint.get("arm_offset") for name, joint in joints.items() if isinstance(joint, Mapping)}
    frees = {name: mapping(joint, "spring").get("free_angle") for name, joint in joints.items()}
    included = {name: mapping(joint, "spring").get("included_angle") or
                mapping(joint, "spring", "make").get("included_angle") for name, joint in joints.items()}  # fmt: skip
    rows = [
        {"name": name, "offset": offset, "free": frees[name], "included": included[name]}
        for name, offset in offsets.items()
        if offset
    ]
    return {"pictures": shown, "absent": absent, "offsets": rows, "assembly": _assembly(result)}


def _assembly(result: Result) -> list[dict[str, Any]]:
    """The steps in which each joint is put together."""
    found = []
    for name, steps in mapping(result.content, "solids", "assembly").items():
        texts = [str(step.get("step")) for step in steps if isinstance(step, Mapping)]
        found.append({"name": name, "steps": texts})
    return found


SECTION = ReportSection("pictures", "Pictures of the parts", content)

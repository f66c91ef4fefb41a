"""Data for the leg's page, from ``page.json`` and ``leg.glb``: the leg in three dimensions, exchange of parts."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from synth.reports.quantities import text
from synth.reports.reading import Json, Result, value_of
from synth.reports.scripts import data_block
from synth.reports.section import mapping, sequence

GLB, PAGE = "parts/leg.glb", "page.json"
_MAGIC = b"glTF"


def live_data(result: Result) -> Json | None:
    """The content of ``page.json`` with the stops and parts of the design; None if it is not in the folder."""
    path = result.path(PAGE)
    if path is None:
        return None
    try:
        page = json.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError):
        return None
    if not isinstance(page, dict) or page.get("format") != "synth/page/1":
        return None
    design = mapping(result.content, "joints")
    for joint in sequence(page, "leg", "joints"):
        stops = [value_of(end) for end in sequence(design, str(joint.get("name")), "stops")]
        joint["stops"] = stops if len(stops) == 2 and None not in stops else joint.get("range")
        joint["fit"] = _fit(mapping(design, str(joint.get("name"))))
    page["parts"] = _parts(result, mapping(page, "bill"))
    page["within"] = value_of(mapping(result.content, "response", "forecast").get("within"))
    page["has_solids"] = _glb(result) is not None
    return page


def _fit(joint: Json) -> Json:
    """The fitted values that the sliders mark: with the chosen damper's law if there is such a fit."""
    wanted, refit = mapping(joint, "wanted"), mapping(joint, "refit")
    found = {key: refit.get(key) or wanted.get(key) for key in ("spring_rate", "free_angle")}
    return {**found, "law": "the chosen damper's law" if refit else "a linear damper"}


def glb_text(result: Result) -> str:
    """The whole leg's GLB, deflated, in base 64; empty without one."""
    data = _glb(result)
    return "" if data is None else base64.b64encode(zlib.compress(data)).decode("ascii")


def _glb(result: Result) -> bytes | None:
    path = result.path(GLB)
    data = path.read_bytes() if path is not None else b""
    return data if data[:4] == _MAGIC else None


def block(name: str, content: Any) -> Markup:
    """Data for the page's scripts, under an id of ours."""
    return Markup('<script type="application/json" id="{}">{}</script>').format(name, data_block(content))


def _parts(result: Result, bill: Json) -> list[Json]:
    """Every drawn part: its joint, the body that it moves with, its file, mass and line of the bill of materials."""
    listed = {str(item.get("path")): item for item in sequence(result.content, "files") if isinstance(item, Mapping)}
    found = []
    for part in sequence(result.content, "solids", "parts"):
        if not isinstance(part, Mapping):
            continue
        name = str(part.get("part"))
        files = [f"parts/{name}.{ending}" for ending in ("step", "stl") if f"parts/{name}.{ending}" in listed]
        moves = next((listed[file].get("moves_with") for file in files if listed[file].get("moves_with")), None)
        mass = part.get("mass")
        found.append(
            {
                "name": name,
                "joint": str(part.get("joint")),
                "family": str(part.get("family")),
                "moves_with": moves or part.get("moves_with"),
                "files": files,
                "material": str(part.get("material") or part.get("made") or ""),
                "mass": text(mass) if value_of(mass) is not None else "",
                "bill": str(bill.get(name, "")),
            }
        )
    return found

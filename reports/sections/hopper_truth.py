"""The models against the published leg: findings, heights, maps, influence of unpublished numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.hopper_map import Map, map_figure
from synth.reports.figures.model_bars import ModelBar, models_figure
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

MEASURES = {"clearance": "ground clearance", "total_height": "rise of the centre of mass"}
# m, clearance: Knaup & Aukes, simulation D and experiment.
PUBLISHED = (("22 cm predicted", 0.22), ("18.3 cm measured", 0.183))


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """One row a finding, one column a pose and measure."""
    rows: dict[str, dict[str, Any]] = {}
    for item in sequence(result.content, "claims"):
        if isinstance(item, Mapping):
            rows.setdefault(str(item["claim"]), {})[f"{item['pose']}, {item['measure']}"] = item
    if not rows:
        return AbsentResult("truth.json holds no findings")
    keys = list(next(iter(rows.values())))
    heads = []
    for key in keys:
        pose, _, measure = key.partition(", ")
        crouch = mapping(result.content, "poses", f"HP, {pose}").get("crouch_upper")
        heads.append({"pose": pose, "crouch": crouch, "measure": MEASURES.get(measure, measure)})
    over = []
    for pose in mapping(result.content, "poses").values():
        built = [value_of(mapping(pose, "models", model, "at_the_built", "total_height")) for model in ("D", "full")]
        over += [100 * (built[0] / built[1] - 1)] if built[0] and built[1] else []
    counts = [sum(bool(row[key]["comes_out"]) for row in rows.values()) for key in keys]
    return {"rows": rows, "keys": keys, "heads": heads, "counts": counts, "total": len(rows), "over": over}


def heights(result: Result) -> dict[str, Any] | AbsentResult:
    """The built leg by every model in both poses."""
    shown = []
    for name, pose in mapping(result.content, "poses").items():
        for measure, words in MEASURES.items():
            bars = []
            for model, found in mapping(pose, "models").items():
                height = mapping(found, "at_the_built", measure)
                low, high = height.get("interval90") or (None, None)
                bars.append(ModelBar(model, value_of(height) or 0.0, low, high))
                if model == "B" and (own := mapping(pose, "C", "own_contact", measure)):
                    bars.append(ModelBar("C, own contact", value_of(own) or 0.0))
            title = f"{name} pose: {words} of 12 cm and 210:1"
            shown.append({"title": title, "svg": models_figure(title, bars, PUBLISHED)})
    return {"figures": shown, "poses": mapping(result.content, "poses")} if shown else AbsentResult("no pose")


def maps(result: Result) -> dict[str, Any] | AbsentResult:
    """Models D and full over ratio and length, their best ringed, the built leg as a diamond."""
    shown = []
    for name, pose in mapping(result.content, "poses").items():
        for model in ("A", "D", "full"):
            found = mapping(pose, "maps", model)
            best = mapping(pose, "models", model, "best", "clearance")
            if not found or not best:
                continue
            data = Map(found["gear_ratio"], found["leg_length_m"], found["clearance_m"])
            picked = (float(best["gear_ratio"]), value_of(best["leg_length"]) or 0.0)
            title = f"{name} pose, model {model}: clearance"
            shown.append({"title": title, "svg": map_figure(title, data, (), picked, (210.59, 0.12))})
    return {"figures": shown} if shown else AbsentResult("no map")


def sensitivities(result: Result) -> dict[str, Any] | AbsentResult:
    """Heights of the built leg with one unpublished number changed at a time."""
    found = mapping(result.content, "sensitivities")
    return {"poses": found} if found else AbsentResult("none were computed")


SECTION = ReportSection("hopper-truth", "Reproduced findings", content)
HEIGHTS = ReportSection("hopper-heights", "The built leg by every model", heights)
MAPS = ReportSection("hopper-maps", "Ratio and length", maps)
SENSITIVITIES = ReportSection("hopper-sensitivities", "Unpublished numbers", sensitivities)

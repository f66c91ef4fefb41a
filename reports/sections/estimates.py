"""Wanted spring rate, damper rate and free angle, their uncertainty, and the effect of the free angle's treatment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from markupsafe import Markup

from synth.reports.figures.interval_bars import IntervalRow, interval_figure
from synth.reports.figures.svg import shorten
from synth.reports.quantities import in_si, interval_of, percent
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

# Stage -> what it is. A fit.json is a stage of its own, under the empty name.
_STAGES = {
    "source": "the recorded leg: with its own links and time scale",
    "target": "wanted: the robot's links, moving like the recorded leg in scaled time",
    "refit": "spring and free angle refitted with the chosen dampers' curves",
    "": "the recorded leg",
}
_RATES = (("spring_rate", "k"), ("damper_rate", "b"))
NAMED = 3  # numbers of the leg file that are named beside an interval
LEAST_SHARE = 0.02  # of the variance, that is worth naming


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Estimates by joint and stage, the free angle's variants by stage, and what is not separable."""
    fits = stages_of(result)
    if not fits:
        return AbsentResult(f"{result.name} holds no fit")
    joints = list(dict.fromkeys(name for fit in fits.values() for name in mapping(fit, "joints")))
    rows = []
    for joint in joints:
        stages = [_row(stage, fit, joint) for stage, fit in fits.items() if joint in mapping(fit, "joints")]
        rows.append({"name": joint, "stages": stages})
    choices = [choice for stage, fit in fits.items() if (choice := _choice(stage, fit))]
    return {
        "joints": rows,
        "stages": [{"name": stage, "what": _STAGES[stage]} for stage in fits],
        "single": "" in fits,
        "choices": sorted(choices, key=lambda choice: choice["stage"] != "target"),
        "not_separable": _by_text(fits, "not_separable", str),
        "families": [family for stage, fit in fits.items() for family in _families(stage, fit, result)],
        "proposals": _by_text(fits, "proposals", lambda item: str(mapping(item).get("text", ""))),
        "static": [
            {"stage": stage, **point}
            for stage, fit in fits.items()
            for point in sequence(fit, "static")
            if isinstance(point, dict)
        ],
        "sources": [row for stage, fit in fits.items() for row in _sources(stage, fit)],
        "refits": [found for stage, fit in fits.items() if (found := _refits(stage, fit))],
    }


def _families(stage: str, fit: Json, result: Result) -> list[Json]:
    """Springs and dampers that fit a joint about equally well, the reported one marked, and the chosen spring."""
    found = []
    for family in sequence(fit, "families"):
        joint = str(mapping(family).get("joint"))
        reported = in_si(mapping(fit, "joints", joint, "spring_rate"))
        members = [
            {**member, "reported": in_si(mapping(member, "spring_rate")) == reported}
            for member in sequence(mapping(family), "members")
            if isinstance(member, dict)
        ]
        chosen = mapping(result.content, "joints", joint, "spring") if stage == "target" else {}
        rate = chosen.get("rate") or mapping(chosen, "make").get("rate")
        found.append({"stage": stage, "joint": joint, "members": members, "chosen": rate})
    return found


def _sources(stage: str, fit: Json) -> list[Json]:
    """Sources of each interval: the trials' share of the variance, and the largest shares of the leg file's values."""
    rows = []
    for source in sequence(fit, "interval_sources"):
        shares = {name: float(share) for name, share in mapping(source, "shares").items()}
        trials = shares.pop("trials", 0.0)
        ranked = sorted(shares.items(), key=lambda item: -item[1])[:NAMED]
        joint, kind = str(mapping(source).get("joint")), str(mapping(source).get("quantity"))
        rows.append({
            "stage": stage,
            "joint": joint,
            "quantity": kind.replace("_", " "),
            "estimate": mapping(fit, "joints", joint, kind),
            "trials": f"{100 * trials:.0f}\u00a0%",
            "links": ", ".join(f"{name} {100 * share:.0f}\u00a0%" for name, share in ranked if share >= LEAST_SHARE),
        })  # fmt: skip
    return rows


def _refits(stage: str, fit: Json) -> Json | None:
    """Summary of the bootstrap's refits, if the intervals come from them."""
    intervals = mapping(fit, "intervals")
    if intervals.get("by") != "bootstrap":
        return None
    ratios = [float(value) for value in mapping(intervals, "over_sensitivities").values()]
    return {
        "stage": stage,
        "refits": intervals.get("refits"),
        "settled": intervals.get("settled"),
        "least": f"{min(ratios):.2f}",
        "greatest": f"{max(ratios):.2f}",
    }


def stages_of(result: Result) -> dict[str, Json]:
    """The fits of a result by stage, in the order in which they were made."""
    if "stages" not in result.content:
        return {"": result.content} if mapping(result.content, "joints") else {}
    found = {stage: mapping(result.content, "stages", stage) for stage in ("source", "target", "refit")}
    return {stage: fit for stage, fit in found.items() if mapping(fit, "joints")}


def _row(stage: str, fit: Json, joint: str) -> Json:
    return {
        "stage": stage or "fit",
        "wanted": stage == "target",
        "estimates": mapping(fit, "joints", joint),
        "rms": mapping(fit, "rms").get(joint),
        "noise": mapping(fit, "noise").get(joint),
    }


def _choice(stage: str, fit: Json) -> Json | None:
    """The free angle's variants of one stage; None if there is nothing to compare."""
    free = mapping(fit, "free_angle")
    variants = [variant for variant in sequence(free, "variants") if isinstance(variant, dict)]
    mode = free.get("mode")
    if len(variants) < 2:
        return {"stage": stage, "mode": mode, "why": free.get("why"), "table": [], "figure": None} if mode else None
    used = next((variant for variant in variants if variant.get("free_angle") == mode), variants[0])
    table = []
    for joint in mapping(fit, "joints"):
        for variant in variants:
            entry: Json = {"joint": joint, "free_angle": variant.get("free_angle"), "used": variant is used}
            for key, _ in _RATES:
                quantity = mapping(variant, key).get(joint)
                entry[key] = quantity
                reference = value_of(mapping(used, key).get(joint))
                apart = quantity is not None and variant is not used
                entry[f"{key}_off"] = percent(value_of(quantity), reference) if apart else ""
            entry["rms"] = mapping(variant, "rms").get(joint)
            entry["spread"] = mapping(variant, "free_angle_spread").get(joint)
            table.append(entry)
    figure = _figure(stage, list(mapping(fit, "joints")), variants, used)
    return {"stage": stage, "mode": mode, "why": free.get("why"), "table": table, "figure": figure,
            "n_variant": len(variants), "damper": any(row["damper_rate"] for row in table)}  # fmt: skip


def _figure(stage: str, joints: list[str], variants: list[Json], used: Json) -> Markup | None:
    """Rates of each variant over those of the one used."""
    rows: list[IntervalRow] = []
    for joint in joints:
        first = True
        for key, symbol in _RATES:
            reference = in_si(mapping(used, key).get(joint))
            if not reference:
                continue
            for group, variant in enumerate(variants):
                quantity = mapping(variant, key).get(joint)
                value = in_si(quantity)
                if value is None:
                    continue
                scale = value / (value_of(quantity) or 1.0) / reference
                low, high = interval_of(quantity) or (None, None)
                treatment = str(variant.get("free_angle")).replace("_", " ")
                label = f"{shorten(joint, 14)} {symbol}, {treatment}"
                ends = (None if low is None else low * scale, None if high is None else high * scale)
                rows.append(IntervalRow(label, group, value / reference, *ends, first))
                first = False
    title = f"Spring and damper rates by treatment of the free angle{f', stage {stage}' if stage else ''}"
    return interval_figure(title, "rate over that of the treatment used", rows) if rows else None


def _by_text(fits: dict[str, Json], key: str, text_of: Callable[[Any], str]) -> list[Json]:
    """Each sentence under ``key`` once, with its stages."""
    found: dict[str, list[str]] = {}
    for stage, fit in fits.items():
        for item in sequence(fit, key):
            found.setdefault(text_of(item), []).append(stage)
    return [{"text": text, "stages": [stage for stage in stages if stage]} for text, stages in found.items()]


SECTION = ReportSection("estimates", "Spring rate, damper rate and free angle", content)

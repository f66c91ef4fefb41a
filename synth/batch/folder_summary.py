"""All fits of a folder in one table and one JSON, read from what each fit wrote."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import synth
from synth.errors import Problem

FORMAT = "synth/fits/1"
ESTIMATES = ("spring_rate", "damper_rate", "free_angle")
UNITS = {"spring_rate": "N*m/rad", "damper_rate": "N*m*s/rad", "free_angle": "deg"}


@dataclass(frozen=True)
class Failed:
    """A project that could not be fitted, and why; ``crash`` True where the fault is this program's."""

    name: str
    messages: tuple[str, ...]
    crash: bool = False


def fits_json(folder: Path, fitted: Sequence[str], failed: Sequence[Failed]) -> dict[str, Any]:
    """The content of ``fits.json``, from the ``fit.json`` of each of ``fitted`` below ``folder``/legs."""
    legs = []
    for name in fitted:
        found = json.loads((folder / "legs" / name / "fit.json").read_text(encoding="utf-8"))
        legs.append(
            {
                "name": name,
                "fit": f"legs/{name}/fit.json",
                "report": f"legs/{name}/report.html",
                "trials": sum(not trial["held_out"] for trial in found["trials"]),
                "joints": {
                    j: {k: e for k, e in joint.items() if k in ESTIMATES} for j, joint in found["joints"].items()
                },
                "rms": found["rms"],
                "free_angle": found["free_angle"]["mode"],
                "warnings": found["warnings"],
                "not_separable": found["not_separable"],
            }
        )
    return {
        "format": FORMAT,
        "versions": {"synth": synth.__version__},
        "legs": legs,
        "failed": [{"name": f.name, "messages": list(f.messages), "crash": f.crash} for f in failed],
    }


def table(content: Mapping[str, Any]) -> dict[str, list[Any]]:
    """``fits.csv``: a row a joint of each leg, and a row for each project that failed."""
    columns: dict[str, list[Any]] = {"leg": [], "state": [], "joint": [], "trials": []}
    for key in ESTIMATES:
        columns |= {f"{key}{end} [{UNITS[key]}]": [] for end in ("", " low", " high")}
    columns |= {"rms [deg]": [], "warnings": [], "message": []}
    for leg in content["legs"]:
        for joint, estimates in leg["joints"].items():
            row: list[Any] = [leg["name"], "fitted", joint, leg["trials"]]
            for key in ESTIMATES:
                estimate = estimates.get(key)
                low, high = (estimate or {}).get("interval90") or (None, None)
                row += [None if estimate is None else estimate["value"], low, high]
            row += [leg["rms"].get(joint, {}).get("value"), len(leg["warnings"]), None]
            _add(columns, row)
    for item in content["failed"]:
        _add(columns, [item["name"], "failed", *[None] * (len(columns) - 3), " | ".join(item["messages"])])
    return columns


def _estimates(joint: Mapping[str, Any]) -> dict[str, Any]:
    return {key: estimate for key, estimate in joint.items() if key in ESTIMATES}


def _add(columns: dict[str, list[Any]], row: Sequence[Any]) -> None:
    for column, value in zip(columns.values(), row, strict=True):
        column.append(value)


def messages(problems: Sequence[Problem]) -> tuple[str, ...]:
    """Problems as one line each, of text that any file can hold."""
    texts = (str(problem).encode("utf-8", "backslashreplace").decode("utf-8") for problem in problems)
    return tuple(" ".join(text.split()) for text in texts)

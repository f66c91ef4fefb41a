"""All fits of a folder in one table, read from the files of each fit; failed projects of any kind of work."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.errors import Problem

ESTIMATES = ("spring_rate", "damper_rate", "free_angle")
UNITS = {"spring_rate": "N*m/rad", "damper_rate": "N*m*s/rad", "free_angle": "deg"}


@dataclass(frozen=True)
class Failed:
    """A project that failed, with messages; ``crash`` True after an internal error."""

    name: str
    messages: tuple[str, ...]
    crash: bool = False


def fit_entry(name: str, folder: Path) -> dict[str, Any]:
    """A leg of ``fits.json`` from the ``fit.json`` in its folder."""
    found = json.loads((folder / "fit.json").read_text(encoding="utf-8"))
    return {
        "name": name,
        "fit": f"legs/{name}/fit.json",
        "report": f"legs/{name}/report.html",
        "trials": sum(not trial["held_out"] for trial in found["trials"]),
        "joints": {j: {k: e for k, e in joint.items() if k in ESTIMATES} for j, joint in found["joints"].items()},
        "rms": found["rms"],
        "free_angle": found["free_angle"]["mode"],
        "warnings": found["warnings"],
        "not_separable": found["not_separable"],
    }


def fit_columns(content: Mapping[str, Any]) -> dict[str, list[Any]]:
    """``fits.csv``: a row per joint of each leg, and one per failed project; ``warnings`` as ``synth fit`` counts.

    An unknown free angle has its interval and no value.
    """
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
                known = estimate is not None and not estimate.get("unknown")
                row += [estimate["value"] if known else None, low, high]
            row += [leg["rms"].get(joint, {}).get("value"), len(leg["warnings"]) + len(leg["not_separable"]), None]
            add_row(columns, row)
    add_failed(columns, content)
    return columns


def add_failed(columns: dict[str, list[Any]], content: Mapping[str, Any]) -> None:
    """Append a row for each project that failed: name and state in the first columns, messages in the last."""
    for item in content["failed"]:
        add_row(columns, [item["name"], "failed", *[None] * (len(columns) - 3), " | ".join(item["messages"])])


def add_row(columns: dict[str, list[Any]], row: Sequence[Any]) -> None:
    """Append one cell to each column, in the columns' order."""
    for column, value in zip(columns.values(), row, strict=True):
        column.append(value)


def messages(problems: Sequence[Problem]) -> tuple[str, ...]:
    """Problems as one line each, in characters that any file can hold."""
    texts = (str(problem).encode("utf-8", "backslashreplace").decode("utf-8") for problem in problems)
    return tuple(" ".join(text.split()) for text in texts)

"""Many diagnoses: ``synth gap`` on a folder of projects, of swinging and of jumping legs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from synth.api.gaps import CheckedGap, gap, read_gap, with_checked_trials
from synth.api.jump_gaps import jump_gap, read_jump_gap
from synth.batch.folder_summary import add_failed, add_row
from synth.batch.folder_task import FolderTask, files_of, identity_of
from synth.files.gap_kind import is_hopper_gap
from synth.files.hopper_gap_project import HopperGapProject
from synth.parts.catalogs import Catalogue
from synth.reports.many_pages import write_gaps_report
from synth.units import factor

JumpTask = tuple[HopperGapProject, Catalogue]
LIKELIEST = 3  # causes of each leg in the summary; its own gap.json lists all
EXPLAINED = ("effect", "joint", "parameters")
STAGES = ("as_designed", "before", "after", "noise_floor")


def gaps() -> FolderTask:
    """The task; its projects are checked here and diagnosed by the workers."""
    return FolderTask(
        kind="gap",
        made="gaps",
        done="diagnosed",
        read=_read_project,
        identity=lambda given: identity_of(_project(given)),
        checked=lambda given: len(_project(given).trials),
        files=gap_files,
        entry=_entry,
        columns=_columns,
        page=write_gaps_report,
    )


def gap_files(given: CheckedGap | JumpTask) -> dict[str, bytes]:
    """A diagnosis's files, content by relative name: a worker's result on any machine."""
    return files_of((gap(given) if isinstance(given, CheckedGap) else jump_gap(*given)).write)


def _read_project(path: Path) -> CheckedGap | JumpTask:
    if is_hopper_gap(path):
        project, catalogue, _ = read_jump_gap(path)
        return project, catalogue
    return with_checked_trials(read_gap(path))


def _project(given: CheckedGap | JumpTask) -> Any:
    return given.project if isinstance(given, CheckedGap) else given[0]


def _entry(name: str, folder: Path) -> dict[str, Any]:
    """A leg of ``gaps.json``, from its ``gap.json``."""
    found = json.loads((folder / "gap.json").read_text(encoding="utf-8"))
    return {
        "name": name,
        "gap": f"legs/{name}/gap.json",
        "report": f"legs/{name}/report.html",
        "trials": len(found["trials"]),
        "verdict": found["verdict"],
        "sentence": found["sentence"],
        "explanation": [{key: cause[key] for key in EXPLAINED} for cause in found["explanation"]],
        "ranked": [
            {key: cause[key] for key in ("effect", "joint", "probability", "shrink")}
            for cause in found["ranked"][:LIKELIEST]
        ],
        "probability_none": found["probability_none"],
        "probability_unknown": found["probability_unknown"],
        "where": found["where"]["joint"],
        "rms": {stage: found["gap"][stage] for stage in STAGES},
        "warnings": found["warnings"],
    }


def _columns(content: Mapping[str, Any]) -> dict[str, list[Any]]:
    """``gaps.csv``: one row per leg with its explanation and most probable single cause; then the failed ones."""
    heads = ["leg", "state", "trials", "verdict", "explanation", "likeliest", "joint", "probability [1]", "shrink [1]"]
    heads += ["shrink low [1]", "shrink high [1]", "none [1]", "unknown [1]"]
    heads += [f"{stage.replace('_', ' ')} [deg]" for stage in STAGES]
    columns: dict[str, list[Any]] = {head: [] for head in (*heads, "warnings", "message")}
    for leg in content["legs"]:
        causes = " + ".join(f"{cause['effect']} {cause['joint']}" for cause in leg["explanation"])
        first = leg["ranked"][0] if leg["ranked"] else {}
        shrink = first.get("shrink") or {}
        low, high = shrink.get("interval90") or (None, None)
        row = [leg["name"], "diagnosed", leg["trials"], leg["verdict"], causes or None]
        row += [first.get("effect"), first.get("joint"), first.get("probability"), shrink.get("value"), low, high]
        row += [leg["probability_none"], leg["probability_unknown"]]
        row += [_degrees(leg["rms"][stage]) for stage in STAGES]
        add_row(columns, [*row, len(leg["warnings"]), None])
    add_failed(columns, content)
    return columns


def _degrees(quantity: Mapping[str, Any] | None) -> float | None:
    if not quantity or quantity.get("value") is None:
        return None
    return float(quantity["value"]) * factor(quantity["unit"], "deg")

"""Many designs: ``synth leg`` on a folder of projects."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.api.design_input import read_design
from synth.api.designs import design
from synth.batch.folder_summary import add_failed, add_row
from synth.batch.folder_task import FolderTask, files_of, identity_of
from synth.files.leg_project import LegProject
from synth.parts.catalogs import Catalogue
from synth.remarks import of_joint
from synth.reports.many_pages import write_legs_report

WANTED = ("spring_rate", "damper_rate", "free_angle")
UNITS = {"spring_rate": "N*m/rad", "damper_rate": "N*m*s/rad", "free_angle": "deg"}


@dataclass(frozen=True, eq=False)
class LegTask:
    """A design to make: its project, the parts to choose from, and the solids to draw."""

    project: LegProject
    catalogue: Catalogue
    solids: bool
    pictures: bool


def legs(
    with_options: Callable[[LegProject, Catalogue], LegProject], *, solids: bool = True, pictures: bool = True
) -> FolderTask:
    """The task; ``with_options`` applies the command line's options to each project."""

    def read(path: Path) -> LegTask:
        project, catalogue = read_design(path)
        return LegTask(with_options(project, catalogue), catalogue, solids, pictures)

    def identity(task: LegTask) -> dict[str, str]:
        asked = {"parts": repr(task.project.parts), "drawn": f"{solids} {pictures}"}
        return identity_of(task.project) | asked

    return FolderTask(
        kind="leg-design",
        made="legs",
        done="designed",
        read=read,
        identity=identity,
        checked=lambda task: len(task.project.trials),
        files=leg_files,
        entry=_entry,
        columns=_columns,
        page=write_legs_report,
        refused=lambda entry: tuple(entry["failed_checks"]),
    )


def leg_files(task: LegTask) -> dict[str, bytes]:
    """A design's files, content by relative name; ``design.json`` names checks that the solids failed."""
    made = design(task.project, task.catalogue, solids=task.solids)
    return files_of(lambda folder: made.write_with(folder, pictures=task.pictures))


def _entry(name: str, folder: Path) -> dict[str, Any]:
    """A leg of ``legs.json``, from its ``design.json``."""
    found = json.loads((folder / "design.json").read_text(encoding="utf-8"))
    return {
        "name": name,
        "design": f"legs/{name}/design.json",
        "report": f"legs/{name}/report.html",
        "joints": {
            joint: {"wanted": about["wanted"], "spring": _part(about["spring"]), "damper": _part(about["damper"])}
            for joint, about in found["joints"].items()
        },
        "rms": found["response"]["wanted_to_built"]["rms"],
        "joint_rms": found["response"]["wanted_to_built"]["joints"],
        "another_motion": found["response"].get("animal_to_wanted", {}).get("another_motion", []),
        "failed_checks": [check["text"] for check in found["solids"]["checks"] if not check["passed"]],
        "drawn": found["solids"]["drawn"],
        "warnings": [of_joint(item["joint"], item["text"]) for item in found["warnings"]],
    }


def _part(about: Mapping[str, Any] | None) -> str | None:
    """A joint's part in words: of a catalogue, or a spring to make; None if there is none."""
    if not about:
        return None
    if about.get("make"):
        return "to make"
    return about.get("part")


def _columns(content: Mapping[str, Any]) -> dict[str, list[Any]]:
    """``legs.csv``: one row per joint of each leg, and one per failed project."""
    columns: dict[str, list[Any]] = {"leg": [], "state": [], "joint": []}
    columns |= {f"wanted {key.replace('_', ' ')} [{UNITS[key]}]": [] for key in WANTED}
    columns |= {"spring": [], "damper": [], "rms [deg]": [], "leg rms [deg]": [], "animal's motion": []}
    columns |= {"warnings": [], "message": []}
    for leg in content["legs"]:
        failed = " | ".join(leg["failed_checks"])
        for joint, about in leg["joints"].items():
            row = [leg["name"], "check failed" if failed else "designed", joint]
            row += [(about["wanted"].get(key) or {}).get("value") for key in WANTED]
            row += [about["spring"], about["damper"], leg["joint_rms"][joint]["value"], leg["rms"]["value"]]
            row.append("another" if joint in leg["another_motion"] else "made")
            add_row(columns, [*row, len(leg["warnings"]), failed or None])
    add_failed(columns, content)
    return columns

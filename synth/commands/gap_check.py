"""``synth gap --check``: seconds, before any fit, what the recordings can tell and what is wrong with them."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.commands.table_text import table_text

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.files.gap_project import GapProject

Json = Mapping[str, Any]
MOST_FINDINGS = 8  # on the screen; JSON and page have all
MOST_CLUSTERS = 6  # on the screen, too
# Causes whose smallest size people ask for first; the others stand in the JSON and on the page.
ASKED = ("coulomb_friction", "backlash", "spring_preload", "spring_hysteresis", "latency", "link_mass")


def run_check(arguments: argparse.Namespace, progress: Progress, project: GapProject) -> int:
    """Check the recordings; print the answer, and write ``check.json`` and a page where ``--out`` is given."""
    from synth.diagnosis.check.run import check

    progress.compiling(len(project.leg.joints))
    with progress.stage("checking"), ExitStack() as open_stage:

        def say(text: str) -> None:
            open_stage.close()
            open_stage.enter_context(progress.stage(text))

        found = check(project, say)
    document = found.as_json()
    if arguments.out:
        from synth.files.output import output_folder, write_json
        from synth.reports import write_check_report

        with output_folder(arguments.out) as folder:
            write_json(folder / "check.json", document)
            write_check_report(folder)
    if progress.as_json:
        from synth.files.text_forms import json_text, plain

        progress.document(json_text(plain(document, ""), 0))
    else:
        progress.result(check_text(document))
    if arguments.out:
        progress.say(f"check: {Path(arguments.out) / 'check.json'}")
        progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def check_text(content: Json) -> str:
    """The answer, what is wrong, the smallest sizes that show, and what passes for what."""
    parts = [str(content["sentence"]), *_findings(content["findings"])]
    if content["causes"]:
        share = f"{100 * content['remainder_assumed']:g} %"
        parts += ["", f"smallest that these trials show, as read and with {share} of the motion left unexplained:"]
        parts.append(_sizes(content["causes"]))
    if content["not_told_apart"]:
        parts += ["", "these pass for each other:", *_clusters(content["not_told_apart"])]
    return "\n".join(parts)


def _findings(findings: Sequence[Json]) -> list[str]:
    lines = []
    for finding in findings[:MOST_FINDINGS]:
        place = ", ".join(part for part in (finding["recording"], finding["joint"]) if part)
        remedy = f" -> {finding['remedy']}" if finding["remedy"] else ""
        lines.append(f"{finding['level']}: {place}{': ' if place else ''}{finding['text']}{remedy}")
    if len(findings) > MOST_FINDINGS:
        lines.append(f"and {len(findings) - MOST_FINDINGS} more")
    return lines


def _sizes(causes: Sequence[Json]) -> str:
    """A row a cause that people ask for, a column a joint."""
    joints = list(dict.fromkeys(cause["joint"] for cause in causes if cause["joint"] not in ("base", "all")))
    shown = {(cause["effect"], cause["joint"]): cause["visible_from"] for cause in causes}
    rows = [["", *joints]]
    for effect in ASKED:
        if any((effect, joint) in shown for joint in joints):
            rows.append([effect.replace("_", " "), *(_size(shown.get((effect, joint), {})) for joint in joints)])
    return table_text(rows)


def _size(visible: Json | None) -> str:
    """The first strength; ``none`` where no size would show, ``-`` where the cause cannot act."""
    if visible is None:
        return "none"
    if not visible:
        return "-"
    first = next(iter(visible.values()))
    return f"{first['value']:.2g} {first['unit']}"


def _clusters(clusters: Sequence[Json]) -> list[str]:
    lines = []
    for cluster in clusters[:MOST_CLUSTERS]:
        names = ", ".join(f"{c['effect'].replace('_', ' ')} ({c['joint']})" for c in cluster["causes"])
        remedy = f" -> {cluster['remedy']}" if cluster["remedy"] else " -> no trial of the usual kinds parts them"
        lines.append(f"- {names}{remedy}")
    if len(clusters) > MOST_CLUSTERS:
        lines.append(f"and {len(clusters) - MOST_CLUSTERS} more groups")
    return lines

"""``synth gap --check``: problems of the recordings and what they can distinguish, in seconds and without a fit."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.commands.table_text import table_text
from synth.units import significant

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.files.gap_project import GapProject

Json = Mapping[str, Any]
MOST_FINDINGS = 8  # on the screen; JSON and page list all
MOST_CLUSTERS = 6  # on the screen; JSON and page list all
# Effects shown on the screen; the JSON and the page list all. Those of a drive have a row where some joint has it.
ASKED = ("coulomb_friction", "backlash", "spring_preload", "spring_hysteresis", "latency", "link_mass")
OF_TORQUES = ("torque_gain", "torque_offset", "torque_delay")
OF_SERVOS = ("servo_gain", "dead_band", "command_delay", "command_rate_limit", "gear_play")
OF_MOTORS = ("torque_constant", "winding_resistance", "current_limit", "gear_friction", "voltage_sag")


def run_check(arguments: argparse.Namespace, progress: Progress, project: GapProject) -> int:
    """Check the recordings and print the answer; write ``check.json`` and a page if ``--out`` is given."""
    from synth.api.report import stage_by_stage
    from synth.diagnosis.check.run import check

    progress.compiling(len(project.leg.joints))
    with progress.stage("checking"), stage_by_stage(progress.stage) as say:
        found = check(project, say)
    document = found.as_json()
    if arguments.out:
        from synth.files.input_hashes import input_files
        from synth.files.output import output_folder, write_json
        from synth.reports import write_check_report

        with output_folder(arguments.out, inputs=input_files(project)) as folder:
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
    """The answer, the findings, the smallest detectable sizes, and causes that cannot be separated."""
    parts = [str(content["sentence"]), *_findings(content["findings"])]
    if content["causes"]:
        share = f"{100 * content['remainder_assumed']:g} %"
        parts += ["", f"smallest detectable size, at the noise floor and with {share} of the motion unexplained:"]
        parts.append(_sizes(content["causes"]))
    if content["not_told_apart"]:
        parts += ["", "cannot be separated:", *_clusters(content["not_told_apart"])]
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
    """One row per common cause, one column per joint."""
    joints = list(dict.fromkeys(cause["joint"] for cause in causes if cause["joint"] not in ("base", "all")))
    shown = {(cause["effect"], cause["joint"]): cause for cause in causes}
    rows = [["", *joints]]
    for effect in (*ASKED, *OF_TORQUES, *OF_SERVOS, *OF_MOTORS):
        if any((effect, joint) in shown for joint in joints):
            rows.append([effect.replace("_", " "), *(_size(shown.get((effect, joint))) for joint in joints)])
    return table_text(rows)


def _size(cause: Json | None) -> str:
    """The first strength, ``at most`` it of a limit; ``none`` where no size is detectable, ``-`` without the cause."""
    if cause is None:
        return "-"
    visible, only = cause["visible_from"], cause.get("only_from")
    shown = visible or only
    if not shown:
        return "none" if visible is None else "-"
    first = next(iter(shown.values()))
    size = f"{'at most ' if cause.get('limit') else ''}{significant(first['value'], 2)} {first['unit']}"
    stated = cause.get("stated", {}).get(next(iter(shown)))
    if stated:
        size = f"a change of {size} from the stated {significant(stated['value'], 3)}"
    return size if visible else f"only from {size}, implausible"


def _clusters(clusters: Sequence[Json]) -> list[str]:
    from synth.diagnosis.check.separability import LEAST_SINE  # imported here, like the check

    lines = []
    for cluster in clusters[:MOST_CLUSTERS]:
        names = ", ".join(f"{c['effect'].replace('_', ' ')} ({c['joint']})" for c in cluster["causes"])
        sine = cluster["sine_with_trial"]
        then = significant(1.0 / sine, 2) if sine > LEAST_SINE else f"more than {significant(1.0 / LEAST_SINE, 2)}"
        helps = f" -> {cluster['remedy']} (then from {then} times the smallest size)"
        remedy = helps if cluster["remedy"] else " -> no usual kind of trial separates them"
        lines.append(f"- {names}{remedy}")
    if len(clusters) > MOST_CLUSTERS:
        more = len(clusters) - MOST_CLUSTERS
        lines.append(f"and {more} more group{'' if more == 1 else 's'}")
    return lines

"""The main cause on six real rigs, from each half of the recordings: ``python -m real_rigs``.

Each rig is diagnosed twice: learnt from one half and scored on the other, and the other way round. See ``make rigs``.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from real_rigs.recorded import RIGS, absent
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project


def half_of(name: str, folder: Path, half: int) -> dict[str, Any]:
    """Result of ``synth gap`` on one half: verdict, first causes, and reduction of the gap on unseen trials."""
    begun = time.process_time()
    project = read_gap_project(RIGS[name](folder).project(folder, half))
    found = diagnose(project.leg, project.trials, project.tolerance, seed=project.seed).as_json()
    ranked = found["ranked"]
    return {
        "verdict": found["verdict"],
        "first": [[cause["effect"], cause["joint"]] for cause in ranked[:3]],
        "probability": ranked[0]["probability"] if ranked else None,
        "shrink": ranked[0].get("shrink", {}).get("value") if ranked else None,
        "shrink_of_all": found["gap"]["shrink"]["value"],
        "remainder_times_noise": found["remainder"]["times_noise"],
        "explanation": [[cause["effect"], cause["joint"]] for cause in found["explanation"]],
        "tied": [[[cause["effect"], cause["joint"]] for cause in other] for other in found["tied"]],
        "parameters": [cause["parameters"] for cause in found["explanation"]],
        "none": found["probability_none"],
        "unknown": found["probability_unknown"],
        "as_designed": found["gap"]["as_designed"]["value"],
        "before": found["gap"]["before"]["value"],
        "after": found["gap"]["after"]["value"],
        "noise_floor": found["gap"]["noise_floor"]["value"],
        "processor": round(time.process_time() - begun, 1),
    }


def row(name: str, halves: list[dict[str, Any]]) -> str:
    """One rig as lines of text: one per half, and whether they agree."""
    lines = []
    for letter, half in zip("ab", halves, strict=True):
        first = " (".join(half["first"][0]) + ")" if half["first"] else "nothing"
        odds = f" p {half['probability']:.2f}, takes {half['shrink']:.0%}" if half["first"] else ""
        named = " + ".join(f"{effect} ({joint})" for effect, joint in half["explanation"]) or "-"
        lines.append(
            f"{name:16s} {letter}  {half['verdict']:8s} {first:32s}{odds:22s} "
            f"{half['as_designed']:6.2f} {half['before']:6.2f} {half['after']:6.2f} {half['noise_floor']:7.4f} deg  "
            f"{half['processor']:5.0f} s  {named}"
        )
    lines.append(f"{'':16s}    the halves {'agree' if said_first(halves[0]) == said_first(halves[1]) else 'DISAGREE'}")
    return "\n".join(lines)


def said_first(half: dict[str, Any]) -> list[str] | None:
    """Effect and joint of the first cause; None for the verdict ``none``."""
    first: list[str] | None = half["first"][0] if half["first"] and half["verdict"] != "none" else None
    return first


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="real_rigs", description=__doc__)
    parser.add_argument("--to", type=Path, required=True, help="folder for rigs.json")
    parser.add_argument("--only", nargs="*", choices=list(RIGS), help="these rigs alone")
    asked = parser.parse_args(words)
    missing = absent()
    if missing:
        print(f"not here: {', '.join(missing)}", file=sys.stderr)  # noqa: T201
        return 1
    told: dict[str, list[dict[str, Any]]] = {}
    print("rig, half, verdict, first cause; RMS on the other half: as designed, before, after, noise floor")  # noqa: T201
    for name in asked.only or RIGS:
        with tempfile.TemporaryDirectory() as folder:
            told[name] = [half_of(name, Path(folder), half) for half in (0, 1)]
        print(row(name, told[name]), flush=True)  # noqa: T201
    agreed = sum(said_first(h[0]) == said_first(h[1]) for h in told.values())
    print(f"{agreed} of {len(told)} rigs have the same first cause in both halves")  # noqa: T201
    asked.to.mkdir(parents=True, exist_ok=True)
    (asked.to / "rigs.json").write_text(json.dumps(told, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())

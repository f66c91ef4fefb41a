"""Simpler methods on the same cases: ``run_all`` for every case in a process pool, stored as one JSON per case."""

from __future__ import annotations

import hashlib
import json
import math
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from blind import run, score
from blind.page import Method
from blind.views import FAILED, View

WORDS = {
    "least residual": "every number of the leg free, each candidate effect added in turn; the smallest residual names "
    "the cause. It always names one, and is taken to name its first two where there are two.",
    "BIC on the torque": "the torque that the nominal leg lacks, regressed on each effect's own torque beside the "
    "springs' and dampers' rates; the least BIC names the cause or none.",
    "largest change": "every number of the leg free, no effect at all; the number that moves by most tolerances names "
    "the cause: a mass link_mass; a centre of mass, inertia or length link_inertia; a spring hardening_spring if it "
    "comes out stiffer, one_sided_spring if softer; a damper coulomb_friction if stronger, shear_thinning_damping if "
    "weaker; a free angle spring_preload.",
}


def one(name: str, cases: Path, out: Path) -> None:
    """All baselines on one case."""
    from blind.baseline_fits import free_fit, largest_change, least_residual
    from blind.baseline_torque import bic
    from synth.files.gap_project import read_gap_project

    project = read_gap_project(cases / name / "gap.yaml")
    freed = free_fit(project)
    views = {
        "least residual": least_residual(freed, project),
        "BIC on the torque": bic(project),
        "largest change": largest_change(freed, project),
    }
    (out / f"{name}.json").write_text(json.dumps({method: _json(view) for method, view in views.items()}) + "\n")


def _json(view: View) -> dict[str, Any]:
    return {
        "verdict": view.verdict,
        "ranked": [[*key, p if math.isfinite(p) else None] for key, p in view.ranked],
        "none": view.none if math.isfinite(view.none) else None,
        "after": view.after if math.isfinite(view.after) else None,
    }


def _view(document: Mapping[str, Any]) -> View:
    ranked = tuple(((e, j), math.nan if p is None else p) for e, j, p in document["ranked"])
    named = () if document["verdict"] == "none" else tuple(key for key, _ in ranked[:2])
    none, after = (math.nan if document[key] is None else document[key] for key in ("none", "after"))
    return View(document["verdict"], ranked, named, none=none, after=after)


def run_all(cases: Path, out: Path, workers: int) -> None:
    """Run them on every case without a result of this program."""
    out.mkdir(parents=True, exist_ok=True)
    note, now = out / run.PROGRAM, _program()
    if not note.exists() or note.read_text() != now:
        for file in out.glob("*.json"):
            file.unlink()
        note.write_text(now)
    names = sorted(folder.name for folder in cases.iterdir() if not (out / f"{folder.name}.json").exists())
    print(f"baselines of {len(names)} cases", file=sys.stderr, flush=True)  # noqa: T201
    with ProcessPoolExecutor(workers) as pool:
        list(pool.map(partial(one, cases=cases, out=out), names))


def _program() -> str:
    """Hash of the package and of the baselines themselves."""
    total = hashlib.sha256(run.source_hash().encode())
    for path in sorted(Path(__file__).parent.glob("baseline*.py")):
        total.update(path.read_bytes())
    return total.hexdigest()


def methods(out: Path, answers: Mapping[str, Mapping[str, Any]]) -> list[Method]:
    """The baselines with the scores that apply to them."""
    documents = {n: json.loads(f.read_text()) if (f := out / f"{n}.json").exists() else {} for n in answers}
    made = []
    for name, words in WORDS.items():
        views = {n: _view(document[name]) if name in document else FAILED for n, document in documents.items()}
        lines = [*score.naming(answers, views), *score.alarms(answers, views)]
        if name == "BIC on the torque":
            lines += score.calibration(answers, views)
        else:
            lines += score.shrinking(answers, views)
        made.append(Method(name, views, lines, words))
    return made

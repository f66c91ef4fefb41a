"""A method's diagnosis of one case, in one form for ``synth gap`` and the baselines."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Key = tuple[str, str]  # effect and joint


@dataclass(frozen=True)
class View:
    """A method's diagnosis of a case.

    ``ranked`` : single causes, likeliest first, each with its probability (nan where the method gives none).
    ``explanation``, ``tied`` : the causes accepted, and the others that would do as well. ``after`` : deg, RMS on held-
    out trials with the explanation in (nan where the method predicts nothing).
    """

    verdict: str  # effect, none, tie, unknown, or failed
    ranked: tuple[tuple[Key, float], ...]
    explanation: tuple[Key, ...] = ()
    tied: tuple[tuple[Key, ...], ...] = ()
    none: float = math.nan
    unknown: float = math.nan
    after: float = math.nan
    next_trial: Mapping[str, Any] | None = None
    seconds: float = math.nan

    @property
    def keys(self) -> list[Key]:
        """Ranked causes without their probabilities."""
        return [key for key, _ in self.ranked]

    @property
    def first(self) -> tuple[Key, float]:
        """The most probable cause; an empty name with probability 0 if there is none."""
        return self.ranked[0] if self.ranked else (("", ""), 0.0)


FAILED = View("failed", ())


def from_gap(document: Mapping[str, Any], seconds: float = math.nan) -> View:
    """From ``gap.json``."""

    def keys(causes: list[Mapping[str, Any]]) -> tuple[Key, ...]:
        return tuple((cause["effect"], cause["joint"]) for cause in causes)

    return View(
        verdict=document["verdict"],
        ranked=tuple(((c["effect"], c["joint"]), float(c["probability"])) for c in document["ranked"]),
        explanation=keys(document["explanation"]),
        tied=tuple(keys(other) for other in document["tied"]),
        none=float(document["probability_none"]),
        unknown=float(document["probability_unknown"]),
        after=float(document["gap"]["after"]["value"]),
        next_trial=document["next_experiment"],
        seconds=seconds,
    )


def read_views(out: Path, names: list[str]) -> dict[str, View]:
    """The diagnoses of the named cases; one without output counts as failed."""
    found = {}
    for name in names:
        file, note = out / name / "gap.json", out / f"{name}.run.json"
        if not file.is_file():
            found[name] = FAILED
            continue
        seconds = json.loads(note.read_text())["seconds"] if note.is_file() else math.nan
        found[name] = from_gap(json.loads(file.read_text()), seconds)
    return found

"""The input section of ``gap.json``, for every plant: effects, settings, defaults, versions."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any, Protocol

import numpy as np

import synth
from synth.arrays import Array
from synth.diagnosis.diagnosis_result import PHASES, Cause, Diagnosis
from synth.estimation.parameters import PlantEffect
from synth.remarks import remarks_json
from synth.units import quantity

LIBRARIES = ("numpy", "scipy", "numba")
STAGES = ("as_designed", "before", "after")


class LeftDefault(Protocol):
    """A default value chosen by the program."""

    @property
    def key(self) -> str:
        """The project file's key."""

    @property
    def value(self) -> str:
        """The value as it would be written in a file."""

    @property
    def reason(self) -> str:
        """The reason for this value."""


class DiagnosisProject(Protocol):
    """A project of a diagnosis."""

    @property
    def seed(self) -> int:
        """Seed of the resampling."""

    @property
    def tolerance(self) -> Any:
        """A dataclass of standard deviations."""

    @property
    def defaults(self) -> Sequence[LeftDefault]:
        """The defaults chosen by the program."""


def basis_json(
    result: Diagnosis,
    project: DiagnosisProject,
    effect_called: Callable[[str], PlantEffect],
    units: Mapping[str, str],
    inputs: Mapping[str, str],
) -> dict[str, Any]:
    """The input of a diagnosis; ``units`` of tolerances that are not relative, ``inputs`` file -> SHA-256."""
    found = [result.explanation, [entry.cause for entry in result.ranked], *result.tied]
    return {
        "effects": describe_effects([cause for causes in found for cause in causes], effect_called),
        "phases": list(PHASES),
        **remarks_json(result.warnings),
        "settings": {"seed": project.seed, **tolerance_settings(asdict(project.tolerance), units)},
        "defaults": [{"key": d.key, "value": d.value, "why": d.reason} for d in project.defaults],
        "inputs": dict(inputs),
        "versions": {"synth": synth.__version__, **{n: importlib.metadata.version(n) for n in LIBRARIES}},
    }


def rms(values: Array) -> float | None:
    """Root mean square of the known values; None if there are none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


def describe_effects(causes: Sequence[Cause], effect_called: Callable[[str], PlantEffect]) -> dict[str, dict[str, Any]]:
    """Every effect among the causes: meaning, formula, source, and what a page shows of its parameters."""
    found = {}
    for name in dict.fromkeys(cause.effect for cause in causes):
        effect = effect_called(name)
        shown = {
            p.name: {"label": p.words, "form": p.form}
            | ({"added_to": p.added_to} if p.added_to else {})
            | ({"choices": list(p.choices)} if p.choices else {})
            for p in effect.parameters
        }
        texts = {"meaning": effect.meaning, "formula": effect.formula, "source": effect.source}
        found[name] = {**texts, "parameters": shown}
    return found


def tolerance_settings(tolerances: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, Any]:
    """One setting per tolerance, in its unit or in percent; ``joints``: joint -> deviating values."""
    found = {f"tolerance.{name}": value for name, value in tolerances.items() if name != "joints"}
    for joint, quantities in tolerances.get("joints", {}).items():
        found |= {f"tolerance.{joint}.{name}": value for name, value in quantities.items()}
    return {
        key: {**quantity(value, units.get(key.rsplit(".", 1)[1], "percent")), "how": "one standard deviation"}
        for key, value in found.items()
    }

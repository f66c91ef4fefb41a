"""What ``gap.json`` of every plant says beside the diagnosis: effects, settings, defaults, versions."""

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
from synth.units import quantity

LIBRARIES = ("numpy", "scipy", "numba")
STAGES = ("as_designed", "before", "after")


class LeftDefault(Protocol):
    """A value that a project leaves to the program."""

    @property
    def key(self) -> str:
        """Of the project file."""

    @property
    def value(self) -> str:
        """As it would be written."""

    @property
    def reason(self) -> str:
        """Why this value."""


class DiagnosisProject(Protocol):
    """A project that asks for a diagnosis."""

    @property
    def seed(self) -> int:
        """Of the resampling."""

    @property
    def tolerance(self) -> Any:
        """A dataclass of standard deviations."""

    @property
    def defaults(self) -> Sequence[LeftDefault]:
        """What the program chose."""


def basis_json(
    result: Diagnosis,
    project: DiagnosisProject,
    effect_called: Callable[[str], PlantEffect],
    units: Mapping[str, str],
    inputs: Mapping[str, str],
) -> dict[str, Any]:
    """What a diagnosis rests on; ``units`` of the tolerances that are no shares, ``inputs`` file -> SHA-256."""
    found = [result.explanation, [entry.cause for entry in result.ranked], *result.tied]
    return {
        "effects": described([cause for causes in found for cause in causes], effect_called),
        "phases": list(PHASES),
        "warnings": list(result.warnings),
        "settings": {"seed": project.seed, **tolerance_settings(asdict(project.tolerance), units)},
        "defaults": [{"key": d.key, "value": d.value, "why": d.reason} for d in project.defaults],
        "inputs": dict(inputs),
        "versions": {"synth": synth.__version__, **{n: importlib.metadata.version(n) for n in LIBRARIES}},
    }


def rms(values: Array) -> float | None:
    """Root mean square of what is known; None where nothing is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


def described(causes: Sequence[Cause], effect_called: Callable[[str], PlantEffect]) -> dict[str, dict[str, str]]:
    """Every effect among the causes: what it is, its formula and source."""
    found = {}
    for name in dict.fromkeys(cause.effect for cause in causes):
        effect = effect_called(name)
        found[name] = {"meaning": effect.meaning, "formula": effect.formula, "source": effect.source}
    return found


def tolerance_settings(tolerances: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, Any]:
    """One setting a tolerance, in its unit or else in percent; ``joints``: joint -> those that differ there."""
    found = {f"tolerance.{name}": value for name, value in tolerances.items() if name != "joints"}
    for joint, quantities in tolerances.get("joints", {}).items():
        found |= {f"tolerance.{joint}.{name}": value for name, value in quantities.items()}
    return {
        key: {**quantity(value, units.get(key.rsplit(".", 1)[1], "percent")), "how": "one standard deviation"}
        for key, value in found.items()
    }

"""What a check of a model expects, what was found, and how far they may be apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import synth
from synth.units import quantity

FORMAT = "synth/check/1"


@dataclass(frozen=True)
class ModelCheck:
    """One check: ``expected`` and ``found`` in the SI unit of ``unit``; ``limit`` of their difference, likewise.

    ``where``: the joint or part that is looked at; ``source``: of what is expected.
    """

    name: str
    where: str
    expected: float
    found: float
    limit: float
    unit: str
    source: str

    @property
    def off(self) -> float:
        """How far apart they are."""
        return abs(self.found - self.expected)

    @property
    def passed(self) -> bool:
        """Within the limit; what is not a number is not."""
        return self.off <= self.limit

    def as_json(self) -> dict[str, Any]:
        """The check's entry of ``check.json``."""
        numbers = {"expected": self.expected, "found": self.found, "off": self.off, "limit": self.limit}
        finite = {key: quantity(value, self.unit) if value == value else None for key, value in numbers.items()}
        return {"name": self.name, "where": self.where, "passed": self.passed, **finite, "source": self.source}


@dataclass(frozen=True)
class ModelChecks:
    """All checks of one file; ``left_out``: a sentence on each that could not be done."""

    name: str
    kind: str  # leg or hopper
    checks: tuple[ModelCheck, ...]
    left_out: tuple[str, ...]
    inputs: Sequence[tuple[str, str]] = ()

    @property
    def failed(self) -> list[ModelCheck]:
        """Those beyond their limits."""
        return [check for check in self.checks if not check.passed]

    def as_json(self) -> dict[str, Any]:
        """The content of ``check.json``."""
        return {
            "format": FORMAT,
            "name": self.name,
            "kind": self.kind,
            "passed": not self.failed,
            "checks": [check.as_json() for check in self.checks],
            "left_out": list(self.left_out),
            "inputs": dict(self.inputs),
            "versions": {"synth": synth.__version__},
        }

"""A check of a model: expected value, model value, allowed difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import synth
from synth.remarks import remarks_json
from synth.units import quantity

FORMAT = "synth/check/1"


@dataclass(frozen=True)
class ModelCheck:
    """One check: ``expected`` and ``found`` in SI, displayed in ``unit``; ``limit`` of their difference in SI.

    ``where``: joint or part; ``source``: of the expected value.
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
        """The absolute difference."""
        return abs(self.found - self.expected)

    @property
    def passed(self) -> bool:
        """Whether the difference is within the limit; a value that is not a number is not."""
        return self.off <= self.limit

    def as_json(self) -> dict[str, Any]:
        """The check's entry of ``check.json``."""
        numbers = {"expected": self.expected, "found": self.found, "off": self.off, "limit": self.limit}
        finite = {key: quantity(value, self.unit) if value == value else None for key, value in numbers.items()}
        return {"name": self.name, "where": self.where, "passed": self.passed, **finite, "source": self.source}


@dataclass(frozen=True)
class ModelChecks:
    """All checks of one file; ``left_out``: one sentence for each check that was not possible.

    ``doubts``: sentences on links that no limb has, which no check tests: the model of an impossible leg holds too.
    """

    name: str
    kind: str  # leg or hopper
    checks: tuple[ModelCheck, ...]
    left_out: tuple[str, ...]
    inputs: Sequence[tuple[str, str]] = ()
    doubts: Sequence[str] = ()

    @property
    def failed(self) -> list[ModelCheck]:
        """The checks beyond their limits."""
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
            **remarks_json(self.doubts),
            "inputs": dict(self.inputs),
            "versions": {"synth": synth.__version__},
        }

"""Dimensions with a declared range, checked in this one place.

Everything in ``cad`` is in millimetres and degrees, as in workshops and STEP files. The caller converts from SI.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

_KEY = "limit"


@dataclass(frozen=True)
class Limit:
    """The allowed closed range of one dimension and the reason for its ends."""

    low: float
    high: float
    unit: str
    reason: str

    @property
    def allowed(self) -> str:
        """The range in words, e.g. ``0.2 to 12 mm``."""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()


@dataclass(frozen=True)
class DimensionProblem:
    """One dimension that cannot be built: name, value, allowed range, and reason.

    ``least`` : the value from which this reason falls away, where it is a number that others may follow.
    """

    dimension: str
    value: object
    allowed: str
    reason: str
    least: float | None = None

    def __str__(self) -> str:
        shown = f"{self.value:.6g}" if isinstance(self.value, float) else repr(self.value)
        return f"{self.dimension} = {shown}: allowed is {self.allowed}; {self.reason}"


def rounded_up(value: float) -> str:
    """A least value (mm) in a message, rounded up to a hundredth, so that the value it names is allowed."""
    return f"{math.ceil(value * 100.0 - 1e-6) / 100.0:g}"


class DimensionError(ValueError):
    """Dimensions from which no valid part can be built. It has all problems found, not only the first."""

    def __init__(self, problems: DimensionProblem | list[DimensionProblem]) -> None:
        self.problems: list[DimensionProblem] = problems if isinstance(problems, list) else [problems]
        super().__init__("\n".join(str(problem) for problem in self.problems))


def dimension(default: Any, low: float, high: float, unit: str, reason: str) -> Any:
    """A dataclass field with its range and reason; ``default`` may be None (derived) or ``dataclasses.MISSING``."""
    return dataclasses.field(default=default, metadata={_KEY: Limit(low, high, unit, reason)})


def limit_of(family: type, name: str) -> Limit:
    """The declared range of one field of a dimension dataclass."""
    fields = {item.name: item for item in dataclasses.fields(family)}
    limit: Limit = fields[name].metadata[_KEY]
    return limit


def range_problems(dimensions: Any, prefix: str = "") -> list[DimensionProblem]:
    """Every field of a dimension dataclass that is not a number or is outside its declared range.

    A field whose default is None may be None: then it is derived from the others.
    """
    problems = []
    for item in dataclasses.fields(dimensions):
        limit: Limit | None = item.metadata.get(_KEY)
        value = getattr(dimensions, item.name)
        if limit is None or (value is None and item.default is None):
            continue
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value) or not limit.low <= value <= limit.high:
            problems.append(DimensionProblem(prefix + item.name, value, limit.allowed, limit.reason))
    return problems

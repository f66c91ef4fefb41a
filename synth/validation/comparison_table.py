"""A table of a reproduction: published numbers beside ours, and the reasons for their differences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from synth.estimation.intervals import Estimate
from synth.units import quantity

Cell = dict[str, Any] | str | None


@dataclass(frozen=True)
class ComparisonRow:
    """One row: ``label``, then a cell for every further column: a quantity, a text, or None.

    ``holds`` : whether a published claim is found again; None: the row is no claim, or one to which ours is set.
    """

    label: str
    cells: tuple[Cell, ...]
    holds: bool | None = None

    def as_json(self) -> dict[str, Any]:
        """The entry under ``rows``."""
        judged = {} if self.holds is None else {"holds": self.holds}
        return {"label": self.label, "cells": list(self.cells), **judged}


@dataclass(frozen=True)
class ComparisonTable:
    """One table. ``how`` : the method. ``differences`` : sentences on the differences, made from computed figures."""

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[ComparisonRow, ...]
    how: str
    differences: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The entry under ``tables``."""
        return {
            "name": self.name,
            "title": self.title,
            "columns": list(self.columns),
            "rows": [row.as_json() for row in self.rows],
            "how": self.how,
            "differences": list(self.differences),
        }


def table_cell(value: Estimate | float | None, unit: str = "") -> Cell:
    """An estimate with its interval, or an SI number with its display ``unit``; None for None and nan."""
    if isinstance(value, Estimate):
        return value.as_json()
    return None if value is None or value != value else quantity(float(value), unit)


def percent(ratio: float) -> str:
    """A ratio as a change, ``+12 %``."""
    return f"{100 * (ratio - 1):+.0f} %"


def listed(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"

"""A section of a page: one module says what it shows, one template how."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from synth.reports.reading import Json, Result


@dataclass(frozen=True)
class AbsentResult:
    """Why a section is left out."""

    why: str


@dataclass(frozen=True)
class ReportSection:
    """One section.

    Parameters
    ----------
    name
        the anchor, and the template ``NAME.html``.
    title
        its heading.
    content
        what the template needs from a result, or why there is nothing to show.
    template
        where several sections share one: its name instead of the section's.
    """

    name: str
    title: str
    content: Callable[[Result], Mapping[str, Any] | AbsentResult]
    template: str = ""


def mapping(parent: object, *keys: str) -> Json:
    """The mapping at these keys below each other; an empty one where it is missing or something else."""
    found = parent
    for key in keys:
        found = found.get(key) if isinstance(found, Mapping) else None
    return dict(found) if isinstance(found, Mapping) else {}


def sequence(parent: object, *keys: str) -> list[Any]:
    """The list at these keys below each other; an empty one where it is missing or something else."""
    found = mapping(parent, *keys[:-1]).get(keys[-1])
    return list(found) if isinstance(found, list) else []


def fit_of(result: Result) -> Json:
    """The fit to recorded motion: ``stages.source`` of a design, all of a ``fit.json``."""
    return mapping(result.content, "stages", "source") if "stages" in result.content else result.content


def fit_key(result: Result) -> str:
    """Where ``fit_of`` stands in the JSON, as a prefix of its keys."""
    return "stages.source." if "stages" in result.content else ""

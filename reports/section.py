"""A section of a page: a module gives its content, a template its layout."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from synth.reports.reading import Json, Result


@dataclass(frozen=True)
class AbsentResult:
    """Why a section is left out."""

    why: str


@dataclass(frozen=True)
class FirstFigure:
    """A section's figure for the page's opening; ``pose`` : the leg that follows the figure's cursor, or nothing."""

    drawing: Markup
    caption: str
    pose: Markup


@dataclass(frozen=True)
class ReportSection:
    """One section.

    Parameters
    ----------
    name
        the anchor, and the template ``NAME.html``.
    title
        its heading, if the content has no ``section_title`` of its own.
    content
        the template's data from a result, or the reason why the section is left out.
    template
        name of the template, if several sections share one; default the section's name.
    """

    name: str
    title: str
    content: Callable[[Result], Mapping[str, Any] | AbsentResult]
    template: str = ""


def mapping(parent: object, *keys: str) -> Json:
    """The nested mapping at these keys; an empty one if it is missing or of another type."""
    found = parent
    for key in keys:
        found = found.get(key) if isinstance(found, Mapping) else None
    return dict(found) if isinstance(found, Mapping) else {}


def sequence(parent: object, *keys: str) -> list[Any]:
    """The nested list at these keys; an empty one if it is missing or of another type."""
    found = mapping(parent, *keys[:-1]).get(keys[-1])
    return list(found) if isinstance(found, list) else []


def records(parent: object, *keys: str) -> list[Json]:
    """The mappings of the nested list at these keys; what else it holds is left out."""
    return [dict(item) for item in sequence(parent, *keys) if isinstance(item, Mapping)]


def fit_of(result: Result) -> Json:
    """The fit to recorded motion: ``stages.source`` of a design, all of a ``fit.json``."""
    return mapping(result.content, "stages", "source") if "stages" in result.content else result.content


def fit_key(result: Result) -> str:
    """The path of ``fit_of`` in the JSON, as a prefix of its keys."""
    return "stages.source." if "stages" in result.content else ""

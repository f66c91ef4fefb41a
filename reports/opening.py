"""The opening of every page: the verdict, what to do next, the most important figure and numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from synth.reports.quantities import interval_text, prose, text
from synth.reports.severity import Group, ShownWarning, count_by_level, foremost

NOTHING = Markup("")
MOST_FOREMOST_LETTERS = 260  # of a warning above the fold; the fold holds the whole


@dataclass(frozen=True)
class Cell:
    """A cell of the opening's table: the value, and in small print its uncertainty or reference."""

    text: str
    small: str = ""


@dataclass(frozen=True)
class Figures:
    """The table: heads of its columns, and rows whose first cell names them."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""


@dataclass(frozen=True)
class Opening:
    """A page's first screen.

    Parameters
    ----------
    verdict
        the result, in one or two sentences.
    trust
        its reliability, in one sentence.
    steps
        what to do next, the most important first.
    good
        whether the verdict is good, bad, or neither (None). It sets the colour only.
    wide
        the figure is below the table, over the whole width.
    beside
        a drawing that follows the figure's cursor.
    """

    verdict: str
    trust: str = ""
    steps: Sequence[str] = ()
    figure: Markup = NOTHING
    caption: str = ""
    figures: Figures | None = None
    good: bool | None = None
    wide: bool = False
    beside: Markup = NOTHING


@dataclass(frozen=True)
class OpeningWarnings:
    """The warnings in the opening."""

    foremost: list[Group]
    counted: list[tuple[str, str, list[ShownWarning]]]
    total: int


def opening_warnings(warnings: Sequence[ShownWarning]) -> OpeningWarnings:
    """At most three that could change a decision, and all of them by level."""
    groups = foremost(warnings)
    return OpeningWarnings(groups, count_by_level(warnings), len(warnings))


def estimate(quantity: object) -> Cell:
    """A quantity with its 90 % interval below it."""
    return Cell(text(quantity), interval_text(quantity))


def as_markup(words: str) -> Markup:
    """The text as markup, with the parts between backticks as code."""
    pieces = str(words).split("`")
    if len(pieces) % 2 == 0:  # an unpaired backtick
        return escape(prose(words))
    return Markup("").join(
        Markup("<code>{}</code>").format(piece) if i % 2 else escape(prose(piece)) for i, piece in enumerate(pieces)
    )


def joined_names(names: Sequence[str], conjunction: str = "and") -> str:
    """``hip, knee and ankle``."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {conjunction} {names[-1]}"


def cut_short(words: str, most: int = MOST_FOREMOST_LETTERS) -> str:
    """A text cut after a sentence, or after a clause or a word with an ellipsis."""
    if len(words) <= most:
        return words
    cut = words[:most]
    stop = max(cut.rfind(". "), cut.rfind("; "))
    if stop <= most // 2:
        return cut[: cut.rfind(" ")] + " …"
    return cut[: stop + 1] if cut[stop] == "." else cut[:stop] + " …"

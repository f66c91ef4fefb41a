"""Errors in the user's input, with messages that say how to correct them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

LONGEST_WORD = 80  # characters of a value in a message
LONGEST = 2_000  # characters of a message: about a screen
LONGEST_PLACE = 500  # characters of a file's or key's name; twice what a disk takes for one name
_OPENING = re.compile(r"""(?<!\w)["']""")
_CLOSING = re.compile(r"""["'](?!\w)""")
_WORD = re.compile(r"\S{%d,}" % (3 * LONGEST_WORD))  # noqa: UP031


@dataclass(frozen=True)
class Problem:
    """One mistake in one place of the user's input.

    Parameters
    ----------
    text : what is wrong, with the value as written, what is allowed and how to write it.
    file : the file as the user named it, or None for the command line.
    line : 1-based line in that file, where known.
    key : dotted key path or column name, where there is one, e.g. ``joints.knee.link.mass``.
    """

    text: str
    file: str | None = None
    line: int | None = None
    key: str | None = None

    def __str__(self) -> str:
        place = _without_middle(self.file or "")
        if self.line is not None:
            place += f":{self.line}"
        parts = [part for part in (place, _without_middle(self.key or "")) if part]
        return ": ".join([*parts, readable(self.text)])


def _without_middle(name: str) -> str:
    """A name with its middle left out where it is too long to be one."""
    return name if len(name) <= LONGEST_PLACE else f"{name[:LONGEST_WORD]}...{name[-LONGEST_WORD:]}"


def readable(text: str) -> str:
    """A message with long values shortened, so that the text around them stays visible."""
    text = _with_short_quotes(text)
    text = _WORD.sub(lambda found: f"{found[0][:LONGEST_WORD]}...", text)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _with_short_quotes(text: str) -> str:
    """The text with long words in quotes shortened, in one pass.

    Marks are paired from the left, so that what stands between two words in quotes is never taken for one. A mark
    after a letter opens none and one before a letter closes none: apostrophes, and marks in a user's own words.
    """
    closes = {mark.start() for mark in _CLOSING.finditer(text)}
    last = {mark: max((at for at in closes if text[at] == mark), default=-1) for mark in "\"'"}
    opens = {mark.start() for mark in _OPENING.finditer(text) if last[mark[0]] > mark.start()}
    kept, done, start = list[str](), 0, -1
    for at in sorted(opens | closes):
        if start < 0:
            start = at if at in opens else -1
        elif at in closes and text[at] == text[start]:
            if at - start - 1 > LONGEST_WORD:
                kept += [text[done : start + LONGEST_WORD - 2], "..."]
                done = at
            start = -1
    return "".join([*kept, text[done:]])


def did_you_mean(value: str, names: Iterable[str], most: int = 1, cutoff: float = 0.6) -> str:
    """``; did you mean knee?`` with up to ``most`` names similar to ``value``; empty if none is.

    A name identical to the value is left out; one that only looks identical is marked as such.
    """
    from difflib import get_close_matches

    if len(value) > 100:
        return ""
    folded = {name.casefold(): name for name in names if name != value}
    near = [folded[each] for each in get_close_matches(value.casefold(), list(folded), n=most, cutoff=cutoff)]
    if not near:
        return ""
    alike = _seen(near[0]) == _seen(value) and near[0].casefold() != value.casefold()
    how = ", which looks the same but is written with other characters or blanks" if alike else ""
    return f"; did you mean {' or '.join(near)}{how}?"


def _seen(name: str) -> str:
    """The visible form of a name: no blanks, no zero-width characters, composed accents."""
    import unicodedata

    return "".join(c for c in unicodedata.normalize("NFKC", name).casefold() if c.isprintable() and not c.isspace())


class UserError(Exception):
    """Input that cannot be used. The command line prints every problem and exits with status 2."""

    def __init__(self, problems: Problem | str | list[Problem]) -> None:
        if isinstance(problems, str):
            problems = Problem(problems)
        self.problems: list[Problem] = problems if isinstance(problems, list) else [problems]
        super().__init__("\n".join(str(problem) for problem in self.problems))


class CannotBeHad(UserError):
    """A valid request that nothing can meet. The command line exits with status 1."""

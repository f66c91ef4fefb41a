"""The severity of a warning: it could change a decision, limits trust in a number, or is for information.

The result states it for each warning under ``severity`` (``decide``, ``check`` or ``note``), and the remedy under
``remedy``. A warning without a severity counts as ``check``, so that it is not hidden among the notes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

MOST_SHOWN = 3  # warnings above the fold
LEVELS = ("decide", "check", "note")
WORDS = {
    "decide": "could change a decision",
    "check": "limit the trust in a number",
    "note": "for information",
}
_FIGURES = re.compile(r"[^\s,;:]*\d[^\s,;:]*")  # numbers and part numbers, in which warnings of one kind differ


@dataclass(frozen=True)
class ShownWarning:
    """A warning as the page shows it."""

    joint: str
    text: str
    key: str
    level: str
    remedy: str = ""

    @property
    def kind(self) -> str:
        """The common form of warnings that differ only in joint, part and numbers."""
        return _FIGURES.sub("#", self.text)


@dataclass(frozen=True)
class Group:
    """Warnings of one kind, shown once: the places concerned, and the first one's text."""

    joints: tuple[str, ...]
    text: str
    remedy: str
    more: int  # further ones of the same kind


def warning_of(joint: str, text: str, key: str, stated: object = None) -> ShownWarning:
    """The warning with its level; ``stated`` is the result's own entry, a mapping with ``severity`` and ``remedy``."""
    level = stated.get("severity") if isinstance(stated, Mapping) else None
    remedy = stated.get("remedy") if isinstance(stated, Mapping) else None
    return ShownWarning(
        joint, text, key, level if level in LEVELS else "check", remedy if isinstance(remedy, str) else ""
    )


def foremost(warnings: Sequence[ShownWarning]) -> list[Group]:
    """At most three groups of those that could change a decision."""
    groups: dict[str, list[ShownWarning]] = {}
    for warned in warnings:
        if warned.level == "decide":
            groups.setdefault(warned.kind, []).append(warned)
    return [
        Group(
            tuple(dict.fromkeys(w.joint for w in found if w.joint)),
            found[0].text,
            found[0].remedy,
            len(found) - 1,
        )
        for found in list(groups.values())[:MOST_SHOWN]
    ]


ONE = {"check": "limits the trust in a number"}


def count_by_level(warnings: Sequence[ShownWarning]) -> list[tuple[str, str, list[ShownWarning]]]:
    """(level, its words, its warnings) of each level that has any."""
    rows: Mapping[str, list[ShownWarning]] = {level: [w for w in warnings if w.level == level] for level in LEVELS}
    return [
        (level, ONE.get(level, WORDS[level]) if len(found) == 1 else WORDS[level], found)
        for level, found in rows.items()
        if found
    ]

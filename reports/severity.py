"""How much a warning matters: whether it could change a decision, bears on trust in a number, or is just to be known.

The texts come from all over the program. A warning may state its own level under ``severity`` (``decide``, ``check`` or
``note``); else the first rule whose pattern is in the text says it. What no rule knows is ``check``, so that a new
warning is never buried.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

MOST_SHOWN = 3  # warnings above the fold
LEVELS = ("decide", "check", "note")
WORDS = {
    "decide": "could change a decision",
    "check": "limit what a number is worth",
    "note": "good to know",
}


@dataclass(frozen=True)
class Rule:
    """Texts with this pattern are of this level; among equals the earlier rule is shown first."""

    level: str
    pattern: str
    remedy: str = ""  # what to do, as a sentence


RULES: tuple[Rule, ...] = (
    Rule(
        "check",
        r"link .*ends up at|links? .*includes: none",
        "State what the link weighs and what its figures hold: `link: {..., includes: none}`.",
    ),
    Rule("check", r"its link is simulated at|g are assumed, of|parts still change with"),
    Rule("note", r"does not hold all of the leg|lost samples|instead of|drawn right-hand|estimated from|is not drawn"),
    Rule("note", r"time is stretched|is drawn at|side by side|mirrored pair|no pictures"),
    Rule("note", r"no bought spring meets"),
    Rule("decide", r"no (single )?spring|none (of|fits)|cannot be built|not exported"),
    Rule("decide", r"may break|would yield|above the gearbox|exceeds|too weak"),
    Rule("decide", r"off the wanted motion|hangs on what the fit"),
    Rule(
        "decide",
        r"torque-speed law of .* is assumed",
        "Record drops with that damper alone and name them under `dampers:`.",
    ),
    Rule("decide", r"damper's law decides about the spring"),
    Rule("decide", r"sense|wrong way|sign of|not agree|disagree"),
    Rule("check", r"the fit leaves|lacks something|edge of"),
    Rule("check", r"not separable"),
    Rule("check", r"drawn on beyond|says nothing beyond|was measured between|measured up to"),
    Rule("check", r"Measure yours|does not give the|catalogue does not say"),
)


@dataclass(frozen=True)
class Warned:
    """A warning as the page shows it."""

    joint: str
    text: str
    key: str
    level: str
    rank: int  # of its rule; smaller matters more
    remedy: str = ""


@dataclass(frozen=True)
class Group:
    """Warnings of one rule, told once: those concerned, and what the first of them says."""

    joints: tuple[str, ...]
    text: str
    remedy: str
    more: int  # further ones of the same kind


def judged(joint: str, text: str, key: str, stated: object = None) -> Warned:
    """The warning with its level; ``stated`` is its own, where the result gives one."""
    found = next(((i, rule) for i, rule in enumerate(RULES) if re.search(rule.pattern, text)), None)
    rank, level, remedy = (len(RULES), "check", "") if found is None else (found[0], found[1].level, found[1].remedy)
    if isinstance(stated, str) and stated in LEVELS:
        level = stated
    return Warned(joint, text, key, level, rank, remedy)


def ordered(warnings: Iterable[Warned]) -> list[Warned]:
    """Those that could change a decision first; within a level by rule, in the order of the result."""
    return sorted(warnings, key=lambda w: (LEVELS.index(w.level), w.rank))


def foremost(warnings: Sequence[Warned]) -> list[Group]:
    """At most three groups of those that could change a decision."""
    groups: dict[int, list[Warned]] = {}
    for warned in ordered(warnings):
        if warned.level == "decide":
            groups.setdefault(warned.rank, []).append(warned)
    return [
        Group(
            tuple(dict.fromkeys(w.joint for w in found if w.joint)),
            found[0].text,
            found[0].remedy,
            len(found) - 1,
        )
        for found in list(groups.values())[:MOST_SHOWN]
    ]


def counted(warnings: Sequence[Warned]) -> list[tuple[str, str, list[Warned]]]:
    """(level, its words, its warnings) of each level that has any."""
    rows: Mapping[str, list[Warned]] = {level: [w for w in ordered(warnings) if w.level == level] for level in LEVELS}
    return [(level, WORDS[level], found) for level, found in rows.items() if found]

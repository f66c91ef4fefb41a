"""One thing that a check of recordings has to say: how bad it is, what it is, and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

Level = Literal["fault", "doubt", "note"]
LEVELS: tuple[Level, ...] = ("fault", "doubt", "note")


@dataclass(frozen=True)
class Finding:
    """``fault``: a diagnosis would be wrong; ``doubt``: it may be, or tells less; ``note``: good to know.

    ``text`` says what is there, with its figures; ``remedy`` what to do, empty where nothing needs doing. ``recording``
    and ``joint`` name the place, empty where it is all of them.
    """

    level: Level
    text: str
    remedy: str = ""
    recording: str = ""
    joint: str = ""

    @property
    def place(self) -> str:
        """Recording and joint, as far as there is one."""
        return ", ".join(part for part in (self.recording, self.joint) if part)

    def as_json(self) -> dict[str, Any]:
        """The entry under ``findings``."""
        return {
            "level": self.level,
            "recording": self.recording,
            "joint": self.joint,
            "text": self.text,
            "remedy": self.remedy,
        }


def worst_first(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """By level, else in the order given."""
    return tuple(sorted(findings, key=lambda finding: LEVELS.index(finding.level)))


def of_alike(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Findings that say the same of several recordings as one, which names the first and counts the others."""
    groups: dict[tuple[str, ...], list[Finding]] = {}
    for finding in findings:
        groups.setdefault((finding.level, finding.joint, finding.text, finding.remedy), []).append(finding)
    made = []
    for group in groups.values():
        first, more = group[0], len(group) - 1
        name = first.recording + (f" and {more} more" if more else "")
        made.append(Finding(first.level, first.text, first.remedy, name, first.joint))
    return tuple(made)

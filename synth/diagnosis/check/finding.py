"""One finding of a check of recordings: level, text, remedy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from synth.diagnosis.plants.swinging_chain.held_starts import HELD_START
from synth.diagnosis.plants.swinging_chain.slips import Slip
from synth.remarks import Remark, kind_of, severity_of

Level = Literal["fault", "doubt", "note"]
LEVELS: tuple[Level, ...] = ("fault", "doubt", "note")


@dataclass(frozen=True)
class Finding:
    """``fault``: a diagnosis would be wrong; ``doubt``: it may be wrong or show less; ``note``: for information.

    ``text`` states the finding with its figures; ``remedy`` what to do, empty if nothing is needed. ``recording``
    and ``joint`` name the place, empty if it applies to all.
    """

    level: Level
    text: str
    remedy: str = ""
    recording: str = ""
    joint: str = ""

    @property
    def place(self) -> str:
        """Recording and joint, if any."""
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


def finding_of_remark(remark: str, recordings: Sequence[str]) -> Finding:
    """A remark on the trials: for information if it says so, else a doubt; its place taken out of the words.

    A recording that starts while the leg is held is a fault: the cause that is found on it is wrong.
    """
    level: Level = "note" if severity_of(remark) == "note" else "fault" if kind_of(remark) == HELD_START else "doubt"
    named = [name for name in recordings if remark.startswith(f"{name}: ")]
    place = max(named, key=len, default="")
    remedy = remark.remedy if isinstance(remark, Remark) else ""
    return Finding(level, remark[len(place) + 2 :] if place else str(remark), remedy, place)


def finding_of_slip(slip: Slip, level: Level = "fault") -> Finding:
    """What a user's files have wrong by a slip."""
    return Finding(level, slip.text, slip.remedy, slip.place)


def worst_first(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Findings by level, otherwise in the order given."""
    return tuple(sorted(findings, key=lambda finding: LEVELS.index(finding.level)))


def merge_alike(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Merge equal findings of several recordings: name the first and count the others."""
    groups: dict[tuple[str, ...], list[Finding]] = {}
    for finding in findings:
        groups.setdefault((finding.level, finding.joint, finding.text, finding.remedy), []).append(finding)
    made = []
    for group in groups.values():
        first, more = group[0], len(group) - 1
        name = first.recording + (f" and {more} more" if more else "")
        made.append(Finding(first.level, first.text, first.remedy, name, first.joint))
    return tuple(made)

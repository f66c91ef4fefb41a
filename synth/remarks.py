"""Sentences about a result with a severity, which the code that raises them states; it is not guessed from the words.

A remark is a ``str``, so it joins, prints and compares as one. A sentence without a severity is ``check``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

Severity = Literal["decide", "check", "note"]
SEVERITIES: tuple[Severity, ...] = ("decide", "check", "note")  # what matters most first


class Remark(str):
    """A sentence.

    ``severity`` : ``decide``, it could change a decision; ``check``, it bears on what a number is worth; ``note``, good
    to know. ``remedy`` : what to do about it, a sentence; may be empty.
    """

    __slots__ = ("remedy", "severity")
    severity: Severity
    remedy: str

    def __new__(cls, text: str, severity: Severity = "check", remedy: str = "") -> Remark:
        """A sentence with its severity."""
        made = super().__new__(cls, text)
        made.severity, made.remedy = severity, remedy
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        """What makes it anew in another process."""
        return Remark, (str(self), self.severity, self.remedy)


def decisive(text: str, remedy: str = "") -> str:
    """A sentence that could change a decision."""
    return Remark(text, "decide", remedy)


def noted(text: str) -> str:
    """A sentence that is good to know, no more."""
    return Remark(text, "note")


def about(name: str, remark: str) -> str:
    """``name: remark``, of the same severity."""
    return like(remark, f"{name}: {remark}")


def like(remark: str, text: str) -> str:
    """Another text of the same severity and remedy."""
    return Remark(text, severity_of(remark), remark.remedy if isinstance(remark, Remark) else "")


def severity_of(text: str) -> Severity:
    """The stated severity; ``check`` if none was stated."""
    return text.severity if isinstance(text, Remark) else "check"


def remarks_json(remarks: Iterable[str]) -> dict[str, list[Any]]:
    """As result files hold them: the bare texts under ``warnings``, and in the same order ``remarks``."""
    listed = list(remarks)
    return {"warnings": [str(remark) for remark in listed], "remarks": [remark_json(remark) for remark in listed]}


def remark_json(remark: str) -> dict[str, Any]:
    """``text``, ``severity``, and ``remedy`` where there is one."""
    found = {"text": str(remark), "severity": severity_of(remark)}
    if isinstance(remark, Remark) and remark.remedy:
        found["remedy"] = remark.remedy
    return found


def read_remark(item: Any) -> Remark:
    """What ``remark_json`` wrote; a bare text too."""
    if isinstance(item, dict):
        severity = item.get("severity")
        return Remark(
            str(item.get("text")),
            severity if severity in SEVERITIES else "check",
            str(item.get("remedy") or ""),
        )
    return Remark(str(item))

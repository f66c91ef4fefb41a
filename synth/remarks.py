"""Sentences about a result with what they are about, which the code that raises them states.

Nothing is guessed from the words: severity, kind and joint are attributes.

A remark is a ``str``, so it joins, prints and compares as one. A sentence without a severity is ``check``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

Severity = Literal["decide", "check", "note"]
MOST_DIGITS = 9  # of a number beside its limit; more would be rounding of the arithmetic
SEVERITIES: tuple[Severity, ...] = ("decide", "check", "note")  # the most important first


class Remark(str):
    """A sentence.

    ``severity`` : ``decide``, it could change a decision; ``check``, it affects the reliability of a number; ``note``,
    for information only. ``remedy`` : what to do, a sentence; may be empty. ``kind`` : what it is about, where code
    depends on it, a constant beside the code that raises it. ``joint`` : the name of the joint that it is about. Both
    may be empty.
    """

    __slots__ = ("joint", "kind", "remedy", "severity")
    severity: Severity
    remedy: str
    kind: str
    joint: str

    def __new__(
        cls, text: str, severity: Severity = "check", remedy: str = "", kind: str = "", joint: str = ""
    ) -> Remark:
        """A sentence with its severity."""
        made = super().__new__(cls, text)
        made.severity, made.remedy, made.kind, made.joint = severity, remedy, kind, joint
        return made

    @property
    def attributes(self) -> tuple[Severity, str, str, str]:
        """All but the text, in the order in which a remark takes them."""
        return self.severity, self.remedy, self.kind, self.joint

    def __reduce__(self) -> tuple[Any, ...]:
        """The call that restores it in another process."""
        return Remark, (str(self), *self.attributes)


def decisive(text: str, remedy: str = "") -> str:
    """A sentence that could change a decision."""
    return Remark(text, "decide", remedy)


def noted(text: str) -> str:
    """A sentence for information only."""
    return Remark(text, "note")


def at_joint(joint: str, text: str, severity: Severity = "check", *, kind: str = "") -> Remark:
    """``joint: text``, a sentence about a joint."""
    return Remark(f"{joint}: {text}", severity, kind=kind, joint=joint)


def about(name: str, remark: str) -> str:
    """``name: remark``, with the same attributes."""
    return like(remark, f"{name}: {remark}")


def of_joint(joint: str | None, remark: str) -> str:
    """The remark under its joint's name, once: most begin with it. None: of the whole leg."""
    return remark if joint is None or remark.startswith(f"{joint}: ") else about(joint, remark)


def like(remark: str, text: str) -> str:
    """Another text with the same attributes."""
    return Remark(text, *remark.attributes) if isinstance(remark, Remark) else Remark(text)


def severity_of(text: str) -> Severity:
    """The stated severity; ``check`` if none was stated."""
    return text.severity if isinstance(text, Remark) else "check"


def kind_of(text: str) -> str:
    """The stated kind; empty if none was stated."""
    return text.kind if isinstance(text, Remark) else ""


def joint_of(text: str) -> str | None:
    """The joint that a sentence is about; None if none was stated."""
    return text.joint or None if isinstance(text, Remark) else None


def remarks_json(remarks: Iterable[str]) -> dict[str, list[Any]]:
    """In the form of result files: the plain texts under ``warnings``, and in the same order ``remarks``."""
    listed = list(remarks)
    return {"warnings": [str(remark) for remark in listed], "remarks": [remark_json(remark) for remark in listed]}


def remark_json(remark: str) -> dict[str, Any]:
    """``text``, ``severity``, and ``remedy`` if there is one."""
    found = {"text": str(remark), "severity": severity_of(remark)}
    if isinstance(remark, Remark) and remark.remedy:
        found["remedy"] = remark.remedy
    return found


def read_remark(item: Any) -> Remark:
    """A remark from the form of ``remark_json``, or from a plain text."""
    if isinstance(item, dict):
        severity = item.get("severity")
        return Remark(
            str(item.get("text")),
            severity if severity in SEVERITIES else "check",
            str(item.get("remedy") or ""),
        )
    return Remark(str(item))


def unlike(value: float, limit: float, style: str = ".4g") -> tuple[str, str]:
    """Both numbers in ``style`` (``.0f``, ``.4g``), with as many more digits as they need to read differently.

    50.3 and 50 in ``.0f`` become ``50.3`` and ``50.0``. Equal numbers stay alike.
    """
    digits, kind = int(style[1:-1]), style[-1]
    for more in range(digits, max(digits, MOST_DIGITS) + 1):
        found = f"{value:.{more}{kind}}", f"{limit:.{more}{kind}}"
        if found[0] != found[1]:
            return found
    return f"{value:{style}}", f"{limit:{style}}"

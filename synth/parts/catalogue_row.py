"""What every catalogue row has: columns with a unit and a meaning, its place, source and status."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar, Literal, Self

State = Literal["", "complete", "usable", "incomplete", "contradiction", "suspect", "alternate", "size only", "other"]
"""Empty before it is determined; ``other`` is any other word that a table's status column begins with."""
DECLARED: tuple[State, ...] = ("usable", "incomplete", "contradiction", "suspect", "alternate", "size only")
SEPARATORS: dict[State, str] = {"incomplete": ", "}  # of reasons in the column; of other states a semicolon


def declared_state(status: str) -> State:
    """The state that a cell of a table's status column begins with."""
    if status in ("", "complete"):
        return "complete" if status else ""
    return next((state for state in DECLARED if status.startswith(state)), "other")


def quantity_column(
    unit: str,
    shown: str,
    *,
    key: bool = False,
    zero: bool = False,
    signed: bool = False,
    least: float = -math.inf,
    most: float = math.inf,
) -> Any:
    """A column; ``shown``: display unit; ``zero``, ``signed``: values <= 0 are allowed.

    ``least`` and ``most``: the smallest and the largest value, in ``unit``.
    """
    rules = {
        "unit": unit, "shown": shown, "key": key, "zero": zero, "signed": signed, "least": least, "most": most,
    }  # fmt: skip
    return field(default=None, metadata=rules)


def text_column(*, key: bool = False, choices: tuple[str, ...] = ()) -> Any:
    """A text column. ``key``: identifies a file of this family."""
    return field(default="", metadata={"unit": None, "key": key, "choices": choices})


@dataclass(frozen=True)
class CatalogueRow:
    """The common part of every catalogue row: place, source and status.

    ``status`` is the column: ``state``, with ``reasons`` behind it. ``judged`` sets all three.
    """

    family: ClassVar[str]
    file: str = field(default="", metadata={"column": False})
    line: int = field(default=0, metadata={"column": False})
    status: str = text_column()
    source: str = text_column()
    as_published: str = text_column()
    note: str = text_column()
    price: str = field(default="", metadata={"unit": None, "key": False, "choices": (), "currency": True})  # of one
    state: State = field(default="", metadata={"column": False})
    reasons: tuple[str, ...] = field(default=(), metadata={"column": False})

    def judged(self, state: State, reasons: Sequence[str] = ()) -> Self:
        """The row with this state, whose reasons stand behind it in the column."""
        because = f": {SEPARATORS.get(state, '; ').join(reasons)}" if reasons else ""
        return replace(self, state=state, reasons=tuple(reasons), status=f"{state}{because}")

    @property
    def complete(self) -> bool:
        """Whether the row has all required values without contradiction."""
        return self.state == "complete"

    @property
    def choosable(self) -> bool:
        """Whether it may be chosen: complete, or usable within the limits of its status (``usable``)."""
        return self.complete or self.state == "usable"

    @property
    def sound(self) -> bool:
        """Whether it is not declared suspect or an alternate, also before its status is computed."""
        return self.state in ("", "complete")

    @property
    def place(self) -> str:
        """``file:line``."""
        return f"{self.file}:{self.line}"

    @classmethod
    def columns(cls) -> tuple[Field[Any], ...]:
        """The fields that are columns of the CSV."""
        return tuple(item for item in fields(cls) if item.metadata.get("column", True))

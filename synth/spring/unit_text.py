"""Sentences with quantities: metric in results, and in the units of the input on the screen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from synth.files.shown_units import METRIC, ShownUnits
from synth.remarks import unlike


@dataclass(frozen=True)
class MeasuredText:
    """A quantity in a sentence: ``value`` in the SI unit ``si`` (``1``: a plain number), displayed in ``style``.

    ``beside`` : a limit in the same sentence, from which it shall read differently.
    """

    value: float
    si: str = "1"
    style: str = ".4g"
    beside: float | None = None

    def words(self, shown: ShownUnits) -> str:
        """The number with its displayed unit."""
        value = shown.value(self.value, self.si)
        if self.beside is None:
            number = f"{value:{self.style}}"
        else:
            number, _ = unlike(value, shown.value(self.beside, self.si), self.style)
        return number if self.si == "1" else f"{number} {shown.unit(self.si)}"


class UnitText(str):
    """A sentence of words and quantities; as a ``str`` it is metric, as result files are."""

    __slots__ = ("pieces",)
    pieces: tuple[str | MeasuredText, ...]

    def __new__(cls, *pieces: str | MeasuredText) -> UnitText:
        """The pieces one after another; those of a ``UnitText`` stay convertible."""
        flat: list[str | MeasuredText] = []
        for piece in pieces:
            flat += piece.pieces if isinstance(piece, UnitText) else (piece,)
        made = super().__new__(cls, _words(flat, METRIC))
        made.pieces = tuple(flat)
        return made

    def as_data(self) -> list[Any]:
        """The pieces as plain values, for a stored result."""
        return [
            piece if isinstance(piece, str) else [piece.value, piece.si, piece.style, piece.beside]
            for piece in self.pieces
        ]

    @classmethod
    def from_data(cls, data: Sequence[Any]) -> UnitText:
        """The text whose pieces ``as_data`` gave."""
        return cls(*(piece if isinstance(piece, str) else MeasuredText(*piece) for piece in data))

    def __reduce__(self) -> tuple[Any, ...]:
        """The call that restores it in another process."""
        return UnitText, self.pieces


def in_units(text: str, shown: ShownUnits) -> str:
    """The sentence with its quantities in the displayed units; a plain text as it is."""
    return _words(text.pieces, shown) if isinstance(text, UnitText) else text


def join_texts(separator: str, texts: Iterable[str]) -> UnitText:
    """Several sentences in one."""
    pieces: list[str] = []
    for text in texts:
        pieces += [separator, text] if pieces else [text]
    return UnitText(*pieces)


def _words(pieces: Iterable[str | MeasuredText], shown: ShownUnits) -> str:
    return "".join(piece if isinstance(piece, str) else piece.words(shown) for piece in pieces)

"""What a drawn part is ordered or cut by, as data; the sentences of files and reports are made from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

Kind = Literal["bearing", "shim", "collar", "pin", "screw", "set screw", "nut"]
Stock = Literal["ground rod, h6", "tube"]


@dataclass(frozen=True)
class StandardPart:
    """A part that every dealer sells by standard, size and length.

    ``size`` : as in an order, ``M3``, ``8 x 14 x 0.5`` or ``628/8-2Z``. ``length`` : mm, of what is sold in lengths.
    ``words`` : what else the order says. ``thread`` : nominal diameter, mm, of a screw. ``has_nut`` : a screw that ends
    in a nut; else it ends in a heat-set insert. ``washer`` : standard of the washer under a screw's head.
    """

    kind: Kind
    standard: str
    size: str
    words: str
    length: float | None = None
    thread: float | None = None
    has_nut: bool = False
    washer: str = ""

    @property
    def designation(self) -> str:
        """The part alone, ``ISO 8734 - 2.5 x 24 dowel pin, steel``, without nut and washer."""
        long = "" if self.length is None else f" x {self.length:g}"
        return f"{self.standard} - {self.size}{long}{self.words}"

    @property
    def washer_size(self) -> str:
        """Size of the washer under its head, ``3`` for M3; empty without one."""
        return f"{self.thread:g}" if self.washer and self.thread is not None else ""

    @property
    def has_insert(self) -> bool:
        """Whether it is a screw that ends in a heat-set insert."""
        return self.thread is not None and not self.has_nut

    def __str__(self) -> str:
        washer = f", with washer {self.washer} - {self.washer_size}" if self.washer else ""
        return f"buy: {self.designation}{washer}{'; with nut' * self.has_nut}"

    def as_json(self) -> dict[str, Any]:
        """All fields."""
        return asdict(self)


@dataclass(frozen=True)
class CutPart:
    """A length cut from rod or tube.

    ``size`` : of its section, mm, ``8`` or ``20 x 2``. ``length`` : mm. ``work`` : what is to be done to it then.
    """

    stock: Stock
    size: str
    length: float
    work: str

    @property
    def designation(self) -> str:
        """Stock, section and length, ``tube, 20 x 2 mm, 140.0 mm long``."""
        return f"{self.stock}, {self.size} mm, {self.length:.1f} mm long"

    def __str__(self) -> str:
        return f"cut from {self.designation}; {self.work}"

    def as_json(self) -> dict[str, Any]:
        """All fields."""
        return asdict(self)


Made = str | StandardPart | CutPart
"""How a part comes to be: its order, its cut, or in words, such as ``print``."""


def made_from(item: Mapping[str, Any]) -> StandardPart | CutPart:
    """The part whose ``as_json`` this is."""
    return CutPart(**item) if "stock" in item else StandardPart(**item)


def screw(
    standard: str, thread: float, length: float, *, kind: Kind = "screw", has_nut: bool = False, washer: str = ""
) -> StandardPart:
    """A steel screw; ``thread`` and ``length`` in mm."""
    words = ", steel" if kind == "screw" else f" {kind}, steel"
    return StandardPart(kind, standard, f"M{thread:g}", words, length, thread, has_nut, washer)

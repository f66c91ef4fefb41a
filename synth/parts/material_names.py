"""Spellings of wire materials: trade names and the designations of standards, read as one name of the catalogue.

A text names a material if each of its words is a known name or says nothing about the strength, and all names agree:
``Music Wire (ASTM A228)`` does, ``302/316`` and ``music wire XL`` do not. Nothing is guessed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

from synth.errors import UserError, did_you_mean
from synth.parts.rows import MaterialRow, WireRow
from synth.parts.wire import WireMaterial, wire_material

# Designations by the name in wire_materials.csv: ASTM, EN 10088 (1.4310), UNS (S30200), JIS G 3522 (SWP) and G 4314
# (SUS). 304 and 1.4310 have the modulus and strength of 302 (ASTM A313).
ALIASES: Mapping[str, tuple[str, ...]] = {
    "music wire": ("music", "piano", "piano wire", "music (piano) wire", "A228", "A228M", "SWP", "SWP-A", "SWP-B"),
    "hard drawn": ("hard drawn MB", "A227", "A227M"),
    "oil tempered": ("oil tempered MB", "A229", "A229M"),
    "valve spring": ("A230",),
    "chrome vanadium": ("A231", "A232", "Cr-V", "SAE 6150", "AISI 6150"),
    "chrome silicon": ("A401", "A401M", "Cr-Si", "Si-Cr", "SAE 9254", "AISI 9254"),
    "stainless 302": ("302", "304", "302/304", "18-8", "1.4310", "S30200", "S30400", "SUS302", "SUS304", "SUS304-WPB"),
    "stainless 316": ("316", "1.4401", "S31600", "SUS316", "SUS316-WPA"),
    "stainless 17-7": ("17-7", "17-7PH", "631", "1.4568", "S17700", "SUS631", "SUS631J1"),
    "phosphor bronze": ("phos bronze", "B159", "C51000"),
    "spring brass": ("brass", "B134", "C26000"),
    "beryllium copper": ("BeCu", "B197", "C17200"),
    "inconel X-750": ("X-750",),
    "monel 400": ("monel",),
    "EN 10270-1 SL": ("10270-1 SL",),
    "EN 10270-1 SM": ("10270-1 SM",),
    "EN 10270-1 DM": ("10270-1 DM",),
    "EN 10270-1 SH": ("10270-1 SH",),
    "EN 10270-1 DH": ("10270-1 DH",),
    "stainless": ("inox",),
}
STAINLESS = "stainless"  # of no named grade: the usual one
USUAL_STAINLESS = "stainless 302"
# What may stand beside a name and change nothing. A standard for several grades names none of them.
BESIDE = (
    "wire", "steel", "spring", "PH", "carbon", "high carbon", "patented", "cold drawn", "type", "grade", "per", "plain",
    "zinc plated", "passivated", "ASTM", "AISI", "SAE", "UNS", "SS", "EN", "DIN", "DIN EN", "JIS", "A313", "EN 10088-3",
    "10088-3", "EN 10270-1", "10270-1", "EN 10270-2", "10270-2", "EN 10270-3", "10270-3", "G 3522", "G 4314",
)  # fmt: skip
# Names that the wider one beside them agrees with: "stainless 17-7 PH", "oil tempered chrome silicon".
WIDER: Mapping[str, tuple[str, ...]] = {
    STAINLESS: ("stainless 302", "stainless 316", "stainless 17-7"),
    "music wire": ("EN 10270-1 SH", "EN 10270-1 DH"),
    "hard drawn": ("music wire", *(f"EN 10270-1 {grade}" for grade in ("SL", "SM", "DM", "SH", "DH"))),
    "oil tempered": ("valve spring", "chrome vanadium", "chrome silicon", *(
        f"EN 10270-2 {quality}{alloy}" for quality in ("FD", "TD", "VD") for alloy in ("C", "CrV", "SiCr")
    )),
}  # fmt: skip
_BUILT_IN = tuple(sorted({*ALIASES, *(name for each in WIDER.values() for name in each)} - {STAINLESS}))
_WORD = re.compile(r"[^\W\d_]+|\d+(?:\.\d+)?")
_EDITION = re.compile(r"(?<=\d):\d{4}(-\d\d)?\b|(?<=\bA\d{3})(M?)-\d\d\b", re.IGNORECASE)  # EN 10270-1:2011, A228-16


@dataclass(frozen=True)
class KnownMaterials:
    """The wire materials of the catalogues' judged rows, found by any of their spellings."""

    rows: tuple[MaterialRow, ...]
    wires: tuple[WireRow, ...] = ()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names in the catalogues, sorted."""
        return tuple(sorted({row.material for row in self.rows}))

    def name(self, written: str) -> str | None:
        """The catalogue's name of a material; None if the text names none, or more than one."""
        return material_name(written, self.names)

    def modulus(self, written: str, diameter: float) -> float | None:
        """Young's modulus of wire of ``diameter`` m, Pa; None if it or the material is unknown."""
        material = self.material(written)
        return None if material is None else material.elastic_modulus(diameter)

    def material(self, written: str) -> WireMaterial | None:
        """The data of a material; None if it is unknown."""
        name = self.name(written)
        if name is None:
            return None
        if name not in self._found:
            self._found[name] = wire_material(name, self.rows, self.wires)
        return self._found[name]

    @cached_property
    def _found(self) -> dict[str, WireMaterial]:
        """Materials by name; each stores the properties of its sizes."""
        return {}

    def fault(self, written: str) -> str:
        """What is wrong with a material's name, with similar ones; empty if it is known."""
        if self.name(written) is not None:
            return ""
        return f'"{written}" is not a known wire material{self.similar(written)}'

    def unknown_strength(self, written: str, diameter: float | None) -> str:
        """Why wire of ``diameter`` m cannot be held against its strength; empty if it can."""
        material = self.material(written)
        if material is None:
            return f"material {self.fault(written)}"
        try:
            if diameter is not None:
                material.properties(diameter)
        except UserError as error:
            return str(error)
        return ""

    def similar(self, written: str) -> str:
        """``; did you mean music wire?`` with similar names; empty if none is similar."""
        spellings = [*self.names, *(alias for each in ALIASES.values() for alias in each)]
        return did_you_mean(written, spellings, most=3)


def same_material(one: str, other: str) -> bool:
    """Whether two texts are equal, or name one material of the built-in catalogue."""
    name = material_name(one, _BUILT_IN)
    return one == other or (name is not None and name == material_name(other, _BUILT_IN))


@lru_cache(maxsize=4096)
def material_name(written: str, known: tuple[str, ...]) -> str | None:
    """The name among ``known`` that a text writes, in its own spelling or in a usual one; None if it is none."""
    folded = written.strip().casefold()
    for name in known:
        if name.casefold() == folded:
            return name
    names = _named(tuple(_WORD.findall(_EDITION.sub(r"\2", folded))), _spellings(known))
    if names is None:
        return None
    precise = {name for name in names if not any(other in WIDER.get(name, ()) for other in names)}
    if len(precise) != 1:
        return None
    name = precise.pop()
    name = USUAL_STAINLESS if name == STAINLESS else name
    return name if name in known else None


@lru_cache(maxsize=32)
def _spellings(known: tuple[str, ...]) -> dict[str, str]:
    """Names by their spellings without blanks and signs; empty for what names nothing."""
    found = {_squeezed(each): "" for each in BESIDE}
    for name, aliases in ALIASES.items():
        found |= {_squeezed(each): name for each in (name, *aliases)}
    return found | {_squeezed(name): name for name in known}


def _squeezed(text: str) -> str:
    return "".join(_WORD.findall(text.casefold()))


def _named(words: Sequence[str], spellings: Mapping[str, str]) -> set[str] | None:
    """All names in the text, the longest spelling first; None if a word is unknown."""
    names, start = set[str](), 0
    while start < len(words):
        ends = range(len(words), start, -1)
        end = next((end for end in ends if "".join(words[start:end]) in spellings), None)
        if end is None:
            return None
        names.add(spellings["".join(words[start:end])])
        start = end
    return names - {""}

"""Display units of a result: inch or metric, from --units or from the input.

Result files keep their units; only the screen and the winding sheet change.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth import units
from synth.errors import UserError
from synth.files.spring_words import System

SYSTEMS: tuple[System, ...] = ("inch", "metric")

# SI unit -> the usual unit in each system on a drawing or a data sheet.
_UNITS: dict[str, dict[str, str]] = {
    "metric": {
        "m": "mm",
        "kg": "g",
        "Pa": "MPa",
        "N": "N",
        "N*m": "N*m",
        "N*m/rad": "N*m/rad",
        "N*m*s/rad": "N*m*s/rad",
        "rad": "deg",
    },
    "inch": {
        "m": "in",
        "kg": "oz",
        "Pa": "kpsi",
        "N": "lbf",
        "N*m": "in*lbf",
        "N*m/rad": "in*lbf/rad",
        "N*m*s/rad": "in*lbf*s/rad",
        "rad": "deg",
    },
}
# Units of a number in a project, a leg file or on the command line; comments and names are left out below.
_INCH = re.compile(r"""(?<=\d)[ -]?(?:"|(?:in|inch|inches|ft|lb|lbs|lbf|oz|ozf|psi|kpsi|thou|mil)(?![A-Za-z]))""")
_METRIC = re.compile(r"(?<=\d) ?(?:[kmcuµ]?m|[km]?g|[mkc]?N(?![a-z])|[mkc]?Nm+|[MkG]?Pa)(?![A-Za-z])")
_COMMENT = re.compile(r"(?m)(?:^|\s)#.*$")
_READ = 1_000_000  # bytes of a project file: larger ones are refused anyway


@dataclass(frozen=True)
class ShownUnits:
    """Converts SI values and a result file's quantities into the units of one system."""

    system: System = "metric"

    def unit(self, si: str) -> str:
        """The displayed unit for the SI unit ``si``."""
        return _UNITS[self.system].get(si, si)

    def value(self, value: float, si: str) -> float:
        """A value in ``si`` in the displayed unit."""
        return value * units.factor(si, self.unit(si))

    def text(self, value: float, si: str, digits: str = ".4g") -> str:
        """A value in ``si`` with its unit."""
        return f"{self.value(value, si):{digits}} {self.unit(si)}"

    def of(self, quantity: Mapping[str, Any], si: str) -> dict[str, Any]:
        """A result file's ``{"value", "unit", "interval90"}`` in the displayed unit."""
        factor = units.factor(quantity["unit"], self.unit(si))
        shown = {**quantity, "value": quantity["value"] * factor, "unit": self.unit(si)}
        if quantity.get("interval90"):
            shown["interval90"] = [None if end is None else end * factor for end in quantity["interval90"]]
        return shown

    def throughout(self, content: Any) -> Any:
        """A result's content with every quantity that has a unit in this system in that unit; the rest as it is."""
        if isinstance(content, Mapping):
            if isinstance(content.get("unit"), str) and isinstance(content.get("value"), (int, float)):
                si = next((si for si in _UNITS[self.system] if _alike(content["unit"], si)), None)
                return content if si is None else self.of(content, si)
            return {name: self.throughout(item) for name, item in content.items()}
        return [self.throughout(item) for item in content] if isinstance(content, (list, tuple)) else content


def _alike(unit: str, si: str) -> bool:
    """Whether a unit has the dimension of an SI unit of lengths, masses, stresses, forces or torques."""
    try:
        units.factor(unit, si)
    except UserError:
        return False
    return si != "rad"


METRIC = ShownUnits("metric")


def written_system(texts: Iterable[str]) -> System:
    """Inch if more quantities are written in inch units than in metric ones, else metric."""
    inch = metric = 0
    for text in texts:
        plain = _COMMENT.sub("", text)
        inch += len(_INCH.findall(plain))
        metric += len(_METRIC.findall(plain))
    return "inch" if inch > metric else "metric"


def shown_for(asked: str | None, files: Iterable[Path] = (), texts: Iterable[str] = ()) -> ShownUnits:
    """From --units, else from the units in the files and texts.

    A file that can no longer be read is ignored.
    """
    if asked in SYSTEMS:
        return ShownUnits("inch" if asked == "inch" else "metric")
    found = list(texts)
    for path in files:
        if path.suffix.casefold() in (".yaml", ".yml"):
            try:
                found.append(path.read_bytes()[:_READ].decode("utf-8", errors="replace"))
            except OSError:
                continue
    return ShownUnits(written_system(found))

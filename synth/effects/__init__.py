"""What a joint may do beyond a linear spring and damper: one file an effect.

Each module of this package is named as in the file format and holds a compiled ``torque(rotation, rate,
*parameters)``; ``SPECIFICATIONS`` here carries what must be known without compiling anything.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """One number of an effect: its key in files, SI unit, the value where a file gives none (None: it must)."""

    name: str
    unit: str
    default: float | None = None


@dataclass(frozen=True)
class Specification:
    """An effect's name and its parameters in the order of its compiled function; off when the first is zero."""

    name: str
    parameters: tuple[Parameter, ...]
    meaning: str

    @property
    def module(self) -> str:
        """Import path of the module with the compiled function."""
        return f"synth.effects.{self.name}"


SPECIFICATIONS: tuple[Specification, ...] = (
    Specification(
        "coulomb_friction",
        (Parameter("torque", "N*m"), Parameter("speed", "rad/s", 0.02)),
        "dry friction, constant in speed; `speed` is where its sign is smoothed",
    ),
)


def effect_parameters() -> dict[str, dict[str, str]]:
    """Effect name -> parameter name -> SI unit, for reading files."""
    return {effect.name: {p.name: p.unit for p in effect.parameters} for effect in SPECIFICATIONS}

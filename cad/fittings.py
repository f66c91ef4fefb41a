"""Fittings of a joint, its loads, and its printing: dimensions in mm, N*m and MPa.

Our catalogues have no vendors' drawings of dampers and encoders, so each default is our own choice or has its source in
its field. Measure the parts that you bought.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from synth.cad.arm_shaft import FORMS, Form
from synth.cad.limits import DimensionProblem, dimension, range_problems, rounded_up

Hold = Literal["unknown", "none", "set_screw", "clamp"]
HOLDS: tuple[Hold, ...] = ("unknown", "none", "set_screw", "clamp")
HUB_REMEDY = (
    "set_screw or clamp if the damper's hub has one, or a form that turns with the shaft (d, square, hex), or another "
    "damper"
)


@dataclass(frozen=True)
class LoadDimensions:
    """Loads on a joint's parts; zero means unknown, and the load is not checked."""

    spring_rate: float = dimension(0.0, 0.0, 500.0, "N*m/rad", "as built, of both springs where there are two")
    damper_torque: float = dimension(0.0, 0.0, 200.0, "N*m", "the damper's largest, which goes through the shaft's key")


@dataclass(frozen=True)
class PrintDimensions:
    """Printer, print material and its required strength. The default material is Markforged's Onyx.

    ``strength`` is Onyx' tensile yield (Markforged composites data sheet). No data sheet gives the strength between
    layers; the fraction 0.5 is our assumption, so highly loaded parts should be printed with the load along the layers.
    """

    bed: tuple[float, float, float] = (320.0, 132.0, 154.0)
    strength: float = dimension(36.0, 1.0, 500.0, "MPa", "tensile yield along the layers")
    between_layers: float = dimension(0.5, 0.05, 1.0, "", "share of the strength that holds layer to layer")
    density: float = dimension(1.2, 0.3, 9.0, "g/cm^3", "solid material; Onyx 1.2")
    safety: float = dimension(1.5, 1.0, 10.0, "", "of stress against strength; 1.5 where loads are known")
    overhang: float = dimension(45.0, 10.0, 80.0, "deg", "from the vertical, that prints without support")
    thinnest: float = dimension(1.2, 0.2, 5.0, "mm", "wall that prints: two lines of 0.4 mm and their join")

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every number that is out of range."""
        found = range_problems(self, prefix)
        sizes = self.bed if isinstance(self.bed, tuple) else ()
        # From 10 mm, a coin, to the largest printers.
        if len(sizes) != 3 or not all(isinstance(size, (int, float)) and 10.0 <= size <= 2000.0 for size in sizes):
            found.append(DimensionProblem(prefix + "bed", self.bed, "three lengths of 10 to 2000 mm", "the bed's room"))
        return found


@dataclass(frozen=True)
class EncoderDimensions:
    """A magnetic angle sensor on ear B, over the shaft's end: round body, screws on a circle outside it."""

    body_diameter: float = dimension(22.0, 6.0, 80.0, "mm", "round housing; 22 is that of small ones (RLS RM22)")
    body_depth: float = dimension(5.0, 1.0, 40.0, "mm", "of the recess that it lies in")
    bolt_circle: float = dimension(27.0, 8.0, 100.0, "mm", "screw centres, outside the body")
    bolt_count: int = dimension(2, 2, 8, "", "two screws at least hold it from turning")
    bolt_diameter: float = dimension(2.4, 2.2, 6.0, "mm", "clearance hole, M2 by default")
    magnet_diameter: float = dimension(
        4.0,
        1.0,
        20.0,
        "mm",
        "diametric magnet in the shaft's end; 4 x 4 and 6 x 2.5 (AS5030's) are sold",
    )
    magnet_depth: float = dimension(4.0, 0.5, 10.0, "mm", "of its pocket in the shaft's end, the magnet's length")
    air_gap: float = dimension(1.0, 0.3, 5.0, "mm", "magnet to sensor; makers ask for 0.5 to 3")

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every reason why this encoder cannot be mounted."""
        return _screw_problems(self, self.body_diameter, "the encoder's body", prefix)


@dataclass(frozen=True)
class AdapterDimensions:
    """A coupling between the joint's shaft and a damper that has its own shaft instead of a bore.

    It is pinned on the joint's shaft. A round output is pinned too, which requires a hole drilled in it; on a flat of
    any other form a set screw removes the backlash.
    """

    output_diameter: float = dimension(6.0, 2.0, 30.0, "mm", "of the damper's shaft, or across its flats")
    output_grip: float = dimension(12.0, 2.0, 80.0, "mm", "how far it goes in; twice its diameter holds")
    shaft_grip: float = dimension(16.0, 2.0, 120.0, "mm", "how far the joint's shaft goes in")
    web: float = dimension(2.0, 1.0, 20.0, "mm", "between the two, so that neither pushes the other")
    form: Form = "d"

    @property
    def length(self) -> float:
        """Along the shaft, mm."""
        return self.output_grip + self.web + self.shaft_grip

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every number that is out of range."""
        return range_problems(self, prefix) + _form_problems(self.form, prefix + "form")


@dataclass(frozen=True)
class BoreDimensions:
    """The bore of a damper for the joint's shaft: its form, and its diameter or width across the flats.

    If the shaft can be milled to a square, D or hexagon of this size, it is milled; for a larger bore an insert is
    printed and pinned on the shaft. ``hub``: what holds a round shaft in a round bore, which alone would slip: a set
    screw, for which the shaft's end gets a flat, a clamp, or nothing, which is refused; ``unknown`` is drawn.
    """

    form: Form = "round"
    size: float | None = dimension(None, 2.0, 30.0, "mm", "left out: the joint's shaft")
    hub: Hold = "unknown"

    @property
    def slips(self) -> bool:
        """Whether nothing that is drawn or known turns the damper with the shaft."""
        return self.form == "round" and self.hub in ("unknown", "none")

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every number that is out of range, and a bore in which the shaft would slip."""
        found = range_problems(self, prefix) + _form_problems(self.form, prefix + "form")
        if self.form == "round" and self.hub == "none":
            reason = "a round shaft in a round bore transmits no torque: nothing would turn the damper"
            found.append(DimensionProblem(prefix + "hub", self.hub, HUB_REMEDY, reason))
        elif self.hub not in HOLDS:
            found.append(DimensionProblem(prefix + "hub", self.hub, ", ".join(HOLDS), "what holds a round shaft"))
        return found


@dataclass(frozen=True)
class DamperDimensions:
    """The envelope of a bought rotary damper: round body, two or more screws on a circle outside the body.

    ``unknown``: assumed dimensions, as text with the key for the measured value; drawn parts state them.
    """

    outer_diameter: float = dimension(40.0, 6.0, 150.0, "mm", "round body; 40 is a common oil damper")
    body_length: float = dimension(16.0, 3.0, 100.0, "mm", "from its flange to its end")
    bolt_circle: float = dimension(50.0, 9.0, 200.0, "mm", "screw centres, outside the body")
    bolt_count: int = dimension(4, 2, 12, "", "two screws at least hold a torque")
    bolt_diameter: float = dimension(3.4, 2.2, 9.0, "mm", "clearance hole, M3 by default")
    adapter: AdapterDimensions | None = None
    bore: BoreDimensions = field(default_factory=BoreDimensions)
    travel: float | None = dimension(None, 0.0, 1e5, "deg", "from one end to the other; left out it has no ends")
    unknown: tuple[str, ...] = ()

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every reason why this damper cannot be mounted."""
        found = _screw_problems(self, self.outer_diameter, "the damper's body", prefix)
        found += self.bore.problems(prefix + "bore.")
        return found + (self.adapter.problems(prefix + "adapter.") if self.adapter is not None else [])


@dataclass(frozen=True)
class MountDimensions:
    """A flange instead of the upper half's tube socket, by which the first joint is attached to the body."""

    thickness: float = dimension(8.0, 3.0, 30.0, "mm", "of the flange; twice a screw's diameter holds its head")
    bolt_diameter: float = dimension(4.5, 2.0, 13.0, "mm", "clearance hole, M4 by default")
    spacing_along: float = dimension(24.0, 6.0, 200.0, "mm", "of the four screws, along the hinge axis")
    spacing_across: float | None = dimension(
        None, 10.0, 400.0, "mm", "of the four screws, across it; left out their heads just pass the ears"
    )

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every number that is out of range, and screws whose heads would meet."""
        found, heads = range_problems(self, prefix), 2 * self.bolt_diameter
        if not found and self.spacing_along < heads:
            text = f"at least {heads:.4g} mm with screws of {self.bolt_diameter:g} mm"
            found.append(DimensionProblem(prefix + "spacing_along", self.spacing_along, text, "their heads would meet"))
        return found


def _form_problems(form: str, name: str) -> list[DimensionProblem]:
    if form in FORMS:
        return []
    return [DimensionProblem(name, form, ", ".join(FORMS), "the section by which a damper is driven")]


def _screw_problems(
    part: EncoderDimensions | DamperDimensions, body: float, what: str, prefix: str
) -> list[DimensionProblem]:
    """Why screws on a circle cannot hold a round body of diameter ``body`` (mm); other ranges first."""
    found = range_problems(part, prefix)
    if found:
        return found
    if not isinstance(part.bolt_count, int):
        found.append(DimensionProblem(prefix + "bolt_count", part.bolt_count, "a whole number", "it counts"))
    beside = (part.bolt_diameter + 1.0) / math.sin(math.pi / part.bolt_count)
    outside = body + part.bolt_diameter + 2.0
    if part.bolt_circle < max(beside, outside):
        reason = f"the screws pass outside {what} with 1 mm between"
        if beside > outside:
            reason = f"{part.bolt_count} screws fit on it with 1 mm between"
        least = max(beside, outside)
        allowed = f"at least {rounded_up(least)} mm"
        found.append(DimensionProblem(prefix + "bolt_circle", part.bolt_circle, allowed, reason, least))
    return found

"""Stress in what carries the spring's and the damper's torque, in closed form.

A clamped arm brings its spring's moment M into its seat of length l, which bears it by pressures that grow linearly
from the middle to both ends (a rigid bar in an elastic bed). What follows from it:

- the V's flanks, at 45 deg: the load at the end of the seat 6 M/l^2 a length on half of the wire's width;
- the cap, lifted by the V with as much at either end, 3 M/l in all, between its two screws a apart: a beam on two
  supports, 9 M a/(2 l^2 t^2);
- the screws' inserts, which take 3 M/(2 l) each: shear of the print round an insert;
- the seat plate, held on the ear by friction only: n screws at the radius r hold M when each is tightened to
  M/(n mu r), which its insert must bear as well;
- the horns of the stops: a cantilever that bears the spring's and the damper's torque at the stop;
- ears and hinge shaft: the force that keeps the coil on the axis (``cad.flexed_wire``): pressure F/(2 d t) in two ears,
  bending F L/8 over their span, the tongue spreading the load;
- the D-shaft, twisted by the damper: 16 T/(pi (0.9 d)^3), and pressed on half its flat, 2 h wide and l long, with a
  linear distribution: 3 T/(h^2 l).

Print bears less from layer to layer: Hankinson's formula between the two strengths. Nothing here is a peak at a
notch; sections and mean pressures only, as the material's scatter allows no more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cad.arm_layout import ArmLayout
from cad.arm_shaft import FLAT_DEPTH
from cad.dimensions import JointDimensions
from cad.fittings import PrintDimensions
from cad.flexed_wire import effective_length
from cad.hardware import insert_of
from cad.layout import JointLayout
from cad.outline import unit
from cad.parts import file_name
from cad.pose import loaded_wire
from cad.results import CheckResult, at_most

Axis = tuple[float, float, float]
SHAFT_YIELD = 240.0  # MPa; 303 stainless, the softest that ground shafts are sold in
BEARING = 1.5  # of the tensile strength, that a hole's wall bears (edge distance of two diameters)
FRICTION = 0.2  # print on print, dry; PLA and nylon are measured at 0.2 to 0.5
SHEAR = 1.0 / math.sqrt(3.0)  # of the tensile strength (von Mises)
# Directions that a load in the plane of the layers may have.
ALL_AROUND: tuple[Axis, Axis] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@dataclass(frozen=True)
class Stress:
    """One stress: where, how much, what the material bears, and which dimensions lower it.

    ``directions``: along which it pulls, in the joint's frame; empty: steel, which bears the same in all.
    """

    name: str
    part: str  # end of the part's name
    value: float  # MPa
    strength: float  # MPa, along the layers
    directions: tuple[Axis, ...]
    helped_by: tuple[str, ...]

    def allowed(self, printing: PrintDimensions, layers: Axis | None) -> float:
        """What may be there (MPa) when the part is printed with its layers square to ``layers``."""
        if not self.directions or layers is None:
            return self.strength / printing.safety
        share = min(_share(direction, layers, printing.between_layers) for direction in self.directions)
        return self.strength * share / printing.safety


def _share(direction: Axis, layers: Axis, between: float) -> float:
    """Hankinson: what is left of the strength at the angle between the pull and the layers' normal."""
    across = sum(a * b for a, b in zip(direction, layers, strict=True)) ** 2
    return between / (between * (1.0 - across) + across)


def axis_force(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Largest force (N) with which one spring presses on the hinge's axis, from stop to stop."""
    spring = dimensions.spring
    stiff = effective_length(spring.radius, spring.drawn_coils, layout.free_arm)
    rigidity = dimensions.loads.spring_rate / dimensions.springs * 1e3 * stiff  # EI, N mm^2
    found = (loaded_wire(dimensions, layout, angle) for angle in dimensions.stop_angles)
    return rigidity * max(wire.force for wire in found)


def _seat(dimensions: JointDimensions, layout: JointLayout, arm: ArmLayout, half: str, printed: float) -> list[Stress]:
    """Seat of one arm: V, cap and inserts; ``printed`` MPa: the print's strength."""
    seat, wire = layout.seat, dimensions.spring.wire_diameter
    moment = dimensions.spring_torque * 1e3 / dimensions.springs
    insert = insert_of(seat.screw)
    body = "seat" if half == "upper" else "lower"
    across, up = (*unit(arm.direction + 90.0), 0.0), (0.0, 0.0, 1.0)
    flank = 6 * moment / seat.length**2 / (wire / 2)
    bending = 9 * moment * seat.screw_at / (seat.length**2 * seat.cap**2)
    torn = 1.5 * moment / seat.length / (math.pi * insert.hole * insert.length)
    longer = ("seat_length",)
    return [
        Stress(f"{half} seat, pressure", body, flank, BEARING * printed, (across,), longer),
        Stress(f"{half} cap, bending", f"{half}_cap", bending, printed, (across,), ("cap", "seat_length")),
        Stress(f"{half} seat's inserts, shear", body, torn, SHEAR * printed, (up,), (*longer, "seat_screw")),
    ]


def _plate(dimensions: JointDimensions, layout: JointLayout, printed: float) -> Stress:
    """What the seat plate's screws must be tightened to, as shear of the print round their inserts."""
    moment = dimensions.spring_torque * 1e3 / dimensions.springs
    insert, plate = insert_of(layout.seat.screw), layout.plate
    tightened = moment / (len(plate.angles) * FRICTION * plate.radius)
    torn = tightened / (math.pi * insert.hole * insert.length)
    return Stress("seat plate's inserts, shear", "seat", torn, SHEAR * printed, ((0.0, 0.0, 1.0),), ("seat_screw",))


def _stops(dimensions: JointDimensions, layout: JointLayout, printed: float) -> list[Stress]:
    """Each horn's bending where it leaves the cup."""
    torque = (dimensions.spring_torque + dimensions.loads.damper_torque) * 1e3
    floor = layout.floor_top - layout.floor_bottom
    found = []
    for stop, which in zip(layout.stops, ("low", "high"), strict=True):
        lever = stop.outer - layout.space.tongue_radius
        bending = 6 * torque / stop.outer * lever / (floor * stop.width**2)
        along = (*unit(stop.flank), 0.0)
        found.append(Stress(f"{which} stop, bending", "lower", bending, printed, (along,), ("wall", "floor")))
    return found


def key_pressure(torque: float, diameter: float, length: float) -> float:
    """Pressure (MPa) on half the flat of a D-shaft, ``length`` mm long, that bears ``torque`` N*m."""
    flat = diameter / 2 * math.sqrt(1.0 - (1.0 - 2 * FLAT_DEPTH) ** 2)
    return 3 * torque * 1e3 / (flat**2 * length)


def _damper(dimensions: JointDimensions, layout: JointLayout, printed: float) -> list[Stress]:
    """The damper's torque through the D-shaft and its keys."""
    torque, shaft = dimensions.loads.damper_torque, dimensions.shaft_diameter
    adapter = dimensions.damper.adapter
    # Where an arbor stands in the pocket, its bore keys the shaft as well.
    key = layout.floor_top - layout.floor_bottom if not layout.space.arbor_radius else 2 * layout.half_width
    bore = BEARING * printed
    found = [
        Stress("shaft, torsion", "shaft", 16 * torque * 1e3 / (math.pi * (0.9 * shaft) ** 3), SHEAR * SHAFT_YIELD, (),
               ("shaft_diameter",)),
        Stress("shaft's key in the lower half", "lower", key_pressure(torque, shaft, key), bore, ALL_AROUND,
               ("floor", "shaft_diameter")),
    ]  # fmt: skip
    if adapter is not None:
        for where, diameter, grip, helped in (
            ("shaft's key in the adapter", shaft, adapter.shaft_grip, "adapter.shaft_grip"),
            ("damper's key in the adapter", adapter.output_diameter, adapter.output_grip, "adapter.output_grip"),
        ):
            pressure = key_pressure(torque, diameter, grip)
            found.append(Stress(where, "damper_adapter", pressure, bore, ALL_AROUND, (helped, "shaft_diameter")))
    return found


def stresses(dimensions: JointDimensions, layout: JointLayout, printing: PrintDimensions) -> tuple[Stress, ...]:
    """Every stress that a known load makes in a joint; none for a load of zero."""
    found: list[Stress] = []
    printed = printing.strength
    if dimensions.spring_torque > 0.0:
        for half, arm in (("upper", layout.upper), ("lower", layout.lower)):
            found += _seat(dimensions, layout, arm, half, printed)
        found.append(_plate(dimensions, layout, printed))
        found += _stops(dimensions, layout, printed)
        shaft, span = dimensions.shaft_diameter, layout.gap_a + layout.gap_b + dimensions.plate
        between = dimensions.springs * axis_force(dimensions, layout)
        ears = between / (2 * shaft * dimensions.plate)
        found.append(Stress("ears' bores, pressure", "upper", ears, BEARING * printed, ALL_AROUND, ("plate",)))
        bending = 32 * (between * span / 8) / (math.pi * shaft**3)
        found.append(Stress("shaft, bending", "shaft", bending, SHAFT_YIELD, (), ("shaft_diameter",)))
    if dimensions.loads.damper_torque > 0.0:
        found += _damper(dimensions, layout, printed)
    flip_x, flip_z = layout.flips
    return tuple(_flipped(stress, flip_x, flip_z) for stress in found)


def _flipped(stress: Stress, flip_x: int, flip_z: int) -> Stress:
    directions = tuple((flip_x * x, y, flip_z * z) for x, y, z in stress.directions)
    return Stress(stress.name, stress.part, stress.value, stress.strength, directions, stress.helped_by)


def check_strength(
    dimensions: JointDimensions, layout: JointLayout, printing: PrintDimensions, layers: dict[str, Axis]
) -> list[CheckResult]:
    """Every stress against what is allowed; ``layers``: the layers' normal of each printed part, by the part's name."""
    results, joint = [], file_name(dimensions.name)
    for stress in stresses(dimensions, layout, printing):
        name = f"{joint}_{stress.part}"
        allowed = stress.allowed(printing, layers.get(name))
        helped = " or ".join(stress.helped_by)
        text = f"a larger {helped} lowers it; safety {printing.safety:g} is in the limit"
        results.append(at_most(f"strength: {stress.name}", name, stress.value, allowed, "MPa", text))
    return results

"""Stress in what carries the spring's and the damper's torque, in closed form.

An arm of lever s presses on its shaft with F = T/s, square to the arm. What follows from it:

- the arm's dowel, a cantilever of length a above its seat: 32 F a/(pi p^3);
- its seat, a rigid pin in print t deep: pressure F (4 + 6 a/t)/(p t), from the force and its moment about the
  seat's middle (linear distribution; Shigley, Mechanical Engineering Design, press-fit and pinned joints);
- the lug round the seats, twisted by F (a + t/2): 3 M/(w t^2 (1 - 0.63 t/w)) (Roark, torsion of a strip), and torn
  out through its rim: F/(2 t e);
- of a pair of springs the lower dowel goes through the floor and both press on it the same way: 2 F, and no moment
  but that of what the springs differ, a fifth at 10 % of rate either way;
- ears and hinge shaft: the coil leans on the lower half, so what passes between the halves is the upper arm's F:
  pressure F/(2 d t) in two ears, bending F L/8 over their span, the tongue spreading the load;
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
from cad.layout import JointLayout
from cad.outline import unit
from cad.parts import file_name
from cad.results import CheckResult, at_most

Axis = tuple[float, float, float]
DOWEL_YIELD = 600.0  # MPa; hardened dowel pins (ISO 8734) bear more, stainless ones (ISO 2338 A1) less
SHAFT_YIELD = 240.0  # MPa; 303 stainless, the softest that ground shafts are sold in
BEARING = 1.5  # of the tensile strength, that a hole's wall bears (edge distance of two diameters)
UNEVEN = 0.2  # of an arm's force, that a pair of springs may differ: each is sold to 10 % of its rate
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


def arm_force(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Largest force (N) of one arm on its shaft: torque over the lever, which is the arm's length to the shaft."""
    return dimensions.spring_torque * 1e3 / layout.pin_reach / dimensions.springs


def _levers(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Largest height (mm) of the contact over the seat's face: upper and lower arm."""
    slope = dimensions.spring.drawn_pitch / (2 * math.pi * dimensions.spring.radius)
    drift = slope * layout.pin_reach
    return (
        layout.gap - (layout.coil_start + layout.coil_height - layout.coil_drop + drift),
        layout.coil_start - drift - layout.floor_top,
    )


def _seat(
    dimensions: JointDimensions, arm: ArmLayout, half: str, force: float, lever: float, printed: float
) -> list[Stress]:
    """Dowel, seat and lug of one arm, or of a pair's lower arms on one dowel; ``printed`` MPa: the print's strength."""
    pin, wall = dimensions.pin_diameter, dimensions.wall
    deep = "floor" if half == "lower" else "plate"
    depth = dimensions.floor_thickness if half == "lower" else dimensions.plate
    pressed, tilting = (2 - UNEVEN, UNEVEN) if half == "lower" and dimensions.springs == 2 else (1.0, 1.0)
    push = (*unit(arm.direction + 90.0), 0.0)
    along = (*unit(arm.direction), 0.0)
    apart = math.dist(arm.bearing, arm.keeper)
    width = apart + pin + 2 * wall
    twist = tilting * force * (lever + depth / 2)
    pressure = (pressed * force + 6 * twist / depth) / (pin * depth)
    strip = max(1.0 - 0.63 * depth / width, 0.37)
    return [
        Stress(f"{half} dowel, bending", f"{half}_arm_shaft", 32 * force * lever / (math.pi * pin**3), DOWEL_YIELD, (),
               ("pin_diameter",)),
        Stress(f"{half} dowel's seat, pressure", half, pressure, BEARING * printed, (push,), ("pin_diameter", deep)),
        Stress(f"{half} lug, torsion", half, 3 * twist / (width * depth**2 * strip), SHEAR * printed, (push, along),
               (deep, "wall")),
        Stress(f"{half} lug, tear-out", half, pressed * force / (2 * depth * wall), SHEAR * printed, (push,),
               (deep, "wall")),
    ]  # fmt: skip


def key_pressure(torque: float, diameter: float, length: float) -> float:
    """Pressure (MPa) on half the flat of a D-shaft, ``length`` mm long, that bears ``torque`` N*m."""
    flat = diameter / 2 * math.sqrt(1.0 - (1.0 - 2 * FLAT_DEPTH) ** 2)
    return 3 * torque * 1e3 / (flat**2 * length)


def _damper(dimensions: JointDimensions, layout: JointLayout, printed: float) -> list[Stress]:
    """The damper's torque through the D-shaft and its keys."""
    torque, shaft = dimensions.loads.damper_torque, dimensions.shaft_diameter
    adapter = dimensions.damper.adapter
    # Where an arbor stands in the pocket, its bore keys the shaft as well.
    key = dimensions.floor_thickness if not layout.arbor_radius else 2 * layout.half_width
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
    force = arm_force(dimensions, layout)
    if force > 0.0:
        upper, lower = _levers(dimensions, layout)
        found += _seat(dimensions, layout.upper, "upper", force, upper, printed)
        found += _seat(dimensions, layout.lower, "lower", force, lower, printed)
        shaft, span = dimensions.shaft_diameter, 2 * layout.gap + dimensions.plate
        between = dimensions.springs * force
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

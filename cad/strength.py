"""Stresses from the spring's and the damper's torque, in closed form.

A clamped arm transmits its spring's moment M to its seat of length l. The seat's pressure grows linearly from the
middle to both ends (a rigid bar on an elastic foundation). The resulting stresses are:

- the flanks of the V groove, at 45 deg: the line load 6 M/l^2 at the end of the seat, on half of the wire's width;
- the cap, lifted by the V with as much at either end, 3 M/l in all, between its two screws a apart: a beam on two
  supports, 9 M a/(2 l^2 t^2);
- the screws' inserts, which take 3 M/(2 l) each: shear of the print round an insert;
- the seat plate, held on the ear by friction only: n screws at the radius r hold M when each is tightened to
  M/(n mu r), which its insert must bear as well;
- the horns of the stops: a cantilever that bears the spring's and the damper's torque at the stop;
- ears and hinge shaft: the force that keeps the coil on the axis (``cad.flexed_wire``): pressure F/(2 d t) in two ears,
  bending F L/8 over their span, the tongue spreading the load;
- the shaft in torsion by the damper: 16 T/(pi (0.9 d)^3), where the tenth accounts for the hole of its pin;
- its end, milled to fit the damper, in torsion as a round shaft of the width across its flats;
- its pins (Roloff/Matek, cross pin under torsion): shear of the pin 4 T/(pi D d^2), pressure in the print beside it
  T/(d s (D + s)), s of its length in the hub on either side, D the shaft, d the pin;
- a D, square or hexagon that drives or is driven: pressure on half of each flat, h wide and l long, that grows
  linearly to its edge: 3 T/(n l h^2) with n half flats (a D: one; a square: four; a hexagon: six);
- the bearings: the force that keeps the coil on the axis, halved, against their static load;
- the link's tube: what holds the link against the spring bends it by up to the torque at the stop, M/Z with
  Z = pi (D^4 - d^4)/(32 D); its screws' holes lie on the neutral line;
- the tube's sockets, which pass that moment on as a seat does: the pressure of its line load 6 M/l^2 on the tube's
  width, and the pull that it causes in the walls on both sides of the tube, 3 M/(l^2 t) (net section of a lug).

Print has a lower strength between layers: Hankinson's formula interpolates between the two strengths. Stresses are
those of sections and mean pressures, without notch factors, which the material's scatter does not justify.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad.arm_layout import ArmLayout
from synth.cad.arm_shaft import FLAT_DEPTH, SIDES, Form, flat_distance
from synth.cad.damper_bracket import ROTOR_GRIP
from synth.cad.dimensions import JointDimensions
from synth.cad.fitting_problems import adapter_pins, has_insert, longest_pin
from synth.cad.fittings import PrintDimensions
from synth.cad.flexed_wire import effective_length
from synth.cad.hardware import Pin, insert_of
from synth.cad.layout import JointLayout
from synth.cad.outline import unit
from synth.cad.parts import file_name
from synth.cad.pose import loaded_wire
from synth.cad.results import CheckResult, check_at_most
from synth.cad.shaft_line import tongue_pin

Axis = tuple[float, float, float]
SHAFT_YIELD = 240.0  # MPa; 303 stainless, the softest that ground shafts are sold in
PIN_YIELD = 650.0  # MPa; lowest published value for the core of hardened dowels; ASME B18.8.5M: 1050 MPa in shear
# MPa, 0.2 % proof stress: EN AW-6060 T6 extruded, EN 755-2, the softest that aluminium tube is commonly sold in
# (6060 T66: 160, 6063 T6: 170, 6082 T6: 250); from memory, the standard was not at hand.
TUBE_YIELD = 150.0
BEARING = 1.5  # of the tensile strength: bearing strength of a hole's wall (edge distance of two diameters)
FRICTION = 0.2  # print on print, dry; PLA and nylon are measured at 0.2 to 0.5
SHEAR = 1.0 / math.sqrt(3.0)  # of the tensile strength (von Mises)
# Directions that a load in the plane of the layers may have.
ALL_AROUND: tuple[Axis, Axis] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))

STATED = ("shaft_diameter", "wall", "link_width", "tube_wall")  # dimensions that help and that a user states
OF_DAMPER = {"damper.bore.size": "a damper with a thicker hub", "damper.body_length": "a longer damper"}


@dataclass(frozen=True)
class Stress:
    """One stress: place, value, strength of the material, and dimensions that reduce it.

    ``directions``: along which it pulls, in the joint's frame; empty: steel, which bears the same in all.
    """

    name: str
    part: str  # end of the part's name
    value: float  # MPa
    strength: float  # MPa, along the layers
    directions: tuple[Axis, ...]
    helped_by: tuple[str, ...]

    def allowed(self, printing: PrintDimensions, layers: Axis | None) -> float:
        """The allowed value (MPa) when the part is printed with its layers perpendicular to ``layers``."""
        if not self.directions or layers is None:
            return self.strength / printing.safety
        share = min(_share(direction, layers, printing.between_layers) for direction in self.directions)
        return self.strength * share / printing.safety


def _share(direction: Axis, layers: Axis, between: float) -> float:
    """Hankinson: the remaining strength at the angle between the pull and the layers' normal."""
    across = sum(a * b for a, b in zip(direction, layers, strict=True)) ** 2
    return between / (between * (1.0 - across) + across)


def axis_force(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Largest force (N) of one spring on the hinge's axis, from stop to stop."""
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
    bending = 9 * moment * seat.screw_at / ((seat.length - arm.relief) ** 2 * seat.cap**2)
    torn = 1.5 * moment / seat.length / (math.pi * insert.hole * insert.length)
    longer = ("seat_length",)
    return [
        Stress(f"{half} seat, pressure", body, flank, BEARING * printed, (across,), longer),
        Stress(f"{half} cap, bending", f"{half}_cap", bending, printed, (across,), ("cap", "seat_length")),
        Stress(f"{half} seat's inserts, shear", body, torn, SHEAR * printed, (up,), (*longer, "seat_screw")),
    ]


def _plate(dimensions: JointDimensions, layout: JointLayout, printed: float) -> Stress:
    """The required tightening of the seat plate's screws, as shear of the print around their inserts."""
    moment = dimensions.spring_torque * 1e3 / dimensions.springs
    insert, plate = insert_of(layout.seat.screw), layout.plate
    tightened = moment / (len(plate.angles) * FRICTION * plate.radius)
    torn = tightened / (math.pi * insert.hole * insert.length)
    return Stress("seat plate's inserts, shear", "seat", torn, SHEAR * printed, ((0.0, 0.0, 1.0),), ("seat_screw",))


def _stops(dimensions: JointDimensions, layout: JointLayout, printed: float) -> list[Stress]:
    """Each horn's bending at its root."""
    torque = dimensions.stop_torque * 1e3
    floor = layout.floor_top - layout.floor_bottom
    found = []
    for stop, which in zip(layout.stops, ("low", "high"), strict=True):
        lever = stop.outer - layout.space.tongue_radius
        bending = 6 * torque / stop.outer * lever / (floor * stop.width**2)
        along = (*unit(stop.flank), 0.0)
        found.append(Stress(f"{which} stop, bending", "lower", bending, printed, (along,), ("wall", "floor")))
    return found


def tube_modulus(outer: float, wall: float) -> float:
    """Section modulus (mm^3) of a tube of diameter ``outer`` and thickness ``wall``, mm."""
    inner = outer - 2 * wall
    return math.pi * (outer**4 - inner**4) / (32 * outer)


def _link(dimensions: JointDimensions, layout: JointLayout, printed: float) -> list[Stress]:
    """The link's tube, and the sockets in which both halves hold a tube."""
    moment, along = dimensions.stop_torque * 1e3, ((1.0, 0.0, 0.0),)
    bending = moment / tube_modulus(dimensions.link_width, dimensions.tube_wall)
    found = [Stress("link's tube, bending", "link", bending, TUBE_YIELD, (), ("link_width", "tube_wall"))]
    line_load = 6 * moment / layout.socket_depth**2
    deeper = ("socket", "link_width")
    for half in ("lower", "upper") if dimensions.mount is None else ("lower",):
        pressure, pull = line_load / dimensions.link_width, line_load / (2 * dimensions.wall)
        found += [
            Stress(f"{half} socket, pressure", half, pressure, BEARING * printed, along, deeper),
            Stress(f"{half} socket's wall, tension", half, pull, printed, along, (*deeper, "wall")),
        ]
    return found


def key_pressure(torque: float, form: Form, size: float, length: float) -> float:
    """Pressure (MPa) on the flats of a section, ``length`` mm long, that bears ``torque`` N*m."""
    if form == "d":
        count, half = 1, size / 2 * math.sqrt(1.0 - (1.0 - 2 * FLAT_DEPTH) ** 2)
    else:
        count, half = SIDES[form], size / 2 * math.tan(math.pi / SIDES[form])
    return 3 * torque * 1e3 / (count * half**2 * length)


def pin_stresses(torque: float, pin: Pin, shaft: float, hub: float) -> tuple[float, float]:
    """Shear (MPa) of a cross pin, and pressure (MPa) beside it in a hub of diameter ``hub`` mm."""
    held = (min(pin.length, hub) - shaft) / 2
    shear = 4 * torque * 1e3 / (math.pi * shaft * pin.size**2)
    return shear, torque * 1e3 / (pin.size * held * (shaft + held))


def _pin_stresses(
    where: str, part: str, torque: float, pin: Pin, shaft: float, hub: float, printed: float, helped: tuple[str, ...]
) -> list[Stress]:
    shear, pressure = pin_stresses(torque, pin, shaft, hub)
    return [
        Stress(f"{where}, shear of the pin", "shaft", shear, SHEAR * PIN_YIELD, (), ("shaft_diameter",)),
        Stress(f"{where}, pressure of the pin", part, pressure, BEARING * printed, ALL_AROUND, helped),
    ]


def _damper(dimensions: JointDimensions, layout: JointLayout, printed: float) -> list[Stress]:
    """The damper's torque through shaft, pins and their connection to the damper."""
    torque, shaft = dimensions.loads.damper_torque, dimensions.shaft_diameter
    damper, bore = dimensions.damper, BEARING * printed
    pin = tongue_pin(dimensions, layout.space.tongue_radius)
    assert pin is not None
    twisted = 16 * torque * 1e3 / (math.pi * (0.9 * shaft) ** 3)
    found = [Stress("shaft, torsion", "shaft", twisted, SHEAR * SHAFT_YIELD, (), ("shaft_diameter",))]
    found += _pin_stresses(
        "shaft in the lower half",
        "lower",
        torque,
        pin,
        shaft,
        2 * layout.space.tongue_radius,
        printed,
        ("shaft_diameter",),
    )
    if damper.adapter is not None:
        adapter, pins = damper.adapter, adapter_pins(dimensions)
        outputs = [(shaft, pins[0]), *([(adapter.output_diameter, pins[1])] if len(pins) > 1 else [])]
        for (diameter, held), whose in zip(outputs, ("shaft", "damper"), strict=False):
            assert held is not None
            found += _pin_stresses(
                f"{whose} in the adapter",
                "damper_adapter",
                torque,
                held,
                diameter,
                held.length,
                printed,
                ("wall", "shaft_diameter"),
            )
        if adapter.form != "round":
            pressure = key_pressure(torque, adapter.form, adapter.output_diameter, adapter.output_grip)
            found.append(Stress("damper's key in the adapter", "damper_adapter", pressure, bore, ALL_AROUND,
                                ("adapter.output_grip",)))  # fmt: skip
    elif not has_insert(dimensions):
        found += _milled_stresses(dimensions)
    else:
        size = damper.bore.size
        assert size is not None
        held = longest_pin(dimensions.hardware.pin, shaft, size - 2 * dimensions.fit)
        assert held is not None
        found += _pin_stresses(
            "shaft in the damper's insert",
            "damper_insert",
            torque,
            held,
            shaft,
            held.length,
            printed,
            ("shaft_diameter",),
        )
        if damper.bore.form != "round":
            grip = ROTOR_GRIP * damper.body_length
            pressure = key_pressure(torque, damper.bore.form, size, grip)
            found.append(Stress("damper's insert, pressure", "damper_insert", pressure, bore, ALL_AROUND,
                                ("damper.body_length",)))  # fmt: skip
    return found


def _milled_stresses(dimensions: JointDimensions) -> list[Stress]:
    """The shaft's milled end in the damper: torsion of the circle within its flats, pressure on them."""
    torque, bore = dimensions.loads.damper_torque, dimensions.damper.bore
    if bore.form == "round":
        return []
    size = bore.size if bore.size is not None else dimensions.shaft_diameter
    inside = size / 2 + flat_distance(bore.form, size)  # across the flats; of a D less than its free circle
    twisted = 16 * torque * 1e3 / (math.pi * inside**3)
    pressure = key_pressure(torque, bore.form, size, ROTOR_GRIP * dimensions.damper.body_length)
    return [
        Stress("shaft's end, torsion", "shaft", twisted, SHEAR * SHAFT_YIELD, (), ("damper.bore.size",)),
        Stress("shaft's end in the damper, pressure", "shaft", pressure, BEARING * SHAFT_YIELD, (),
               ("damper.bore.size",)),
    ]  # fmt: skip


def stresses(dimensions: JointDimensions, layout: JointLayout, printing: PrintDimensions) -> tuple[Stress, ...]:
    """Every stress of a known load in a joint; none for a load of zero."""
    found: list[Stress] = []
    printed = printing.strength
    if dimensions.spring_torque > 0.0:
        for half, arm in (("upper", layout.upper), ("lower", layout.lower)):
            found += _seat(dimensions, layout, arm, half, printed)
        found.append(_plate(dimensions, layout, printed))
        found += _stops(dimensions, layout, printed)
        shaft, span = dimensions.shaft_diameter, layout.gap_a + layout.gap_b + layout.ear
        between = dimensions.springs * axis_force(dimensions, layout)
        bearing = dimensions.hardware.bearing
        ears = between / (2 * bearing.outer_diameter * bearing.width)
        found.append(Stress("ears' bores, pressure", "upper", ears, BEARING * printed, ALL_AROUND, ("shaft_diameter",)))
        bending = 32 * (between * span / 8) / (math.pi * shaft**3)
        found.append(Stress("shaft, bending", "shaft", bending, SHAFT_YIELD, (), ("shaft_diameter",)))
    if dimensions.loads.damper_torque > 0.0:
        found += _damper(dimensions, layout, printed)
    if dimensions.stop_torque > 0.0:
        found += _link(dimensions, layout, printed)
    flip_x, flip_z = layout.flips
    return tuple(_flip_stress(stress, flip_x, flip_z) for stress in found)


def _flip_stress(stress: Stress, flip_x: int, flip_z: int) -> Stress:
    directions = tuple((flip_x * x, y, flip_z * z) for x, y, z in stress.directions)
    return Stress(stress.name, stress.part, stress.value, stress.strength, directions, stress.helped_by)


def remedy(stress: Stress) -> str:
    """What a user may change to reduce a stress; dimensions that ``cad.sizing`` chooses are named as such."""
    stated = [name for name in stress.helped_by if name in STATED]
    ways = [f"a larger {' or '.join(stated)}"] if stated else []
    ways += [OF_DAMPER[name] for name in stress.helped_by if name in OF_DAMPER]
    ways += ["a stronger print (print_strength)"] if stress.directions else []
    sized = [name for name in stress.helped_by if name not in (*STATED, *OF_DAMPER)]
    words = " or ".join(name.rpartition(".")[2].replace("_", " ") for name in sized)
    text = f"{' or '.join(ways)} reduces it"
    return text + (f"; so does a larger {words}, which the program chooses" if sized else "")


def check_strength(
    dimensions: JointDimensions, layout: JointLayout, printing: PrintDimensions, layers: dict[str, Axis]
) -> list[CheckResult]:
    """Every stress against what is allowed; ``layers``: the layers' normal of each printed part, by the part's name."""
    results, joint = [], file_name(dimensions.name)
    bearing = dimensions.hardware.bearing
    if dimensions.spring_torque > 0.0:
        load = dimensions.springs * axis_force(dimensions, layout) / 2
        text = f"static load of {bearing.designation}, half of the force that keeps the coil on the axis on each"
        text += "; a larger shaft_diameter allows a larger bearing"
        limit = bearing.static_load / printing.safety
        results.append(check_at_most("strength: bearing", f"{joint}_bearing_a", load, limit, "N", text))
    for stress in stresses(dimensions, layout, printing):
        name = f"{joint}_{stress.part}"
        allowed = stress.allowed(printing, layers.get(name))
        text = f"{remedy(stress)}; safety {printing.safety:g} is in the limit"
        results.append(check_at_most(f"strength: {stress.name}", name, stress.value, allowed, "MPa", text))
    return results

"""Checks of a joint's fittings: encoder, damper's adapter, mount, shaft. Arithmetic only, no solids."""

from __future__ import annotations

import math

from synth.cad.arm_layout import longest_seat
from synth.cad.arm_shaft import SIDES, Form, circumradius, flat_distance
from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import Pin, insert_of, pin_at_least, pin_size
from synth.cad.layout import SUNK_ASIDE, JointLayout, bearing_pocket, bracket_bore, fixing_screw
from synth.cad.limits import DimensionProblem, rounded_up
from synth.cad.link_socket import socket_screw
from synth.cad.outlines import mount_across
from synth.cad.screw_places import SET_SCREW, bracket_depths
from synth.cad.shaft_line import lay_shaft, pin_spare, tongue_pin

# of a square's or hexagon's diagonal that the rod it is milled from may have: a twentieth off each corner
ROUNDED = 0.9

BESIDE = 1.2  # mm of print between an insert's hole and what is beside it: three lines
BODY_WALL = 0.5  # mm, least wall of a bought damper's body: sheet metal
LOOSEST_FIT = 0.06  # of a shaft's diameter: with more clearance only pins and set screws would align the shaft
LEAST_HELD = 1.2  # mm, least engagement of a pin in its hub, on either side of the shaft
LEAST_INSERT_WALL = 1.6  # mm, of a printed insert round the shaft: four lines


def adapter_radius(dimensions: JointDimensions) -> float:
    """Outer radius of the damper's adapter, mm: a wall around the wider bore, and the set screw's insert."""
    adapter = dimensions.damper.adapter
    wide = dimensions.shaft_diameter / 2
    deep = 0.0
    if adapter is not None:
        wide = max(wide, circumradius(adapter.form, adapter.output_diameter))
        if adapter.form != "round":
            deep = flat_distance(adapter.form, adapter.output_diameter) + insert_of(SET_SCREW).length + 0.5
    return max(wide + dimensions.fit + dimensions.wall, deep)


def adapter_pins(dimensions: JointDimensions) -> list[Pin | None]:
    """Pins of the adapter: through the joint's shaft, and through a round output; None if none is sold."""
    adapter = dimensions.damper.adapter
    if adapter is None:
        return []
    outside = 2 * adapter_radius(dimensions)
    found = [longest_pin(dimensions.hardware.pin, dimensions.shaft_diameter, outside)]
    if adapter.form == "round":
        found.append(longest_pin(pin_size(adapter.output_diameter), adapter.output_diameter, outside))
    return found


def longest_pin(size: float, shaft: float, outside: float) -> Pin | None:
    """The longest pin sold that ends within a hub of diameter ``outside`` (mm) and is held on both sides."""
    found = pin_at_least(size, shaft + 2 * LEAST_HELD)
    if found is None or found.length > outside:
        return None
    while (longer := pin_at_least(size, found.length + 0.5)) is not None and longer.length <= outside:
        found = longer
    return found


def has_insert(dimensions: JointDimensions) -> bool:
    """Whether the damper's bore takes a printed insert on the shaft rather than the shaft's milled end."""
    bore = dimensions.damper.bore
    if dimensions.damper.adapter is not None or bore.size is None:
        return False
    return milled_size(bore.form, bore.size) > dimensions.shaft_diameter


def milled_size(form: Form, size: float) -> float:
    """Diameter (mm) of the rod from which a section is milled; squares and hexagons may have round corners."""
    return ROUNDED * 2 * circumradius(form, size) if form in SIDES else size


def fitting_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Fittings that do not fit, under the responsible dimension."""
    return [
        *_seat(dimensions, layout),
        *_fit(dimensions),
        *_pin_problems(dimensions, layout),
        *_socket(dimensions, layout),
        *damper_problems(dimensions, layout),
        *_encoder(dimensions),
        *_mount(dimensions, layout),
    ]


def damper_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """What does not fit of the damper and of what joins it to the shaft; no size of the spring matters."""
    return [
        *_bracket(dimensions, layout),
        *_bore(dimensions),
        *_body(dimensions),
        *_adapter(dimensions),
    ]


def _seat(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """A seat so long that the rising arm lets the cap touch the pad."""
    longest = longest_seat(dimensions)
    if layout.seat.length <= longest:
        return []
    reason = "the arm rises with the coil's pitch: the cap of a longer seat would touch the pad beside the wire"
    if dimensions.seat_length is None:
        reason += "; the load asks for this length: take two springs or a thicker wire on a wider coil"
    return [DimensionProblem(f"{dimensions.name}.seat_length", layout.seat.length, f"at most {longest:.4g} mm", reason)]


def _fit(dimensions: JointDimensions) -> list[DimensionProblem]:
    most = LOOSEST_FIT * dimensions.shaft_diameter
    if dimensions.fit <= most:
        return []
    allowed = f"at most {most:.3g} mm with a shaft of {dimensions.shaft_diameter:g} mm"
    return [DimensionProblem(f"{dimensions.name}.fit", dimensions.fit, allowed, "the shaft would tilt in its bore")]


def _pin_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """A tongue too small for its pin, or without a place for the pin's hole."""
    name, text = f"{dimensions.name}.shaft_diameter", "a thinner shaft, or a coil with more space around it"
    if tongue_pin(dimensions, layout.space.tongue_radius) is None:
        reason = "no dowel pin is sold that ends inside the lower half"
        return [DimensionProblem(name, dimensions.shaft_diameter, text, reason)]
    if pin_spare(layout, lay_shaft(dimensions, layout, 0.0)) < BESIDE:
        reason = "the pin's hole would meet the seat's inserts in every direction"
        return [DimensionProblem(name, dimensions.shaft_diameter, text, reason)]
    return []


def _socket(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """A link so wide that no screw is sold for its socket."""
    if socket_screw(layout.socket_outer) is not None:
        return []
    name = f"{dimensions.name}.link_width"
    return [DimensionProblem(name, dimensions.link_width, "a thinner tube", "no screw of the tables passes its socket")]


def least_bolt_circle(dimensions: JointDimensions) -> float:
    """Smallest circle (mm) of the damper's screws: their inserts stand in the sleeve's wall, their heads in ear A."""
    screw = fixing_screw(dimensions.damper.bolt_diameter)
    inserts = bracket_bore(dimensions) + BESIDE + insert_of(screw.size).hole / 2
    return 2 * max(inserts, bearing_pocket(dimensions) + BESIDE + screw.head_diameter / 2 + SUNK_ASIDE)


def _bracket(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Screws too near to the sleeve's inside, too near to each other, or longer than the sleeve."""
    damper, name = dimensions.damper, f"{dimensions.name}.damper"
    screw = fixing_screw(damper.bolt_diameter)
    insert = insert_of(screw.size)
    wide = max(insert.hole, screw.head_diameter + 2 * SUNK_ASIDE) + BESIDE
    apart = wide / math.sin(math.pi / damper.bolt_count)
    least = max(least_bolt_circle(dimensions), apart)
    if damper.bolt_circle < least:
        reason = f"inserts for M{screw.size:g} need space in the sleeve around damper and collar, and heads in the ear"
        return [
            DimensionProblem(
                f"{name}.bolt_circle", damper.bolt_circle, f"at least {rounded_up(least)} mm", reason, least
            )
        ]
    above, below = bracket_depths(dimensions, layout)
    if above + below + BESIDE > layout.bracket_height:
        more = damper.body_length + above + below + BESIDE - layout.bracket_height
        reason = "the screws from both ends of the damper's sleeve would meet"
        return [DimensionProblem(f"{name}.body_length", damper.body_length, f"at least {more:.4g} mm", reason)]
    return []


def _bore(dimensions: JointDimensions) -> list[DimensionProblem]:
    """A damper's bore that fits neither a milled shaft nor a printed insert."""
    bore, shaft = dimensions.damper.bore, dimensions.shaft_diameter
    if dimensions.damper.adapter is not None or bore.size is None:
        return []
    name = f"{dimensions.name}.damper.bore.size"
    if bore.form == "round" and bore.size < shaft:
        reason = "the shaft goes into the damper's bore"
        return [DimensionProblem(name, bore.size, f"at least {shaft:g} mm, or a thinner shaft", reason)]
    shortest = pin_at_least(dimensions.hardware.pin, shaft + 2 * LEAST_HELD)
    held = math.inf if shortest is None else shortest.length
    # The wall is thinnest at a flat, which of a D is nearer to the axis than half its size.
    walled = (shaft / 2 + LEAST_INSERT_WALL + dimensions.fit) / flat_distance(bore.form, 1.0)
    least = max(walled, held + 2 * dimensions.fit)
    wide = 2 * circumradius(bore.form, bore.size)
    if not has_insert(dimensions):
        return []
    if bore.form == "round" and bore.hub != "unknown":
        reason = "the hub's set screw or clamp holds the shaft itself, not a printed insert round it"
        return [DimensionProblem(name, bore.size, f"{shaft:g} mm, the shaft's, or a shaft_diameter like it", reason)]
    if bore.size >= least:
        most = 2 * bracket_bore(dimensions) - 2 * dimensions.clearance
        if wide <= most:
            return []
        return [DimensionProblem(name, bore.size, f"at most {most:.4g} mm across corners", "it turns in the sleeve")]
    milled = shaft / milled_size(bore.form, 1.0)
    allowed = (
        f"at most {milled:.4g} mm, to which the shaft is milled, or at least {least:.4g} mm for an insert on it, or "
        f"another shaft_diameter than {shaft:g} mm"
    )
    return [DimensionProblem(name, bore.size, allowed, "an insert needs a wall round the shaft, and a pin")]


def damper_opening(dimensions: JointDimensions) -> float:
    """Radius (mm) of the space in the damper's envelope for the shaft, or for what connects it."""
    damper, shaft = dimensions.damper, dimensions.shaft_diameter
    if damper.adapter is not None:
        output = circumradius(damper.adapter.form, damper.adapter.output_diameter)
    else:
        output = circumradius(damper.bore.form, shaft if damper.bore.size is None else damper.bore.size)
    return max(shaft / 2, output) + dimensions.clearance


def _body(dimensions: JointDimensions) -> list[DimensionProblem]:
    """A damper's body with no wall round what turns in it."""
    least, wide = 2 * (damper_opening(dimensions) + BODY_WALL), dimensions.damper.outer_diameter
    if wide >= least:
        return []
    name, reason = f"{dimensions.name}.damper.outer_diameter", "the shaft, or what connects it, turns in the damper"
    return [DimensionProblem(name, wide, f"at least {least:.4g} mm, or a thinner shaft", reason)]


def least_encoder_circle(dimensions: JointDimensions) -> float:
    """Smallest circle (mm) of the screws of an encoder's seat: inserts beside the bearing, holes beside the collar."""
    encoder = dimensions.encoder
    assert encoder is not None
    hole = insert_of(fixing_screw(encoder.bolt_diameter).size).hole
    inserts = 2 * (bearing_pocket(dimensions) + BESIDE) + hole
    return max(inserts, 2 * (dimensions.hardware.radius + dimensions.clearance + BESIDE) + encoder.bolt_diameter)


def _encoder(dimensions: JointDimensions) -> list[DimensionProblem]:
    encoder, name, found = dimensions.encoder, dimensions.name, []
    if encoder is None:
        return []
    if encoder.magnet_diameter > dimensions.shaft_diameter - 1.0:
        most = f"at most {dimensions.shaft_diameter - 1.0:.4g} mm in a shaft of {dimensions.shaft_diameter:g} mm"
        reason = "its pocket needs half a millimetre of steel around it"
        found.append(DimensionProblem(f"{name}.encoder.magnet_diameter", encoder.magnet_diameter, most, reason))
    bore = dimensions.shaft_diameter + 2 * dimensions.clearance
    if bore + 2.0 > encoder.body_diameter:
        text = f"at least {bore + 2.0:.4g} mm with a shaft of {dimensions.shaft_diameter:g} mm"
        reason = "it lies on a rim round the shaft's bore"
        found.append(DimensionProblem(f"{name}.encoder.body_diameter", encoder.body_diameter, text, reason))
    least = least_encoder_circle(dimensions)
    if encoder.bolt_circle < least:
        reason = "its screws stand in ear B outside the bearing, and pass the collar"
        allowed = f"at least {least:.4g} mm with a shaft of {dimensions.shaft_diameter:g} mm"
        found.append(DimensionProblem(f"{name}.encoder.bolt_circle", encoder.bolt_circle, allowed, reason))
    return found


def _adapter(dimensions: JointDimensions) -> list[DimensionProblem]:
    adapter = dimensions.damper.adapter
    if adapter is None:
        return []
    name, found = f"{dimensions.name}.damper", []
    least = 2 * (adapter_radius(dimensions) + dimensions.clearance)
    if dimensions.damper.outer_diameter < least:
        text = f"at least {least:.4g} mm"
        outer = dimensions.damper.outer_diameter
        found.append(
            DimensionProblem(f"{name}.outer_diameter", outer, text, "the adapter turns in the bracket's sleeve")
        )
    if None in adapter_pins(dimensions):
        reason = "no dowel pin is sold that ends inside the adapter"
        found.append(DimensionProblem(f"{dimensions.name}.wall", dimensions.wall, "a thicker wall", reason))
    sizes = [("shaft_grip", adapter.shaft_grip, dimensions.hardware.pin)]
    sizes.append(("output_grip", adapter.output_grip, pin_size(adapter.output_diameter)
                  if adapter.form == "round" else insert_of(SET_SCREW).hole))  # fmt: skip
    for key, grip, hole in sizes:
        if grip < hole + 2 * BESIDE:
            text = f"at least {hole + 2 * BESIDE:.4g} mm"
            found.append(DimensionProblem(f"{name}.adapter.{key}", grip, text, "a pin or set screw is in its middle"))
    return found


def _mount(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    mount = dimensions.mount
    if mount is None or mount.spacing_across is None:
        return []
    least = mount_across(dimensions, layout)
    if mount.spacing_across >= least:
        return []
    name = f"{dimensions.name}.mount.spacing_across"
    return [DimensionProblem(name, mount.spacing_across, f"at least {least:.4g} mm", "screw heads would meet the ears")]

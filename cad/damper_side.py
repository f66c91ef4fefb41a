"""The damper's end of the hinge's shaft, and its connection to the damper."""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad import arm_shaft, damper_adapter, damper_bracket, standard_part
from synth.cad.arm_shaft import Form, ShaftShape
from synth.cad.damper_adapter import PIN_TURN, SET_SCREW_LENGTH, Hub
from synth.cad.damper_bracket import ACCESS_TURN, Access, Sleeve
from synth.cad.dimensions import JointDimensions
from synth.cad.fitting_problems import adapter_pins, adapter_radius, damper_opening, has_insert, longest_pin
from synth.cad.hardware import Pin, insert_of
from synth.cad.layout import JointLayout, fixing_screw
from synth.cad.parts import DrawnPart
from synth.cad.screw_places import SET_SCREW, bracket_depths
from synth.cad.shaft_line import AXIAL_GAP, lay_shaft
from synth.cad.standard_part import CutPart, StandardPart

ACCESS = 3.0  # mm, radius of holes in the sleeve: a pin of a 12 mm shaft and the keys of set screws pass them


@dataclass(frozen=True)
class ShaftEnd:
    """The shaft's lower end: height, form (mm), and the radius of the bore in the damper's envelope."""

    bottom: float
    form: Form
    size: float
    length: float  # over which it has that form
    damper_bore: float


def sleeve_of(dimensions: JointDimensions, layout: JointLayout) -> Sleeve:
    """The damper bracket's dimensions."""
    hole = insert_of(fixing_screw(dimensions.damper.bolt_diameter).size).hole / 2
    depths = bracket_depths(dimensions, layout)
    collar, adapter = dimensions.hardware.collar, dimensions.damper.adapter
    at = -AXIAL_GAP - dimensions.hardware.washer.thickness - collar.width / 2
    access = [Access(at, min(ACCESS, collar.width / 2 - 0.5), damper_bracket.key_turn(dimensions.damper.bolt_count))]
    if adapter is not None:
        low = damper_adapter.pin_heights(adapter)[1] + _adapter_top(dimensions, layout) + layout.gap_a + layout.ear
        access.append(Access(low, ACCESS, _fastening_turn(dimensions)))
    return Sleeve(
        layout.bracket_radius, layout.bracket_bore, dimensions.wall, layout.bracket_height, hole, depths, tuple(access)
    )


def _fastening_turn(dimensions: JointDimensions) -> float:
    """Direction (deg) of the hole for the adapter's set screw or output pin, which turns with the lower half.

    One to which the travel brings it: of those farthest from the damper's screws the nearest to the unloaded joint's.
    """
    adapter = dimensions.damper.adapter
    drawn = (PIN_TURN, PIN_TURN + 180.0) if adapter is not None and adapter.form == "round" else (0.0,)
    low, high = sorted(dimensions.opening(angle) for angle in dimensions.stop_angles)
    free, apart = dimensions.opening(dimensions.free_angle), 360.0 / dimensions.damper.bolt_count
    places = [(start, turn) for start in drawn for turn in range(math.ceil(low), math.floor(high) + 1)]

    def rank(place: tuple[float, int]) -> tuple[float, float]:
        from_middle = (place[0] + place[1] - ACCESS_TURN) % apart
        return -min(from_middle, apart - from_middle), -abs(place[1] - free)

    start, turn = max(places, key=rank)
    return start + turn


def _adapter_top(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Z (mm) of the adapter's face below the collar."""
    return -layout.gap_a - layout.ear - AXIAL_GAP - dimensions.hardware.stack - dimensions.clearance


def shaft_end(dimensions: JointDimensions, layout: JointLayout) -> ShaftEnd:
    """The position and form of the shaft's end."""
    damper, shaft, wide = dimensions.damper, dimensions.shaft_diameter, damper_opening(dimensions)
    if damper.adapter is not None:
        bottom = _adapter_top(dimensions, layout) - damper.adapter.shaft_grip
        return ShaftEnd(bottom, "round", shaft, 0.0, wide)
    outside = layout.gap_a + layout.ear
    bottom = damper_bracket.rotor_bottom(damper, layout.bracket_height) - outside
    form, size = damper.bore.form, damper.bore.size if damper.bore.size is not None else shaft
    if has_insert(dimensions) or (form == "round" and damper.bore.hub != "set_screw"):
        return ShaftEnd(bottom, "round", shaft, 0.0, wide)
    if form == "round":  # a flat for the set screw of the damper's hub
        form, size = "d", shaft
    grip = damper_bracket.ROTOR_GRIP * damper.body_length
    return ShaftEnd(bottom, form, size, grip, wide)


def damper_side(dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    """The shaft, and the adapter or insert with its pins and set screw."""
    end = shaft_end(dimensions, layout)
    line = lay_shaft(dimensions, layout, end.bottom)
    found: list[DrawnPart] = []
    holes = [(line.pin_height, line.pin.size, line.pin_angle)]
    hub = _hub(dimensions, layout)
    if hub is not None:
        top = (
            _adapter_top(dimensions, layout) if dimensions.damper.adapter is not None else _insert_top(end, dimensions)
        )
        found += _on_the_end(dimensions, hub, top)
        holes.append((top + hub.pin_height, hub.pin.size, PIN_TURN))
    encoder = dimensions.encoder
    pocket = (0.0, 0.0) if encoder is None else (encoder.magnet_diameter, encoder.magnet_depth)
    shape = ShaftShape(
        dimensions.shaft_diameter, end.bottom, line.top, end.form, end.size, end.length, tuple(holes), pocket
    )
    length = line.top - end.bottom
    work = "drilled for its pins"
    if end.form != "round":
        work += f"; end milled to a {_words(end.form)} of {end.size:g} mm over {end.length:.1f} mm"
    elif dimensions.damper.adapter is None and dimensions.damper.bore.slips:
        work += "; its end is still to be made to drive the damper, whose hub is unknown"
    if encoder is not None:
        work += f"; other end bored {encoder.magnet_diameter:g} mm, {encoder.magnet_depth:g} mm deep for the magnet"
    solid = arm_shaft.build_shaft(shape)
    made = CutPart("ground rod, h6", f"{dimensions.shaft_diameter:g}", length, work)
    return [DrawnPart("shaft", "shaft", "lower", solid, arm_shaft.shaft_volume(shape), False, made), *found]


def _words(form: Form) -> str:
    return {"d": "D", "hex": "hexagon"}.get(form, form)


def _insert_top(end: ShaftEnd, dimensions: JointDimensions) -> float:
    """Z (mm) of the upper end of an insert for the damper's bore."""
    return end.bottom + damper_bracket.ROTOR_GRIP * dimensions.damper.body_length


def _hub(dimensions: JointDimensions, layout: JointLayout) -> Hub | None:
    """The sleeve on the shaft's end; None if the shaft itself enters the damper."""
    shaft, fit, damper = dimensions.shaft_diameter, dimensions.fit, dimensions.damper
    if damper.adapter is not None:
        pin = adapter_pins(dimensions)[0]
        assert pin is not None  # checked when the joint was laid out
        return Hub(adapter_radius(dimensions), shaft, fit, pin, damper_adapter.pin_heights(damper.adapter)[0])
    if not has_insert(dimensions):
        return None
    assert damper.bore.size is not None
    pin = longest_pin(dimensions.hardware.pin, shaft, damper.bore.size - 2 * fit)
    assert pin is not None
    return Hub(damper.bore.size / 2, shaft, fit, pin, -damper_bracket.ROTOR_GRIP * damper.body_length / 2)


def _on_the_end(dimensions: JointDimensions, hub: Hub, top: float) -> list[DrawnPart]:
    """Adapter or insert, its pin, and the fastening of the damper's own shaft."""
    adapter, bore = dimensions.damper.adapter, dimensions.damper.bore
    shift = (0, 0, top)
    pins = [("damper_pin", hub.pin, top + hub.pin_height)]
    if adapter is None:
        assert bore.size is not None
        length = damper_bracket.ROTOR_GRIP * dimensions.damper.body_length
        solid = damper_adapter.build_insert(bore.form, bore.size, length, hub).translate(shift)
        found = [DrawnPart("damper_insert", "damper_insert", "lower", solid, None, True, "print")]
    else:
        output = adapter_pins(dimensions)[1] if adapter.form == "round" else None
        solid = damper_adapter.build_adapter(adapter, hub, output).translate(shift)
        exact = damper_adapter.adapter_volume(adapter, hub, output)
        found = [DrawnPart("damper_adapter", "damper_adapter", "lower", solid, exact, True, "print")]
        low, flat = damper_adapter.set_screw_place(adapter)
        if output is not None:
            pins.append(("damper_output_pin", output, top + low))
        else:
            body = arm_shaft.cross_hole(top + low, SET_SCREW / 2, flat + SET_SCREW_LENGTH, 0.0, flat)
            volume = math.pi * SET_SCREW**2 / 4 * SET_SCREW_LENGTH
            made = standard_part.screw("ISO 4026", SET_SCREW, SET_SCREW_LENGTH, kind="set screw")
            found.append(DrawnPart("damper_set_screw", "screw", "lower", body, volume, False, made))
    return found + [_pin(suffix, pin, height) for suffix, pin, height in pins]


def _pin(suffix: str, pin: Pin, height: float) -> DrawnPart:
    return pin_part(suffix, pin, height, PIN_TURN)


def pin_part(suffix: str, pin: Pin, height: float, turn: float) -> DrawnPart:
    """A dowel pin as it is bought."""
    solid = arm_shaft.build_pin(pin.size, pin.length, height, turn)
    made = StandardPart("pin", pin.standard, f"{pin.size:g}", " dowel pin, steel", pin.length)
    return DrawnPart(suffix, "pin", "lower", solid, math.pi / 4 * pin.size**2 * pin.length, False, made)

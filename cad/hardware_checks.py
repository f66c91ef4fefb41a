"""Checks of bought parts on the solids: the pin that drives the shaft, axial play, screws."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import insert_of
from synth.cad.joint import BuiltJoint
from synth.cad.near_body import NearBody
from synth.cad.parts import BuiltPart
from synth.cad.results import CheckResult, check_at_least, check_at_most
from synth.cad.screw_places import ENGAGED
from synth.cad.standard_part import StandardPart
from synth.cad.travel import OVERLAP_LIMIT, Bodies, gather_meshes, manifold, turn_solid

PIN_TURNED = 10.0  # deg, rotation of the tongue's pin in the test whether it drives the shaft
MOST_AXIAL = 1.0  # mm, end of the search for axial play
AXIAL_STEP = 1e-3  # mm, accuracy of its bisection
AXIAL_LIMIT = 0.1  # mm: the thinnest shim washer of DIN 988
ROUNDED = 0.02  # mm, chord error of meshes


def check_keyed(joint: BuiltJoint) -> list[CheckResult]:
    """The pin connects tongue and shaft, and nothing connects the shaft to the upper half.

    A pin rotated by a few degrees must overlap both; the rotated shaft must not overlap any upper part.
    """
    dimensions, pin = joint.dimensions, joint.part("pin")
    turned_pin = manifold(pin.mesh).rotate((0.0, 0.0, PIN_TURNED))
    results = []
    for suffix in ("lower", "shaft"):
        shared = float((turned_pin ^ manifold(joint.part(suffix).mesh)).volume())
        text = f"overlap of the pin with {joint.part(suffix).name} when turned by {PIN_TURNED:g} deg"
        results.append(check_at_least("keyed", pin.name, shared, _half_overlap(dimensions, suffix, pin), "mm^3", text))
    shaft = manifold(joint.part("shaft").mesh).rotate((0.0, 0.0, 90.0))
    free = max(
        float((shaft ^ manifold(part.mesh)).volume())
        for part in joint.parts
        if part.group == "upper" and part.family != "damper"
    )
    text = "overlap with the upper half when turned by a quarter"
    return [*results, check_at_most("free", joint.part("shaft").name, free, OVERLAP_LIMIT, "mm^3", text)]


def _half_overlap(dimensions: JointDimensions, suffix: str, pin: BuiltPart) -> float:
    """Half of the overlap of a pin turned in its hole with its neighbour, mm^3.

    At the radius r the pin is displaced by r sin(turn); the swept area per length is that times its diameter.
    """
    shaft, length = dimensions.shaft_diameter / 2, max(pin.size) / 2
    size = dimensions.hardware.pin
    inner, outer = (0.0, shaft) if suffix == "shaft" else (shaft, length)
    aside = math.sin(math.radians(PIN_TURNED))
    return 0.5 * 2 * min(aside * (outer**2 - inner**2) / 2, size * (outer - inner)) * size * 0.5


def check_axial_play(bodies: Bodies) -> list[CheckResult]:
    """Axial travel of the shaft with its parts before a thrust washer meets an ear, from the solids."""
    turn = bodies.joint.turn("lower", bodies.joint.dimensions.rest_angle)
    found = [_axial_travel(bodies, way, turn) for way in (-1.0, 1.0)]
    text = f"the shaft shifts by {found[0]:.3f} and {found[1]:.3f} mm along the hinge; collars are clamped to set it"
    return [check_at_most("axial play", bodies.joint.part("shaft").name, sum(found), AXIAL_LIMIT, "mm", text)]


def _axial_travel(bodies: Bodies, way: float, turn: float) -> float:
    """Shift (mm) of the lower half along the hinge, ``way`` 1 or -1, before it meets the upper one.

    The shaft and its rings are small and stop first. Where the rest of the half is free at that place, it has been
    free before, and the place is that of the whole half.
    """
    rings = [part.mesh for part in bodies.parts["lower"] if part.name not in bodies.names["lower"]]
    place = last_free(_beyond(bodies, gather_meshes(rings), way, turn), MOST_AXIAL, AXIAL_STEP)
    rest = turn_solid(bodies.moving["lower"], turn).translate((0.0, 0.0, way * place))
    if (bodies.halves["upper"] ^ rest).is_empty():
        return place
    return last_free(_beyond(bodies, bodies.halves["lower"], way, turn), MOST_AXIAL, AXIAL_STEP)


def _beyond(bodies: Bodies, body: Any, way: float, turn: float) -> Callable[[float], float]:
    """By the shift (mm) of a body of the lower half: common volume with the upper one over what is rounding, mm^3."""
    lower = turn_solid(body, turn)
    upper = NearBody(bodies.halves["upper"]).near(lower, MOST_AXIAL)
    lower = NearBody(lower).near(upper, MOST_AXIAL)
    return lambda shift: float((upper ^ lower.translate((0.0, 0.0, way * shift))).volume()) - OVERLAP_LIMIT


def last_free(beyond: Callable[[float], float], end: float, step: float) -> float:
    """Where bisection from 0 to ``end``, down to ``step``, finds the last place at which a rising function is below 0.

    That place depends on the root alone, so it is guessed by the line through the last two values above 0: an overlap
    that grows linearly takes five evaluations instead of ten. The function is below 0 at 0 and above it at the end.
    """
    parts = 1 << math.ceil(math.log2(end / step))
    free, met = 0, parts
    above: list[tuple[int, float]] = []  # places and values, the last two of a line that meets the root
    lines = 0
    while met - free > 1:
        place, lines = (free + met) // 2, lines + 1
        if len(above) > 1 and lines % 3:  # every third place is the middle, for a function that is far from a line
            (far, more), (near, less) = above[-2:]
            root = near - less * (far - near) / (more - less) if more > less else near
            place = min(max(math.floor(root), free + 1), met - 1)
        value = beyond(end * place / parts)
        if value <= 0.0:
            free = place
        else:
            met = place
            above.append((place, value))
    return end * free / parts


def check_screws(joint: BuiltJoint) -> list[CheckResult]:
    """Every screw in an insert engages at least 1.5 diameters and ends inside its part, tested by rays."""
    results = []
    for part in joint.parts:
        made = part.made
        # A set screw lies inside its insert, without a head from which its length in the print could be measured.
        if not isinstance(made, StandardPart) or not made.has_insert or made.kind == "set screw":
            continue
        nominal = made.thread
        assert nominal is not None
        engaged, spare = _engagement(joint, part, nominal)
        text = f"in print beside its insert; its end {spare:+.2f} mm inside the far face"
        least = ENGAGED * nominal - ROUNDED
        results.append(check_at_least("screw engagement", part.name, engaged, least, "mm", text))
        results.append(check_at_least("screw ends inside", part.name, spare, -ROUNDED, "mm", text))
    return results


def _engagement(joint: BuiltJoint, screw: BuiltPart, size: float) -> tuple[float, float]:
    """Length (mm) of a screw in the print around its insert, and the distance of its end from the print's far face.

    By rays beside the insert's hole, along the screw, against each printed part of its half. The result is for the part
    that contains the screw's end.
    """
    mesh = screw.mesh.vertices
    radial = np.hypot(*(mesh[:, :2] - mesh[:, :2].mean(axis=0)).T)
    shank = mesh[radial < size / 2 + 0.1]  # mm, for the mesh's chords
    ends = (float(shank[:, 2].min()), float(shank[:, 2].max()))
    head = float(mesh[radial > size / 2 + 0.1][:, 2].mean())
    tip, under = (ends[0], ends[1]) if head > sum(ends) / 2 else (ends[1], ends[0])
    x, y = mesh[:, :2].mean(axis=0)
    beside = insert_of(size).hole / 2 + 0.3
    best = (-math.inf, -math.inf)
    for part in joint.parts:
        if not part.printed or part.group != screw.group:
            continue
        solid, walls = manifold(part.mesh), []
        for k in range(8):
            angle = math.pi * k / 4
            at = (x + beside * math.cos(angle), y + beside * math.sin(angle))
            walls += [_wall_at(solid, at, tip, under)]
        known = [wall for wall in walls if wall is not None]
        if len(known) >= 6:
            engaged = min(held for held, _ in known)
            spare = min(left for _, left in known)
            best = max(best, (engaged, spare))
    return best


def _wall_at(solid: Any, at: tuple[float, float], tip: float, under: float) -> tuple[float, float] | None:
    """Print along a line beside a screw at its end: length along the screw, and beyond the end."""
    way = 1.0 if under > tip else -1.0
    far = 1000.0 * way
    inside = tip + 0.5 * way
    hits = solid.ray_cast((*at, inside), (*at, inside + far))
    back = solid.ray_cast((*at, inside), (*at, inside - far))
    if not hits or not back or hits[0].normal[2] * way < 0.0 or back[0].normal[2] * way > 0.0:
        return None
    near, beyond = float(hits[0].position[2]), float(back[0].position[2])
    return abs(near - tip) if abs(near - tip) < abs(under - tip) else abs(under - tip), (tip - beyond) * way

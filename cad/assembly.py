"""The assembly of a joint: steps in order with their parts, and the exploded view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from synth.cad.by_torques import BY_TORQUES
from synth.cad.joint import BuiltJoint
from synth.cad.parts import BuiltPart, Mesh

FEELER = 0.05  # mm, feeler gauge under a collar: half of the allowed axial play
SPREAD = 0.75  # of the joint's width: distance between the parts of successive steps in the exploded view
BELOW = 1.5  # of the joint's width: distance by which parts from between the ears are drawn below them

APART = ("shaft",)  # families drawn away from the largest part of their step: numbered too


@dataclass(frozen=True)
class AssemblyStep:
    """One step: the action, its parts (names), and their positions in the exploded view.

    ``along`` and ``below``: shifts along the hinge axis (canonical) and away from the upper link, in joint widths.
    """

    text: str
    parts: tuple[str, ...]
    along: float
    below: float


def assembly(joint: BuiltJoint) -> tuple[AssemblyStep, ...]:
    """The steps in order; together they contain every part of the joint once."""
    names = {part.name: part for part in joint.parts}
    prefix = next(iter(names)).removesuffix("upper")
    left = dict(names)

    def take(*endings: str) -> tuple[str, ...]:
        found = tuple(name for name in names if name.removeprefix(prefix).startswith(endings) and name in left)
        for name in found:
            del left[name]
        return found

    hardware, pair = joint.dimensions.hardware, len(joint.springs) == 2
    bearing, feeler = hardware.bearing.sold_as, f"{FEELER:g} mm"
    encoder = joint.dimensions.encoder
    fixings = [*take("upper_socket", "lower_socket")]
    planned = [
        (f"press the bearings ({bearing}) into both ears of the upper half from between them, flush to 0.2 mm below; "
         "a drop of retaining compound holds them", ("bearing",), 0.0, 0.6),
        ("screw the damper's bracket to ear A from between the ears", ("damper_bracket", "bracket_screw"), -1.0, 0.0),
        ("lay the spring into the lower half's pocket and clamp its lower arm under the cap"
         + (_second_spring(joint) if pair else ""),
         ("spring", "lower_cap", "lower_screw"), 0.5, 1.7),
        ("clamp the spring's upper arm under the cap of the seat plate" + (", of both plates" if pair else ""),
         ("seat", "upper_cap", "upper_screw"), 1.1, 1.0),
        ("slip collar and thrust washer of ear A on the shaft" + _on_shaft(joint),
         ("collar_a", "thrust_washer_a", "damper_adapter", "damper_insert", "damper_pin"), -1.8, 1.2),
        ("set lower half, spring and seat plate between the ears and push the shaft through from ear A's side",
         ("lower", "shaft"), 0.0, 1.7),
        (f"push the pin ({hardware.pin:g} mm) through the hole in the lower half's rim and the shaft",
         ("pin",), 0.0, 1.0),
        (f"slip thrust washer and collar on at ear B; clamp both collars with a feeler of {feeler} under one, that of "
         "ear A through the hole in the bracket", ("collar_b", "thrust_washer_b"), 1.8, 0.0),
        (_seat_step(joint), ("seat_screw",), 1.3, 0.0),
        (_damper_step(joint),
         ("damper", "damper_screw", "damper_output_pin", "damper_set_screw"), -2.2, 0.0),
    ]  # fmt: skip
    if encoder is not None:
        text = "lay the angle sensor into its seat, the magnet into the shaft's end, and screw the seat to ear B"
        planned.append((text, ("encoder",), 2.4, 0.0))
    steps = []
    # Longer endings first: a bracket's screw is no bracket.
    wanted = {ending for _, endings, _, _ in planned for ending in endings}
    owner = {name: max((e for e in wanted if _is_named(name, prefix, e)), key=len, default="") for name in left}
    for text, endings, along, below in planned:
        steps.append(AssemblyStep(text, tuple(n for n, ending in owner.items() if ending in endings), along, below))
    steps.append(AssemblyStep("push the tubes into their sockets and put the screws through, with their nuts",
                      tuple(fixings), 0.0, 0.0))  # fmt: skip
    upper = AssemblyStep("set the heat-set inserts into the holes of all printed parts with a soldering iron",
                 tuple(n for n, ending in owner.items() if not ending), 0.0, 0.0)  # fmt: skip
    return (upper, *steps)


def _second_spring(joint: BuiltJoint) -> str:
    """On which side of the floor each hand of a pair lies."""
    first, second = (joint.seat(spring)[0].spring.hand for spring in joint.springs)
    return f", the {first}-hand one on ear B's side, the {second}-hand one on the other side"


def _is_named(name: str, prefix: str, ending: str) -> bool:
    """Whether a part matches an ``ending``: itself, numbered, or of the second spring."""
    rest = name.removeprefix(prefix)
    if rest == ending:
        return True
    if not rest.startswith(f"{ending}_"):
        return False
    number = rest.removeprefix(f"{ending}_").replace("_", "")
    return number.isdigit() or number in ("a", "b") or ending == "encoder"


def _seat_step(joint: BuiltJoint) -> str:
    """The seat to 0, and the free angle: where the joint comes to rest, or by torques where a stop keeps it from it."""
    dimensions = joint.dimensions
    low, high = dimensions.stop_angles
    stop = low if dimensions.free_angle <= low else high
    if dimensions.rests_free:
        against = ""
        find = (
            "read the angle at which it comes to rest, from both sides: their mean is its free angle. If it rests on a "
            f"stop, its free angle lies beyond: {BY_TORQUES}"
        )
    else:
        against = ", against the spring,"
        find = f"find its free angle, beyond the stop at {stop:.1f} deg, on which it would rest: {BY_TORQUES}"
    return (
        f"turn the seat{against} to 0 on its scale (the longest marks meet) and tighten its screws through the "
        f"slots of the ear; with the damper still off, lay the joint on its side and {find}. Turn the seat to the "
        "setting that the design gives for it"
    )


def _borne(joint: BuiltJoint) -> str:
    torque = joint.dimensions.loads.damper_torque
    return f", which must hold {torque:.3g} N*m" if torque > 0.0 else ""


def _on_shaft(joint: BuiltJoint) -> str:
    damper = joint.dimensions.damper
    if damper.adapter is None and damper.bore.form == "round" and damper.bore.hub == "unknown":
        return (
            "; but first see what turns the damper with it: the damper's hub is unknown and is drawn as a round bore, "
            f"in which the shaft slips. Make the shaft's end to fit the hub{_borne(joint)}"
        )
    if any(part.family == "damper_adapter" for part in joint.parts):
        return ", and pin the damper's adapter on its end"
    if any(part.family == "damper_insert" for part in joint.parts):
        return ", and pin the damper's insert on its end"
    return ""


def _damper_step(joint: BuiltJoint) -> str:
    return (
        "put the damper on, now that the seat is set, and screw it to the bracket" + _at_damper(joint) + _clocked(joint)
    )


def _at_damper(joint: BuiltJoint) -> str:
    names = [part.name for part in joint.parts]
    if any(name.endswith("damper_set_screw") for name in names):
        return "; turn the link until the set screw on its shaft's flat faces the hole in the bracket, and tighten it"
    if any(name.endswith("damper_output_pin") for name in names):
        return "; drill its shaft, turn the link until the pin's hole faces that in the bracket, and push the pin in"
    damper = joint.dimensions.damper
    if damper.adapter is not None or damper.bore.form != "round":
        return ""
    borne = _borne(joint)
    if damper.bore.hub == "unknown":
        return f"; its hub must turn with the shaft{borne}"
    if damper.bore.hub == "clamp":
        return f"; tighten its hub's clamp on the shaft{borne}"
    return f"; tighten its hub's set screw on the flat of the shaft's end{borne}"


def _clocked(joint: BuiltJoint) -> str:
    """How a damper that has ends is set to the joint's stops."""
    turns = joint.dimensions.damper.travel
    if turns is None:
        return ""
    low, high = joint.dimensions.stop_angles
    middle = (low + high) / 2.0
    past = (turns - (high - low)) / 2.0
    where = "beyond its stops" if past >= 0.0 else "before its stops: turn it no further, by hand or by a motion"
    return (
        f". It turns by {turns:.4g} deg only: put it on with the joint at {middle:.1f} deg, half way between its "
        f"stops, and the damper in the middle of its travel. Its ends are then at {low - past:.1f} and "
        f"{high + past:.1f} deg of the joint, {abs(past):.1f} deg {where}"
    )


def exploded_view(joint: BuiltJoint) -> list[tuple[BuiltPart, Mesh, int]]:
    """Every part of the exploded view with the number of its step; the joint at its files' angle, upper link up."""
    upper = joint.part("upper").mesh.vertices
    width = float(upper[:, 2].max() - upper[:, 2].min())
    flip = joint.layout.flips[1]
    parts = {part.name: part for part in joint.parts}
    found = []
    steps = assembly(joint)
    lower = next(step.below for step in steps if joint.part("lower").name in step.parts)
    for number, step in enumerate(steps, start=1):
        for name in step.parts:
            part = parts[name]
            along, below = _shifts(part, name, step)
            if "lower_socket" in name:
                below = lower  # in the lower half's socket, not where that was: behind the upper half
            shift = (0.0, -BELOW * width * below, SPREAD * width * along * flip)
            found.append((part, joint.filed_mesh(part).turned(0.0, shift), number))
    return found


def _shifts(part: BuiltPart, name: str, step: AssemblyStep) -> tuple[float, float]:
    """Shifts of a part in joint widths: its step's, increased for a part that would be hidden in another."""
    along, below = step.along, step.below
    if part.family == "bearing":
        along += 0.35 if name.endswith("_a") else -0.35
    elif part.family == "screw" and "damper_screw" in name:
        along -= 0.5
    elif part.family == "screw" and "bracket_screw" in name:
        along += 1.6
    elif part.family == "spring":
        along += 0.3
    elif part.family == "encoder":
        along += 0.4
    elif part.family == "shaft":
        along, below = along - 0.2, below + 0.7
    elif part.family in ("damper_adapter", "damper_insert", "pin") and "damper" in name:
        along -= 0.6
    elif part.family == "collar":
        along += -0.25 if name.endswith("_a") else 0.25
    return along, below


def numbers_at(items: Sequence[tuple[BuiltPart, Mesh, int]]) -> list[tuple[str, tuple[float, float, float]]]:
    """The positions of each step's number in the picture, mm: at its largest part, and at a part that lies apart.

    Of the sockets' screws at the upper half: the lower one is behind the spring.
    """
    found: dict[tuple[int, str], tuple[tuple[bool, float], Mesh]] = {}
    for part, mesh, number in items:
        key = (number, part.family if part.family in APART else "")
        rank = ("lower_socket" not in part.name, abs(mesh.volume))
        if key not in found or rank > found[key][0]:
            found[key] = (rank, mesh)
    places = []
    for (number, _), (_, mesh) in sorted(found.items(), key=lambda item: item[0]):
        x, y, z = ((mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2).tolist()
        places.append((str(number), (x, y, z)))
    return places

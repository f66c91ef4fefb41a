"""What to do next with a designed leg, in an order in which it can be done."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.opening import joined_names
from synth.reports.quantities import brief, share_text, with_decimals
from synth.reports.reading import Json, value_of
from synth.reports.section import mapping, sequence

GAIN = 0.2  # of the chance, from which measuring the springs is recommended
LEAST_TURN = 0.05  # deg of a seat: the scale reads to one degree
LEAST_LEFT = 0.5  # deg beyond a seat's travel that count: half of what its scale reads


def slipping_dampers(document: Json) -> list[str]:
    """Joints that have no damping as drawn: nothing turns the damper with the shaft."""
    return [name for name, joint in mapping(document, "joints").items() if mapping(joint, "damper").get("slips")]


def left_out(document: Json) -> list[str]:
    """What stated ranges leave out, ``wanted motion of the knee``."""
    ranges = {name: mapping(joint, "range") for name, joint in mapping(document, "joints").items()}
    return [f"{what} of the {name}" for name, found in ranges.items() for what in sequence(found, "outside")]


def still_joints(document: Json) -> list[str]:
    """Joints that hardly move as built."""
    return [name for name, joint in mapping(document, "joints").items() if mapping(joint, "motion").get("still")]


def measured_joints(document: Json) -> list[str]:
    """The joints whose spring's free angle is measured."""
    return [str(name) for name in sequence(document, "response", "free_angles_measured")]


def steps(document: Json, without: list[str], failed: list[Mapping[str, Any]], slipping: list[str]) -> list[str]:
    """What to do, in an order in which it can be done: the free angle is read in the printed joint, its damper off."""
    if without:
        return [
            "Relax that spring's requirements under `select:`; the section on springs to make shows the nearest ones."
        ]
    if failed:
        return [f"{failed[0].get('text')}. Change `cad:` or `select:` in the project."]
    if not mapping(document, "joints"):
        return []
    still = _still(document)
    if not mapping(document, "solids").get("drawn"):
        return [
            *still,
            "Run without `--no-cad` before you order: only then do the links carry their joints' parts, and spring "
            "rates go with the links' inertia. That run gives the parts to print, too.",
        ]
    found = [*still, *_dampers_first(document, slipping)]
    turns, measuring = _seat_turns(document), _measurement_step(document)
    if left_out(document):
        found.insert(0, _wider(document))
    beyond = _beyond_seat(document)
    if beyond:
        return [*found, *beyond]
    if turns:
        last = "" if measuring else ", tighten them, and put the dampers on"
        return [*found, f"Turn the seats on their scales: {joined_names(turns)}{last}.", *measuring]
    what = "the other parts" if found else "the parts"
    assemble = "; assemble the joints with their seats at 0 and the dampers off" if measuring else ""
    return [*found, f"Order {what} in `bom.csv`, print the plates `parts/leg_print_*.3mf`{assemble}.", *measuring]


def _still(document: Json) -> list[str]:
    """The decision on joints that hardly move as built."""
    found, joints = [], mapping(document, "joints")
    for name in still_joints(document):
        motion = mapping(joints, name, "motion")
        built, wanted = (with_decimals(value_of(motion.get(key)) or 0.0, 1) for key in ("built", "wanted"))
        found.append(f"{name} (built {built}°, wanted {wanted}°)")
    if not found:
        return []
    turn = "turns" if len(found) == 1 else "turn"
    return [
        f"Have a leg first that moves: as built, {joined_names(found)} hardly {turn}. The warnings say what to change; "
        "order nothing before."
    ]


def _wider(document: Json) -> str:
    """The decision on ranges that are narrower than the wanted motion, or that leave out the rest pose."""
    found = []
    for name, joint in mapping(document, "joints").items():
        known = mapping(joint, "range")
        if not sequence(known, "outside"):
            continue
        low, high = (with_decimals(value_of(end) or 0.0, 1) for end in sequence(known, "stated"))
        least, most = (with_decimals(value_of(end) or 0.0, 1) for end in sequence(known, "wanted"))
        rest = with_decimals(value_of(known.get("rest")) or 0.0, 1)
        found.append(f"{name} (stated {low} to {high}°, wanted {least} to {most}°, rest {rest}°)")
    return (
        f"Widen the range of {joined_names(found)} in the target's leg file, or want another motion, and run again; "
        "built as it is, the leg stops at the end of its range."
    )


def _dampers_first(document: Json, slipping: list[str]) -> list[str]:
    """Dampers to measure before anything is printed."""
    joints = mapping(document, "joints")
    assumed = [name for name, joint in joints.items() if sequence(joint, "damper", "assumed_sizes")]
    if not slipping and not assumed:
        return []
    place = f"`cad: {{dampers: {{{(slipping or assumed)[0]}: …}}}}`"
    if not slipping:
        what = (
            f"Get the dampers first and measure them: sizes of those of {joined_names(assumed)} are assumed as drawn."
        )
    else:
        what = f"Get the dampers first and measure what turns them with the shaft, for {joined_names(slipping)}."
        what += " Their other sizes are assumed, too." if assumed else ""
    return [f"{what} Write it under {place} and run again, before anything is made."]


def _seat_turns(document: Json) -> list[str]:
    """``knee +1.9°`` for each joint whose spring is measured."""
    found = []
    for name, joint in mapping(document, "joints").items():
        turn = value_of(mapping(joint, "seat", "setting").get("turn"))
        if turn is not None:
            sign = "+" if turn > LEAST_TURN else ""
            found.append(f"{name} {sign}{with_decimals(turn if abs(turn) > LEAST_TURN else 0.0, 1)}°")
    return found


def _beyond_seat(document: Json) -> list[str]:
    """Joints whose seat cannot be set for the measured free angle: the angle is misread, or the spring is another."""
    left = {
        name: value_of(mapping(joint, "seat", "setting").get("left"))
        for name, joint in mapping(document, "joints").items()
    }
    far = [(name, off) for name, off in left.items() if off is not None and abs(off) > LEAST_LEFT]
    if not far:
        return []
    shown = joined_names([f"{name} by {with_decimals(abs(off), 1)}°" for name, off in far])
    return [
        f"The measured free angle is beyond the seat's travel at {shown}. Check that it is the angle of the assembled "
        "joint, not of the loose spring; else wind or choose another spring."
    ]


def _measurement_step(document: Json) -> list[str]:
    """The measurement of the free angles that are not known, if it raises the chance."""
    response, known = mapping(document, "response"), measured_joints(document)
    left = [name for name in mapping(document, "joints") if name not in known]
    chance = value_of(mapping(response, "forecast").get("chance"))
    measured = value_of(mapping(response, "forecast_free_angles_measured").get("chance"))
    if not left or chance is None or measured is None or measured - chance <= GAIN:
        return []
    within = brief(mapping(response, "forecast").get("within"))
    assumed = sequence(response, "forecast", "assumed_laws", "joints")
    condition = f" if the assumed damper {'laws hold' if len(assumed) > 1 else 'law holds'}" if assumed else ""
    return [
        f"{_free_angle_step(document, left)} Run again: "
        f"the page then says how far to turn the seats, and the chance of staying within {within} changes from "
        f"{share_text(chance)} to {share_text(measured)}{condition}. Then set the seats and put the dampers on."
    ]


def _free_angle_step(document: Json, left: list[str]) -> str:
    """How to find the free angles of the joints ``left``: at rest, or from torques where a stop is in the way."""
    joints, said = mapping(document, "joints"), []
    far = [name for name in left if _beyond_stop(mapping(joints, name))]
    near = [name for name in left if name not in far]
    side = "lying on its side, damper off and seat at 0"
    if near:
        entry = f"`measured: {{spring: {{{near[0]}: {{free_angle: … deg}}}}}}`"
        said.append(
            f"In each assembled joint ({joined_names(near)}), {side}, read the angle at which it comes to rest, to a "
            "degree; it is not the loose spring's angle. On a stop it tells nothing: see the joint's order of "
            f"assembly. Write it as {entry}."
        )
    if far:
        entry = f"`measured: {{spring: {{{far[0]}: {{free_angle: … deg, free_angle_by: torque}}}}}}`"
        said.append(
            f"The free angle of {joined_names(far)} lies beyond a stop, on which the joint would rest. In the "
            f"assembled joint, {side}, turn the link off the stop with a spring scale, square to it at a known "
            "distance from the hinge, to two angles A and B some 15° apart; with the torques M and N there the free "
            f"angle is A − M (B − A)/(N − M). Write it as {entry}."
        )
    return " ".join(said)


def _beyond_stop(joint: Json) -> bool:
    """Whether the joint's stops keep it from its free angle; False where nothing is drawn."""
    free, stops = value_of(mapping(joint, "spring").get("free_angle")), [value_of(s) for s in sequence(joint, "stops")]
    known = [stop for stop in stops if stop is not None]
    return free is not None and len(known) == 2 and not known[0] < free < known[1]

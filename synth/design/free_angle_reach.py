"""Free angles that a joint's stops keep it from: a reading there is the stop's, so it is found from torques instead."""

from __future__ import annotations

from math import degrees, radians

from synth.cad.by_torques import BY_TORQUES
from synth.design.forecast import MEASURED_ANGLE
from synth.design.leg_design import LegDesign
from synth.errors import Problem, UserError

WRITE_IT = "write it with free_angle_by: torque"


def out_of_reach(design: LegDesign) -> list[str]:
    """Joints of the drawing that rest on a stop before their spring is unloaded."""
    joints = () if design.drawn is None else design.drawn.dimensions.joints
    return [joint.name for joint in joints if not joint.rests_free]


def refuse_stops(design: LegDesign) -> None:
    """Raise UserError for free angles that were read where the drawn joint rests on a stop, or cannot rest at all."""
    problems = []
    for name, angle, (low, high) in _measured_angles(design):
        if low + MEASURED_ANGLE < angle < high - MEASURED_ANGLE:
            continue
        stop = min((low, high), key=lambda end: abs(angle - end))
        if abs(angle - stop) <= MEASURED_ANGLE:
            why = f"where the {name} rests on its stop, at {degrees(stop):.4g} deg: its free angle lies beyond"
        else:
            why = f"beyond the stop of the {name} at {degrees(stop):.4g} deg, where it cannot have come to rest"
        text = f"{degrees(angle):.4g} deg is {why}. Find the free angle from torques: {BY_TORQUES}. Then {WRITE_IT}"
        problems.append(Problem(text, str(design.project.path), key=f"measured.spring.{name}.free_angle"))
    if problems:
        raise UserError(problems)


def _measured_angles(design: LegDesign) -> list[tuple[str, float, tuple[float, float]]]:
    """Joint, free angle as read at rest, and drawn stops, rad, of each measured spring."""
    known, found = design.project.measured_springs, []
    for joint in () if design.drawn is None else design.drawn.dimensions.joints:
        measured = known.get(joint.name)
        if measured is not None and measured.free_angle is not None and measured.free_angle_by == "rest":
            low, high = joint.stop_angles
            found.append((joint.name, measured.free_angle, (radians(low), radians(high))))
    return found

"""From a chosen design to the joint dimensions for ``cad``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil, degrees, pi, remainder
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.design.damper_drawing import damper_of
from synth.design.drawable_springs import drawn_pitch
from synth.design.drawn_travel import drawn_range, is_asked, stops_of, turned_sentences, yields_of
from synth.design.leg_design import LegDesign, Solids, fastest_rates
from synth.design.spring_hands import hand_notes, hands_of, is_pair, unstated_hand
from synth.design.stop_places import least_stops, within_damper
from synth.errors import Problem, UserError
from synth.parts.part_candidates import MEASURE_IT
from synth.remarks import noted
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import Joint

if TYPE_CHECKING:
    from synth.cad import JointDimensions, PrintDimensions

CIRCLE_STEPS = 10.0  # a mm, to which the least circle of screws is rounded up: it is what a message asks for


@dataclass(frozen=True)
class _Given:
    """What a joint is drawn with, mm.

    ``arm``: the spring's free arm; None: as short as the joint allows. ``circle``: of the damper's screws; None: its
    own. ``tube``: its diameter and wall.
    """

    arm: float | None
    circle: float | None
    tube: tuple[float, float]


def dimensions_of(design: LegDesign, arms: Sequence[float | None] | None = None) -> Solids:
    """Dimensions of the built leg's joints, drawn in the rest pose.

    Seats with their caps and screws, the floor, the sockets, the grip of a damper's adapter and, if the project does
    not state them, the shaft and the links' tube grow until they bear the joint's torque. All links have the tube of
    the joint that asks for the largest, since a tube's two ends lie in two joints. ``arms``: the springs' free arm
    lengths, mm; None, for one or for all: as short as the joint allows.

    Raises
    ------
    cad.DimensionError
        if a joint cannot be drawn, for the first such joint. Of circles of screws that are too small it names the least
        possible of each joint, after the links that are too short even with these.
    """
    from synth import cad
    from synth.cad.leg_joints import link_problems
    from synth.cad.strength import tube_modulus

    options = design.project.cad
    printing = cad.PrintDimensions(
        bed=(options.bed[0] * 1e3, options.bed[1] * 1e3, options.bed[2] * 1e3),
        strength=options.print_strength * 1e-6,
        between_layers=options.between_layers,
        density=options.print_density * 1e-3,
        safety=options.safety,
    )
    stated = (options.link_width * 1e3, options.tube_wall * 1e3)
    tube, asking = stated, None
    while True:
        notes: list[str] = []
        joints, narrow = _drawn_joints(design, tube, arms, printing, notes)
        largest = max(joints, key=lambda joint: tube_modulus(joint.link_width, joint.tube_wall))
        if tube == (largest.link_width, largest.tube_wall):
            break
        tube, asking = (largest.link_width, largest.tube_wall), largest
    if asking is not None:
        notes.append(_tube_note(asking, stated))
    leg = cad.LegDimensions(design.project.name[:60], tuple(joints), tilt=degrees(design.built.tilt), printing=printing)
    if narrow:
        raise cad.DimensionError([*link_problems(leg), *narrow])
    return Solids(leg, tuple(notes))


def _drawn_joints(
    design: LegDesign,
    tube: tuple[float, float],
    arms: Sequence[float | None] | None,
    printing: PrintDimensions,
    notes: list[str],
) -> tuple[list[JointDimensions], list[Any]]:
    """Each joint, large enough for its loads, from links of ``tube`` (mm); the problems of circles of screws."""
    pose = np.degrees(design.built.to_measured(design.rest_pose))
    fastest = fastest_rates(design.built_motions, [release.time for release in design.wanted.releases])
    joints, narrow = list[Any](), list[Any]()
    for j in range(len(design.built.joints)):
        arm = None if arms is None else arms[j]

        def drawn(circle: float | None, j: int = j, arm: float | None = arm) -> JointDimensions:
            moves = (float(pose[j]), float(fastest[j]))
            return _borne(design, _joint(design, j, moves, _Given(arm, circle, tube), notes), printing, notes)

        joint, problem = with_least_circle(drawn)
        joints.append(joint)
        narrow += [] if problem is None else [problem]
    return joints, narrow


def _tube_note(asking: JointDimensions, stated: tuple[float, float]) -> str:
    """What tube the links have instead of the ``stated`` one (mm), for the joint that asks for it."""
    text = (
        f"to bear {asking.stop_torque:.3g} N*m at the stop of {asking.name}, the links are of tube "
        f"{asking.link_width:g} x {asking.tube_wall:g} mm instead of {stated[0]:g} x {stated[1]:g} mm"
    )
    return noted(text)


def with_least_circle(drawn: Callable[[float | None], JointDimensions]) -> tuple[JointDimensions, Any]:
    """The joint, and the problem of its damper's circle of screws with the least that is possible; None if it fits.

    Which limit of the circle is the largest shows only in the drawing that the smaller ones allow.

    Raises
    ------
    cad.DimensionError : anything else does not fit, or no larger circle does.
    """
    from synth import cad

    circle, first = None, None
    while True:
        try:
            joint = drawn(circle)
        except cad.DimensionError as error:
            (problem, *others) = error.problems
            if others or problem.least is None or not problem.dimension.endswith(".damper.bolt_circle"):
                raise
            if circle is not None and problem.least <= circle:
                raise
            first = replace(problem, value=(first or problem).value)
            circle = ceil(problem.least * CIRCLE_STEPS - 1e-6) / CIRCLE_STEPS
        else:
            return joint, None if first is None else replace(first, allowed=f"at least {circle:g} mm")


def _joint(design: LegDesign, j: int, moves: tuple[float, float], given: _Given, notes: list[str]) -> JointDimensions:
    """One joint before it is sized.

    ``moves``: its rest angle, deg, and its fastest rate, rad/s.
    """
    from synth import cad

    joint, options = design.built.joints[j], design.project.cad
    assert joint.spring is not None
    (rest, fastest), circle = moves, given.circle
    yields = yields_of(design, j)
    moved = drawn_range(design, j, rest)
    travel, stops = stops_of(design, j, moved, yields, notes)
    turns = design.dampers.chosen[j].turns
    if turns is not None:
        least = least_stops(moved, asked=is_asked(design, j))
        travel, stops = within_damper(travel, stops, least, degrees(turns))
    notes += turned_sentences(design, j)
    option = design.springs.chosen[j]
    notes += hand_notes(joint.name, option)
    damper = damper_of(design, j, options.shaft_diameter * 1e3, notes)
    dimensions = cad.JointDimensions(
        name=joint.name,
        spring=replace(_spring(design, j, notes), free_arm=given.arm),
        free_angle=degrees(joint.spring.free_angle),
        rest_angle=min(max(rest, travel[0]), travel[1]),  # a stated range may leave it out: it then leans on a stop
        range=travel,
        stops=stops,
        yields=yields,
        zero_angle=degrees(joint.zero),
        sign=joint.sign,
        damper=damper if circle is None else replace(damper, bolt_circle=circle),
        link_length=joint.link.length * 1e3,
        link_width=given.tube[0],
        tube_wall=given.tube[1],
        shaft_diameter=options.shaft_diameter * 1e3,
        clearance=options.clearance * 1e3,
        wall=options.wall * 1e3,
        loads=cad.LoadDimensions(joint.spring.rate, _damper_torque(joint, fastest)),
        mount=cad.MountDimensions() if options.mount and j == 0 else None,
        springs=2 if is_pair(option) else 1,
        closes=option.closes,
    )
    if not dimensions.rests_free:
        notes.append(_out_of_reach(dimensions))
    turned = replace(dimensions, upper_arm_angle=cad.clear_upper_arm_angle(dimensions))
    if turned.upper_arm_angle != 0.0:
        offset = remainder(turned.arm_offset, 360.0)
        text = f"{joint.name}: with this travel the upper arm cannot lie on the zero line of the angle; it is drawn "
        where = f"at {turned.upper_arm_angle:+.0f} deg from that line, and the lower arm at {offset:+.1f} deg"
        notes.append(noted(text + where))
    return turned


def _out_of_reach(dimensions: JointDimensions) -> str:
    low, high = dimensions.stop_angles
    stop = low if dimensions.free_angle <= low else high
    return (
        f"{dimensions.name}: its spring is unloaded at {dimensions.free_angle:.1f} deg, beyond the stop at {stop:.1f} "
        "deg. The joint without a load rests on that stop, so its free angle is to be found from torques. Files of the "
        f"joint's parts show it at {dimensions.filed_angle:.1f} deg, and the assembly's STEP leaves its spring out"
    )


def _damper_torque(joint: Joint, fastest: float) -> float:
    """The damper's torque (N*m) at the joint's fastest speed, rad/s."""
    if joint.damper is None:
        return 0.0
    if joint.damper.curve is not None:
        return float(torque_at(joint.damper.curve, np.array(fastest)))
    return (joint.damper.rate or 0.0) * fastest


def _borne(design: LegDesign, asked: JointDimensions, printing: PrintDimensions, notes: list[str]) -> JointDimensions:
    """The joint large enough for its loads, with an encoder seat if it fits; changes are added to ``notes``."""
    from synth import cad
    from synth.cad.fitting_problems import least_encoder_circle

    left_open = {default.key for default in design.project.defaults}
    may = set(cad.SIZED) | ({"shaft_diameter"} if "cad.shaft_diameter" in left_open else set())
    if not left_open.issuperset({"cad.link_width", "cad.tube_wall"}):
        may.remove("link_width")
    grown = cad.sized(asked, printing, may)
    changed = _grown(asked, grown)
    if changed:
        loads = f"{asked.spring_torque:.3g} N*m and the damper's {asked.loads.damper_torque:.3g} N*m"
        notes.append(noted(f"{asked.name}: to bear the spring's {loads}: {', '.join(changed)}"))
    if not design.project.cad.encoder:
        return grown
    seated = replace(grown, encoder=cad.EncoderDimensions())
    # These screws fasten the printed seat, not the sensor; their positions depend on the parts on the shaft.
    circle = max(cad.EncoderDimensions().bolt_circle, ceil(least_encoder_circle(seated)))
    seated = replace(grown, encoder=cad.EncoderDimensions(bolt_circle=circle))
    try:
        return replace(seated, upper_arm_angle=cad.clear_upper_arm_angle(seated))
    except cad.DimensionError as error:
        notes.append(f"{asked.name}: the encoder seat is not drawn: {error.problems[0]}")
        return grown


def _grown(asked: JointDimensions, grown: JointDimensions) -> list[str]:
    """Each dimension that sizing changed, with its new value, for the note."""
    before_grip, after_grip = (
        None if joint.damper.adapter is None else joint.damper.adapter.output_grip for joint in (asked, grown)
    )
    return [
        f"{name.replace('_', ' ')} {after:g} mm" + (f" instead of {before:g}" if before is not None else "")
        for name, before, after in (
            ("seat_screw", asked.seat_screw, grown.seat_screw),
            ("seat_length", asked.seat_length, grown.seat_length),
            ("cap", asked.cap, grown.cap),
            ("floor", asked.floor_thickness, grown.floor_thickness),
            ("tube's sockets", asked.socket_depth, grown.socket_depth),
            ("damper's shaft in the adapter", before_grip, after_grip),
            ("shaft_diameter", asked.shaft_diameter, grown.shaft_diameter),
        )
        if after != before
    ]


def _spring(design: LegDesign, j: int, notes: list[str]) -> Any:
    from synth import cad

    option, name = design.springs.chosen[j], design.built.joint_names[j]
    if option.row is not None:
        row = option.row
        if row.wire_diameter is None or row.mean_diameter is None or row.body_coils is None:
            text = (
                f"{row.part} ({row.place}) cannot be drawn: {row.status}{MEASURE_IT}. Or leave the solids out: --no-cad"
            )
            raise UserError(Problem(text, str(design.project.path), key=f"select.joints.{name}.spring"))
        if row.leg_convention not in ("", "tangent"):
            text = (
                f"{row.part} ({row.place}) has {row.leg_convention} legs; the joints are drawn for tangent ones only: "
                "choose another spring, or leave the solids out with --no-cad"
            )
            raise UserError(Problem(text, str(design.project.path), key=f"select.joints.{name}.spring"))
        notes += unstated_hand(name, option)
        assert row.rate is not None
        # The catalogue's rate is that of the body alone; the arms make the spring softer.
        stiff = pi * row.mean_diameter * row.body_coils * row.rate * option.count / option.rate * 1e3
        return cad.SpringDimensions(
            row.wire_diameter * 1e3, row.mean_diameter * 1e3, row.body_coils, degrees(option.included_angle),
            pitch=drawn_pitch(row), stiff_length=stiff if option.rate != row.rate * option.count else None,
            hand=hands_of(option)[0],
        )  # fmt: skip
    made = option.design
    assert made is not None
    return cad.SpringDimensions(
        made.wire_diameter * 1e3, made.mean_diameter * 1e3, made.body_coils, degrees(made.included_angle),
        stiff_length=pi * made.mean_diameter * made.active_coils * 1e3, hand=hands_of(option)[0],
    )  # fmt: skip

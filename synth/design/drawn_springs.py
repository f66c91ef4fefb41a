"""The design as drawn: springs with the arms of their joints, stops, and the resulting leg.

A spring's rate depends on the free length of its arms, and that length on the drawn joint. Joint and spring are
therefore solved together. A spring to wind gets the mean diameter at which it has the designed rate with these arms. A
bought spring has the catalogue's rate of the body, reduced by the compliance of the arms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, degrees, pi, radians
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.design.choose_springs import SpringOption
from synth.design.drawn_remedies import remedy_of
from synth.design.drawn_travel import well_seated
from synth.design.forecast import spring_tolerance
from synth.design.joint_sizing import dimensions_of
from synth.design.leg_design import LegDesign, Solids
from synth.design.leg_reach import short_legs
from synth.design.measured_forecast import with_measured_forecast
from synth.design.measured_rate import rate_in_joint
from synth.parts.catalogs import Catalogue
from synth.remarks import decisive
from synth.spring.bought_spring import check_bought
from synth.spring.evaluate import check_spring
from synth.spring.loose_test import loose_test, pin_distance
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign
from synth.spring.spring_search import lasts
from synth.swing.leg_model import Leg
from synth.units import quantity

if TYPE_CHECKING:
    from synth.cad import JointDimensions

ROUNDS = 8  # iterations of spring and joint; the demo converges in three
SETTLED = 1e-5  # relative, of mean diameters and rates from round to round
HALVINGS = 60  # bisection steps of a bracket of a factor of four: to machine precision
SEAT_TRAVEL = 13.0  # deg, either way; default of ``cad``
LEAST_LEFT = radians(0.1)  # remaining error of a free angle that gives a warning: the resolution of an encoder
LEAST_PLAY = radians(0.01)  # a smaller backlash is rounding of the meshes


def draw_up(design: LegDesign, catalogue: Catalogue) -> LegDesign:
    """The design with its springs, stops and joints as drawn; its motions are simulated again if the leg changed.

    Raises
    ------
    cad.DimensionError
        if a joint cannot be drawn.
    UserError
        if a part cannot be drawn.
    """
    arms: tuple[float, ...] | None = None
    for _ in range(ROUNDS):
        seated = well_seated(design)
        if seated is not design:  # other seats, other arms
            design, arms = seated, None
        solids = _laid_out(design, arms)
        found = _free_arms(solids)
        # Arms may only grow, so that the iteration of spring and joint does not oscillate.
        arms = found if arms is None else tuple(max(a, b) for a, b in zip(arms, found, strict=True))
        chosen = tuple(
            _with_free_arms(option, dimensions, arm, catalogue)
            for option, dimensions, arm in zip(design.springs.chosen, solids.dimensions.joints, arms, strict=True)
        )
        change = max(_change(before, after) for before, after in zip(design.springs.chosen, chosen, strict=True))
        design = _with_springs(design, chosen)
        if change < SETTLED:
            break
    solids = dimensions_of(design, arms)
    drawn = zip(design.built.joint_names, design.springs.chosen, solids.dimensions.joints, strict=True)
    short = [text for each in drawn for text in short_legs(*each)]
    solids = replace(solids, notes=(*solids.notes, *_worse_as_drawn(design), *short))
    return replace(design, drawn=solids, built=with_stops(design.built, solids.dimensions.joints))


def _worse_as_drawn(design: LegDesign) -> list[str]:
    """A sentence for each spring to wind that violates a limit or does not last only with the arms of its drawn joint.

    The search estimates the arms; what it found is among the design's warnings already.
    """
    found = []
    for name, option in zip(design.built.joint_names, design.springs.chosen, strict=True):
        made, searched = option.design, option.result
        if made is None or searched is None:
            continue
        known = {each.limit for item in searched.nearest for each in item.design.violations}
        known = known if searched.best is None else set()
        broken = [each for each in made.violations if each.limit not in known]
        texts, limits = [each.text for each in broken], [each.limit for each in broken]
        lasted = searched.best is not None and lasts(searched.best, searched.wish.limits)
        if lasted and not lasts(made, searched.wish.limits) and searched.wish.limits.cycles is None:
            assert made.life is not None
            texts.append(f"strength over stress for {DESIGN_LIFE:.0f} full turns {made.life.factor(DESIGN_LIFE):.3f}")
            limits.append("fatigue")
        if texts:
            remedy = remedy_of(name, limits, searched.wish.limits, design.project.cad)
            found.append(decisive(f"{name}: the spring to wind, as its joint holds it, has {'; '.join(texts)}", remedy))
    return found


def _laid_out(design: LegDesign, arms: Sequence[float | None] | None) -> Solids:
    """The joints with these free arms, mm; the joint sets an arm that is too short for the new coil."""
    from synth.cad import DimensionError

    while True:
        try:
            return dimensions_of(design, arms)
        except DimensionError as error:
            found = {problem.dimension for problem in error.problems}
            short = [f"{joint.name}.spring.free_arm" in found for joint in design.built.joints]
            if arms is None or not any(short):
                raise
            arms = [None if open_again else arm for arm, open_again in zip(arms, short, strict=True)]


def _free_arms(solids: Solids) -> tuple[float, ...]:
    """The free arm lengths (mm) that the joints require, rounded up to a tenth."""
    from synth.cad.checked_layout import lay_out

    return tuple(ceil(10.0 * lay_out(joint).free_arm - 1e-6) / 10.0 for joint in solids.dimensions.joints)


def _with_free_arms(
    option: SpringOption, dimensions: JointDimensions, arm: float, catalogue: Catalogue
) -> SpringOption:
    """A spring with free arms of ``arm`` mm."""
    from synth.cad.arm_layout import seat_size
    from synth.cad.flexed_wire import effective_length

    spring = dimensions.spring
    distance = pin_distance(arm * 1e-3, seat_size(dimensions).length * 1e-3)
    if option.row is not None:
        row = option.row
        assert row.rate is not None
        body = pi * spring.mean_diameter * spring.drawn_coils
        rate = row.rate * body / effective_length(spring.radius, spring.drawn_coils, arm)
        check = option.check
        if check is not None:
            length, turned = arm * 1e-3, (check.travel, check.opening_travel)
            check = check_bought(row, catalogue, *turned, arm=lambda *sizes: length, rate=rate)
        loose = loose_test(row.rate, spring.drawn_coils, spring.mean_diameter * 1e-3, distance)
        return replace(option, rate=rate * option.count, check=check, loose=loose)
    assert option.design is not None
    made = _wound(option, dimensions, arm, catalogue)
    body_rate = made.rate * made.active_coils / made.body_coils
    loose = loose_test(body_rate, made.body_coils, made.mean_diameter, distance)
    return replace(option, design=replace(made, loose=loose))


def _wound(option: SpringOption, dimensions: JointDimensions, arm: float, catalogue: Catalogue) -> SpringDesign:
    """The spring to wind with the mean diameter that gives its rate with free arms of ``arm`` mm."""
    from synth.cad.flexed_wire import effective_length
    from synth.cad.layout import place
    from synth.cad.torsion_spring import wire_length

    assert option.design is not None
    assert option.result is not None
    made, rate = option.design, option.rate / option.design.count
    task = replace(
        option.result.wish.task,
        travel=made.travel,
        opening_travel=made.opening_travel,
        free_arm=lambda *sizes: arm * 1e-3,
        pitch=dimensions.spring.drawn_pitch / dimensions.spring.wire_diameter,
    )
    wire, coils = made.wire_diameter, dimensions.spring.drawn_coils
    # EI of the designed spring, independent of the formula and calibration of its rate: rate = EI/(pi D Na).
    rigidity = made.rate * pi * made.mean_diameter * made.active_coils
    wanted = rigidity / rate * 1e3  # mm
    low, high = 0.5 * made.mean_diameter * 1e3, 2.0 * made.mean_diameter * 1e3
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if effective_length(middle / 2, coils, arm) < wanted else (low, middle)
    mean = (low + high) / 2
    drawn = replace(dimensions.spring, mean_diameter=mean, free_arm=arm)
    layout = place(replace(dimensions, spring=drawn))
    legs = layout.arm_length * 1e-3
    found = check_spring(
        catalogue.find_material(made.material),
        wire,
        mean * 1e-3,
        made.body_coils,
        replace(task, leg_lengths=(legs, legs)),
        included_angle=made.included_angle,
        stated_rate=rate,
        count=made.count,
    )
    active = wanted / (pi * mean)
    length = wire_length(drawn, layout.arm_length) * 1e-3
    return replace(
        found,
        active_coils=active,
        rate_bending_form=made.rate_bending_form * rate / made.rate,
        rate_friction_form=made.rate_friction_form * rate / made.rate,
        wire_length=length,
        mass=found.mass * length / found.wire_length,
        hand=made.hand,
    )


def _change(before: SpringOption, after: SpringOption) -> float:
    change = abs(after.rate / before.rate - 1.0)
    if before.design is not None and after.design is not None:
        change = max(change, abs(after.design.mean_diameter / before.design.mean_diameter - 1.0))
    return change


def _with_springs(design: LegDesign, chosen: Sequence[SpringOption]) -> LegDesign:
    """The design with these springs; if a rate changed, the rest pose is kept and the motions are simulated again."""
    drawn = {id(before): after for before, after in zip(design.springs.chosen, chosen, strict=True)}
    ranked = tuple(tuple(drawn.get(id(option), option) for option in each) for each in design.springs.ranked)
    springs = replace(design.springs, chosen=tuple(chosen), ranked=ranked)
    rates = np.array([option.rate for option in chosen])
    before = design.built.spring_rate
    if np.allclose(rates, before, rtol=1e-9):
        return replace(design, springs=springs)
    pose, joints = design.rest_pose, []
    for joint, rate, angle in zip(design.built.joints, rates, pose, strict=True):
        assert joint.spring is not None
        rest = float(angle + (joint.rest - angle) * joint.spring.rate / rate)
        spring = replace(joint.spring, rate=float(rate), free_angle=joint.zero + joint.sign * rest)
        joints.append(replace(joint, spring=spring))
    return simulate_built_leg(replace(design, springs=springs, built=replace(design.built, joints=tuple(joints))))


def simulate_built_leg(design: LegDesign) -> LegDesign:
    """The design with the motions and errors of its built leg simulated again."""
    motions = tuple(found[:, :, 0] for found in design.wanted.simulate([design.built]))
    return replace(design, built_motions=motions, errors=design.wanted.errors([design.built])[0])


def with_stops(leg: Leg, joints: Sequence[JointDimensions]) -> Leg:
    """The leg with joint ranges that end at the drawn stops."""
    ranges = [tuple(radians(angle) for angle in joint.stop_angles) for joint in joints]
    return replace(
        leg,
        joints=tuple(replace(joint, range=(ends[0], ends[1])) for joint, ends in zip(leg.joints, ranges, strict=True)),
    )


def as_drawn(design: LegDesign, joints: Mapping[str, Any]) -> LegDesign:
    """The design with the play of its drawn joints as backlash in the built leg, and its motions with it.

    ``joints`` : the entries of ``solids.joints`` in ``design.json``.
    """
    built = []
    for joint in design.built.joints:
        play = joints.get(joint.name, {}).get("play")
        gap = 0.0 if play is None else radians(play["value"])
        known = joint.effects.get("backlash", {}).get("gap", 0.0)
        if gap > LEAST_PLAY and gap > known:
            joint = replace(joint, effects={**joint.effects, "backlash": {"gap": gap}})
        built.append(joint)
    if tuple(built) == design.built.joints:
        return design
    return simulate_built_leg(replace(design, built=replace(design.built, joints=tuple(built))))


@dataclass(frozen=True)
class SeatSetting:
    """The setting of a joint's seat for the measured spring; angles in rad.

    ``turn`` is the setting on the scale, positive towards larger free angles. ``left`` is the part of the free angle's
    error beyond the seat's travel. ``rate`` and ``free_angle`` are the resulting values of the joint.
    """

    turn: float
    left: float
    rate: float
    free_angle: float

    def as_json(self) -> dict[str, Any]:
        """For ``design.json``."""
        return {
            "turn": quantity(self.turn, "deg"),
            "left": quantity(self.left, "deg"),
            "rate": quantity(self.rate, "N*m/rad"),
            "free_angle": quantity(self.free_angle, "deg"),
        }


def seats_set(design: LegDesign) -> tuple[LegDesign, dict[str, SeatSetting]]:
    """The design with measured springs, their seats set so that the leg has its designed rest pose.

    A rate measured on the loose spring is converted into the joint's. The parts are unchanged. Rates and free angles of
    the built leg become those of the measured springs, and its motions and its forecasts are made with them. For a
    spring of another rate the free angle is the one with the designed rest pose. Where only the rate is measured, the
    seat is taken as it can be set later, and has no setting: that follows from the free angle.
    """
    known = design.project.measured_springs
    if not known:
        return design, {}
    pose, joints, settings = design.rest_pose, [], {}
    for index, joint in enumerate(design.built.joints):
        measured = known.get(joint.name)
        if measured is None:
            joints.append(joint)
            continue
        assert joint.spring is not None
        option = design.springs.chosen[index]
        rate = rate_in_joint(measured, option) if measured.rate is not None else joint.spring.rate
        rest = float(pose[index] + (joint.rest - pose[index]) * joint.spring.rate / rate)
        suits = joint.zero + joint.sign * rest
        found = measured.free_angle if measured.free_angle is not None else joint.spring.free_angle
        travel = radians(SEAT_TRAVEL)
        if design.drawn is not None:
            travel = radians(design.drawn.dimensions.joints[index].seat_travel)
        turn = min(travel, max(-travel, suits - found))
        if measured.free_angle is not None:
            settings[joint.name] = SeatSetting(turn, suits - found - turn, rate, found + turn)
        joints.append(replace(joint, spring=replace(joint.spring, rate=rate, free_angle=found + turn)))
    design = replace(design, built=replace(design.built, joints=tuple(joints)))
    design = _with_rate_warnings(_with_seat_warnings(design, settings))
    return with_measured_forecast(simulate_built_leg(design), known), settings


def _with_rate_warnings(design: LegDesign) -> LegDesign:
    """The design with a warning for each measured rate that is off the designed one by more than its tolerance."""
    asked, warnings = design.project.parts.tolerance, []
    for joint, option in zip(design.built.joints, design.springs.chosen, strict=True):
        measured = design.project.measured_springs.get(joint.name)
        if measured is None or measured.rate is None or joint.spring is None:
            continue
        off, allowed = joint.spring.rate / option.rate - 1.0, spring_tolerance(option, asked).rate
        if abs(off) > allowed:
            text = (
                f"{joint.name}: the measured spring has {joint.spring.rate:.4g} N*m/rad in the joint, {off:+.0%} from "
                f"the designed {option.rate:.4g} (tolerance {allowed:.0%}). All figures are with the measured rate"
            )
            remedy = "Check the unit, the distance of the force from the coil, and that it is this joint's spring."
            warnings.append((joint.name, decisive(text, remedy)))
    return replace(design, warnings=(*warnings, *design.warnings))


def _with_seat_warnings(design: LegDesign, settings: Mapping[str, SeatSetting]) -> LegDesign:
    """The design with a warning for each seat whose travel is too small."""
    warnings = [
        (
            name,
            decisive(
                f"{name}: the free angle of the measured spring is {degrees(setting.left):+.1f} deg beyond its seat's "
                f"travel, which ends at {degrees(setting.turn):+.1f} deg",
                "Check that the assembled joint's angle was read, not the loose spring's; else wind or choose another.",
            ),
        )
        for name, setting in settings.items()
        if abs(setting.left) > LEAST_LEFT
    ]
    return replace(design, warnings=(*warnings, *design.warnings))

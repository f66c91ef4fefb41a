"""The solids of a leg built, checked and written joint by joint, in side processes where there are any.

A joint's checks, files and pictures need nothing of the other joints, so each process builds only the joints that it
works on. The results do not depend on the number of processes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.compiling.solid_kernel import load_cadquery
from synth.design.chain_work import Built, Packed, check_chain_of, leg_of_copies
from synth.shared_calls import ResultOf, SideCall
from synth.side_processes import carried_out, packed, process_count, unpacked

if TYPE_CHECKING:
    from synth.cad import BuiltLeg, CheckResult, ExportedFile, LegDimensions
    from synth.cad.chain_checks import Shadow
    from synth.cad.joint import BuiltJoint
    from synth.design.part_masses import PartMass, Pieces

# Weighed masses (kg) by part, numbers of dampers and springs by joint.
Known = tuple[Mapping[str, float], Mapping[str, "Pieces"]]


def load_kernel() -> None:
    """Load the solids' kernel and the meshes' libraries, which takes seconds, before they are needed."""
    load_cadquery()
    import manifold3d  # noqa: F401
    import scipy.optimize  # noqa: F401  # the gates' linear programme
    import trimesh  # noqa: F401

    from synth.cad import assembly, checks, export, printing  # noqa: F401
    from synth.design import part_masses  # noqa: F401


def joint_masses(
    dimensions: LegDimensions, weighed: Mapping[str, float], pieces: Mapping[str, Pieces]
) -> tuple[PartMass, ...]:
    """Every part's mass, joint by joint, of facets and therefore within 1e-5; arguments as ``masses_of``.

    Raises
    ------
    cad.DimensionError
        with everything that does not fit, in all joints.
    """
    _laid_out(dimensions)
    calls = [SideCall(_masses, (dimensions, k, weighed, pieces), place) for k, place in _places(dimensions)]
    return tuple(mass for found in carried_out(calls) for mass in found)


def _masses(
    dimensions: LegDimensions, index: int, weighed: Mapping[str, float], pieces: Mapping[str, Pieces]
) -> tuple[PartMass, ...]:
    from synth.cad.leg_joints import build_leg_of_facets
    from synth.design.part_masses import masses_of

    return masses_of(build_leg_of_facets(dimensions), weighed, pieces, [index])


def _laid_out(dimensions: LegDimensions) -> None:
    from synth.cad.leg_joints import lay_out_leg

    lay_out_leg(dimensions)


def _places(dimensions: LegDimensions) -> list[tuple[int, int | None]]:
    """Each joint with the process that it belongs to: as many in each, the rest in whichever is free."""
    count, number = len(dimensions.joints), process_count()
    whole = count // number * number if number else 0
    return [(k, k % number if k < whole else None) for k in range(count)]


@dataclass(frozen=True)
class CheckedLeg:
    """All checks of a leg in their order; ``record``: the entries ``print``, ``parts``, ``joints`` and ``assembly``.

    ``orders`` : by name, what each part that is bought by a standard or cut is ordered by, ``StandardPart.as_json``.
    ``built`` : each joint with its link, for ``written_leg``. ``notes`` : sentences on what no check forbids.
    """

    checks: tuple[CheckResult, ...]
    record: dict[str, Any]
    orders: dict[str, Any]
    masses: list[dict[str, Any]]
    built: Built
    notes: list[str]

    @property
    def passed(self) -> bool:
        """Whether every check has passed."""
        return all(check.passed for check in self.checks)

    @staticmethod
    def check_json(check: CheckResult, picture: str | None) -> dict[str, Any]:
        """A check as written in ``design.json``."""
        return {
            "name": check.name,
            "part": check.part,
            "passed": check.passed,
            "value": _value(check.value, check.unit),
            "limit": _value(check.limit, check.unit),
            "text": str(check),
            **({"angle": _value(check.angle, "deg")} if check.angle is not None else {}),
            **({"picture": picture} if picture is not None else {}),
        }


def _value(value: float, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit or "1"}


@dataclass(frozen=True)
class _Parts:
    """What is found from a joint's parts one by one: checks of the parts and of their printing, and their record."""

    alone: list[CheckResult]
    printing: list[CheckResult]
    plans: list[dict[str, Any]]
    parts: list[dict[str, Any]]
    orders: dict[str, Any]
    steps: list[dict[str, Any]]
    masses: list[dict[str, Any]]


def checked_leg(dimensions: LegDimensions, weighed: Mapping[str, float], pieces: Mapping[str, Pieces]) -> CheckedLeg:
    """Build and check every joint, with the record of its parts.

    Raises
    ------
    cad.DimensionError
        with everything that does not fit, in all joints.
    """
    _laid_out(dimensions)
    homes, names = _homes(dimensions), [joint.name for joint in dimensions.joints]
    count = len(names)
    # A process that has built its joints checks while another one still builds.
    calls = [SideCall(_pack_joint, (dimensions, k), home) for k, home in homes]
    calls += [SideCall(_of_motion, (k, ResultOf(k))) for k in range(count)]
    calls += [SideCall(_of_parts, (dimensions, k, (weighed, pieces)), home) for k, home in homes]
    # A link's check needs the joint that follows.
    calls += [SideCall(_of_link, (dimensions, k - 1, ResultOf(k - 1)), home) for k, home in homes[1:]]
    found = carried_out(calls)
    built, moving, parts, links = (found[k * count : (k + 1) * count] for k in range(4))
    checks = [
        c for (motion, *_), part in zip(moving, parts, strict=True) for c in (*part.alone, *motion, *part.printing)
    ]
    record = {
        "print": [plan for part in parts for plan in part.plans],
        "parts": [item for part in parts for item in part.parts],
        "joints": {name: json for name, (_, json, _) in zip(names, moving, strict=True)},
        "assembly": {name: part.steps for name, part in zip(names, parts, strict=True)},
    }
    masses = [mass for part in parts for mass in part.masses]
    orders = {name: order for part in parts for name, order in part.orders.items()}
    chain, notes = check_chain_of(dimensions, built, [shadows for _, _, shadows in moving])
    checks += [*(check for link in links for check in link), *chain]
    return CheckedLeg(tuple(checks), record, orders, masses, built, notes)


def _homes(dimensions: LegDimensions) -> list[tuple[int, int | None]]:
    """Each joint with the process that builds it, and has its solids."""
    number = process_count()
    return [(k, k % number if number else None) for k in range(len(dimensions.joints))]


def _pack_joint(dimensions: LegDimensions, index: int) -> Packed:
    """A joint and its link.

    In a copy the last bits of directions differ, so copies are used where any process may be, and nowhere else.
    """
    from synth.cad.leg_joints import built_leg

    leg = built_leg(dimensions)
    return packed(leg.joints[index]), packed(leg.links[index])


def _of_motion(index: int, packed: Packed) -> tuple[list[CheckResult], dict[str, Any], list[Shadow]]:
    """Checks of a joint's moving parts, its entry in the record, and the shadows of its parts."""
    from synth.cad.chain_checks import shadows_of
    from synth.cad.checks import check_interference

    joint, link = (unpacked(each) for each in packed)
    return check_interference(joint, link), _joint_json(joint), shadows_of(index, joint, link)


def _of_parts(dimensions: LegDimensions, index: int, known: Known) -> _Parts:
    from synth.cad.assembly import assembly
    from synth.cad.checks import check_parts
    from synth.cad.leg_joints import built_leg
    from synth.cad.moments import about_z
    from synth.cad.printing import WAYS_UP, check_printing, plan_joint
    from synth.design.part_masses import mass_json, masses_of

    leg, printing = built_leg(dimensions), dimensions.printing
    joint = leg.joints[index]
    turns = {part.name: joint.turn(part.group, joint.dimensions.filed_angle) for part in joint.parts}
    return _Parts(
        alone=check_parts(joint, leg.links[index]),
        printing=check_printing(joint, printing),
        plans=[
            {"part": plan.part, "up": plan.up,
             "up_in_file": [_value(round(x, 6), "1") for x in about_z(WAYS_UP[plan.up], turns[plan.part])],
             "support": _value(plan.overhang, "mm^2"),
             "contact": _value(plan.contact, "mm^2"), "wobbly": plan.wobbly,
             "size": [_value(size, "mm") for size in plan.size]}
            for plan in plan_joint(joint, printing)
        ],
        parts=part_records(leg, index),
        orders=_orders(leg, index),
        steps=[{"step": step.text, "parts": list(step.parts)} for step in assembly(joint)],
        masses=[mass_json(item) for item in masses_of(leg, *known, [index])],
    )  # fmt: skip


def _of_link(dimensions: LegDimensions, index: int, packed: Packed) -> list[CheckResult]:
    from synth.cad.checks import check_link
    from synth.cad.leg_joints import BuiltWhenUsed, built_leg

    leg = built_leg(dimensions)
    links = BuiltWhenUsed(len(leg.links), lambda _: unpacked(packed[1]))
    return check_link(replace(leg, links=links), index)


def written_leg(
    dimensions: LegDimensions, built: Built, folder: Path, *, pictures: bool
) -> tuple[list[ExportedFile], list[str]]:
    """Write a leg that has passed its checks; the files, and a sentence if its pictures could not be drawn.

    ``built`` : of its ``CheckedLeg``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    homes = _homes(dimensions)
    # The whole leg in pieces that any process takes; what only one of them can do comes first.
    calls = [SideCall(work, (dimensions, built, folder)) for work in (_write_leg, _write_others)]
    calls += [SideCall(_write_joint, (dimensions, k, folder), home) for k, home in homes]
    calls += [SideCall(_draw_joint, (dimensions, k, folder), home) for k, home in homes if pictures]
    calls += [SideCall(_draw_leg, (dimensions, built, folder))] if pictures else []
    leg, others, *found = carried_out(calls)
    whole, joints, drawn = [*leg, *others], found[: len(homes)], found[len(homes) :]
    files = [file for parts, _ in joints for file in parts]
    files += [file for _, assembled in joints for file in assembled]
    missing = [each for each in drawn if isinstance(each, str)]
    shown = [] if missing else [file for each in drawn for file in each]
    return [*files, *whole, *shown], missing[:1]


def _write_joint(dimensions: LegDimensions, index: int, folder: Path) -> tuple[list[ExportedFile], list[ExportedFile]]:
    """The files of a joint's parts, and of the joint."""
    from synth.cad.export import write_assembly, write_parts
    from synth.cad.leg_joints import built_leg

    leg = built_leg(dimensions)
    return write_parts(leg, index, folder), write_assembly(leg, index, folder)


def _draw_joint(dimensions: LegDimensions, index: int, folder: Path) -> list[ExportedFile] | str:
    """The pictures of a joint, or why there are none."""
    from synth import cad
    from synth.cad.export import draw_joint
    from synth.cad.leg_joints import built_leg

    try:
        return draw_joint(built_leg(dimensions), index, folder)
    except cad.PreviewError as error:
        return str(error)


def _write_leg(dimensions: LegDimensions, built: Built, folder: Path) -> list[ExportedFile]:
    """The assembly of the whole leg."""
    from synth.cad.export import write_assembly

    return write_assembly(leg_of_copies(dimensions, tuple(built)), None, folder)


def _write_others(dimensions: LegDimensions, built: Built, folder: Path) -> list[ExportedFile]:
    """The files of the whole leg for printing, viewing and cutting."""
    from synth.cad.export import write_for_others

    return write_for_others(leg_of_copies(dimensions, tuple(built)), folder)


def _draw_leg(dimensions: LegDimensions, built: Built, folder: Path) -> list[ExportedFile] | str:
    """The picture of the whole leg, or why there is none."""
    from synth import cad
    from synth.cad.export import draw_whole

    try:
        return draw_whole(leg_of_copies(dimensions, tuple(built)), folder)
    except cad.PreviewError as error:
        return str(error)


def failures_of(dimensions: LegDimensions, checks: Sequence[CheckResult], folder: Path) -> dict[str, CheckResult]:
    """Pictures of the failed checks; see ``cad.draw_failures``.

    Raises
    ------
    cad.PreviewError
        when this machine cannot draw.
    """
    [found] = carried_out([SideCall(_draw_failures, (dimensions, checks, folder))])
    return dict(found)


def _draw_failures(dimensions: LegDimensions, checks: Sequence[CheckResult], folder: Path) -> dict[str, CheckResult]:
    from synth import cad
    from synth.cad.leg_joints import built_leg

    return cad.draw_failures(built_leg(dimensions), checks, folder)


def part_records(leg: BuiltLeg, index: int) -> list[dict[str, Any]]:
    """Every part of a joint with its method of manufacture, mass, centre of mass and inertia.

    ``size`` and ``com`` are in the frame of the part's STL and STEP: the joint's, hinge axis z, its parent link along
    +y, at the files' angle. ``in_link`` has them in the frame of the half that the part moves with, whose link lies
    along y: towards the parent (+y) for the upper half, away from it (-y) for the lower one. ``box`` is the part's own
    size, however it points. ``inertia`` is about the
    com, for the axis parallel to the hinge, the same in both.
    """
    from synth.cad.moments import about_z

    joint, density, found = leg.joints[index], leg.dimensions.printing.density, []
    angle = joint.dimensions.filed_angle
    for part in (*joint.parts, leg.links[index]):
        mass, turn = part.mass(density), joint.turn(part.group, angle)
        item: dict[str, Any] = {
            "part": part.name, "joint": joint.dimensions.name, "family": part.family, "made": str(part.made),
            "moves_with": part.group, "material": part.material,
            "mass": None if mass is None else _value(mass, "g"), "size": joint.filed_mesh(part).size,
            "in_link": {"size": part.size}, "box": part.mesh.own_size,
        }  # fmt: skip
        if part.printed:
            item["volume"] = _value(part.moments().volume, "mm^3")
        if mass is not None:
            moments = part.moments()
            item["com"] = [_value(place, "mm") for place in about_z(moments.centre, turn)]
            item["in_link"]["com"] = [_value(place, "mm") for place in moments.centre]
            item["inertia"] = _value(mass * 1e-9 * moments.about_z / moments.volume, "kg*m^2")
        found.append(item)
    return found


def _orders(leg: BuiltLeg, index: int) -> dict[str, Any]:
    made = {part.name: part.made for part in (*leg.joints[index].parts, leg.links[index])}
    return {name: order.as_json() for name, order in made.items() if not isinstance(order, str)}


def _joint_json(joint: BuiltJoint) -> dict[str, Any]:
    """Properties of a drawn joint: play, stop angles, arms and seat."""
    from synth.cad.play import play_of

    dimensions, layout, play = joint.dimensions, joint.layout, play_of(joint)
    return {
        "play": None
        if play is None
        else {**_value(play.width, "deg"), "low": _value(play.low, "deg"), "high": _value(play.high, "deg")},
        "stops": [_value(angle, "deg") for angle in dimensions.stop_angles],
        "arms": {
            "free": _value(layout.free_arm, "mm"),
            "clamped": _value(layout.seat.length, "mm"),
            "whole": _value(layout.arm_length, "mm"),
            "upper_arm_angle": _value(dimensions.upper_arm_angle, "deg"),
            "drawn_rate_over_designed": _value(_rate_ratio(dimensions.spring, layout.free_arm), "1"),
        },
        "seat": {"travel": _value(layout.plate.travel, "deg"), "scale": _value(1.0, "deg")},
    }


def _rate_ratio(spring: Any, free_arm: float) -> float:
    from synth.cad.flexed_wire import effective_length

    drawn = effective_length(spring.radius, spring.drawn_coils, free_arm)
    return 1.0 if spring.stiff_length is None else float(spring.stiff_length / drawn)

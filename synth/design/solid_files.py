"""The solids of a design: drawn, checked, written, and recorded in ``design.json``."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.cad.by_torques import BY_TORQUES
from synth.design.drawing_refusals import not_drawable
from synth.design.free_angle_reach import WRITE_IT, out_of_reach
from synth.design.measured_forecast import measured_free_angles
from synth.errors import CannotBeHad, Problem
from synth.files.output import write_json
from synth.files.stage_cache import StageCache, key_of
from synth.remarks import decisive
from synth.spring.loose_test import HOW_HELD

if TYPE_CHECKING:
    from synth.cad import CheckResult, ExportedFile, JointDimensions
    from synth.cad.standard_part import CutPart, StandardPart
    from synth.design.choose_springs import SpringOption
    from synth.design.drawn_springs import SeatSetting
    from synth.design.leg_design import LegDesign, Solids
    from synth.design.part_masses import PartMass, Pieces
    from synth.spring.winding_sheet import JointTravel

NOT_FINAL = "Run without --no-cad before you order parts."
RECORD = "solids.json"  # of a kept stage; not part of the output
NOT_DRAWN: dict[str, Any] = {
    "pictures": [],
    "solids": {"drawn": False, "checks": [], "print": [], "parts": [], "joints": {}, "notes": []},
}


@dataclass(frozen=True)
class DrawnSolids:
    """What was drawn of a design.

    ``extra`` : the entries ``pictures`` and ``solids`` of ``design.json``, where ``solids.drawn`` is whether the joints
    were exported. ``masses`` : of each part. ``orders`` : by name, what each part that is bought by a standard or cut
    is ordered by.
    """

    extra: dict[str, Any]
    masses: tuple[PartMass, ...] = ()
    orders: Mapping[str, StandardPart | CutPart] = field(default_factory=dict)


def draw_solids(design: LegDesign, folder: Path, cache: StageCache, *, pictures: bool) -> DrawnSolids:
    """Draw the joints into ``folder/parts`` if every check passes, else a picture of each failure into ``checks``.

    Raises
    ------
    UserError : dimensions from which no joint can be drawn, by name.
    """
    from synth import cad
    from synth.cad.standard_part import made_from
    from synth.design.mass_loop import pieces_of
    from synth.design.part_masses import mass_from

    solids, weighed, pieces = design.drawn, design.project.cad.masses, pieces_of(design)
    assert solids is not None
    key = key_of("solids", solids, pictures, sorted(weighed.items()), sorted(pieces.items()))
    if not cache.fetch(key, folder):
        try:
            record, whole = _draw_solids(solids, folder, (weighed, pieces), pictures=pictures)
        except cad.DimensionError as error:
            raise not_drawable(error, design.project) from None
        write_json(folder / RECORD, record)
        if whole:
            cache.keep(key, folder, ("parts", "checks", RECORD))
    record = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    (folder / RECORD).unlink()
    shown = [f"parts/{item['path']}" for item in record.pop("files") if item["kind"] == "png"]
    masses = tuple(mass_from(item) for item in record.pop("masses"))
    orders = {name: made_from(item) for name, item in record.pop("orders").items()}
    if record["drawn"]:
        _write_requests(design, folder / "parts")
    captions = [{"path": path, "caption": _caption(design, path)} for path in shown]
    return DrawnSolids({"pictures": captions, "solids": record}, masses, orders)


def _write_requests(design: LegDesign, folder: Path) -> None:
    """A dimensioned drawing of each spring to wind, as drawn in its joint, for a spring maker's quotation."""
    from synth.design.spring_hands import hands_of
    from synth.files.shown_units import METRIC
    from synth.spring.spring_files import write_request

    assert design.drawn is not None
    for option, joint in zip(design.springs.chosen, design.drawn.dimensions.joints, strict=True):
        if option.design is not None:
            path, travel = folder / f"{joint.name}_spring_quotation.dxf", joint_travel(option, joint)
            write_request(option.design, METRIC, path, travel, hands_of(option))


def joint_travel(option: SpringOption, joint: JointDimensions) -> JointTravel:
    """The travels of a joint's spring to wind, as it is seated."""
    from synth.spring.winding_sheet import JointTravel

    assert option.design is not None
    stops = [radians(joint.closing(angle)) for angle in joint.ends]
    return JointTravel(option.design.travel, option.design.opening_travel, stops[0], -stops[1])


def on_bed(design: LegDesign, bed: tuple[float, ...]) -> LegDesign:
    """The design to print on a bed of this size, m; the joints do not depend on it."""
    if design.drawn is None:
        return design
    dimensions = design.drawn.dimensions
    size = (bed[0] * 1e3, bed[1] * 1e3, bed[2] * 1e3)
    dimensions = replace(dimensions, printing=replace(dimensions.printing, bed=size))
    return replace(design, drawn=replace(design.drawn, dimensions=dimensions))


def not_weighed(design: LegDesign) -> LegDesign:
    """The design without drawing, with warnings on the masses that its links lack or may lack, first of all."""
    links = {joint.name: joint.link.includes for joint in design.project.target.joints}
    bare = [name for name, includes in links.items() if includes == "none"]
    whole = [name for name in links if name not in bare]
    texts = []
    if bare:
        texts.append(
            f"nothing is drawn, so the masses of the joints' parts are missing on the links of {', '.join(bare)}, "
            "whose figures do not include them (includes: none): the leg will be heavier than simulated, and spring "
            "rates go with the links' inertia"
        )
    if whole:
        texts.append(
            f"nothing is drawn, so the links of {', '.join(whole)} are taken as the target states them, with the "
            "joints' parts (includes: joint). Where the drawn parts weigh more than that, or leave the rest too little "
            "inertia, the links become heavier or gain inertia, and spring rates go with it"
        )
    found = tuple((None, decisive(text, NOT_FINAL)) for text in texts)
    return replace(design, warnings=(*found, *design.warnings))


def require_drawn(solids: dict[str, Any], project: Path, report: Path) -> None:
    """Raise CannotBeHad with every failed check if nothing was exported for that reason."""
    failed = [check for check in solids["checks"] if not check["passed"]]
    if not failed:
        return
    text = f"the joints are not exported, {len(failed)} of {len(solids['checks'])} checks failed; pictures in {report}"
    raise CannotBeHad([Problem(text, str(project), key="cad"), *(Problem(c["text"], key="cad") for c in failed)])


def _draw_solids(
    solids: Solids, folder: Path, known: tuple[Mapping[str, float], Mapping[str, Pieces]], *, pictures: bool
) -> tuple[dict[str, Any], bool]:
    """Build, check and write; the record, and whether it is complete (requested pictures were drawn).

    ``known``: weighed masses (kg) by part, and numbers of dampers and springs by joint.
    """
    from synth import cad
    from synth.design.solid_work import checked_leg, failures_of, written_leg

    leg = checked_leg(solids.dimensions, *known)
    notes, whole = [*solids.notes, *leg.notes, *_wobbly_sentence(leg.record["print"])], True
    files: list[ExportedFile] = []
    failures: dict[str, CheckResult] = {}
    try:
        if leg.passed:
            files, missing = written_leg(solids.dimensions, leg.built, folder / "parts", pictures=pictures)
            notes += missing
            whole = not missing
        elif pictures:
            failures = failures_of(solids.dimensions, leg.checks, folder / "checks")
    except cad.PreviewError as error:
        notes.append(str(error))
        whole = False
    shown = {check: f"checks/{name}" for name, check in failures.items()}
    record = {
        "drawn": leg.passed,
        "checks": [leg.check_json(check, shown.get(check)) for check in leg.checks],
        **leg.record,
        "notes": notes,
        "files": [{"path": item.path, "kind": item.kind} for item in files],
        "orders": leg.orders,
        "masses": leg.masses,
    }
    return record, whole


def _wobbly_sentence(plans: Sequence[Mapping[str, Any]]) -> list[str]:
    """A sentence on the parts that stand on very little of the bed."""
    found = [
        f"{plan['part']} on {plan['contact']['value']:.0f} mm^2 of {plan['size'][0]['value']:.0f} x "
        f"{plan['size'][1]['value']:.0f} mm"
        for plan in plans
        if plan["wobbly"]
    ]
    if not found:
        return []
    return [f"on the printer some parts stand on very little, print them with a brim or a raft: {', '.join(found)}"]


def with_settings(extra: dict[str, Any], design: LegDesign, settings: Mapping[str, SeatSetting]) -> dict[str, Any]:
    """``extra`` with the setting of each seat (zero, or for the measured spring) and how to measure the spring."""
    solids = dict(extra["solids"])
    joints = {name: dict(solids["joints"].get(name, {})) for name in design.built.joint_names}
    for name, setting in settings.items():
        joints[name]["seat"] = {**joints[name].get("seat", {}), "setting": setting.as_json()}
    notes = list(solids["notes"])
    for name, setting in settings.items():
        notes.append(f"{name}: turn the seat to {degrees(setting.turn):+.1f} deg on its scale for the measured spring")
    if solids["drawn"] and len(measured_free_angles(design)) < len(joints):
        notes.append(HOW_TO_MEASURE)
        far = [name for name in out_of_reach(design) if name not in measured_free_angles(design)]
        if far:
            notes.append(f"the free angle of {', '.join(far)} lies beyond a stop: there, {BY_TORQUES}; {WRITE_IT}")
    if joints and not settings and solids["drawn"]:
        notes += _how_to_test(design)
    return {**extra, "solids": {**solids, "joints": joints, "notes": notes}}


def _how_to_test(design: LegDesign) -> list[str]:
    """How to measure the springs' rates, and the rates to expect."""
    tests = [
        f"{name} {option.number * option.test.rate:.4g} N*m/rad at {option.test.distances[0] * 1e3:.4g} mm "
        f"({option.rate:.4g} in the joint)"
        for name, option in zip(design.built.joint_names, design.springs.chosen, strict=True)
        if option.test is not None
    ]
    if not tests:
        return []
    return [
        f"a rate can be measured too, {HOW_HELD}, at a distance from the coil. To expect of all springs of a joint "
        f"together: {', '.join(tests)}. Write it as measured: {{spring: {{JOINT: {{rate: 1 N*m/rad}}}}}}; it is "
        "converted into the rate in the joint, which clamps both arms. State another distance as rate_distance, and "
        "rate_held: joint for a rate that was measured in the joint"
    ]


HOW_TO_MEASURE = (
    "the tolerance of a spring's free angle, commonly 10 deg, is the largest of all. Assemble each joint with its seat "
    "at 0 and without the damper, lay it on its side so that no weight turns it, and read the joint's angle at which "
    "it comes to rest (the mean of both sides), not on a stop; the angle between the loose spring's arms is another. "
    "Write it as measured: {spring: {JOINT: {free_angle: 98 deg}}}; the report then "
    "gives the setting of the seat. + on the scale (the end with the pit) increases the free angle. The marks are "
    "5 deg apart on the ear and 4 deg apart on the seat plate: the scale is a vernier that reads to one degree"
)


def _caption(design: LegDesign, path: str) -> str:
    """Caption of a picture: the leg, a joint with its arm offset, or a part of a joint."""
    stem = Path(path).stem
    for index, name in enumerate(design.built.joint_names):
        named = name.replace(" ", "_")
        if stem == named or stem.startswith(f"{named}_"):
            part = stem.removeprefix(named).lstrip("_").replace("_", " ")
            if part == "exploded":
                return f"{name} joint, exploded view; the numbers are the assembly steps"
            offset = f"arm offset {degrees(design.arm_offset(index)):+.1f} deg"
            return (
                f"{name}, {part}" if part and part != "inside" else f"{name} joint{', cut open' * bool(part)}: {offset}"
            )
    return "the whole leg in its rest pose" if stem == "leg" else stem

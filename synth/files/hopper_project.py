"""The project file of ``synth hopper``: leg, motors, sweep and objectives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees, sin
from pathlib import Path
from typing import Literal

import numpy as np

from synth.errors import Problem
from synth.files.bending_pairs import read_bending
from synth.files.hopper_sections import (
    ContactSection,
    FlexureSection,
    HopperFile,
    LaminateSection,
    LegSection,
    LengthsSection,
    MotorSection,
    PartsSection,
    ToleranceSection,
)
from synth.files.named_files import InputFile, ProjectReader
from synth.files.paths import inside, shared
from synth.files.schema import Default
from synth.files.validate import gathering
from synth.files.yaml_lines import Document, Key
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg, HopperTolerances, Laminate, MotorOptions, in_reach

MOST_DESIGNS = 20_000_000  # of a sweep: at 8 000 designs a second and core, 20 minutes on two
SAME_END = 1e-9  # of a step: rounding of a range that the step divides
MEASURED_LINK = ("reference_length", "link_mass", "beam_rate", "bending")  # keys of a laminate's link as measured


@dataclass(frozen=True, eq=False)
class HopperProject:
    """The input of ``synth hopper``; see the sections.

    ``height`` : the height used for relative heights, and the default objective: the foot's
    clearance, or the total height, the rise of the centre of mass over the crouch.
    """

    path: Path
    name: str
    model: str
    leg: HopperLeg
    contact: Contact
    motor_options: MotorOptions
    motors: tuple[str, ...]
    gearbox: Literal["warn", "stop"]
    catalogs: tuple[Path, ...]
    lengths: tuple[float, ...]
    tolerances: HopperTolerances
    written_tolerances: frozenset[str]  # keys that the file gives; the maker's statements do not replace them
    objectives: tuple[str, ...]
    choose: str
    intervals: str
    parts: PartsSection
    defaults: tuple[Default, ...]
    inputs: tuple[InputFile, ...]
    problems_at: Document
    height: str = "clearance"


def read_hopper_project(path: str | Path) -> HopperProject:
    """Read a project of kind ``hopper-design``.

    Raises
    ------
    UserError
        With every mistake of the file; also if no length of the sweep allows the crouch.
    """
    reader = ProjectReader.open(path, "hopper-design")
    document, section = reader.document, reader.section
    file = section(HopperFile)
    leg, laminate = section(LegSection, "leg"), section(LaminateSection, "laminate")
    flexures, contact = section(FlexureSection, "flexures"), section(ContactSection, "contact")
    motors, lengths = section(MotorSection, "motors"), section(LengthsSection, "lengths")
    tolerance, parts = section(ToleranceSection, "tolerance"), section(PartsSection, "parts")
    catalogs = reader.matched(motors.catalogs, ("motors", "catalogs")) if motors is not None else ()
    swept = _lengths(reader, lengths) if lengths is not None else ()
    if laminate is not None and laminate.links == "strip":
        _refuse_measured_link(reader)
    elif laminate is not None:
        laminate = _measured_bending(reader, laminate)
    whole = _leg(leg, laminate, flexures, swept) if leg and laminate and flexures and swept else None
    if whole is not None:
        _check_pose(reader, whole, swept)
    reader.finish()
    assert file is not None
    assert whole is not None
    assert motors is not None
    assert parts is not None

    def meant(names: Sequence[str], key: str) -> list[str]:
        """The default objective of a file that uses total heights, told as such."""
        if file.height == "clearance" or key in reader.written:
            return list(names)
        used = ["total_height" if name == "clearance" else name for name in names]
        reader.defaults[:] = [
            d._replace(value=", ".join(used), reason="of height: total") if d.key == key else d for d in reader.defaults
        ]
        return used

    options = {name: getattr(motors, name) for name in
               ("supply", "rotor_inertia", "inductance", "resistance", "friction_share")}  # fmt: skip
    return HopperProject(
        path=document.path,
        name=file.name or reader.stem,
        model=file.model,
        leg=whole,
        contact=Contact(**vars(contact)),
        motor_options=MotorOptions(**options),
        motors=tuple(motors.use),
        gearbox=motors.gearbox,
        catalogs=catalogs,
        lengths=swept,
        tolerances=HopperTolerances(**vars(tolerance)),
        written_tolerances=frozenset(key for key in vars(tolerance) if ("tolerance", key) in document.lines),
        objectives=tuple(dict.fromkeys(meant(file.objectives, "objectives"))),
        choose=meant([file.choose], "choose")[0],
        intervals=file.intervals,
        parts=parts,
        defaults=tuple(reader.defaults),
        inputs=tuple(reader.inputs),
        problems_at=document,
        height=file.height,
    )


def design_named(reader: ProjectReader, key: str) -> HopperProject | None:
    """The hopper-design that another project names under ``key``; None after a reported mistake.

    It and the files that it names, its catalogues and its link's bending, are inputs of the other project.
    """
    name = reader.written.get(key)
    if not isinstance(name, str):
        return None  # reported by the file's own check
    with gathering(reader.problems, reader.document, (key,)):
        path = shared(reader.folder, name)
        reader.note(path)
        design = read_hopper_project(path)
        for item in design.inputs:
            reader.note(path.parent / item.name)
        return design
    return None


def refuse_links_that_do_not_meet(
    reader: ProjectReader, design: HopperProject | None, length: float, key: tuple[str | int, ...]
) -> None:
    """Refuse upper links so short that the lower links, in proportion, do not span the hips."""
    if design is None:
        return
    leg = design.leg.with_length(length)
    if leg.lower_length <= 0.5 * leg.hip_spacing:
        reader.refuse(
            f"with upper links of {length * 1e3:g} mm the lower links are {leg.lower_length * 1e3:g} mm long and do "
            f"not meet under hips {leg.hip_spacing * 1e3:g} mm apart",
            key,
        )


def _lengths(reader: ProjectReader, section: LengthsSection) -> tuple[float, ...]:
    if section.most < section.least:
        reader.refuse(f"most ({section.most * 1e3:g} mm) is below least ({section.least * 1e3:g} mm)", ("lengths",))
        return ()
    steps = (section.most - section.least) / section.step
    count = int(steps + SAME_END) + 1
    if count > MOST_DESIGNS:
        reader.refuse(f"asks for {count} lengths; at most {MOST_DESIGNS}: write a larger step", ("lengths", "step"))
        return ()
    even = [section.least + section.step * i for i in range(count)]
    # both ends are swept: the last step is shorter where the step does not divide the range
    ends = [section.most] if steps - (count - 1) > SAME_END else []
    return tuple(float(f"{length:.9g}") for length in (*even, *ends))


def _leg(leg: LegSection, laminate: LaminateSection, flexures: FlexureSection, swept: Sequence[float]) -> HopperLeg:
    values = vars(leg)
    made = Laminate(
        width=laminate.width, thickness=laminate.thickness, modulus=laminate.modulus, density=laminate.density,
        flexure_thickness=laminate.film_thickness, flexure_modulus=laminate.film_modulus,
    )  # fmt: skip
    if laminate.links == "strip":
        mass, stiffness = made.strip_mass_per_length, made.strip_bending_stiffness
    else:
        mass = laminate.link_mass / laminate.reference_length
        stiffness = laminate.beam_rate * laminate.reference_length / made.beam_rate(1.0) * made.bending_stiffness
    made = Laminate(mass, stiffness, made.width, made.thickness, made.modulus, made.density, made.flexure_thickness,
                    made.flexure_modulus)  # fmt: skip
    return HopperLeg(length=swept[-1], laminate=made, flexures=Flexures(**vars(flexures)), **values)


def _refuse_measured_link(reader: ProjectReader) -> None:
    """Refuse what is written of a measured link beside ``links: strip``, and tell no default of it: none is used."""
    for name in MEASURED_LINK:
        if ("laminate", name) in reader.document.lines:
            text = "belongs to a measured link, but links: strip uses the cross-section; keep one"
            reader.refuse(text, ("laminate", name))
    unused = {f"laminate.{name}" for name in MEASURED_LINK}
    reader.defaults[:] = [default for default in reader.defaults if default.key not in unused]


def _measured_bending(reader: ProjectReader, laminate: LaminateSection) -> LaminateSection:
    """The laminate with the bending rate from ``bending:``, a CSV of ``deflection [deg],torque [N*m]``."""
    if laminate.bending is None:
        return laminate
    key: Key = ("laminate", "bending")
    if ("laminate", "beam_rate") in reader.document.lines:
        reader.refuse('"beam_rate" and "bending" are both given; keep one', key)
        return laminate
    with gathering(reader.problems, reader.document, key):
        path = inside(reader.folder, laminate.bending)
        reader.note(path)
        found = read_bending(path, laminate.bending)
        low, high = found.interval90
        reader.defaults[:] = [default for default in reader.defaults if default.key != "laminate.beam_rate"]
        reason = f"measured: slope of {found.points} pairs in {laminate.bending}, 90 %: {low:.4g} to {high:.4g}"
        if found.loop:
            reason += f"; the link loses {found.loop:.3g} N*m between loading and unloading, which the jump leaves out"
        reader.defaults.append(Default("laminate.beam_rate", f"{found.rate:.4g} N*m/rad", reason))
        return replace(laminate, beam_rate=found.rate)
    return laminate


def _check_pose(reader: ProjectReader, leg: HopperLeg, swept: Sequence[float]) -> None:
    """Refuse a leg that no length allows to crouch, that crosses, or that is extended before it starts."""
    if leg.crouch_lower is not None:
        if ("leg", "crouch") in reader.document.lines:
            reader.refuse("crouch and crouch_lower are both given; keep one", ("leg", "crouch_lower"))
        reader.defaults[:] = [default for default in reader.defaults if default.key != "leg.crouch"]
    if leg.crouch_lower is None and leg.extended >= leg.crouch:
        text = f"{degrees(leg.extended):.1f} deg is not less than the crouch of {degrees(leg.crouch):.1f} deg"
        reader.refuse(f"{text}: the leg would be extended before it starts", ("leg", "extended"))
        return
    knee = 0.5 * leg.hip_spacing + max(swept) * sin(leg.extended)
    if knee <= 0.0:
        text = f"extended to {degrees(leg.extended):.1f} deg, upper links of {max(swept) * 1e3:g} mm cross"
        reader.refuse(f"{text}: their knees would be {2e3 * knee:.0f} mm apart", ("leg", "extended"))
        return
    if not in_reach(leg, np.array(swept)).any():
        found = leg.with_length(swept[-1]).problems()
        text = found[0] if found else "the lower links lie nearly level in the crouch, and lock"
        reader.refuse(f"no length of the sweep allows the crouch; at {swept[-1] * 1e3:g} mm {text}", ("leg", "crouch"))


def model_problem(project: HopperProject, text: str) -> Problem:
    """A mistake in the choice of the model, with its place in the file."""
    return project.problems_at.problem(text, ("model",))


def motor_problem(project: HopperProject, text: str) -> Problem:
    """A mistake in the choice of motors, with its place in the file."""
    return project.problems_at.problem(text, ("motors", "use"))

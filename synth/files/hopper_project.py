"""The project file of ``synth hopper``: leg, motors, sweep and objectives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import degrees, pi, radians, sin
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from synth.errors import Problem
from synth.files.bending_pairs import read_bending
from synth.files.named_files import InputFile, ProjectReader
from synth.files.paths import inside, shared
from synth.files.schema import Because, Default
from synth.files.validate import Quantity, Title, gathering
from synth.files.yaml_lines import Document, Key
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg, HopperTolerances, Laminate, MotorOptions, in_reach

LAB = "the lab's own simulation (idealabasu/code_pynamics)"
MOST_DESIGNS = 20_000_000  # of a sweep: at 8 000 designs a second and core, 20 minutes on two
MOST_INTERVALS = 20_000  # designs; above that only the front has intervals

Length = Annotated[float, Quantity("m", above=0, most=10)]
Angle = Annotated[float, Quantity("rad", least=0, most=pi)]
Share = Annotated[float, Quantity("1", least=0, most=1)]
Name = Literal["point_mass", "A", "B", "C", "D", "full"]
Objective = Literal["clearance", "relative_height", "total_height", "energy", "peak_gear_torque"]


@dataclass(frozen=True)
class LegSection:
    """Geometry, masses and pose; link length is what the sweep varies."""

    hip_spacing: Annotated[float, Quantity("m", least=0, most=10), Because(LAB)] = 0.03
    lower_ratio: Annotated[float, Quantity("1", above=0, most=10), Because(f"{LAB}: all four links alike")] = 1.0
    structure_mass: Annotated[
        float, Quantity("kg", least=0, most=100), Because("the lab's body of 36.9 g less two motors of 9.5 g")
    ] = 0.0179
    foot_mass: Annotated[float, Quantity("kg", least=0, most=100), Because("none in the lab's simulation")] = 0.0
    body_inertia: Annotated[
        float,
        Quantity("kg*m^2", above=0, most=100),
        Because("an estimate: 37 g on 40 mm; only the planar form uses it"),
    ] = 5e-6
    bending: Annotated[
        Literal["none", "upper", "all"], Because("upper links bend most; splitting all four changes 0.1 % of height")
    ] = "upper"
    crouch: Annotated[
        Angle, Because("upper link 0.89 rad below level, the start of the lab's simulation; not published")
    ] = pi / 2 - 0.89
    crouch_lower: Annotated[float | None, Quantity("rad", above=0, most=pi / 2)] = None
    extended: Annotated[
        float, Quantity("rad", least=-pi, most=pi), Because("an assumption: the leg's stop, before the leg is straight")
    ] = radians(10.0)
    stop_rate: Annotated[float, Quantity("N*m/rad", above=0, most=1e4), Because("an assumption: firm")] = 20.0
    stop_dissipation: Annotated[float, Quantity("s/rad", least=0, most=100), Because("an assumption")] = 0.5
    gravity: Annotated[float, Quantity("m/s^2", above=0, most=100), Because("standard")] = 9.81


@dataclass(frozen=True)
class LaminateSection:
    """Links and flexure film. ``links`` measured: from one link's mass and bending; strip: from the cross-section."""

    links: Annotated[
        Literal["measured", "strip"], Because("the lab's link is stiffer than a flat strip of its laminate would be")
    ] = "measured"
    reference_length: Annotated[Length, Because(f"{LAB}: the link whose mass and rate are known")] = 0.12
    link_mass: Annotated[float, Quantity("kg", above=0, most=100), Because(LAB)] = 0.003
    beam_rate: Annotated[float, Quantity("N*m/rad", above=0, most=1e6), Because(LAB)] = 14.0224
    bending: Annotated[str | None, Field(examples=["bending.csv"])] = None
    width: Annotated[Length, Because("the lab's laminates (idealabasu/curating-legs)")] = 0.015
    thickness: Annotated[Length, Because("the thickest of the lab's three laminates")] = 0.0017
    modulus: Annotated[float, Quantity("Pa", above=0, most=1e13), Because("the lab's laminates")] = 10.3e9
    density: Annotated[float, Quantity("kg/m^3", above=0, most=1e5), Because("the lab's laminates")] = 1820.0
    film_thickness: Annotated[Length, Because("the lab's polyester layer")] = 0.0001
    film_modulus: Annotated[float, Quantity("Pa", above=0, most=1e13), Because("polyester film, textbook value")] = (
        3.8e9
    )


@dataclass(frozen=True)
class FlexureSection:
    """The five flexure joints."""

    rate: Annotated[float, Quantity("N*m/rad", least=0, most=1e4), Because(LAB)] = 0.0229183
    damping: Annotated[float, Quantity("N*m*s/rad", least=0, most=1e3), Because(LAB)] = 0.00025
    hip_rest: Annotated[Angle, Because(f"{LAB}: upper links level")] = pi / 2
    knee_rest: Annotated[Angle, Because(f"{LAB}: knee straight")] = 0.0
    foot_rest: Annotated[Angle, Because(f"{LAB}: foot laid flat")] = pi


@dataclass(frozen=True)
class ContactSection:
    """The ground."""

    stiffness: Annotated[
        float, Quantity("N/m", least=300, most=1e7), Because("an assumption; a tenth of it changes the height by 6 %")
    ] = 1e4
    damping: Annotated[float, Quantity("N*s/m", least=0, most=1e3), Because(f"{LAB}; linear law only")] = 10.0
    dissipation: Annotated[
        float, Quantity("s/m", least=0, most=1e3), Because("an assumption: nearly no rebound; Hunt-Crossley only")
    ] = 5.0
    friction: Annotated[float, Quantity("1", least=0, most=10), Because("the lab's value; planar form only")] = 0.7
    slip_speed: Annotated[float, Quantity("m/s", above=0, most=1), Because("smooths friction; planar form only")] = 0.01


@dataclass(frozen=True)
class MotorSection:
    """Motors, and their common properties."""

    use: Annotated[
        list[str], Field(min_length=1, examples=['["N20 HP *"]']), Because("all of the catalogue", "all")
    ] = field(default_factory=lambda: ["*"])
    catalogs: Annotated[list[str], Because("the built-in catalogue only", "none")] = field(default_factory=list)
    supply: Annotated[float | None, Quantity("V", above=0, most=1000), Because("each motor's own", "rated voltage")] = (
        None
    )
    rotor_inertia: Annotated[
        float | None, Quantity("kg*m^2", above=0, most=1),
        Because("not published: 1.5e-8 kg*m^2 for 9.5 g, others by similarity", "estimated"),
    ] = None  # fmt: skip
    inductance: Annotated[
        float | None, Quantity("H", above=0, most=10), Because("not published: R times 0.25 ms", "estimated")
    ] = None
    resistance: Annotated[
        float | None, Quantity("ohm", above=0, most=1e5), Because("voltage over stall current", "derived")
    ] = None
    friction_share: Annotated[Share, Because("of the no-load torque; one point does not determine more")] = 1.0
    gearbox: Annotated[Literal["warn", "stop"], Because("the study's own 210:1 is beyond its gearbox's limit")] = "warn"


@dataclass(frozen=True)
class LengthsSection:
    """Upper links' lengths, both ends included."""

    least: Annotated[Length, Because("shorter ones lock in the default crouch")] = 0.05
    most: Annotated[Length, Because("beyond any optimum found here")] = 0.2
    step: Annotated[float, Quantity("m", above=0, most=1), Because("finer steps make no practical difference")] = 0.005


@dataclass(frozen=True)
class ToleranceSection:
    """90 % half widths, as shares of the value; ``crouch`` as an angle."""

    speed: Annotated[Share, Because("where the maker states none; micro metal motors: 20 %")] = 0.2
    current: Annotated[Share, Because("where the maker states none; micro metal motors: 50 %")] = 0.5
    torque: Annotated[Share, Because("an assumption: stall torque is extrapolated by the maker")] = 0.1
    rotor_inertia: Annotated[Share, Because("an estimate's own uncertainty")] = 0.5
    mass: Annotated[Share, Because("an assumption, of the body")] = 0.05
    joint_damping: Annotated[Share, Because("measured on other joints")] = 0.5
    crouch: Annotated[float, Quantity("rad", least=0, most=0.5), Because("an assumption: 2 deg")] = radians(2.0)


@dataclass(frozen=True)
class _HopperFile:
    kind: str
    name: Title | None = None
    model: Annotated[Name, Because("the complete model")] = "full"
    leg: Any = None
    laminate: Any = None
    flexures: Any = None
    contact: Any = None
    motors: Any = None
    lengths: Any = None
    tolerance: Any = None
    objectives: Annotated[
        list[Objective], Field(min_length=1, max_length=5), Because("the study's two", "clearance, relative_height")
    ] = field(default_factory=lambda: ["clearance", "relative_height"])
    choose: Annotated[Objective, Because("the study's first aim")] = "clearance"
    height: Annotated[Literal["clearance", "total"], Because("the foot above the ground, as the study measured it")] = (
        "clearance"
    )
    intervals: Annotated[
        Literal["auto", "all", "front"], Because(f"all designs up to {MOST_INTERVALS}, beyond them the front only")
    ] = "auto"
    parts: Any = None


@dataclass(frozen=True)
class PartsSection:
    """The flat layers to cut."""

    adhesive: Annotated[Length, Because("the lab's adhesive layer")] = 0.000015
    adhesive_gap: Annotated[Length, Because("clearance between rigid layers and the fold")] = 0.0002
    motor_shaft: Annotated[Length, Because("micro metal motors")] = 0.003
    sheet: Annotated[float, Quantity("m", above=0, most=10), Because("a common laser bed")] = 0.3
    kerf: Annotated[
        float, Quantity("m", least=0, most=0.002), Because("of a CO2 laser in thin sheet; measure a cut slot")
    ] = 0.0001
    film_strain: Annotated[
        float, Quantity("1", above=0, most=1), Because("polyester yields about there (Mylar F-5, H-37232-3)")
    ] = 0.05


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
    file = section(_HopperFile)
    leg, laminate = section(LegSection, "leg"), section(LaminateSection, "laminate")
    flexures, contact = section(FlexureSection, "flexures"), section(ContactSection, "contact")
    motors, lengths = section(MotorSection, "motors"), section(LengthsSection, "lengths")
    tolerance, parts = section(ToleranceSection, "tolerance"), section(PartsSection, "parts")
    catalogs = reader.matched(motors.catalogs, ("motors", "catalogs")) if motors is not None else ()
    swept = _lengths(reader, lengths) if lengths is not None else ()
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
        """The default objective of a file that uses total heights."""
        if file.height == "clearance" or key in reader.written:
            return list(names)
        return ["total_height" if name == "clearance" else name for name in names]

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
    """The hopper-design that another project names under ``key``; None after a reported mistake."""
    name = reader.written.get(key)
    if not isinstance(name, str):
        return None  # reported by the file's own check
    with gathering(reader.problems, reader.document, (key,)):
        path = shared(reader.folder, name)
        reader.note(path)
        return read_hopper_project(path)
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
    count = int((section.most - section.least) / section.step + 1e-9) + 1
    if count > MOST_DESIGNS:
        reader.refuse(f"asks for {count} lengths; at most {MOST_DESIGNS}: write a larger step", ("lengths", "step"))
        return ()
    return tuple(float(f"{section.least + section.step * i:.9g}") for i in range(count))


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


def _measured_bending(reader: ProjectReader, laminate: LaminateSection | None) -> LaminateSection | None:
    """The laminate with the bending rate from ``bending:``, a CSV of ``deflection [deg],torque [N*m]``."""
    if laminate is None or laminate.bending is None:
        return laminate
    key: Key = ("laminate", "bending")
    if ("laminate", "beam_rate") in reader.document.lines:
        reader.refuse('"beam_rate" and "bending" are both given; keep one', key)
        return laminate
    if laminate.links == "strip":
        reader.refuse("belongs to a measured link, but links: strip uses the cross-section; keep one", key)
        return laminate
    with gathering(reader.problems, reader.document, key):
        path = inside(reader.folder, laminate.bending)
        reader.note(path)
        found = read_bending(path, laminate.bending)
        low, high = found.interval90
        reader.defaults[:] = [default for default in reader.defaults if default.key != "laminate.beam_rate"]
        reason = f"measured: slope of {found.points} pairs in {laminate.bending}, 90 %: {low:.4g} to {high:.4g}"
        reader.defaults.append(Default("laminate.beam_rate", f"{found.rate:.4g} N*m/rad", reason))
        return replace(laminate, beam_rate=found.rate)
    return laminate


def _check_pose(reader: ProjectReader, leg: HopperLeg, swept: Sequence[float]) -> None:
    """Refuse a leg that no length allows to crouch, that crosses, or that is extended before it starts."""
    if leg.crouch_lower is not None and ("leg", "crouch") in reader.document.lines:
        reader.refuse("crouch and crouch_lower are both given; keep one", ("leg", "crouch_lower"))
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

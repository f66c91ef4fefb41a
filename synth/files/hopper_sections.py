"""The sections of a hopper-design: keys, limits and reasons of the defaults."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi, radians
from typing import Annotated, Any, Literal

from pydantic import Field

from synth.files.project_options import WIDEST
from synth.files.schema import Because
from synth.files.validate import BARE_DEVIATION, Quantity, Title

LAB = "the lab's own simulation (idealabasu/code_pynamics)"
MOST_INTERVALS = 20_000  # designs; above that only the front has intervals

Length = Annotated[float, Quantity("m", above=0, most=10)]
Angle = Annotated[float, Quantity("rad", least=0, most=pi)]
Share = Annotated[float, Quantity("1", least=0, most=1)]
# With 100 % a motor had no torque at its end.
PlusMinusOrNone = Annotated[float, Quantity("1", least=0, most=WIDEST, bare=BARE_DEVIATION)]
Estimated = Annotated[float, Quantity("1", least=0, most=1, bare=BARE_DEVIATION)]
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
    """Upper links' lengths, both ends included; the last step is shorter where ``step`` does not divide the range."""

    least: Annotated[Length, Because("shorter ones lock in the default crouch")] = 0.05
    most: Annotated[Length, Because("beyond any optimum found here")] = 0.2
    step: Annotated[float, Quantity("m", above=0, most=1), Because("finer steps make no practical difference")] = 0.005


@dataclass(frozen=True)
class ToleranceSection:
    """90 % half widths, as shares of the value; ``crouch`` as an angle."""

    speed: Annotated[PlusMinusOrNone, Because("where the maker states none; micro metal motors: 20 %")] = 0.2
    current: Annotated[PlusMinusOrNone, Because("where the maker states none; micro metal motors: 50 %")] = 0.5
    torque: Annotated[PlusMinusOrNone, Because("an assumption: stall torque is extrapolated by the maker")] = 0.1
    rotor_inertia: Annotated[Estimated, Because("an estimate's own uncertainty")] = 0.5
    mass: Annotated[PlusMinusOrNone, Because("an assumption, of the body")] = 0.05
    joint_damping: Annotated[Estimated, Because("measured on other joints")] = 0.5
    crouch: Annotated[float, Quantity("rad", least=0, most=0.5), Because("an assumption: 2 deg")] = radians(2.0)


@dataclass(frozen=True)
class HopperFile:
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
    motor_shaft: Annotated[Length, Because("micro metal motors; where the catalogue states no shaft")] = 0.003
    sheet: Annotated[float, Quantity("m", above=0, most=10), Because("a common laser bed")] = 0.3
    kerf: Annotated[
        float, Quantity("m", least=0, most=0.002), Because("of a CO2 laser in thin sheet; measure a cut slot")
    ] = 0.0001
    film_strain: Annotated[
        float, Quantity("1", above=0, most=1), Because("polyester yields about there (Mylar F-5, H-37232-3)")
    ] = 0.05

"""The options of projects: how to fit, what to choose from, how to build. SI and radians inside."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from synth.files.fit_words import Cost, Intervals, Method, Weight
from synth.files.schema import Because
from synth.files.validate import Quantity, Title

Length = Annotated[float, Quantity("m", above=0)]
Pressure = Annotated[float, Quantity("Pa", above=0)]
Density = Annotated[float, Quantity("kg/m^3", above=0)]
Share = Annotated[float, Quantity("1", above=0, most=10)]
Turn = Annotated[float, Quantity("rad", above=0, most=radians(3600))]
Ratio = Annotated[float, Quantity("1", least=0.1, most=20)]
Count = Annotated[int, Field(ge=1, le=4)]

Release = Literal["free", "recorded"]


@dataclass(frozen=True)
class FitOptions:
    """How springs and dampers are found.

    Parameters
    ----------
    method
        ``least_squares``: weak form, then Levenberg-Marquardt; ``piecewise``: simplex, joint after joint; ``swarm``.
    cost
        ``trajectory``: angle errors; ``transient``: the same with the first swing weighted; ``characteristics``: rise
        time, damping ratio and the like.
    weight
        what errors are divided by: each joint's ``noise``; that times the joint's ``amplitude`` in the trial over its
        mean; or one number for all joints (``equal``).
    seed
        of everything random.
    intervals
        ``sensitivities``: from the Jacobian at the answer; ``bootstrap``: 200 refits to blocks of residuals put back in
        another order, which shows a skewed interval as such.
    """

    method: Annotated[Method, Because("the one that finds the answer without a starting guess")] = "least_squares"
    cost: Annotated[Cost, Because("uses every sample")] = "trajectory"
    weight: Annotated[Weight, Because("each joint's errors count by how large they are: maximum likelihood")] = "noise"
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0
    intervals: Annotated[Intervals, Because("at no cost; where the trials fix all, both agree")] = "sensitivities"


@dataclass(frozen=True)
class RatePrior:
    """How far the leg file's own values may be trusted, one standard deviation; None: not at all.

    ``spring`` and ``damper`` are shares of the rate given in the leg file, ``free_angle`` is in rad.
    """

    spring: Share | None = None
    damper: Share | None = None
    free_angle: Turn | None = None


@dataclass(frozen=True)
class SpringChoice:
    """What a joint's spring must meet; None: no limit. A ``part`` is taken whatever its numbers.

    ``make`` True: a spring to wind; False: a bought one or none; None: a bought one where one fits. ``objective``,
    ``cycles`` (turns through the whole travel that it must last; without it 100 000 where that can be had) and
    ``rate_formula`` are for one to wind.
    """

    make: Annotated[
        bool | None, Because("a bought spring where one meets the constraints, else one to wind", "as it comes")
    ] = None
    wire: str | None = None
    part: Title | None = None
    rate_tolerance: Annotated[Share, Because("vendors keep a torsion spring's rate within about 10 %")] = 0.1
    included_angle: Annotated[Turn | None, Because("the joint's arm offset takes up any angle", "any")] = None
    travel: Annotated[Turn | None, Because("from the joint's range, else from the wanted motion", "as it moves")] = None
    min_outer_diameter: Length | None = None
    max_outer_diameter: Annotated[Length | None, Because("none was asked for", "no limit")] = None
    min_inner_diameter: Length | None = None
    min_body_length: Length | None = None
    max_body_length: Annotated[Length | None, Because("none was asked for", "no limit")] = None
    min_wire_diameter: Length | None = None
    max_wire_diameter: Length | None = None
    objective: Annotated[Literal["mass", "space", "life"], Because("of springs to wind that hold, the lightest")] = (
        "mass"
    )
    cycles: Annotated[float | None, Quantity("1", least=1, most=1e6)] = None
    rate_formula: Annotated[
        Literal["64", "10.8"],
        BeforeValidator(str),
        Because("bending alone, E d^4/(64 D N); 10.8 a turn reckons with friction between the coils"),
    ] = "64"
    parallel: Annotated[Count, Because("one spring takes the least room")] = 1


@dataclass(frozen=True)
class DamperChoice:
    """What a joint's damper must meet; None: no limit. A ``part`` is taken whatever its numbers.

    ``parallel``: up to so many equal dampers side by side; two let one-way dampers serve as a pair, one each way.
    ``ratios``: turns of the damper for one of the joint, by gears or a belt, that may be used.
    """

    direction: Annotated[Literal["both", "one"], Because("a free swing goes both ways")] = "both"
    travel: Annotated[Turn | None, Because("from the joint's range, else from the wanted motion", "as it moves")] = None
    part: Title | None = None
    max_outer_diameter: Annotated[Length | None, Because("none was asked for", "no limit")] = None
    max_body_length: Length | None = None
    parallel: Annotated[Count, Because("room for one damper is drawn")] = 1
    ratios: Annotated[
        tuple[Ratio, ...],
        Field(strict=False, min_length=1, max_length=20, examples=["[1, 2, 3]"]),
        Because("the damper sits on the joint's own axis"),
    ] = (1.0,)


@dataclass(frozen=True)
class JointChoice:
    """Spring and damper of one joint."""

    spring: SpringChoice = field(default_factory=SpringChoice)
    damper: DamperChoice = field(default_factory=DamperChoice)


@dataclass(frozen=True)
class ToleranceOptions:
    """Assumed tolerances of bought and wound parts; None: those of the catalogue row, else the usual ones.

    ``rate`` and ``torque`` are shares (plus or minus), ``free_angle`` rad. ``measured``: torque of a damper whose
    curve was measured. ``temperature`` K above or below the one at which a damper's torque is stated.
    """

    rate: Share | None = None
    free_angle: Turn | None = None
    torque: Share | None = None
    measured: Annotated[Share, Because("what drops with the damper alone leave open")] = 0.05
    temperature: Annotated[float, Quantity("K", least=0, most=100), Because("a room, winter and summer")] = 5.0


@dataclass(frozen=True)
class PartsOptions:
    """Which parts may be chosen for any joint, and what is asked of the whole leg's response.

    Parameters
    ----------
    vendors
        None: any. Measured dampers and springs to wind are ours to make and always allowed.
    without
        parts that cannot be had.
    system
        ``inch`` or ``metric`` parts only; None: both.
    within
        rad, largest RMS departure from the wanted motion that is still as wished.
    """

    vendors: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    system: Literal["inch", "metric"] | None = None
    within: float = radians(3.0)
    tolerance: ToleranceOptions = field(default_factory=ToleranceOptions)


Rate = Annotated[float, Quantity("N*m/rad", above=0)]
Angle = Annotated[float, Quantity("rad", least=radians(-360), most=radians(360))]


@dataclass(frozen=True)
class MeasuredSpring:
    """What was measured of the spring in hand; None: not measured.

    ``free_angle``: measured angle at which the assembled joint comes to rest by this spring alone, its seat at the zero
    of its scale (link level or joint on its side, so that no weight turns it; damper off). ``rate``: of all springs of
    the joint together.
    """

    free_angle: Angle | None = None
    rate: Rate | None = None


@dataclass(frozen=True)
class DamperShape:
    """What a joint's damper is like, measured on the one bought; lengths in m, None: as the catalogue says.

    ``shaft_side``: ``shaft`` where the damper has one of its own, ``bore`` where it takes the joint's. ``shaft_size``:
    its diameter, or the width across the flats.
    """

    outer_diameter: Length | None = None
    body_length: Length | None = None
    bolt_circle: Length | None = None
    bolts: Annotated[int, Field(ge=2, le=12)] | None = None
    bolt_diameter: Length | None = None
    shaft_side: Literal["shaft", "bore"] | None = None
    shaft_form: Literal["round", "d", "square", "hex"] | None = None
    shaft_size: Length | None = None


@dataclass(frozen=True)
class CadOptions:
    """How the joints are built; lengths in m."""

    shaft_diameter: Annotated[Length, Because("a common steel shaft")] = 0.008
    clearance: Annotated[Length, Because("between moving parts printed by filament")] = 0.0004
    wall: Annotated[Length, Because("seven lines of print; plates and pins grow where a load asks")] = 0.003
    bed: Annotated[
        tuple[Length, ...],
        Field(strict=False, min_length=3, max_length=3, examples=["[320 mm, 132 mm, 154 mm]"]),
        Because("Markforged Mark Two; a part that does not fit is not exported"),
    ] = (0.32, 0.132, 0.154)
    print_strength: Annotated[Pressure, Because("tensile yield of Markforged Onyx, from its data sheet")] = 36e6
    print_density: Annotated[Density, Because("Markforged Onyx")] = 1200.0
    between_layers: Annotated[Share, Because("our assumption; no data sheet gives it. Measure yours")] = 0.5
    safety: Annotated[Share, Because("of stress against strength, where loads are known")] = 1.5
    encoder: Annotated[bool, Because("a seat for an angle sensor of 22 mm over each shaft's end, where it fits")] = True
    mount: Annotated[bool, Because("the first joint hangs from the body by a flange, not by a tube")] = True
    damper_shafts: Annotated[
        dict[str, Length],
        Field(examples=["{hip: 8 mm}"]),
        Because("each damper takes the joint's shaft; one with a shaft of its own gets an adapter", "none"),
    ] = field(default_factory=dict)
    dampers: Annotated[
        dict[str, Any],
        Field(examples=["{hip: {outer_diameter: 42 mm, shaft_side: bore, shaft_form: square, shaft_size: 6 mm}}"]),
        Because("dampers are drawn as the catalogue has them, and by assumption where it does not say", "none"),
    ] = field(default_factory=dict)
    masses: Annotated[
        dict[str, Annotated[float, Quantity("kg", above=0)]],
        Field(examples=["{hip_damper: 62 g}"]),
        Because("of weighed parts; else by solid and density, of bought dampers and encoders assumed", "none"),
    ] = field(default_factory=dict)

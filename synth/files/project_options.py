"""The options of projects: fit, part choice, construction. SI and radians."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from synth.files.fit_words import Cost, Intervals, Method, Weight
from synth.files.schema import Because
from synth.files.spring_words import Objective, RateFormula, System
from synth.files.validate import BARE_DEVIATION, Quantity, Title, refusal

Length = Annotated[float, Quantity("m", above=0)]
Share = Annotated[float, Quantity("1", above=0, most=10, bare=1)]
WIDEST = 0.9  # of a tolerance, plus or minus: from 1 on, rates and torques of zero and below would be drawn
PlusMinus = Annotated[float, Quantity("1", above=0, most=WIDEST, bare=BARE_DEVIATION)]
Travel = Annotated[float, Quantity("rad", above=0, most=radians(720))]  # of a joint, whose angle lies within two turns
Included = Annotated[float, Quantity("rad", above=0, most=radians(360))]  # between two legs
Deviation = Annotated[float, Quantity("rad", above=0, most=radians(180))]  # of an angle: a larger one says nothing
Ratio = Annotated[float, Quantity("1", least=0.1, most=20)]
# Rods for which bearings, collars and thrust washers are listed (cad.shaft_sizes): the joints' shafts are one of these.
SHAFTS = (0.003, 0.004, 0.005, 0.006, 0.008, 0.01, 0.012, 0.015, 0.02)
Shaft = Annotated[float, Quantity("m", sizes=SHAFTS)]
# What a joint is drawn with; the limits and their reasons are those of cad.dimensions and cad.fittings.
Clearance = Annotated[float, Quantity("m", least=1e-4, most=2e-3)]
Wall = Annotated[float, Quantity("m", least=1.2e-3, most=12e-3)]
TubeDiameter = Annotated[float, Quantity("m", least=6e-3, most=80e-3)]
TubeWall = Annotated[float, Quantity("m", least=5e-4, most=10e-3)]
BedSide = Annotated[float, Quantity("m", least=0.01, most=2.0)]
PrintStrength = Annotated[float, Quantity("Pa", least=1e6, most=500e6)]
PrintDensity = Annotated[float, Quantity("kg/m^3", least=300, most=9000)]
Count = Annotated[int, Field(ge=1, le=4)]

ONE_WAY = (
    "one cannot be designed for: the leg is simulated with dampers that act both ways, so the motion would be wrong "
    "for half of each swing. Write direction: both; parallel: 2 allows two one-way dampers as a pair, one per direction"
)


def _both_ways(value: object) -> object:
    """Refuse a damper that acts one way, with what to write instead."""
    if value == "one":
        raise refusal(ONE_WAY)
    return value


@dataclass(frozen=True)
class FitOptions:
    """How springs and dampers are estimated.

    Parameters
    ----------
    method
        ``least_squares``: weak form, then Levenberg-Marquardt; ``piecewise``: simplex, joint after joint; ``swarm``.
    cost
        ``trajectory``: angle errors; ``transient``: the same with the first swing weighted; ``characteristics``: rise
        time, damping ratio and the like.
    weight
        divisor of the residuals: each joint's ``noise``; that times the joint's ``amplitude`` in the trial over its
        mean; or one number for all joints (``equal``).
    seed
        of everything random.
    intervals
        ``sensitivities``: from the Jacobian at the optimum; ``bootstrap``: 200 refits to resampled residuals,
        which also shows skewed intervals.
    """

    method: Annotated[Method, Because("needs no starting guess")] = "least_squares"
    cost: Annotated[Cost, Because("uses every sample")] = "trajectory"
    weight: Annotated[Weight, Because("one noise a joint: maximum likelihood if trials are alike in it")] = "noise"
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0
    intervals: Annotated[Intervals, Because("no extra cost; agrees with the bootstrap in white noise")] = (
        "sensitivities"
    )


@dataclass(frozen=True)
class RatePrior:
    """Prior standard deviations of the leg file's own values; None: no prior.

    ``spring`` and ``damper`` are shares of the rate given in the leg file, ``free_angle`` is in rad.
    """

    spring: Share | None = None
    damper: Share | None = None
    free_angle: Annotated[Deviation | None, Field(examples=["5 deg"])] = None


@dataclass(frozen=True)
class SpringBounds:
    """Requirements that every spring of a joint must meet, bought or to wind; None: no limit.

    ``rate_tolerance`` and ``parallel`` apply to bought springs: one to wind has the wanted rate. A limit on
    a length applies to ``parallel`` springs side by side together.
    """

    rate_tolerance: Annotated[Share, Because("vendors keep a torsion spring's rate within about 10 %")] = 0.1
    included_angle: Annotated[Included | None, Because("the joint's arm offset compensates any angle", "any")] = None
    travel: Annotated[Travel | None, Because("from the joint's range, else from the wanted motion", "as it moves")] = (
        None
    )
    min_outer_diameter: Length | None = None
    max_outer_diameter: Annotated[Length | None, Because("none is given", "no limit")] = None
    min_inner_diameter: Length | None = None
    min_body_length: Length | None = None
    max_body_length: Annotated[Length | None, Because("none is given", "no limit")] = None
    min_wire_diameter: Length | None = None
    max_wire_diameter: Length | None = None
    parallel: Annotated[Count, Because("one spring takes the least room")] = 1


@dataclass(frozen=True)
class SpringChoice(SpringBounds):
    """Requirements of a joint's spring in a leg design. A ``part`` is used ``parallel`` times, whatever its values.

    ``make`` True: a spring to wind; False: a bought one or none; None: a bought one if one fits. ``cycles``: full turns
    that it must last; None: any, of springs to wind 100 000 if possible. ``objective`` and ``rate_formula`` apply to a
    spring to wind.
    """

    make: Annotated[
        bool | None, Because("a bought spring where one meets the constraints, else one to wind", "as it comes")
    ] = None
    wire: str | None = None
    part: Title | None = None
    objective: Annotated[Objective, Because("the smallest of those nearly as light as the lightest")] = "mass"
    cycles: Annotated[float | None, Quantity("1", least=1, most=1e6)] = None
    rate_formula: Annotated[
        RateFormula,
        BeforeValidator(str),
        Because("bending only, E d^4/(64 D N); 10.8 per turn includes friction between the coils"),
    ] = "64"


@dataclass(frozen=True)
class DamperBounds:
    """Requirements that every damper of a joint must meet; None: no limit.

    ``direction`` ``one`` allows single one-way dampers. ``parallel``: largest number of equal dampers; two allow
    one-way dampers as a pair, one per direction. ``ratios``: allowed turns of the damper per turn of the joint, by
    gears or a belt.
    """

    direction: Annotated[Literal["both", "one"], Because("a free swing goes both ways")] = "both"
    travel: Annotated[Travel | None, Because("from the joint's range, else from the wanted motion", "as it moves")] = (
        None
    )
    max_outer_diameter: Annotated[Length | None, Because("none is given", "no limit")] = None
    max_body_length: Annotated[Length | None, Because("none is given", "no limit")] = None
    parallel: Annotated[Count, Because("room for one damper is drawn")] = 1
    ratios: Annotated[
        tuple[Ratio, ...],
        Field(strict=False, min_length=1, max_length=20, examples=["[1, 2, 3]"]),
        Because("the damper sits on the joint's own axis"),
    ] = (1.0,)


@dataclass(frozen=True)
class DamperChoice(DamperBounds):
    """Requirements of a joint's damper in a leg design. A ``part`` is used ``parallel`` times, whatever its sizes.

    ``direction``: the simulated dampers act both ways, so only ``both`` can be designed for.
    """

    direction: Annotated[Literal["both"], BeforeValidator(_both_ways), Because("a free swing goes both ways")] = "both"
    part: Title | None = None


@dataclass(frozen=True)
class JointChoice:
    """Spring and damper of one joint."""

    spring: SpringChoice = field(default_factory=SpringChoice)
    damper: DamperChoice = field(default_factory=DamperChoice)


@dataclass(frozen=True)
class ToleranceOptions:
    """Assumed tolerances of bought and wound parts; None: those of the catalogue row, else usual values.

    ``rate`` and ``torque`` are shares (plus or minus), ``free_angle`` rad. ``measured``: torque of a damper whose
    curve was measured. ``temperature`` K of deviation from the one at which a damper's torque is stated.
    """

    rate: PlusMinus | None = None
    free_angle: Annotated[Deviation | None, Field(examples=["5 deg"])] = None
    torque: PlusMinus | None = None
    measured: Annotated[PlusMinus, Because("remaining uncertainty after drops with only the damper")] = 0.05
    temperature: Annotated[float, Quantity("K", least=0, most=100), Because("a room, winter and summer")] = 5.0


@dataclass(frozen=True)
class PartsOptions:
    """Restrictions of the parts of all joints, and of the whole leg's response.

    Parameters
    ----------
    vendors
        None: any. Measured dampers and springs to wind are always allowed.
    without
        unavailable parts.
    system
        ``inch`` or ``metric`` parts only; None: both.
    within
        rad, largest acceptable RMS departure from the wanted motion.
    """

    vendors: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    system: System | None = None
    within: float = radians(3.0)
    tolerance: ToleranceOptions = field(default_factory=ToleranceOptions)


Rate = Annotated[float, Quantity("N*m/rad", above=0)]
Angle = Annotated[float, Quantity("rad", least=radians(-360), most=radians(360))]


@dataclass(frozen=True)
class MeasuredSpring:
    """Measurements of the available spring; None: not measured.

    ``free_angle``: measured angle at which the assembled joint rests under this spring alone, its seat at zero on
    its scale (link or joint level, so that no weight acts; damper removed). ``free_angle_by``: whether it was read
    there (``rest``), or found from torques (``torque``), as where a stop keeps the joint from resting free. ``rate``:
    of all springs of the joint together. ``rate_held``: how they were held for it: ``loose``, on an arbor with a pin
    pressing square on each arm ``rate_distance`` m from the coil (None: at the distance that the design states), or in
    the ``joint``, which clamps both arms.
    """

    free_angle: Angle | None = None
    free_angle_by: Literal["rest", "torque"] = "rest"
    rate: Rate | None = None
    rate_held: Literal["loose", "joint"] = "loose"
    rate_distance: Annotated[float | None, Quantity("m", least=0, most=1), Field(examples=["25 mm"])] = None


@dataclass(frozen=True)
class DamperShape:
    """Measured dimensions of a joint's damper, in m; None: as in the catalogue.

    ``shaft_side``: ``shaft`` if the damper has its own, ``bore`` if it fits on the joint's. ``shaft_size``:
    its diameter, or the width across flats. ``hub``: what holds the joint's shaft in a round bore; ``none`` or not
    given: nothing, and the shaft would slip.
    """

    outer_diameter: Length | None = None
    body_length: Length | None = None
    bolt_circle: Length | None = None
    bolts: Annotated[int, Field(ge=2, le=12)] | None = None
    bolt_diameter: Length | None = None
    shaft_side: Literal["shaft", "bore"] | None = None
    shaft_form: Literal["round", "d", "square", "hex"] | None = None
    shaft_size: Length | None = None
    hub: Literal["none", "set_screw", "clamp"] | None = None


@dataclass(frozen=True)
class CadOptions:
    """How the joints are built; lengths in m."""

    shaft_diameter: Annotated[Shaft, Because("a common steel shaft")] = 0.008
    clearance: Annotated[Clearance, Because("between moving parts printed by filament")] = 0.0004
    wall: Annotated[Wall, Because("seven lines of print; plates and pins grow where a load asks")] = 0.003
    link_width: Annotated[TubeDiameter, Because("common aluminium tube; a stronger one where a load asks")] = 0.02
    tube_wall: Annotated[TubeWall, Because("common aluminium tube; a stronger one where a load asks")] = 0.0015
    bed: Annotated[
        tuple[BedSide, ...],
        Field(strict=False, min_length=3, max_length=3, examples=["[320 mm, 132 mm, 154 mm]"]),
        Because("Markforged Mark Two; a part that does not fit is not exported"),
    ] = (0.32, 0.132, 0.154)
    print_strength: Annotated[PrintStrength, Because("tensile yield of Markforged Onyx, from its data sheet")] = 36e6
    print_density: Annotated[PrintDensity, Because("Markforged Onyx")] = 1200.0
    between_layers: Annotated[
        float,
        Quantity("1", least=0.05, most=1),
        Because("our assumption; no data sheet gives it. Measure yours"),
    ] = 0.5
    safety: Annotated[
        float, Quantity("1", least=1, most=10), Because("of stress against strength, where loads are known")
    ] = 1.5
    encoder: Annotated[bool, Because("a seat for an angle sensor of 22 mm over each shaft's end, where it fits")] = True
    mount: Annotated[bool, Because("the first joint hangs from the body by a flange, not by a tube")] = True
    damper_shafts: Annotated[
        dict[str, Length],
        Field(examples=["{hip: 8 mm}"]),
        Because("each damper fits on the joint's shaft; one with its own shaft gets an adapter", "none"),
    ] = field(default_factory=dict)
    dampers: Annotated[
        dict[str, Any],
        Field(examples=["{hip: {outer_diameter: 42 mm, shaft_side: bore, shaft_form: square, shaft_size: 6 mm}}"]),
        Because("dampers are drawn from the catalogue, with assumed values where it has none", "none"),
    ] = field(default_factory=dict)
    masses: Annotated[
        dict[str, Annotated[float, Quantity("kg", above=0)]],
        Field(examples=["{hip_damper: 62 g}"]),
        Because("of weighed parts; else by solid and density, of bought dampers and encoders assumed", "none"),
    ] = field(default_factory=dict)

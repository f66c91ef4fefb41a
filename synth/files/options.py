"""The options of projects: how to fit, what to choose from, how to build. SI and radians inside."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians
from typing import Annotated, Literal

from pydantic import Field

from synth.files.schema import Because
from synth.files.validate import Quantity

Length = Annotated[float, Quantity("m", above=0)]
Share = Annotated[float, Quantity("1", above=0, most=10)]
Turn = Annotated[float, Quantity("rad", above=0, most=radians(3600))]

FreeAngle = Literal["auto", "common", "per_trial"]
Method = Literal["least_squares", "piecewise", "swarm"]
Cost = Literal["trajectory", "transient", "characteristics"]
Weight = Literal["amplitude", "equal", "noise"]
Intervals = Literal["sensitivities", "bootstrap"]


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
class Prior:
    """How far the leg file's own values may be trusted, one standard deviation; None: not at all.

    ``spring`` and ``damper`` are shares of the rate given in the leg file, ``free_angle`` is in rad.
    """

    spring: Share | None = None
    damper: Share | None = None
    free_angle: Turn | None = None


@dataclass(frozen=True)
class SpringChoice:
    """What a joint's spring must meet; None: no limit. A ``part`` is taken whatever its numbers.

    ``make`` True: a spring to wind; False: a bought one or none; None: a bought one where one fits.
    """

    make: Annotated[
        bool | None, Because("a bought spring where one meets the constraints, else one to wind", "as it comes")
    ] = None
    wire: str | None = None
    part: str | None = None
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


@dataclass(frozen=True)
class DamperChoice:
    """What a joint's damper must meet; None: no limit. A ``part`` is taken whatever its numbers."""

    direction: Annotated[Literal["both", "one"], Because("a free swing goes both ways")] = "both"
    travel: Annotated[Turn | None, Because("from the joint's range, else from the wanted motion", "as it moves")] = None
    part: str | None = None
    max_outer_diameter: Annotated[Length | None, Because("none was asked for", "no limit")] = None
    max_body_length: Length | None = None


@dataclass(frozen=True)
class JointChoice:
    """Spring and damper of one joint."""

    spring: SpringChoice = field(default_factory=SpringChoice)
    damper: DamperChoice = field(default_factory=DamperChoice)


@dataclass(frozen=True)
class CadOptions:
    """How the joints are built; lengths in m."""

    shaft_diameter: Annotated[Length, Because("a common steel shaft")] = 0.008
    clearance: Annotated[Length, Because("between moving parts printed by filament")] = 0.0004
    wall: Annotated[Length, Because("stiff enough by eye; no stress is checked")] = 0.003
    bed: Annotated[
        tuple[Length, ...],
        Field(strict=False, min_length=3, max_length=3, examples=["[320 mm, 132 mm, 154 mm]"]),
        Because("a desktop printer's bed; only to warn of parts that do not fit"),
    ] = (0.32, 0.132, 0.154)

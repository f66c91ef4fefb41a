"""Options of a fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from synth.files.project_options import RatePrior
from synth.files.static_points_file import StaticPoint
from synth.files.tolerance import Tolerance
from synth.fit.fit_result import FitResult
from synth.swing.leg_model import DamperCurve


@dataclass(frozen=True)
class LegFitOptions:
    """Options of a fit.

    ``free_angle``: auto, common or per_trial. ``weight``: noise (residuals over each joint's noise, one of all
    trials), amplitude (and over the joint's amplitude in each trial) or equal (one noise for all). ``curves``:
    joint name -> known torque-speed curve. ``prior``: standard deviations of the leg file's own values. ``near``:
    an earlier fit of the same recordings, the start of this one, whose free angles and spread are kept. ``static``:
    poses in which the leg was held still by
    known torques. ``intervals``: from sensitivities, or by bootstrap with resampled residuals. ``tolerance``:
    uncertainty of the leg file's links, included in the intervals; None: the links are known exactly. ``release``:
    ``free``: a driven beginning is detected and cut (``free_motion_start``); ``recorded``: all samples are free motion.
    ``laws``: ``auto``: dry friction, quadratic damping or a cubic spring torque is added where it explains what springs
    and linear dampers do not (``another_law``); ``linear``: never. ``wanted``: the recordings are another leg's motion
    that this leg is to follow, so that what is left of them says nothing about the recordings. ``computed``: they are
    the motion of a leg with stated figures (``wanted_motion``): no sensor read them, and no trial can be added.
    """

    free_angle: str = "auto"
    weight: str = "noise"
    curves: Mapping[str, DamperCurve] = field(default_factory=dict)
    seed: int = 0
    prior: RatePrior | None = None
    near: FitResult | None = None
    static: tuple[StaticPoint, ...] = ()
    intervals: str = "sensitivities"
    tolerance: Tolerance | None = None
    release: str = "recorded"
    laws: str = "linear"
    wanted: bool = False
    computed: bool = False

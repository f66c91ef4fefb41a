"""How a leg is to be fitted."""

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
    """How to fit.

    ``free_angle``: auto, common or per_trial. ``weight``: noise (each joint by its own residual), amplitude (and each
    trial by how far the joint moves in it) or equal (one noise for all). ``curves``: joint name -> its known
    torque-speed curve. ``prior``: how far the leg file's own values may be trusted. ``near``: an earlier
    fit of the same recordings, whose spring rates, free angles and their spread this one starts from and keeps to.
    ``static``: poses in which the leg was held still by known torques. ``intervals``: by sensitivities, or by bootstrap
    over blocks of residuals. ``tolerance``: what the leg file leaves open of its links, which the intervals carry;
    None: the links are known exactly. ``release``: ``free``: what something drives at first is looked for and cut
    (``hand``); ``recorded``: the recordings are free from their first sample on.
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

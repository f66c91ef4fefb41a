"""A leg with play in every joint, by our equations and by MuJoCo with the exported model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from synth.files.mjcf import mjcf_text
from synth.model_checks.designed_leg import Predicted, move
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg

PLAY = np.radians(0.3)  # full width, of each joint


def play_errors(mujoco: Any, leg: Leg, releases: Sequence[Predicted]) -> tuple[float, float]:
    """Largest differences in deg: MuJoCo from ours, both with ``PLAY``, and ours with it from ours without."""
    played = leg.with_joints(
        **{joint.name: {"effects": {**joint.effects, "backlash": {"gap": PLAY}}} for joint in leg.joints}
    )
    fastest = np.max([np.abs(np.gradient(r.rotation, r.time, axis=0)).max(axis=0) for r in releases], axis=0)
    model = mujoco.MjModel.from_xml_string(mjcf_text(played, fastest))
    off = effect = 0.0
    for release in releases:
        start = release.rotation[0], release.rate, release.time
        ours, plain = (simulate(each, *start, tolerance=1e-7) for each in (played, leg))
        theirs = move(mujoco, model, played, replace(release, rotation=ours))
        off, effect = max(off, np.abs(theirs - ours).max()), max(effect, np.abs(ours - plain).max())
    return float(np.degrees(off)), float(np.degrees(effect))

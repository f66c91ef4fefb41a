"""Data for the stick figure of a page: ``page.json`` beside ``fit.json`` and ``gap.json``."""

from __future__ import annotations

import math
from typing import Any

import synth
from synth.swing.leg_model import Leg
from synth.units import quantity

FORMAT = "synth/page/1"


def outline_json(leg: Leg) -> dict[str, Any]:
    """Tilt, and each joint's name, zero, sign and link length, in the form of ``import.json``'s leg."""
    joints = [
        {
            "name": joint.name,
            "zero": quantity(joint.zero, "deg"),
            "sign": joint.sign,
            "length": quantity(joint.link.length, "mm"),
        }
        for joint in leg.joints
    ]
    tilt = {"value": float(f"{math.degrees(leg.tilt):.10g}"), "unit": "deg"}
    return {"format": FORMAT, "versions": {"synth": synth.__version__}, "leg": {"tilt": tilt, "joints": joints}}

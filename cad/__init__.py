"""Solids from dimensions: the joints of a leg as parts to print, wind, cut and buy. Millimetres and degrees.

Stands alone; cadquery is loaded only when something is built.

>>> leg = build_leg(LegDimensions("leg", (JointDimensions("knee", spring, free_angle=111, rest_angle=119),)))
>>> files = export_leg(leg, Path("parts"))
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from synth.cad.dimensions import (
    JointDimensions,
    LegDimensions,
    SpringDimensions,
    arm_offset,
)
from synth.cad.fittings import (
    AdapterDimensions,
    BoreDimensions,
    DamperDimensions,
    EncoderDimensions,
    LoadDimensions,
    MountDimensions,
    PrintDimensions,
)
from synth.cad.limits import DimensionError, DimensionProblem

if TYPE_CHECKING:
    from synth.cad.checked_layout import clear_upper_arm_angle
    from synth.cad.checks import CheckResult, GateError, check_leg
    from synth.cad.export import ExportedFile, PreviewError, draw_leg, export_leg
    from synth.cad.failures import draw_failures
    from synth.cad.leg_joints import BuiltLeg, build_leg
    from synth.cad.printing import PrintPlan
    from synth.cad.sizing import SIZED, sized

# Loaded on first use: these modules need numpy and, when called, cadquery.
_LATER = {
    "BuiltLeg": "synth.cad.leg_joints",
    "CheckResult": "synth.cad.checks",
    "ExportedFile": "synth.cad.export",
    "GateError": "synth.cad.checks",
    "PreviewError": "synth.cad.export",
    "SIZED": "synth.cad.sizing",
    "sized": "synth.cad.sizing",
    "PrintPlan": "synth.cad.printing",
    "build_leg": "synth.cad.leg_joints",
    "check_leg": "synth.cad.checks",
    "clear_upper_arm_angle": "synth.cad.checked_layout",
    "draw_failures": "synth.cad.failures",
    "draw_leg": "synth.cad.export",
    "export_leg": "synth.cad.export",
}

__all__ = [
    "SIZED",
    "AdapterDimensions",
    "BoreDimensions",
    "BuiltLeg",
    "CheckResult",
    "DamperDimensions",
    "DimensionError",
    "DimensionProblem",
    "EncoderDimensions",
    "ExportedFile",
    "GateError",
    "JointDimensions",
    "LegDimensions",
    "LoadDimensions",
    "MountDimensions",
    "PreviewError",
    "PrintDimensions",
    "PrintPlan",
    "SpringDimensions",
    "arm_offset",
    "build_leg",
    "check_leg",
    "clear_upper_arm_angle",
    "draw_failures",
    "draw_leg",
    "export_leg",
    "sized",
]


def __getattr__(name: str) -> Any:
    if name in _LATER:
        from importlib import import_module

        return getattr(import_module(_LATER[name]), name)
    raise AttributeError(f"module 'synth.cad' has no attribute {name!r}")

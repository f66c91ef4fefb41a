"""Dimensions in, solids out: the joints of a leg as parts to print, wind, cut and buy. Millimetres and degrees.

Stands alone; cadquery is loaded only when something is built.

>>> leg = build_leg(LegDimensions("leg", (JointDimensions("knee", spring, free_angle=111, rest_angle=119),)))
>>> files = export_leg(leg, Path("parts"))
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from cad.dimensions import (
    JointDimensions,
    LegDimensions,
    SpringDimensions,
    arm_offset,
    included_angle_of,
)
from cad.fittings import (
    AdapterDimensions,
    BoreDimensions,
    DamperDimensions,
    EncoderDimensions,
    LoadDimensions,
    MountDimensions,
    PrintDimensions,
)
from cad.limits import DimensionError, DimensionProblem

if TYPE_CHECKING:
    from cad.checked_layout import clear_upper_arm_angle
    from cad.checks import CheckResult, GateError, check_leg
    from cad.export import ExportedFile, PreviewError, draw_leg, export_leg
    from cad.failures import draw_failures
    from cad.leg_joints import BuiltLeg, build_leg
    from cad.printing import PrintPlan, plan_leg
    from cad.sizing import SIZED, sized

# Loaded on first use: these modules need numpy and, when called, cadquery.
_LATER = {
    "BuiltLeg": "cad.leg_joints",
    "CheckResult": "cad.checks",
    "ExportedFile": "cad.export",
    "GateError": "cad.checks",
    "PreviewError": "cad.export",
    "SIZED": "cad.sizing",
    "sized": "cad.sizing",
    "PrintPlan": "cad.printing",
    "build_leg": "cad.leg_joints",
    "check_leg": "cad.checks",
    "clear_upper_arm_angle": "cad.checked_layout",
    "draw_failures": "cad.failures",
    "draw_leg": "cad.export",
    "export_leg": "cad.export",
    "plan_leg": "cad.printing",
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
    "included_angle_of",
    "plan_leg",
    "sized",
]


def __getattr__(name: str) -> Any:
    if name in _LATER:
        from importlib import import_module

        return getattr(import_module(_LATER[name]), name)
    raise AttributeError(f"module 'cad' has no attribute {name!r}")

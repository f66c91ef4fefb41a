"""From recorded limb motion to springs, dampers and joints, and why the built limb moves differently.

The library: ``read_leg``, ``write_leg``, ``read_trials``, ``fit``, ``gap``, ``jump_gap``, ``design``, ``spring``,
``hopper``, ``compare``, ``load_effect``. Their results are tables (``to_frame``), figures (``plot``), notebook cells
and folders of files (``save``). Everything is loaded when it is first used.
"""

from __future__ import annotations

import importlib
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from synth.compiling.modules import set_class, stands_for_package

__version__ = "0.3.0"

# Public name -> the module that holds it.
_PUBLIC = {
    "CannotBeHad": "synth.errors",
    "Catalogue": "synth.parts.catalogs",
    "Compared": "synth.api.comparisons",
    "Damper": "synth.swing.leg_model",
    "DamperCurve": "synth.swing.leg_model",
    "Design": "synth.api.designs",
    "Fit": "synth.api.fitting",
    "FitOptions": "synth.files.project_options",
    "FitSettings": "synth.api.fitting",
    "Gap": "synth.api.gaps",
    "Hopper": "synth.api.hoppers",
    "Joint": "synth.swing.leg_model",
    "JumpGap": "synth.api.jump_gaps",
    "Leg": "synth.swing.leg_model",
    "Link": "synth.swing.leg_model",
    "Problem": "synth.errors",
    "RatePrior": "synth.files.project_options",
    "Spring": "synth.swing.leg_model",
    "SpringAnswer": "synth.api.springs",
    "Tolerance": "synth.files.tolerance",
    "Trial": "synth.files.trial_list",
    "UserError": "synth.errors",
    "compare": "synth.api.comparisons",
    "design": "synth.api.designs",
    "fit": "synth.api.fitting",
    "gap": "synth.api.gaps",
    "hopper": "synth.api.hoppers",
    "jump_gap": "synth.api.jump_gaps",
    "load_effect": "synth.api.own_effects",
    "read_leg": "synth.api.recorded",
    "read_trials": "synth.api.recorded",
    "spring": "synth.api.springs",
    "write_leg": "synth.api.recorded",
}

if TYPE_CHECKING:
    from synth.api.comparisons import Compared, compare
    from synth.api.designs import Design, design
    from synth.api.fitting import Fit, FitSettings, fit
    from synth.api.gaps import Gap, gap
    from synth.api.hoppers import Hopper, hopper
    from synth.api.jump_gaps import JumpGap, jump_gap
    from synth.api.own_effects import load_effect
    from synth.api.recorded import read_leg, read_trials, write_leg
    from synth.api.springs import SpringAnswer, spring
    from synth.errors import CannotBeHad, Problem, UserError
    from synth.files.project_options import FitOptions, RatePrior
    from synth.files.tolerance import Tolerance
    from synth.files.trial_list import Trial
    from synth.parts.catalogs import Catalogue
    from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

__all__ = [
    "CannotBeHad",
    "Catalogue",
    "Compared",
    "Damper",
    "DamperCurve",
    "Design",
    "Fit",
    "FitOptions",
    "FitSettings",
    "Gap",
    "Hopper",
    "Joint",
    "JumpGap",
    "Leg",
    "Link",
    "Problem",
    "RatePrior",
    "Spring",
    "SpringAnswer",
    "Tolerance",
    "Trial",
    "UserError",
    "__version__",
    "compare",
    "design",
    "fit",
    "gap",
    "hopper",
    "jump_gap",
    "load_effect",
    "read_leg",
    "read_trials",
    "spring",
    "write_leg",
]


class _Public(ModuleType):
    """The module ``synth``: its functions are loaded when first used, and win over packages of the same name.

    ``synth.fit`` is the function, also after ``synth.fit.methods`` was imported, and ``import synth.fit.methods as
    methods`` works, see ``stands_for_package``.
    """

    def __getattr__(self, name: str) -> Any:
        if name not in _PUBLIC:
            raise AttributeError(f"module 'synth' has no attribute {name!r}")
        value = getattr(importlib.import_module(_PUBLIC[name]), name)
        if isinstance(value, FunctionType):
            stands_for_package(value, f"{__name__}.{name}")
        super().__setattr__(name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _PUBLIC and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*vars(self), *_PUBLIC})


set_class(__name__, _Public)

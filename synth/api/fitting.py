"""``synth.fit``: springs, dampers and free angles of a leg from its recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from synth.api.beside_project import (
    not_overridden,
    recordings_of,
    refuse_trials,
    require_fields,
    require_known,
    require_project,
    require_values,
)
from synth.api.report import IN_CODE, Cell, Panel, Report, Stage, silent
from synth.batch.one_fit import Ready, fit_project, ready, write_fit, write_fit_files
from synth.compiling.announced import told_to
from synth.estimation.intervals import Estimate
from synth.files.fit_words import FreeAngle, Laws, Release
from synth.files.input_hashes import read_by
from synth.files.leg_file import PartResolver
from synth.files.leg_in_code import check_leg
from synth.files.made_in_code import in_code, require_class
from synth.files.project_options import FitOptions, RatePrior
from synth.files.projects import FitProject, check_in_code, read_fit_project
from synth.files.tolerance import Tolerance
from synth.files.trial_in_code import checked_trials
from synth.files.trial_list import Trial
from synth.fit.fit_result import FitResult, JointFit
from synth.parts.resolver import resolver
from synth.swing.leg_model import Leg
from synth.units import significant


@dataclass(frozen=True)
class FitSettings:
    """Options that a project file may give beside leg and trials.

    None: as in the project, for a leg the default of the project file.
    ``free_angle``: ``common``, ``per_trial`` or ``auto``. ``release``: ``free`` cuts the driven part at the beginning,
    ``recorded`` fits all samples. ``laws``: ``auto`` adds dry friction, quadratic damping or a cubic spring where it
    explains the motion, ``linear`` never. ``options``: a mapping such as ``{"weight": "equal"}`` changes what it names;
    ``FitOptions`` replaces the project's section ``fit`` as a whole, as ``tolerance`` and ``prior`` do theirs. Without
    a prior, as with ``RatePrior()``, values in the leg are only starting points.
    """

    options: FitOptions | Mapping[str, Any] | None = None
    free_angle: FreeAngle | None = None
    release: Release | None = None
    laws: Laws | None = None
    tolerance: Tolerance | None = None
    prior: RatePrior | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Report):
    """A fitted leg.

    ``project`` : the input. ``result`` : the complete result, see ``FitResult``.
    """

    project: FitProject
    result: FitResult

    @property
    def leg(self) -> Leg:
        """The leg with the estimated springs and dampers."""
        return self.result.leg

    @property
    def joints(self) -> Mapping[str, JointFit]:
        """Joint -> its estimates, each with ``value`` and 90 % interval ``low``, ``high`` in SI and radians."""
        return self.result.joints

    @property
    def rms(self) -> Mapping[str, float]:
        """Joint -> root mean square of its angle error over all counted samples, rad."""
        return self.result.rms

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, and parameters that these trials cannot separate."""
        return (*self.result.warnings, *self.result.not_separable)

    @property
    def headline(self) -> str:
        """Number of joints and trials, and the largest residual."""
        worst = max(self.rms, key=lambda name: self.rms[name])
        count = len(self.result.trials)
        off = f"at most {significant(np.degrees(self.rms[worst]), 2)} deg RMS residual ({worst})"
        return f"{self.project.name}: {len(self.joints)} joints fitted to {count} trials, {off}"

    def columns(self) -> dict[str, list[Cell]]:
        """One row per joint: estimates with their 90 % intervals, and the RMS error.

        A free angle whose interval spans a full turn is unknown, as where a spring may not be there: it has no value.
        """
        table: dict[str, list[Cell]] = {"joint": list(self.joints)}
        for name, key, unit, factor in (
            ("spring rate", "spring_rate", "N*m/rad", 1.0),
            ("damper rate", "damper_rate", "N*m*s/rad", 1.0),
            ("free angle", "free_angle", "deg", 180.0 / np.pi),
        ):
            found: list[Estimate | None] = [getattr(joint, key) for joint in self.joints.values()]
            for end, word in (("value", ""), ("low", " low"), ("high", " high")):
                unknown = [item is None or (end == "value" and item.is_any_angle) for item in found]
                ends = [None if no else getattr(item, end) for item, no in zip(found, unknown, strict=True)]
                table[f"{name}{word} [{unit}]"] = [None if value is None else value * factor for value in ends]
        table["RMS [deg]"] = [float(np.degrees(self.rms[name])) if name in self.rms else None for name in self.joints]
        return table

    def panels(self) -> Sequence[Panel]:
        """One panel per trial: measured and fitted angles."""
        found = []
        for trial in self.result.trials:
            curves = {}
            for j, name in enumerate(self.leg.joint_names):
                curves[f"{name} measured"] = (trial.time, np.degrees(trial.measured[:, j]))
                curves[f"{name} fitted"] = (trial.time, np.degrees(trial.fitted[:, j]))
            dots = frozenset(name for name in curves if name.endswith(" measured"))
            found.append(Panel(trial.name, "time [s]", "angle [deg]", curves, dots))
        return found

    def inputs(self) -> tuple[list[Path], list[str]]:
        """What its project reads."""
        return read_by(self.project)

    def write(self, folder: Path) -> None:
        """``fit.json``, the fitted leg, responses and a report."""
        write_fit(self.result, folder)

    def write_compared(self, folder: Path) -> tuple[str, str]:
        """Without the report."""
        write_fit_files(self.result, folder)
        return "fit", self.project.name


def read_fit(path: str | Path, *, resolve_part: PartResolver | None = None) -> FitProject:
    """Read a project of kind ``fit`` with leg and trials; parts come from the built-in catalogues.

    Raises
    ------
    UserError
        With every mistake of the project, the leg and the trials.
    """
    return read_fit_project(path, resolve_part=resolve_part or resolver())


def fit(
    what: str | Path | FitProject | Leg,
    trials: Sequence[Trial] = (),
    settings: FitSettings | None = None,
    *,
    stage: Stage = silent,
) -> Fit:
    """Estimate springs, dampers and free angles of a leg from its trials.

    Parameters
    ----------
    what
        a project file, a project that was read, or a leg with its ``trials``.
    trials
        of a leg; a project has its own.
    settings
        fit options; those that are given override a project's.
    stage
        called with the current stage.

    Raises
    ------
    UserError
        If trials are given beside a project or none beside a leg, a leg or trials made in code would be refused in a
        file, trials cannot be used, options contradict each other, name a joint or a value that the leg does not have
        or have a value that is not allowed, or no simulated motion comes near the trials.
    """
    if settings is not None:
        require_class(settings, FitSettings)
    if isinstance(what, Leg):
        recorded = recordings_of(trials, "fit")
        project = _in_code(FitProject(IN_CODE, what.name, what, recorded, "auto", FitOptions(), None, (), ()))
    elif isinstance(what, FitProject):
        refuse_trials(trials, what.path, "fit")
        project = _in_code(what)
    else:
        require_project(what, "fit")
        project = read_fit(what)
        refuse_trials(trials, project.path, "fit")
    return fit_checked(check_project(_with_settings(project, settings or FitSettings())), stage=stage)


def _in_code(project: FitProject) -> FitProject:
    """A project whose leg and trials may have been made in code, checked as files are."""
    place = in_code(project.path)
    check_leg(project.leg, place)
    return replace(project, trials=checked_trials(project.trials, project.leg, place))


def _with_settings(project: FitProject, settings: FitSettings) -> FitProject:
    """The project with the given settings; those that override a default of its file are no longer listed as one."""
    given = {name: value for name, value in vars(settings).items() if value is not None}
    over = set(given)
    options = given.pop("options", None)
    if isinstance(options, Mapping):
        require_fields(options, FitOptions, project.path, "options")
        over |= {f"fit.{name}" for name in options}
        given["fit"] = replace(project.fit, **options)
    elif options is not None:
        over.add("fit")
        given["fit"] = options
    if settings.prior == RatePrior():
        given["prior"] = None
    changed = replace(project, **given, defaults=not_overridden(project.defaults, over))
    check_in_code(changed)
    require_known(changed.tolerance, changed.leg, changed.path)
    if changed.prior is not None:
        require_values(changed.prior, changed.leg, changed.path)
    return changed


def check_project(project: FitProject) -> Ready:
    """Run all checks that need no fit; ``needs_effects`` of the answer says what must be compiled."""
    return ready(project)


def fit_checked(given: Ready, *, stage: Stage = silent) -> Fit:
    """Fit a checked project."""
    with told_to(stage), stage("fitting"):
        return Fit(given.project, fit_project(given))

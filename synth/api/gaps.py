"""``synth.gap``: why the built leg moves differently from the designed one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from synth.api.beside_project import not_overridden, recordings_of, refuse_trials, require_known, require_project
from synth.api.diagnosed import Diagnosed
from synth.api.report import IN_CODE, Panel, Stage, silent, stage_by_stage
from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Diagnosis
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.diagnosis.plants.swinging_chain.plain_drive import drive_error
from synth.diagnosis.plants.swinging_chain.stand_in import stand_in
from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
from synth.errors import UserError
from synth.files.gap_kind import is_hopper_gap
from synth.files.gap_project import GapProject, check_in_code, with_rates
from synth.files.gap_project import read_gap_project as _read_gap_project
from synth.files.input_hashes import input_hashes, read_by
from synth.files.leg_in_code import check_leg
from synth.files.made_in_code import in_code
from synth.files.simulator_files import write_simulator_files
from synth.files.tolerance import Tolerance
from synth.files.trial_in_code import checked_trials
from synth.files.trial_list import Trial
from synth.parts.resolver import resolver
from synth.swing.foreign_effects import own_hashes
from synth.swing.leg_model import Leg


@dataclass(frozen=True, eq=False, repr=False)
class Gap(Diagnosed):
    """Why a swinging leg moves differently.

    ``project`` : the input. ``result`` : the complete result, see ``GapResult``.
    """

    project: GapProject
    result: GapResult

    @property
    def diagnosis(self) -> Diagnosis:
        """The diagnosis."""
        return self.result

    @property
    def diagnosed(self) -> Leg:
        """The nominal leg with the explanation applied."""
        return self.result.diagnosed

    def panels(self) -> Sequence[Panel]:
        """One panel per scored trial and joint: measured, best nominal fit, and with the explanation."""
        found = []
        for trial in self.result.trials:
            for j, name in enumerate(self.project.leg.joint_names if trial.scored else ()):
                curves = {
                    "measured": (trial.time, np.degrees(trial.measured[:, j])),
                    "before": (trial.time, np.degrees(trial.before[:, j])),
                    "after": (trial.time, np.degrees(trial.after[:, j])),
                }
                label = f"{name} [deg]"
                found.append(Panel(f"{trial.name}, {name}", "time [s]", label, curves, frozenset({"measured"})))
        return found

    def inputs(self) -> tuple[list[Path], list[str]]:
        """What its project reads."""
        return read_by(self.project)

    def write(self, folder: Path) -> None:
        """``gap.json``, predictions, the diagnosed leg (also for simulators), and a report."""
        from synth.diagnosis.plants.swinging_chain.chain_write import write_gap
        from synth.files.kept_templates import kept_templates
        from synth.reports import write_gap_report

        write_gap(self.result, self.project, folder)
        near = stand_in(self.diagnosed, self.project.trials)
        leg, told = (None, ()) if near is None else (near.leg, near.texts)
        driven = drive_error(self.diagnosed, self.project.trials)
        fastest, deflected = self._fastest(), self._deflected()
        write_simulator_files(self.diagnosed, fastest, folder / "diagnosed", leg, told, driven, deflected)
        write_gap_report(folder, kept_templates())

    def write_compared(self, folder: Path) -> tuple[str, str]:
        """Without files for simulators and the report."""
        from synth.diagnosis.plants.swinging_chain.chain_write import write_gap

        write_gap(self.result, self.project, folder)
        return "gap", self.project.name

    def _fastest(self) -> Array:
        """(n,) rad/s, the largest speed of each joint in the trials; at least one degree per second."""
        speeds = [np.nanmax(np.abs(trial.speed), axis=0, initial=0.0) for trial in self.result.trials]
        return np.asarray(np.maximum(np.max(speeds, axis=0), np.radians(1.0)))

    def _deflected(self) -> Array:
        """(n,) rad, the largest deflection of each joint's spring in the trials, measured and as diagnosed."""
        leg = self.diagnosed
        each = [
            np.nanmax(np.abs(leg.to_rotation(angles) - leg.rest), axis=0, initial=0.0)
            for trial in self.result.trials
            for angles in (trial.measured, trial.after)
        ]
        return np.asarray(np.max(each, axis=0))


@dataclass(frozen=True, eq=False)
class CheckedGap:
    """A project with checked trials."""

    project: GapProject
    warnings: tuple[str, ...]


def read_gap(path: str | Path) -> GapProject:
    """Read a project of kind ``gap`` for a swinging leg.

    Raises
    ------
    UserError
        With every mistake of the project, the leg and the trials.
    """
    return _read_gap_project(path, resolve_part=resolver())


def with_checked_trials(project: GapProject) -> CheckedGap:
    """The project with warnings about its trials."""
    return CheckedGap(project, tuple(check_trials(project.leg, project.trials)))


def gap(
    what: str | Path | CheckedGap | Leg,
    trials: Sequence[Trial] = (),
    *,
    tolerance: Tolerance | None = None,
    noise: Mapping[str, float] | None = None,
    accuracy: float | None = None,
    seed: int | None = None,
    stage: Stage = silent,
) -> Gap:
    """Find why a built leg swings differently from its design.

    Parameters
    ----------
    what
        a project file, a read project, or the designed leg with the ``trials`` of the built one.
    trials
        of the built leg; a project has its own.
    tolerance
        overrides a project's as a whole; None: the project's, of a leg the default of the project file.
    noise
        joint -> RMS in rad that its sensor is known to scatter by, likewise; by default it is estimated.
    accuracy
        rad, a smaller gap does not matter, likewise.
    seed
        of everything random, likewise.
    stage
        called with the current stage.

    Raises
    ------
    UserError
        If the project or its trials cannot be used, trials are given beside a project or none beside a leg, a leg or
        trials made in code would be refused in a file, or the tolerance or the noise names a joint that the leg does
        not have or a value that is not allowed.
    """
    if isinstance(what, Leg):
        checked = with_checked_trials(_in_code(what, trials))
    elif isinstance(what, CheckedGap):
        checked = what
    else:
        require_project(what, "gap")
        if is_hopper_gap(what):
            raise UserError(f"{what} describes a jumping leg: read it with synth.jump_gap")
        checked = with_checked_trials(read_gap(what))
    if not isinstance(what, Leg):
        refuse_trials(trials, checked.project.path, "gap")
    checked = replace(checked, project=_overridden(checked.project, tolerance, noise, accuracy, seed))
    project = checked.project
    with stage("diagnosing"), stage_by_stage(stage) as say:
        result = diagnose(
            project.leg,
            project.trials,
            project.tolerance,
            seed=project.seed,
            noise=project.noise,
            accuracy=project.accuracy,
            next_command=project.next_command,
            progress=say,
        )
    messages = tuple(dict.fromkeys((*checked.warnings, *result.warnings)))
    return Gap(project, replace(result, warnings=messages, inputs=_inputs(project)))


def _in_code(leg: Leg, trials: Sequence[Trial]) -> GapProject:
    """The project of a leg and trials that may have been made in code, checked as files are."""
    place = in_code(IN_CODE)
    check_leg(leg, place)
    designed, defaults = with_rates(leg)
    recorded = checked_trials(recordings_of(trials, "gap"), leg, place, own_legs=True)
    given = tuple(t if t.leg is None else replace(t, leg=with_rates(t.leg)[0]) for t in recorded)
    return GapProject(IN_CODE, leg.name, designed, given, Tolerance(), 0, defaults, ())


def _overridden(
    project: GapProject,
    tolerance: Tolerance | None,
    noise: Mapping[str, float] | None,
    accuracy: float | None,
    seed: int | None,
) -> GapProject:
    """The project with what is given."""
    if tolerance is not None:
        rest = not_overridden(project.defaults, ("tolerance",))
        project = replace(project, tolerance=tolerance, defaults=rest)
    project = project if noise is None else replace(project, noise=dict(noise))
    project = project if accuracy is None else replace(project, accuracy=accuracy)
    project = project if seed is None else replace(project, seed=seed)
    check_in_code(project)
    require_known(project.tolerance, project.leg, project.path)
    return project


def _inputs(project: GapProject) -> Mapping[str, str]:
    """Every input file with its SHA-256: project, leg, the user's effects, all of them candidates, and recordings."""
    return input_hashes(project) | own_hashes()

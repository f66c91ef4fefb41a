"""One fit from its project, for a single ``synth fit`` and for each project of a folder."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from synth.batch.folder_summary import fit_columns, fit_entry
from synth.batch.folder_task import FolderTask, files_of, identity_of
from synth.design.fit_responses import write_fit_responses
from synth.errors import Problem, UserError
from synth.files.input_hashes import input_hashes
from synth.files.leg_file import write_leg
from synth.files.output import write_json
from synth.files.page_outline import outline_json
from synth.files.projects import FitProject, read_fit_project
from synth.files.tolerance import links_json
from synth.fit.copies import without_copies
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.later_samples import recordings_from
from synth.fit.locked_joints import balanced_at, moving_joints, with_locked_joints
from synth.fit.methods import fit_by, require_method
from synth.fit.plausibility import doubts
from synth.fit.recordings import Recording, recordings
from synth.fit.servo_integrals import require_no_integral
from synth.fit.still_start import from_release
from synth.fit.wanted_motion import WantedMotion, with_other_legs, with_wanted_fit


@dataclass(frozen=True, eq=False)
class Ready:
    """A project with its checked recordings; ``messages`` : notes on what was cut or left out."""

    project: FitProject
    fitted: list[Recording]
    held_out: list[Recording]
    messages: tuple[str, ...] = ()
    wanted: WantedMotion | None = None

    @property
    def needs_effects(self) -> bool:
        """Whether the leg has more than springs, linear dampers and gravity: curves, effects, known torques."""
        joints = self.project.leg.joints
        return any(j.effects or (j.damper and j.damper.curve) for j in joints) or any(
            recording.known_torque is not None for recording in (*self.fitted, *self.held_out)
        )


def ready(project: FitProject) -> Ready:
    """Run all checks that need no fit.

    Raises
    ------
    UserError : options contradict each other, every trial is held out, or a recording cannot be used.
    """
    require_no_integral(project.leg, project.trials, str(project.path))
    given = {"static": bool(project.static), "prior": project.prior is not None}
    require_method(project.fit, str(project.path), **given)
    project, wanted = with_wanted_fit(project)
    fitted = [trial for trial in project.trials if not trial.held_out]
    if not fitted:
        text = "every trial is held out; at least one must be fitted"
        raise UserError(Problem(text, str(project.path), key="trials"))
    held_out = [trial for trial in project.trials if trial.held_out]
    moving = moving_joints(project.leg, fitted)
    leg, both = project.leg, (recordings(project.leg, fitted, moving), recordings(project.leg, held_out, ()))
    own, checks, messages = without_copies(*both, str(project.path))
    if project.release == "recorded":
        return Ready(project, own, checks, messages if wanted is None else wanted.messages, wanted)
    begun = [from_release(leg, some) for some in (own, checks)]
    messages = (*messages, *begun[0].messages, *begun[1].messages)
    return Ready(project, begun[0].recordings, begun[1].recordings, messages)


def fit_project(given: Ready) -> FitResult:
    """Fit, and score the held-out trials.

    Raises
    ------
    UserError : no simulated motion of this leg comes near the trials.
    """
    project = given.project
    moving = moving_joints(project.leg, [trial for trial in project.trials if not trial.held_out])
    options = LegFitOptions(
        project.free_angle,
        project.fit.weight,
        {j.name: j.damper.curve for j in project.leg.joints if j.damper and j.damper.curve},
        project.fit.seed,
        project.prior,
        static=balanced_at(project.static, project.leg, moving),
        intervals=project.fit.intervals,
        tolerance=project.tolerance,
        release=project.release,
        laws=project.laws,
        computed=given.wanted is not None,
    )
    result = fit_by(project.leg, given.fitted, options, project.fit)
    if given.held_out:
        from synth.design.stages import with_held_out  # a local import, because it loads the whole design package

        result = with_held_out(result, recordings_from(given.held_out, result.cut) or given.held_out)
    result = with_other_legs(result, () if given.wanted is None else given.wanted.legs)
    messages = (*given.messages, *doubts(project.leg, given.fitted, result))
    result = replace(result, warnings=(*messages, *result.warnings))
    result = with_locked_joints(result, project.leg, moving)
    defaults = [{"key": d.key, "value": d.value, "why": d.reason} for d in project.defaults]
    tolerance = links_json(project.tolerance, project.leg)
    shown = {} if given.wanted is None else given.wanted.as_json()
    return replace(result, inputs=input_hashes(project), tolerance=tolerance, defaults=tuple(defaults), wanted=shown)


def write_fit(result: FitResult, folder: Path) -> None:
    """Write ``fit.json``, the fitted leg, responses and a report."""
    from synth.files.kept_templates import kept_templates
    from synth.reports import write_fit_report

    write_fit_files(result, folder)
    write_fit_report(folder, kept_templates())


def write_fit_files(result: FitResult, folder: Path) -> None:
    """The same without the report."""
    write_json(folder / "fit.json", result.as_json())
    write_leg(result.leg, folder / "fitted.leg.yaml")
    write_fit_responses(result, folder / "responses" / "source")
    write_json(folder / "page.json", outline_json(result.leg))


def fit_files(project: FitProject) -> dict[str, bytes]:
    """A fit's files as content by relative name: what a worker returns, on any machine."""
    result = fit_project(ready(project))
    return files_of(lambda folder: write_fit(result, folder))


def fits() -> FolderTask:
    """``synth fit`` on a folder."""
    from synth.parts.catalogs import Catalogue
    from synth.parts.resolver import resolver
    from synth.reports.many_pages import write_fits_report

    resolve = resolver(Catalogue.load())
    return FolderTask(
        kind="fit",
        made="fits",
        done="fitted",
        read=lambda path: read_fit_project(path, resolve_part=resolve),
        identity=identity_of,
        checked=lambda project: len(ready(project).project.trials),
        files=fit_files,
        entry=fit_entry,
        columns=fit_columns,
        page=write_fits_report,
        effects=False,
    )

"""The complete check of a project's recordings, in seconds; only initial states are fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.diagnosis.angle_search import as_designed
from synth.diagnosis.angle_trials import AngleTrial, largest_of_kinds
from synth.diagnosis.check.cause_responses import responses_of
from synth.diagnosis.check.channels import Channel, accuracy_findings, channel_findings, describe_channels
from synth.diagnosis.check.check_result import Check
from synth.diagnosis.check.clocks import clock_findings, describe_sampling
from synth.diagnosis.check.coverage import coverage_findings, describe_coverage, torque_findings
from synth.diagnosis.check.finding import Finding, finding_of_remark, finding_of_slip, merge_alike, worst_first
from synth.diagnosis.check.lags import Lag, estimate_lags, lag_findings
from synth.diagnosis.check.separability import Separability, separability
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.chain_menu import menu
from synth.diagnosis.plants.swinging_chain.changed_effect import changed_effects
from synth.diagnosis.plants.swinging_chain.column_slips import column_slips
from synth.diagnosis.plants.swinging_chain.far_numbers import FarNumbers, far_numbers
from synth.diagnosis.plants.swinging_chain.pieces import whole_recordings
from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
from synth.diagnosis.workbench import Workbench
from synth.files.input_hashes import input_hashes
from synth.fit.recordings import recordings as as_recordings
from synth.fit.sensor_noise import estimate_sensor

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject

# Share of a joint's motion (RMS) that no model of this kind follows, for any sensor: that of a good real rig with its
# best cause, as ``make rigs`` prints it.
UNEXPLAINED_SHARE = 0.01
SAMPLES_COMPARED, TRIALS_COMPARED = 300, 12  # samples per trial, and trials, for comparing responses
INTEGRATION_TOLERANCE = 1e-5  # rad, of the integrator: responses are a hundred times larger


def check(project: GapProject, say: Callable[[str], None] | None = None) -> Check:
    """Find faults of a project's recordings, and the causes they can distinguish.

    Raises
    ------
    UserError : a trial cannot be read as motion, or no trial moves.
    """
    tell = say or (lambda text: None)
    tell("channels, clocks and ranges")
    leg = project.leg
    # What an undersampled motion does from one sample to the next is no noise, and no reason to call it at rest.
    lost = {
        recording.name
        for recording in as_recordings(leg, project.trials, ())
        if not describe_sampling(leg, recording).resolved
    }
    kept = [trial for trial in project.trials if trial.name not in lost]
    warnings = check_trials(leg, kept) if any(not trial.held_out for trial in kept) else ()
    scene, more = scene_of(leg, project.trials, project.tolerance, project.seed, project.noise)
    # Whole, not the pieces that they are compared in: in a piece a joint may hold still while another moves.
    learnt = [trial.recording for trial in whole_recordings(scene.given)]
    recordings = [*learnt, *(trial.recording for trial in whole_recordings(scene.held))]
    steps = tuple(describe_sampling(leg, recording) for recording in recordings)
    resolved = [recording for recording in learnt if recording.name not in lost]
    found = estimate_sensor(resolved or learnt).stated(leg.joint_names, project.noise)
    read = describe_channels(leg.joint_names, recordings, found, noise_seen=bool(resolved))
    covered = describe_coverage(leg, learnt)
    names = [trial.name for trial in project.trials]
    findings: list[Finding] = [finding_of_remark(text, names) for text in (*warnings, *more)]
    findings += clock_findings(leg, recordings, steps, {trial.name: trial.time_unit for trial in project.trials})
    findings += channel_findings(leg, recordings, found, read)
    findings += accuracy_findings(project.accuracy, read)
    findings += coverage_findings(leg, learnt, covered)
    findings += torque_findings(leg, project.trials)
    told, late = Separability((), (), np.zeros((0, 0))), tuple[Lag, ...]()
    if not _any_fault(findings):
        tell("the recordings against the designed leg")
        compared = describe_channels(leg.joint_names, [trial.recording for trial in scene.given], found)
        bench = _comparison_bench(scene.bench, scene.given, compared)
        columns = column_slips(leg, project.trials, bench)
        findings += [finding_of_slip(slip) for slip in columns] or _far_findings(
            far_numbers(leg, scene.bench, scene.given)
        )
        if not _any_fault(findings):
            tell("causes that can be separated")
            at = as_designed(bench)
            every = candidates(leg, scene.given, natural_sizes_of(leg, scene.given), scene.legs)
            responses, made = responses_of(bench, at, changed_effects(every))
            late = estimate_lags(bench, at, responses)
            findings += lag_findings(late)
            told = separability(bench, at, responses, made, menu(leg, bench, scene.given))
    return Check(
        project.name,
        len(recordings),
        worst_first(merge_alike(findings)),
        steps,
        read,
        covered,
        late,
        told.showings,
        told.clusters,
        told.sines,
        UNEXPLAINED_SHARE,
        input_hashes(project),
    )


def _far_findings(far: FarNumbers) -> list[Finding]:
    """A stated number that is off by a slip of the unit: a fault. Of dampers a doubt: a bearing's is often guessed."""
    return [finding_of_slip(slip, "doubt" if far.only_damping else "fault") for slip in far.slips]


def _any_fault(findings: Sequence[Finding]) -> bool:
    return any(finding.level == "fault" for finding in findings)


def _comparison_bench(bench: Workbench, given: Sequence[AngleTrial], read: Sequence[Channel]) -> Workbench:
    """Fewer samples, a coarser integration, and noise that includes a good rig's remainder."""
    noise = np.hypot(bench.noise, UNEXPLAINED_SHARE * np.array([channel.motion for channel in read]))
    thin = [trial.thinner(SAMPLES_COMPARED) for trial in given]
    kept = tuple(thin[i] for i in sorted(largest_of_kinds(thin)[:TRIALS_COMPARED]))
    return replace(bench, predictor=bench.predictor.coarser(INTEGRATION_TOLERANCE), trials=kept, noise=noise)

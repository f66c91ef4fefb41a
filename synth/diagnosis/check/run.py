"""The complete check of a project's recordings, in seconds; only initial states are fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.diagnosis.angle_search import as_designed
from synth.diagnosis.angle_trials import AngleTrial, largest_of_kinds
from synth.diagnosis.check.against_nominal import column_findings
from synth.diagnosis.check.cause_responses import responses_of
from synth.diagnosis.check.channels import Channel, channel_findings, channels
from synth.diagnosis.check.check_result import Check
from synth.diagnosis.check.clocks import clock_findings, sampling
from synth.diagnosis.check.coverage import coverage, coverage_findings
from synth.diagnosis.check.finding import Finding, of_alike, of_remark, worst_first
from synth.diagnosis.check.lags import Lag, lag_findings, lags
from synth.diagnosis.check.separability import Separability, separability
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, scales
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.chain_menu import menu
from synth.diagnosis.plants.swinging_chain.pieces import wholes
from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
from synth.diagnosis.sensor_noise import estimate_sensor
from synth.diagnosis.workbench import Workbench
from synth.fit.recordings import recordings as as_recordings

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject

# Share of a joint's motion (RMS) that no model of this kind follows, for any sensor: that of a good real rig with its
# best cause, as ``make rigs`` prints it.
REMAINDER = 0.01
SAMPLES, MOST = 300, 12  # samples per trial, and trials, for comparing responses
INTEGRATION = 1e-5  # rad, of the integrator: responses are a hundred times larger


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
        recording.name for recording in as_recordings(leg, project.trials, ()) if not sampling(leg, recording).resolved
    }
    kept = [trial for trial in project.trials if trial.name not in lost]
    warnings = check_trials(leg, kept) if any(not trial.held_out for trial in kept) else ()
    scene, more = scene_of(leg, project.trials, project.tolerance, project.seed, project.noise)
    # Whole, not the pieces that they are compared in: in a piece a joint may hold still while another moves.
    learnt = [trial.recording for trial in wholes(scene.given)]
    recordings = [*learnt, *(trial.recording for trial in wholes(scene.held))]
    steps = tuple(sampling(leg, recording) for recording in recordings)
    resolved = [recording for recording in learnt if recording.name not in lost]
    found = estimate_sensor(resolved or learnt).stated(leg.joint_names, project.noise)
    read = channels(leg.joint_names, recordings, found, noise_seen=bool(resolved))
    covered = coverage(leg, learnt)
    names = [trial.name for trial in project.trials]
    findings: list[Finding] = [of_remark(text, names) for text in (*warnings, *more)]
    findings += clock_findings(leg, recordings, steps)
    findings += channel_findings(leg.joint_names, recordings, found, read)
    findings += coverage_findings(leg, learnt, covered)
    if any(finding.level == "fault" for finding in findings):
        told, late = Separability((), (), np.zeros((0, 0))), tuple[Lag, ...]()
    else:
        tell("the recordings against the designed leg")
        compared = channels(leg.joint_names, [trial.recording for trial in scene.given], found)
        bench = _bench(scene.bench, scene.given, compared)
        findings += column_findings(leg, project.trials, bench)
        tell("causes that can be separated")
        at = as_designed(bench)
        responses, made = responses_of(bench, at, candidates(leg, scene.given, scales(leg, scene.given)))
        late = lags(bench, at, responses)
        findings += lag_findings(late)
        told = separability(bench, at, responses, made, menu(leg, bench, scene.given))
    return Check(
        project.name,
        len(recordings),
        worst_first(of_alike(findings)),
        steps,
        read,
        covered,
        late,
        told.showings,
        told.clusters,
        told.sines,
        REMAINDER,
        {item.name: item.sha256 for item in project.inputs} | {t.name: t.sha256 for t in project.trials},
    )


def _bench(bench: Workbench, given: Sequence[AngleTrial], read: Sequence[Channel]) -> Workbench:
    """Fewer samples, a coarser integration, and noise that includes a good rig's remainder."""
    noise = np.hypot(bench.noise, REMAINDER * np.array([channel.motion for channel in read]))
    thin = [trial.thinner(SAMPLES) for trial in given]
    kept = tuple(thin[i] for i in sorted(largest_of_kinds(thin)[:MOST]))
    return replace(bench, predictor=bench.predictor.coarser(INTEGRATION), trials=kept, noise=noise)

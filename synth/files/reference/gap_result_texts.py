"""Meaning of each field of ``gap.json`` and ``gaps.json``; ``NAME`` and ``[]`` as in ``result_texts``."""

from __future__ import annotations

from synth.files.reference.shared_texts import remark_texts

_SHA = "SHA-256 of each input file."
_PHASES = {
    "release": "Share until the first peak of the speed.",
    "swing": "Share until the envelope falls under 20 % of the release.",
    "settle": "Share until speeds stay under the noise; 0 of a jump, which has no such phase.",
    "rest": "Share of what is left; 0 of a jump.",
}
_BINS = {
    "speed": "joint speed",
    "position": "distance of the joint from its free angle",
    "load": "torque that the joint carries",
    "time": "time after the release",
}
_STAGES = {
    "as_designed": "of the nominal leg as given",
    "before": "of the nominal leg fitted within its tolerances",
    "after": "of the leg with the explanation",
}
_CAUSE = {
    "effect": "Name of the effect.",
    "joint": "Joint, `base` or `all`.",
    "parameters.NAME": "Estimate of a parameter of the effect; of a wrong number against the stated one, its tolerance "
    "included.",
    "gives.NAME": "The number of the drive that the parameter makes, in the leg file's terms: a delay, a limit, a "
    "resistance; missing if it makes none.",
    "stated.NAME": "The same number as the leg file states it; missing if it states none.",
}

GAP = {
    "format": "Name and version of the format.",
    "name": "Of the project.",
    "verdict": "`effect`, `none`, `tie` or `unknown`.",
    "within_accuracy": "Whether the gap is below the required `accuracy:`; causes were then not judged.",
    "sentence": "The verdict in words.",
    **{f"explanation[].{key}": text for key, text in _CAUSE.items()},
    **{f"ranked[].{key}": text for key, text in _CAUSE.items()},
    "ranked[].probability": "Probability that this single cause explains the gap.",
    "ranked[].shrink": "Reduction of the gap above the noise by this cause alone, on scored trials.",
    "ranked[].curve.NAME": "Points of the effect's law if it is a curve.",
    **{f"tied[][].{key}": text for key, text in _CAUSE.items()},
    "probability_none": "Probability that no effect is missing; 1 if the gap is `within_accuracy`.",
    "probability_unknown": "Probability of a cause that no effect of the library explains.",
    "where.joint.NAME": "Share of the gap at a joint; the shares sum to 1.",
    **{f"where.phase.{key}": text for key, text in _PHASES.items()},
    **{f"where.{key}.NAME": f"Share by {text}: `low`, `middle` or `high` third." for key, text in _BINS.items()},
    "remainder.rms": "RMS error above the noise with the explanation, or with the nominal leg if there is none.",
    "remainder.share": "As a share of the gap before; above 1 if the explanation predicts worse.",
    "remainder.times_noise": "As a multiple of the noise floor.",
    "remainder.where.joint.NAME": "Share of the remainder at a joint.",
    **{f"remainder.where.phase.{key}": text for key, text in _PHASES.items()},
    "scored_by": "How scored trials were predicted: `held_out` (by the others, all left out), `in_turn` (each by the "
    "others), `pieces_in_turn` (each piece of the one recording by the others), `fitted` (the trial that was fitted).",
    **{f"gap.{key}": f"RMS error on scored trials {text}." for key, text in _STAGES.items()},
    **{f"gap.joints.NAME.{key}": f"RMS error of the joint {text}." for key, text in _STAGES.items()},
    "gap.noise_floor": "RMS noise of the readings; with coarse counts as they carry it, where it turns a reading.",
    "gap.best_possible": "Lowest RMS error that a model of this kind can reach on these trials.",
    "gap.shrink": "1 - after/before, both less the noise.",
    "gap.shrink_of_best": "The same relative to the largest possible reduction.",
    "gap.scored_on": "Trials that were used neither to fit nor to choose.",
    "next_experiment.why": "The benefit of the trial.",
    "next_experiment.trial.NAME": "Entry for `trials:` of the trial to record.",
    "next_experiment.release.NAME": "Measured angle from which each joint is released.",
    "next_experiment.torque.joint": "Joint on which a known torque acts.",
    "next_experiment.torque.rises_to": "Final torque.",
    "next_experiment.torque.in": "Rise time of the torque.",
    "next_experiment.command": "File with the angles to command.",
    "next_experiment.information": "Expected information about the cause.",
    "next_experiment.menu[].what": "Another trial.",
    "next_experiment.menu[].information": "Its expected information.",
    "free_torque[].joint": "Joint at which a torque of free shape was tried.",
    "free_torque[].over": "Quantity on which the torque depends.",
    "free_torque[].taken": "Share of the gap that it explains.",
    "free_torque[].curve.place": "Values of that quantity.",
    "free_torque[].curve.direction": "Direction of motion at each value.",
    "free_torque[].curve.torque": "Torque at each value.",
    "free_torque[].curve.low": "Lower end of its 90 % interval.",
    "free_torque[].curve.high": "Upper end of its 90 % interval.",
    "moved_numbers[].joint": "Joint of a stated number that the fit moves by 1.5 of its tolerances or more, and that "
    "matters.",
    "moved_numbers[].quantity": "The number, as `tolerance:` names it.",
    "moved_numbers[].change": "Relative to the stated number; of a free angle, added to it.",
    "moved_numbers[].tolerances": "The same in tolerances.",
    "moved_numbers[].at_limit": "Whether it ends where the search does: the true number may be further off.",
    "moved_numbers[].error": "RMS error on scored trials with the fit.",
    "moved_numbers[].error_as_stated": "The same with this number alone as stated.",
    "noise.NAME": "RMS noise of a joint's readings.",
    "trials[].file": "The recording.",
    "trials[].held_out": "Whether it was excluded from fitting.",
    "trials[].scored": "Whether the gap is evaluated on it.",
    "trials[].predicted": "Table of measured angles and of predictions before and after.",
    "trials[].where": "Table of the missing torque.",
    "trials[].alone": "Table of predictions with each of the most probable causes alone.",
    **{f"trials[].rms.NAME.{key}": f"RMS error of the joint in it {text}." for key, text in _STAGES.items()},
    "trials[].locked": "Locked joints.",
    "trials[].tilt": "The base's tilt in it.",
    "trials[].driven_by": "What drives it: a known torque, a servo; missing if nothing does.",
    "trials[].tip_mass": "Mass added to the last link.",
    "trials[].tip_mass.NAME": "Mass added to the last link: its mass, inertia and place.",
    "trials[].kind": "Jump or pull-up.",
    "trials[].motor": "Motor in it.",
    "trials[].leg_length": "Length of the links in it.",
    "trials[].rise.NAME": "Rise of the centre of mass, measured and by each model.",
    "design_at.NAME": "Estimated deviation of a quantity of the design, in standard deviations of its tolerance.",
    "effects.NAME.meaning": "What the effect is.",
    "effects.NAME.formula": "Its torque.",
    "effects.NAME.source": "Source of the formula.",
    "effects.NAME.parameters.NAME.label": "Name of the parameter that a reader sees.",
    "effects.NAME.parameters.NAME.form": "How it is shown: `value`, `change`, `share` or `relative change`.",
    "effects.NAME.parameters.NAME.added_to": "Quantity of the designed joint that a change is added to.",
    "designed.NAME.spring_rate": "Rate of the joint's spring as designed.",
    "designed.NAME.damper_rate": "Rate of the joint's linear damper as designed.",
    "phases": "Names of the phases, by their number in `where/*.csv`.",
    "warnings": "Warnings.",
    **remark_texts("remarks"),
    "settings.WHY": "`seed` of the resampling; `tolerance.mass` and its like, `tolerance.knee.mass` of one joint: "
    "standard deviations from manufacturing and measurement.",
    "defaults[].key": "A key that the project omits.",
    "defaults[].value": "The value used.",
    "defaults[].why": "Why.",
    "inputs.NAME": _SHA,
    "versions.NAME": "Of the program and its libraries.",
}

_MANY = {
    "format": "Name and version of the format.",
    "versions.NAME": "Of the program.",
    "legs[].name": "Of the project: its place in the folder.",
    "legs[].report": "Its own page.",
    "legs[].warnings": "Warnings.",
    "failed[].name": "A project that failed.",
    "failed[].messages": "The reasons.",
    "failed[].crash": "Whether the cause is an internal error.",
}

GAPS = {
    **_MANY,
    "legs[].gap": "Its `gap.json`.",
    "legs[].trials": "Its trials on which the gap is scored.",
    "legs[].verdict": "As in its `gap.json`.",
    "legs[].sentence": "The verdict in words.",
    **{f"legs[].explanation[].{key}": text for key, text in _CAUSE.items()},
    "legs[].ranked[].effect": "Name of one of the most probable effects.",
    "legs[].ranked[].joint": "Joint, `base` or `all`.",
    "legs[].ranked[].probability": "Probability that this single cause explains the gap.",
    "legs[].ranked[].shrink": "Reduction of the gap by this cause alone.",
    "legs[].probability_none": "Probability that no effect is missing.",
    "legs[].probability_unknown": "Probability of an unknown cause.",
    "legs[].where.NAME": "Share of the gap at a joint.",
    **{f"legs[].rms.{key}": f"RMS error {text}." for key, text in _STAGES.items()},
    "legs[].rms.noise_floor": "RMS noise of the readings.",
}

LEGS = {
    **_MANY,
    "legs[].design": "Its `design.json`.",
    "legs[].joints.NAME.wanted.NAME": "Wanted values of spring and damper.",
    "legs[].joints.NAME.spring": "Catalogue part, or `to make`.",
    "legs[].joints.NAME.damper": "Catalogue part.",
    "legs[].rms": "RMS difference between the built leg's angles and the wanted ones.",
    "legs[].joint_rms.NAME": "The same for one joint.",
    "legs[].drawn": "Whether its joints are drawn and exported.",
    "legs[].failed_checks": "Checks of the drawn joints that failed; then no solid is exported.",
}

FITS = {
    **_MANY,
    "legs[].fit": "Its `fit.json`.",
    "legs[].trials": "Fitted trials.",
    "legs[].joints.NAME.NAME": "Estimate of spring rate, damper rate or free angle.",
    "legs[].rms.NAME": "RMS error of a joint.",
    "legs[].free_angle": "`common` or `per_trial`.",
    "legs[].not_separable": "Parameters that its trials do not determine.",
}

"""Meaning of each field of ``gap.json`` and ``gaps.json``; ``NAME`` and ``[]`` as in ``result_texts``."""

from __future__ import annotations

from synth.files.reference.shared_texts import remark_texts

_SHA = "SHA-256 of each input file."
_PHASES = {
    "release": "Share until the first peak of the speed.",
    "swing": "Share until the envelope falls under 20 % of the release.",
    "settle": "Share until speeds stay under the noise.",
    "rest": "Share of what is left.",
}
_BINS = {
    "speed": "joint speed",
    "position": "distance of the joint from its free angle",
    "load": "torque that the joint carries",
    "time": "time after the release",
}
_STAGES = {
    "as_designed": "with the nominal leg to the letter",
    "before": "with the nominal leg at its best within its tolerances",
    "after": "with the explanation in",
}
_CAUSE = {
    "effect": "Name of the effect.",
    "joint": "Joint, `base` or `all`.",
    "parameters.NAME": "Estimate of a parameter of the effect.",
}

GAP = {
    "format": "Name and version of the form.",
    "name": "Of the project.",
    "verdict": "`effect`, `none`, `tie` or `unknown`.",
    "sentence": "The verdict in words.",
    **{f"explanation[].{key}": text for key, text in _CAUSE.items()},
    **{f"ranked[].{key}": text for key, text in _CAUSE.items()},
    "ranked[].probability": "That this single cause is the one.",
    "ranked[].shrink": "Part of the gap above the noise that it alone takes away on scored trials.",
    "ranked[].curve.NAME": "Points of the effect's law, where it is a curve.",
    **{f"tied[][].{key}": text for key, text in _CAUSE.items()},
    "probability_none": "That nothing is missing.",
    "probability_unknown": "That something is missing that no effect here explains.",
    "where.joint.NAME": "Share of the gap at a joint; the shares sum to 1.",
    **{f"where.phase.{key}": text for key, text in _PHASES.items()},
    **{f"where.{key}.NAME": f"Share by {text}: `low`, `middle` or `high` third." for key, text in _BINS.items()},
    "remainder.rms": "What the explanation, or else the nominal leg, leaves beyond the noise.",
    "remainder.share": "Of the gap before.",
    "remainder.times_noise": "Over the noise floor.",
    "remainder.where.joint.NAME": "Share of the remainder at a joint.",
    **{f"remainder.where.phase.{key}": text for key, text in _PHASES.items()},
    **{f"gap.{key}": f"RMS error on scored trials {text}." for key, text in _STAGES.items()},
    **{f"gap.joints.NAME.{key}": f"RMS error of the joint {text}." for key, text in _STAGES.items()},
    "gap.noise_floor": "RMS scatter of the readings themselves.",
    "gap.best_possible": "RMS error that no model of this kind goes below on these trials.",
    "gap.shrink": "1 - after/before, both less the noise.",
    "gap.shrink_of_best": "The same, of what could go at all.",
    "gap.scored_on": "Trials that took no part in fitting or choosing.",
    "next_experiment.why": "What the trial would tell.",
    "next_experiment.trial.NAME": "An entry for `trials:`, to be recorded.",
    "next_experiment.release.NAME": "Measured angle from which each joint is let go.",
    "next_experiment.torque.joint": "Joint that a known torque acts on.",
    "next_experiment.torque.rises_to": "Its end.",
    "next_experiment.torque.in": "Time that it takes to rise.",
    "next_experiment.command": "File with the angles to be commanded.",
    "next_experiment.information": "Expected information on which cause it is.",
    "next_experiment.menu[].what": "Another trial.",
    "next_experiment.menu[].information": "Its expected information.",
    "free_torque[].joint": "Joint at which a torque of free shape was tried.",
    "free_torque[].over": "What the torque depends on.",
    "free_torque[].taken": "Part of the gap that it takes.",
    "free_torque[].curve.place": "Values of what it depends on.",
    "free_torque[].curve.direction": "Direction of motion at each.",
    "free_torque[].curve.torque": "Torque at each.",
    "free_torque[].curve.low": "Lower end of its 90 % interval.",
    "free_torque[].curve.high": "Upper end of its 90 % interval.",
    "noise.NAME": "RMS scatter of a joint's readings.",
    "trials[].file": "The recording.",
    "trials[].held_out": "Whether it was kept from fitting.",
    "trials[].scored": "Whether the gap's figures are taken on it.",
    "trials[].predicted": "Table of measured, before and after.",
    "trials[].where": "Table of the torque that the design lacks.",
    "trials[].alone": "Table of each likeliest cause alone.",
    **{f"trials[].rms.NAME.{key}": f"RMS error of the joint in it {text}." for key, text in _STAGES.items()},
    "trials[].locked": "Joints that were locked.",
    "trials[].tilt": "The base's tilt in it.",
    "trials[].tip_mass": "Mass added to the last link.",
    "trials[].tip_mass.NAME": "Mass added to the last link: its mass, inertia and place.",
    "trials[].kind": "Jump or pull-up.",
    "trials[].motor": "Motor in it.",
    "trials[].leg_length": "Length of the links in it.",
    "trials[].rise.NAME": "Rise of the centre of mass, measured and by each model.",
    "design_at.NAME": "Where within its tolerance a quantity of the design was found, in standard deviations.",
    "effects.NAME.meaning": "What the effect is.",
    "effects.NAME.formula": "Its torque.",
    "effects.NAME.source": "Where the formula stands.",
    "phases": "Names of the phases, by their number in `where/*.csv`.",
    "warnings": "Warnings.",
    **remark_texts("remarks"),
    "settings.WHY": "`seed` of the resampling; `tolerance.mass` and its like, `tolerance.knee.mass` of one joint: one "
    "standard deviation that manufacturing and measuring leave open.",
    "defaults[].key": "A key that the project omits.",
    "defaults[].value": "The value used.",
    "defaults[].why": "Why.",
    "inputs.NAME": _SHA,
    "versions.NAME": "Of the program and its libraries.",
}

_MANY = {
    "format": "Name and version of the form.",
    "versions.NAME": "Of the program.",
    "legs[].name": "Of the project: its place in the folder.",
    "legs[].report": "Its own page.",
    "legs[].warnings": "Warnings.",
    "failed[].name": "A project that nothing could be made of.",
    "failed[].messages": "Why.",
    "failed[].crash": "Whether the fault is the program's.",
}

GAPS = {
    **_MANY,
    "legs[].gap": "Its `gap.json`.",
    "legs[].trials": "Its trials.",
    "legs[].verdict": "As in its `gap.json`.",
    "legs[].sentence": "The verdict in words.",
    **{f"legs[].explanation[].{key}": text for key, text in _CAUSE.items()},
    "legs[].ranked[].effect": "Name of one of the likeliest effects.",
    "legs[].ranked[].joint": "Joint, `base` or `all`.",
    "legs[].ranked[].probability": "That this single cause is the one.",
    "legs[].ranked[].shrink": "Part of the gap that it alone takes away.",
    "legs[].probability_none": "That nothing is missing.",
    "legs[].probability_unknown": "That something unknown is missing.",
    "legs[].where.NAME": "Share of the gap at a joint.",
    **{f"legs[].rms.{key}": f"RMS error {text}." for key, text in _STAGES.items()},
    "legs[].rms.noise_floor": "RMS scatter of the readings themselves.",
}

LEGS = {
    **_MANY,
    "legs[].design": "Its `design.json`.",
    "legs[].joints.NAME.wanted.NAME": "What was wanted of spring and damper.",
    "legs[].joints.NAME.spring": "Catalogue part, or `to make`.",
    "legs[].joints.NAME.damper": "Catalogue part.",
    "legs[].rms": "RMS error of the built leg's angles against the wanted ones.",
    "legs[].joint_rms.NAME": "The same of one joint.",
    "legs[].failed_checks": "Checks of the drawn joints that failed; then no solid is exported.",
}

FITS = {
    **_MANY,
    "legs[].fit": "Its `fit.json`.",
    "legs[].trials": "Trials that were fitted.",
    "legs[].joints.NAME.NAME": "Estimate of spring rate, damper rate or free angle.",
    "legs[].rms.NAME": "RMS error of a joint.",
    "legs[].free_angle": "`common` or `per_trial`.",
    "legs[].not_separable": "What its trials cannot tell.",
}

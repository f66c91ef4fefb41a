"""Meaning of each field of a result file, by file and path; a test compares the paths with real results.

``NAME`` stands for the name of a joint, a file or a source, ``[]`` for the items of a list, ``WHY`` for any text.
A field with a unit is
``{"value", "unit"}``, with ``interval90`` for an estimate; its unit is the file's own.
"""

from __future__ import annotations

from synth.files.reference.design_result_texts import DESIGN
from synth.files.reference.fit_result_texts import FIT, SPRING_TO_MAKE
from synth.files.reference.gap_result_texts import FITS, GAP, GAPS, LEGS
from synth.files.reference.hopper_result_texts import COMPARE, HOPPER

_SHA = "SHA-256 of each input file."

IMPORT = {
    "format": "Name and version of the format.",
    "name": "Of the project, or the leg.",
    "leg.name": "The leg.",
    "leg.tilt": "Its base's tilt.",
    "leg.joints[].name": "Joint.",
    "leg.joints[].zero": "As in the leg file.",
    "leg.joints[].sign": "As in the leg file.",
    "leg.joints[].length": "Of the joint's link.",
    "leg.joints[].range": "As in the leg file.",
    "trials[].file": "The written trial.",
    "trials[].sha256": "Of that file.",
    "trials[].source": "The recording from which it was made.",
    "trials[].source_sha256": "Of that file.",
    "trials[].source_format": "The detected format.",
    "trials[].samples": "Samples in the trial.",
    "trials[].missing.NAME": "Number of them without a reading of this joint; absent if there is none.",
    "trials[].samples_in_source": "Samples in the recording.",
    "trials[].rate": "Samples per second.",
    "trials[].notes": "Notes on detected, repaired or cut parts.",
    "trials[].release.released": "Time of the release on the recording's clock.",
    "trials[].release.not_before": "Last sample before a gap of all joints in which the release is: `released` is then "
    "the first one after it.",
    "trials[].release.driven_until": "End of the driven part.",
    "trials[].points[].time": "Time of a frame of the stick figure.",
    "trials[].points[].unit": "Unit of its coordinates.",
    "trials[].points[].places[]": "Coordinates of each point, to the right and up.",
    "inputs.NAME": _SHA,
    "versions.NAME": "Of the program and its libraries.",
}

SPRING = {
    "format": "Name and version of the format.",
    "wanted.NAME": "The request.",
    "wanted.leg_lengths[]": "Of each leg, to where the load acts.",
    **{f"make.{key}": text for key, text in SPRING_TO_MAKE.items()},
    **{f"alternatives[].{key}": text for key, text in SPRING_TO_MAKE.items()},
    "binding": "Limits that prevent a spring.",
    "nearest": "The nearest springs that can be made.",
    "lasting": "Changes that would reach the design life.",
    "design_life": "Full turns that a spring should last.",
    "notes": "Notes.",
}

RESULTS = {
    "fit.json": FIT,
    "fits.json": FITS,
    "gap.json": GAP,
    "gaps.json": GAPS,
    "design.json": DESIGN,
    "legs.json": LEGS,
    "hopper.json": HOPPER,
    "compare.json": COMPARE,
    "import.json": IMPORT,
    "spring.json": SPRING,
}

# Columns of the tables that are read and written; NAME is a joint's name.
COLUMNS = {
    "trials: *.csv": {
        "time [s]": "Time, rising; it need not be uniform.",
        "NAME [deg]": "Measured angle; `[rad]` too. An empty cell is a missing sample.",
        "NAME velocity [deg/s]": "Its speed, if recorded.",
        "NAME torque [N*m]": "Known torque in the measured angle's positive sense, linear between its samples.",
        "NAME command [deg]": "Commanded angle.",
        "NAME voltage [V]": "At the motor.",
        "NAME current [A]": "Through the motor.",
        "supply [V]": "Of the servos.",
    },
    "damper curve: *.csv": {
        "speed [rpm]": "Speeds above 0, rising; (0, 0) is implied.",
        "torque [N*m]": "Torque at each speed.",
    },
    "responses/source/*.csv of synth fit": {
        "time [s]": "As in the recording.",
        "NAME measured [deg]": "As recorded; empty where no sample was used.",
        "NAME fitted [deg]": "Of the fitted leg.",
    },
}

"""Each trial's measured and fitted angles as files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.files.output import place, stems, write_csv
from synth.fit.fit_result import FitResult


def write_fit_responses(result: FitResult, folder: Path) -> None:
    """Each trial's measured and fitted angles, ``NAME.csv`` in degrees."""
    folder.mkdir(parents=True)
    names = result.leg.joint_names
    for trial, stem in zip(result.trials, stems([t.name for t in result.trials]), strict=True):
        columns: dict[str, Array] = {"time [s]": trial.time}
        for j, name in enumerate(names):
            columns[f"{name} measured [deg]"] = np.degrees(trial.measured[:, j])
            columns[f"{name} fitted [deg]"] = np.degrees(trial.fitted[:, j])
        write_csv(place(folder, f"{stem}.csv"), columns)

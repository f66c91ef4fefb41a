"""Gap of an effect after fitting the design within its tolerances, in noise floors.

What tolerances and each trial's own start could make good is linear, from the design's lanes; that takes no part in
the recordings.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind.jump_engine import Array
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench
from synth.diagnosis.plants.jumping_leg.jump_data import Jump, prepare_jumps, sample_deviation
from synth.diagnosis.plants.jumping_leg.jump_predict import JumpPredictor
from synth.diagnosis.plants.jumping_leg.jump_search import as_designed
from synth.diagnosis.plants.jumping_leg.jump_tolerances import JumpTolerances
from synth.files.hopper_gap_project import read_hopper_gap_project
from synth.parts.catalogs import Catalogue

Told = dict[str, Array]  # channel -> values, "time" among them


@dataclass(frozen=True)
class Absorber:
    """Jumps without the effect, and their derivatives by the tolerances: ``slopes`` (M, n_unknown + 2) per trial."""

    clean: Sequence[Told]
    jumps: Sequence[Jump]
    slopes: Sequence[Array]
    noise: dict[str, float]

    def floors(self, told: Sequence[Told], scale: float = 0.0) -> float:
        """RMS of the remainder over the noise, in the channel that shows it best; ``scale``: of the angle's reading."""
        missed = [self._missed(i, one, scale) for i, one in enumerate(told)]
        shared = self.slopes[0].shape[1] - 2
        size = shared + 2 * len(missed)
        matrix, right = [np.eye(size)], [np.zeros(size)]
        for i, (r, s) in enumerate(zip(missed, self.slopes, strict=True)):
            row = np.zeros((len(r), size))
            row[:, :shared], row[:, shared + 2 * i : shared + 2 * i + 2] = s[:, :shared], s[:, shared:]
            matrix.append(row)
            right.append(r)
        a, b = np.concatenate(matrix), np.concatenate(right)
        left = (b - a @ np.linalg.lstsq(a, b, rcond=None)[0])[size:]
        squares: dict[str, list[Array]] = {}
        first = 0
        for jump in self.jumps:
            for name in jump.measured:
                part = left[first : first + len(jump.time)] / math.sqrt(jump.weight)
                squares.setdefault(name, []).append(part**2)
                first += len(jump.time)
        return max(float(np.sqrt(np.mean(np.concatenate(parts)))) for parts in squares.values())

    def _missed(self, i: int, told: Told, scale: float) -> Array:
        """Whitened difference, with less without the effect."""
        jump, clean = self.jumps[i], self.clean[i]
        parts = []
        for name, values in jump.measured.items():
            a, b = (np.interp(jump.time, one["time"], one[name]) for one in (told, clean))
            a = a * (1.0 + scale) if name == "upper link" else a
            sigma = sample_deviation(jump.time, values, self.noise[name], name)
            parts.append((a - b) / sigma * math.sqrt(jump.weight))
        return np.concatenate(parts)


def absorber(clean: Sequence[Told], write: Callable[[Path], None], noise: dict[str, float]) -> Absorber:
    """``write`` puts a project with the clean recordings into a folder."""
    with tempfile.TemporaryDirectory() as place:
        write(Path(place))
        project = read_hopper_gap_project(Path(place) / "gap.yaml")
        jumps, _ = prepare_jumps(project, Catalogue.load())
    tolerances = JumpTolerances(project.tolerance, 1 + max(jump.group for jump in jumps))
    leg = project.design.leg
    bench = JumpBench(JumpPredictor(tolerances, leg.bending, leg.body_inertia), tuple(jumps))
    slopes = []
    for jump, found in zip(jumps, as_designed(bench).slopes, strict=True):
        # The recordings being clean, their own deviations are too small: to those of the sensors.
        rows = [jump.sigma[n] / sample_deviation(jump.time, v, noise[n], n) for n, v in jump.measured.items()]
        slopes.append(found * np.concatenate(rows)[:, None])
    return Absorber(clean, jumps, slopes, noise)

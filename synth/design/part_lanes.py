"""Sets of parts as lanes of the compiled chain: the parameter rows of a spring and a damper, and the response errors.

Sets differ only in the rows of springs and dampers. A lane is therefore assembled from precomputed columns, one per
joint. Constructing a leg object for each of a million sets would cost more than simulating it.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.design.response import WantedResponse
from synth.swing.damper_curves import compiled_rows
from synth.swing.lane_layout import CURVE_POINTS, LANES
from synth.swing.leg_model import Damper, Leg
from synth.swing.mechanics import coefficients, static_torque
from synth.threads import in_parallel, thread_count

Index = NDArray[np.int64]

TOLERANCE = 1e-5  # of the integrator: 0.001 deg on the example leg; parts differ by tenths of a degree
CHUNK = 8 * LANES  # lanes that one thread runs at a time
ROWS = 3 + 2 * CURVE_POINTS  # rate, rest, damper rate, clamp speeds, clamp slopes


@dataclass(frozen=True)
class ActingElements:
    """The elements at a joint: spring rate (N m/rad) and the damper as referred to the joint."""

    rate: float
    damper: Damper


def column(rate: float, rest: float, damper: Damper) -> Array:
    """(ROWS,) parameters of one joint: rate, rest, damper rate, 12 clamp speeds, 12 clamp slopes; SI units."""
    made = np.zeros(ROWS)
    made[:3] = rate, rest, damper.rate or 0.0
    if damper.curve is not None:
        made[3 : 3 + CURVE_POINTS], made[3 + CURVE_POINTS :] = compiled_rows(damper.curve)
    return made


class PartLanes:
    """Simulates sets of parts in one leg and compares them with the wanted motion.

    Parameters
    ----------
    wanted
        the motion and its releases.
    leg
        the leg for the parts: its links and effects are used, its springs and dampers are not.
    acting
        the candidate springs and dampers, by joint.
    releases
        the largest number of releases to use, evenly chosen from those of ``wanted``.
    """

    def __init__(
        self, wanted: WantedResponse, leg: Leg, acting: Sequence[Sequence[ActingElements]], releases: int | None = None
    ) -> None:
        self.wanted, self.leg, self.acting = wanted, leg, tuple(tuple(each) for each in acting)
        every = 1 if releases is None else max(1, -(-len(wanted.releases) // releases))
        self.releases, self.motions = wanted.releases[::every], wanted.motions[::every]

    def of(self, acting: Sequence[Sequence[ActingElements]]) -> PartLanes:
        """The same leg and releases with other candidates; what does not depend on these is not computed again."""
        known = (self.holding, self._still, self._counts)  # kept by the copy
        assert all(len(each) for each in known)
        other = copy(self)
        other.__dict__.pop("columns", None)
        other.acting = tuple(tuple(each) for each in acting)
        return other

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of options of each joint."""
        return tuple(len(each) for each in self.acting)

    @property
    def n_set(self) -> int:
        """Number of sets."""
        return int(np.prod([float(count) for count in self.counts]))

    @cached_property
    def holding(self) -> tuple[Array, Array]:
        """Wanted rest pose (n,) rad, and the torque (n,) N m that holds it against gravity."""
        pose = self.wanted.rest_pose
        return pose, static_torque(coefficients(self.leg), pose, self.leg.tilt)

    def rest(self, joint: int, rate: float) -> float:
        """Rotation (rad) at which a spring of this rate is unloaded, for a leg with the wanted rest pose."""
        pose, torque = self.holding
        return float(pose[joint] + torque[joint] / rate)

    @cached_property
    def columns(self) -> tuple[Array, ...]:
        """(ROWS, n_option) of each joint."""
        return tuple(
            np.stack([column(each.rate, self.rest(j, each.rate), each.damper) for each in options], axis=1)
            for j, options in enumerate(self.acting)
        )

    def chosen(self, index: Index) -> list[Array]:
        """Columns (ROWS, n_set) by joint of the sets with option numbers ``index`` (n_set, n)."""
        return [columns[:, index[:, j]] for j, columns in enumerate(self.columns)]

    def errors(self, index: Index) -> Array:
        """(n_set,) rad, RMS over joints of the difference from the wanted motion; see ``WantedResponse.overall``."""
        order = np.lexsort(index.T)  # sets with common parts are neighbours and share the integrator's steps
        found = np.empty(len(index))
        found[order] = self.errors_of(self.chosen(index[order]))
        return found

    def errors_of(self, columns: Sequence[Array]) -> Array:
        """The same for given columns (ROWS, n_lane), one array per joint."""
        return np.asarray(np.sqrt(np.sum(self._square(columns), axis=0) / len(self.acting)))

    def _square(self, columns: Sequence[Array]) -> Array:
        """(n_joint, n_lane) rad^2, mean over all samples of the releases; groups of lanes and releases in parallel."""
        n_lane, n_release = columns[0].shape[1], len(self.releases)
        # The groups of lanes do not depend on the number of threads, so the result is the same on any machine.
        share = min(CHUNK, LANES * -(-n_lane // (LANES * thread_count())))
        assert len(self._still) == n_release  # computed here, before threads use it

        def part(index: int) -> Array:
            group, k = divmod(index, n_release)
            return self._sum_of_squares(k, [each[:, group * share : (group + 1) * share] for each in columns])

        parts = in_parallel(part, n_release * -(-n_lane // share))
        sums = [np.sum(parts[first : first + n_release], axis=0) for first in range(0, len(parts), n_release)]
        mean = np.concatenate(sums, axis=1) / np.maximum(self._counts, 1)[:, None]
        return np.where(np.isfinite(mean), mean, np.pi**2)

    @cached_property
    def _still(self) -> list[Array]:
        """(n_row,) of each release: the chain's parameters that do not depend on the parts."""
        return [self.wanted.chain.parameters(self.leg, release.conditions) for release in self.releases]

    def _sum_of_squares(self, number: int, columns: Sequence[Array]) -> Array:
        """(n_joint, n_lane) rad^2, over the samples of one release in which each joint is free."""
        off = self._motion(number, columns) - self.motions[number][:, :, None]
        off[:, list(self.releases[number].conditions.locked)] = 0.0
        return np.asarray(np.sum(off**2, axis=0))

    def residuals(self, index: Index, every: int = 1) -> Array:
        """(n_sample, n_set) residuals whose squares sum to the squared error; of every ``every``-th motion sample."""
        chunks = [index[s : s + CHUNK] for s in range(0, len(index), CHUNK)]
        assert len(self._still) == len(self.releases)
        return np.concatenate(in_parallel(lambda k: self._residuals(chunks[k], every), len(chunks)), axis=1)

    def _residuals(self, index: Index, every: int) -> Array:
        columns, parts = self.chosen(index), []
        scale = np.where(self._counts > 0, 1.0 / np.sqrt(np.maximum(self._counts, 1) * len(columns) / every), 0.0)
        for k, (release, wanted) in enumerate(zip(self.releases, self.motions, strict=True)):
            off = (self._motion(k, columns)[::every] - wanted[::every, :, None]) * scale[:, None]
            off[:, list(release.conditions.locked)] = 0.0
            parts.append(off.reshape(-1, len(index)))
        return np.nan_to_num(np.concatenate(parts), nan=np.pi)

    @cached_property
    def _counts(self) -> Array:
        """(n,) number of samples in which each joint is free."""
        count = np.zeros(len(self.acting))
        for release in self.releases:
            free = [j for j in range(len(count)) if j not in release.conditions.locked]
            count[free] += len(release.time)
        return count

    def _motion(self, number: int, columns: Sequence[Array]) -> Array:
        """(n_time, n, n_lane) rad of the release with this number."""
        chain, release = self.wanted.chain, self.releases[number]
        layout = chain.layout
        lanes = np.repeat(self._still[number][:, None], columns[0].shape[1], axis=1)
        for j, values in enumerate(columns):
            for place, block in enumerate(("spring_rate", "rest", "damper_rate")):
                lanes[layout.row(block, j)] = values[place]
            for block, first in (("curve_speed", 3), ("curve_slope", 3 + CURVE_POINTS)):
                row = layout.row(block, j * CURVE_POINTS)
                lanes[row : row + CURVE_POINTS] = values[first : first + CURVE_POINTS]
        lanes[layout.rows("rotation")] = release.rotation[:, None]
        lanes[layout.rows("rate")] = release.rate[:, None]
        return chain.run(lanes, release.time, TOLERANCE)

"""Springs tuned to dampers: rates and free angles with which a leg moves most nearly as wanted.

Gauss-Newton with step halving on the simulated motions. Used to rank dampers, each with the spring tuned to it.

Many legs are tuned side by side. A leg has few unknowns, so that its nominal motion and the perturbed ones fill only
some of the sixteen lanes that the integrator moves at once; the lanes of several legs share them.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.design.response import WantedRelease, WantedResponse
from synth.fit.trajectories import FIT_STEPS, LanePlan
from synth.fit.unknowns import SpringsAndDampers
from synth.swing.chain import Chain, Conditions
from synth.swing.lane_layout import LANES
from synth.swing.leg_model import Leg, Spring
from synth.threads import in_parallel

TUNING_STEPS = 8  # Gauss-Newton steps at most; a gain below ``TUNED`` ends them earlier
TUNED_RELEASES = 7  # approximate number of releases that suffice to tune a spring; errors are computed over all
TUNED = 0.02  # relative reduction of the squared error below which the steps end
# Of the integrator. On the built-in example's dampers a step in log rate is then within 1e-3 of that with 1e-11 and
# central differences, as with 1e-7, for 0.6 of the time; with 1e-5 within 4e-3.
TOLERANCE = 1e-6
CHUNK = 4  # groups of lanes that one thread runs at a time

Linearised = tuple[Array, Array]  # residuals (n_sample,) rad, and their Jacobian (n_sample, n_unknown)


@dataclass(frozen=True)
class _Tuning:
    """A leg and the joints whose springs are tuned: its lanes, which are a nominal one and one for each unknown."""

    chain: Chain
    leg: Leg
    joints: tuple[int, ...]

    @cached_property
    def unknowns(self) -> SpringsAndDampers:
        """Rates and rests of the joints' springs."""
        return SpringsAndDampers(self.chain, self.leg, self.joints, self.joints, ())

    @cached_property
    def plan(self) -> LanePlan:
        """The perturbation of each lane."""
        return LanePlan.of(self.chain.layout.n, 2 * len(self.joints), (), (), 1.0)

    @cached_property
    def start(self) -> Array:
        """(n_unknown,) the leg's own springs."""
        return self.unknowns.pack(self.leg.spring_rate, self.leg.rest, np.zeros(len(self.leg.joints)))

    @cached_property
    def _still(self) -> dict[Conditions, Array]:
        """(n_row,) parameters under the conditions met so far."""
        return {}

    @property
    def n_lane(self) -> int:
        """Number of lanes; of more than sixteen every sixteenth is nominal."""
        return int(self.plan.common.shape[1])

    def lanes(self, release: WantedRelease, values: Array) -> Array:
        """(n_row, n_lane) at some values (n_unknown,) of the unknowns, at the start of a release."""
        layout, conditions = self.chain.layout, release.conditions
        if conditions not in self._still:
            self._still[conditions] = self.chain.parameters(self.leg, conditions)
        lanes = np.repeat(self._still[conditions][:, None], self.n_lane, axis=1)
        self.unknowns.write(lanes, values[:, None] + self.plan.common)
        lanes[layout.rows("rotation")], lanes[layout.rows("rate")] = release.rotation[:, None], release.rate[:, None]
        return lanes

    def search(self) -> Generator[Array, Linearised, Array]:
        """Yields values at which residuals and Jacobian are asked for, and returns those with the least squares."""
        values = self.start
        residual, jacobian = yield values
        for _ in range(TUNING_STEPS):
            step = _step(jacobian, residual)
            if step is None:
                break  # the springs are kept: the motion does not determine a step
            for halving in range(3):
                moved = np.clip(values + step * 0.5**halving, self.unknowns.lower, self.unknowns.upper)
                new_residual, new_jacobian = yield moved
                if new_residual @ new_residual < residual @ residual:
                    break
            else:
                break
            gain = 1 - (new_residual @ new_residual) / (residual @ residual)
            values, residual, jacobian = moved, new_residual, new_jacobian
            if gain < TUNED:
                break
        return values

    def with_springs(self, values: Array) -> Leg:
        """The leg with these values (n_unknown,) of the unknowns."""
        natural, changed = self.unknowns.natural(values), list(self.leg.joints)
        for place, j in enumerate(self.joints):
            joint, rest = changed[j], float(natural[len(self.joints) + place])
            changed[j] = replace(joint, spring=Spring(float(natural[place]), joint.zero + joint.sign * rest))
        return replace(self.leg, joints=tuple(changed))


def tuned_legs(wanted: WantedResponse, legs: Sequence[Leg], joints: Sequence[Sequence[int]]) -> list[Leg]:
    """The legs, each with the spring rates and free angles of its ``joints`` tuned to the wanted motion."""
    tunings = [_Tuning(wanted.chain, leg, tuple(own)) for leg, own in zip(legs, joints, strict=True)]
    searches, found = [tuning.search() for tuning in tunings], list(legs)
    asked = {k: next(search) for k, search in enumerate(searches)}
    while asked:
        numbers = list(asked)
        answers = _linearised(wanted, [tunings[k] for k in numbers], [asked[k] for k in numbers])
        for k, answer in zip(numbers, answers, strict=True):
            try:
                asked[k] = searches[k].send(answer)
            except StopIteration as ended:
                found[k] = tunings[k].with_springs(ended.value)
                del asked[k]
    return found


def _linearised(wanted: WantedResponse, tunings: Sequence[_Tuning], values: Sequence[Array]) -> list[Linearised]:
    """Of each leg the residuals from the wanted motion, over at most about ``TUNED_RELEASES`` releases."""
    every = max(1, len(wanted.releases) // TUNED_RELEASES)
    releases, motions = wanted.releases[::every], wanted.motions[::every]
    shares = _shares([tuning.n_lane for tuning in tunings])
    # A share is what one thread runs at a time; it does not depend on their number, nor does the result.
    chunks = [shares[first : first + CHUNK] for first in range(0, len(shares), CHUNK)]

    def part(number: int) -> list[Linearised]:
        chunk, k = divmod(number, len(releases))
        groups = [[(tunings[t], values[t]) for t in group] for group in chunks[chunk]]
        return _of_release(releases[k], motions[k], groups)

    parts = in_parallel(part, len(chunks) * len(releases))
    found: list[Linearised] = []
    for chunk in range(len(chunks)):
        for each in zip(*parts[chunk * len(releases) : (chunk + 1) * len(releases)], strict=True):
            found.append((np.concatenate([r for r, _ in each]), np.concatenate([j for _, j in each])))
    return found


def _shares(widths: Sequence[int]) -> list[list[int]]:
    """The numbers of legs whose lanes share a group, in order; ``widths`` : their numbers of lanes."""
    shares: list[list[int]] = []
    free = 0
    for number, width in enumerate(widths):
        if width > free:
            shares.append([])
            free = LANES
        shares[-1].append(number)
        free -= width
    return shares


def _of_release(
    release: WantedRelease, wanted: Array, groups: Sequence[Sequence[tuple[_Tuning, Array]]]
) -> list[Linearised]:
    """Of each leg in groups the residuals from a release's ``wanted`` motion (m, n) rad, and their Jacobian."""
    chain = groups[0][0][0].chain
    each = [(tuning, tuning.lanes(release, values)) for group in groups for tuning, values in group]
    widths = [sum(tuning.n_lane for tuning, _ in group) for group in groups]
    # A leg of more than sixteen lanes fills several groups, each with a nominal lane of its own.
    starts = np.cumsum([0, *widths])[:-1]
    between = [at for start, width in zip(starts, widths, strict=True) for at in range(start, start + width, LANES)][1:]
    out = _run(chain, release, np.concatenate([lanes for _, lanes in each], axis=1), between)
    first, found = 0, []
    for tuning, lanes in each:
        own = out[:, :, first : first + tuning.n_lane]
        first += tuning.n_lane
        if len(each) > 1 and not np.all(np.isfinite(own[-1])):  # one that diverges may end those beside it
            own = _run(chain, release, lanes, range(LANES, tuning.n_lane, LANES))
        slopes = (own[:, :, tuning.plan.moved] - own[:, :, tuning.plan.still]) / tuning.plan.width
        residual = np.nan_to_num(own[:, :, 0] - wanted, nan=np.pi).ravel()
        found.append((residual, np.nan_to_num(slopes).reshape(len(residual), -1)))
    return found


def _run(chain: Chain, release: WantedRelease, lanes: Array, between: Sequence[int]) -> Array:
    """(m, n, n_lane) rad of lanes whose groups are split before these indices."""
    return chain.run(chain.acting.groups(lanes, between), release.time, TOLERANCE, max_steps=FIT_STEPS)


def _step(jacobian: Array, residual: Array) -> Array | None:
    """Damped Gauss-Newton step (n_unknown,); None if the motion does not determine one.

    The derivatives of a diverging motion are so large that their squares overflow.
    """
    with np.errstate(all="ignore"):
        normal, side = jacobian.T @ jacobian, jacobian.T @ residual
    if not (np.all(np.isfinite(normal)) and np.all(np.isfinite(side))):
        return None
    damped = normal + np.diag(1e-4 * np.diag(normal) + 1e-12)
    try:
        # A logarithm of at most 0.7, a factor of two: beyond it the linearisation is invalid.
        return np.asarray(np.clip(-np.linalg.solve(damped, side), -0.7, 0.7))
    except np.linalg.LinAlgError:
        return None

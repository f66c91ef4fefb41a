"""Draws of the fit's unknowns with their correlation: legs consistent with the trials.

Separate intervals lose the correlation: on a ridge k and b may both be wrong by half, but only
together. Choices that depend on the fit use these draws instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import spectrum
from synth.fit.bootstrap import Bootstrap
from synth.fit.diverged_fit import divergence_refused
from synth.fit.link_errors import LinkErrors
from synth.fit.random_streams import Stream
from synth.fit.unknowns import SpringsAndDampers
from synth.swing.leg_model import Joint, Leg

DRAWS = 64  # legs consistent with the trials, for each of which the parts are scored


@divergence_refused()
def draws(values: Array, covariance: Array, refits: Bootstrap | None, links: LinkErrors | None, seed: int) -> Array:
    """(DRAWS, p) unknowns: the bootstrap's refits if available, else normal with the sensitivities' covariance.

    ``links`` : errors of the links' parameters also move all unknowns of a draw together.
    """
    generator = Stream.LEGS.generator(seed)
    moved = np.zeros((DRAWS, len(values)))
    if links is not None:
        sensitivity = links.considered.sensitivity
        moved = generator.normal(size=(DRAWS, sensitivity.shape[1])) @ sensitivity.T
    if refits is not None:
        return refits.values[:DRAWS] + moved[: len(refits.values)]
    root = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    value, vector = spectrum(covariance, root)
    half = vector * np.sqrt(np.maximum(value, 0.0))
    normal = generator.normal(size=(DRAWS, len(values)))
    return np.asarray(values + normal @ half.T * root + moved)


@dataclass(frozen=True, eq=False)
class DrawnLegs(Sequence[Leg]):
    """The leg with each draw of its springs and dampers, made when it is asked for; known damper curves are kept.

    ``values`` : (n_draw, n_unknown), within the bounds of the search; ``kept`` : joints that are not estimated.
    """

    unknowns: SpringsAndDampers
    values: Array
    kept: tuple[Joint, ...] = ()

    @classmethod
    def of(cls, unknowns: SpringsAndDampers, drawn: Array) -> DrawnLegs:
        """From draws (n_draw, n_unknown) that may be outside the bounds."""
        return cls(unknowns, np.clip(drawn, unknowns.lower, unknowns.upper))

    def __len__(self) -> int:
        """Number of draws."""
        return len(self.values)

    @overload
    def __getitem__(self, index: int) -> Leg: ...

    @overload
    def __getitem__(self, index: slice) -> DrawnLegs: ...

    def __getitem__(self, index: int | slice) -> Leg | DrawnLegs:
        """One leg, or some."""
        if isinstance(index, slice):
            return DrawnLegs(self.unknowns, self.values[index], self.kept)
        return leg_with(self.unknowns.fitted_leg(self.values[index]), self.kept)


def leg_with(leg: Leg, kept: Sequence[Joint]) -> Leg:
    """The leg with these joints in place of those of their names."""
    given = {joint.name: joint for joint in kept}
    return replace(leg, joints=tuple(given.get(joint.name, joint) for joint in leg.joints)) if given else leg

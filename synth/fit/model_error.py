"""What a fit's intervals must include beside noise and the links: that the leg's law is not that of the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.fit.random_streams import Stream


@dataclass(frozen=True)
class ModelError:
    """``moved`` (p, c) change of the common unknowns per standard deviation of each independent error; ``sentence``.

    ``by_links`` (p, c') more change per deviation of each of the links' parameters than with the model's law held, in
    the order of ``LinkErrors.names``; None for none.
    """

    moved: Array
    sentence: str
    by_links: Array | None = None

    @property
    def covariance(self) -> Array:
        """(p, p) of the common unknowns."""
        return np.asarray(self.moved @ self.moved.T)

    def added_to(self, drawn: Array, seed: int) -> Array:
        """Draws (k, p) of the unknowns with these errors in them."""
        size = Stream.MODEL_ERROR.generator(seed).normal(size=(len(drawn), self.moved.shape[1]))
        return np.asarray(drawn + size @ self.moved.T)

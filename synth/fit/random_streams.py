"""Random numbers of a fit: a stream of its own for each thing drawn, so that two independent errors are independent."""

from __future__ import annotations

from enum import IntEnum, unique

import numpy as np


@unique
class Stream(IntEnum):
    """What is drawn, and the number of its stream beside the seed. The numbers are names: they count nothing."""

    MODEL_ERROR = 1
    LEGS = 64
    REFITS = 200
    WANTED = 7
    MEAN_FREE_ANGLE = 3

    def generator(self, seed: int) -> np.random.Generator:
        """The stream's generator; the same for the same ``seed``."""
        return np.random.default_rng([seed, self])

"""Choosing without a part is no worse than the listed exchange: a small sample of ``design.removal``."""

from __future__ import annotations

import numpy as np
import pytest

from design.removal import WORSE, case


@pytest.mark.parametrize("seed", [pytest.param(seed, marks=pytest.mark.slow) for seed in (5, 39, 149)])
def test_removing_a_part_is_no_worse_than_the_listed_exchange(seed: int) -> None:
    one = case(seed)
    assert one.outcome == "made"
    assert one.listed is not None
    assert one.found is not None
    assert np.isfinite(one.listed)
    assert one.worse <= WORSE

"""A choice without a part never loses to what the choice with it had listed: a small sample of ``design.removal``."""

from __future__ import annotations

import numpy as np
import pytest

from design.removal import WORSE, case


@pytest.mark.parametrize("seed", [2, 5])
def test_without_a_part_the_result_is_no_worse_than_the_exchange_that_was_listed(seed: int) -> None:
    one = case(seed)
    assert one.outcome == "made"
    assert one.listed is not None
    assert one.found is not None
    assert np.isfinite(one.listed)
    assert one.worse <= WORSE

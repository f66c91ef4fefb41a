"""Priors of parameters and their whitened coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from synth.estimation.parameters import Prior, positive, signed, size, stiff


@pytest.mark.parametrize(
    "prior",
    [
        stiff(10.0, 1e3),
        Prior(np.inf, 0.1, lower=0.0, upper=1e3, inverse=True),
        Prior(5.0, 0.1, lower=0.5, upper=40.0, inverse=True),
        size(2.0),
        signed(2.0, 3.0),
        positive(1.0, 0.5, 0.2, 4.0),
        positive(1.0, 0.5),
    ],
)
def test_every_coordinate_of_the_span_is_within_the_bounds(prior: Prior) -> None:
    low, high = prior.span(8.0)
    assert -8.0 <= low < high <= 8.0
    inside = np.linspace(low, high, 9)
    values = prior.value(inside)
    assert np.all((prior.lower <= values) & (values <= prior.upper))
    assert prior.coordinate(values) == pytest.approx(inside, abs=1e-9)  # none was truncated


def test_a_compliance_needs_a_stiffest_value() -> None:
    with pytest.raises(ValueError, match="finite upper bound"):
        Prior(np.inf, 0.1, lower=0.5, inverse=True)

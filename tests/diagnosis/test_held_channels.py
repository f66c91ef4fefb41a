"""Channels that are read less often than the file has rows."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.simulated_releases import TIME, TWO, recorded
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.check.held_channels import held_finding
from synth.fit.recordings import recordings


def found(change: str, times: int = 4) -> Finding | None:
    """Of a knee whose readings are changed so."""
    (recording,) = recordings(TWO, recorded(TWO, np.array([[0.5, 0.6]]), held_out=0), ())
    reading = recording.rotation[:, 1]
    if change == "held":
        reading[:] = np.repeat(reading[::times], times)[: len(reading)]
    elif change == "counts":
        reading[:] = 0.02 * np.round(reading / 0.02)
    elif change == "ramp":  # counts of a servo that turns at one speed: each stands for four rows
        reading[:] = 0.01 * np.floor(np.arange(len(reading)) / 4.0)
    return held_finding(recording, 1, "knee")


@pytest.mark.parametrize("times", [2, 3, 4, 6])
def test_a_slower_channel_is_told_with_its_rate(times: int) -> None:
    told = found("held", times)
    assert told is not None
    rate = 1.0 / (times * (TIME[1] - TIME[0]))
    assert f"its readings each stand {times} times: this channel is read at {rate:.3g} Hz" in told.text


@pytest.mark.parametrize("change", ["", "counts", "ramp"])
def test_other_readings_are_not(change: str) -> None:
    assert found(change) is None

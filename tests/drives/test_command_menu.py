"""Suggested commands stay within the limits of the recorded ones."""

from __future__ import annotations

import numpy as np
import pytest

from synth.diagnosis.plants.swinging_chain import command_menu
from synth.diagnosis.plants.swinging_chain.command_menu import CommandLimits


@pytest.mark.parametrize("what", list(command_menu._shapes()))
@pytest.mark.parametrize("speed", [0.8, 6.0])
def test_no_command_leaves_the_range_or_is_too_fast(what: str, speed: float) -> None:
    limits = CommandLimits(np.array([-0.4]), np.array([1.0]), np.array([speed]))
    time = np.arange(0.0, command_menu.LENGTH, 1.0 / command_menu.RATE)
    command = command_menu._within(command_menu._shapes()[what], time, limits, 0)
    assert command.min() >= -0.4 - 1e-12
    assert command.max() <= 1.0 + 1e-12
    assert np.abs(np.diff(command)).max() * command_menu.RATE <= speed * (1.0 + 1e-9)
    assert np.ptp(command) > 0.1 * 1.4  # and it moves

"""The socket of a link's tube: flats for its screw's head and nut leave a printable wall at every tube and wall."""

from __future__ import annotations

from dataclasses import replace

import pytest

from synth.cad.fittings import PrintDimensions
from synth.cad.layout import place
from synth.cad.least_joint import least_joint
from synth.cad.link_socket import socket_radius, socket_screw

THINNEST = PrintDimensions().thinnest


@pytest.mark.parametrize("width", [6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 40.0, 80.0])
@pytest.mark.parametrize("wall", [1.2, 1.6, 2.0, 3.0, 4.0])
def test_the_flats_leave_a_wall_that_prints(width: float, wall: float) -> None:
    """Of a wall of 1.6 mm round a tube of 8 mm an M3 screw left 0.42 mm, and the finished joint failed its checks."""
    outer, inside = socket_radius(width, 0.1, wall), width / 2 + 0.1
    screw = socket_screw(outer)
    assert screw is not None
    assert screw.flat - inside >= THINNEST
    assert outer >= inside + wall
    assert outer - inside - wall < 2.0


def test_a_usual_socket_is_a_wall_round_its_tube() -> None:
    joint = least_joint(8.0, 0.4, 3.0, (20.0, 1.5))
    assert place(joint).socket_outer == 20.0 / 2 + joint.fit + 3.0
    thin = replace(joint, link_width=8.0, wall=1.6)
    assert place(thin).socket_outer > 4.0 + joint.fit + 1.6


def test_a_tube_too_wide_for_any_screw_keeps_its_wall_for_the_message() -> None:
    assert socket_screw(socket_radius(140.0, 0.1, 3.0)) is None
    assert socket_radius(140.0, 0.1, 3.0) == 140.0 / 2 + 0.1 + 3.0

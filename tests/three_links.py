"""A leg of three links with releases, and options of springs and dampers for it, for the tests of choosing."""

from __future__ import annotations

import numpy as np

from synth.design.part_lanes import ActingElements
from synth.design.response import WantedRelease, WantedResponse
from synth.parts.damper_law import power_law_curve
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIME = np.linspace(0.0, 1.2, 41)
LEG = Leg(
    "three links",
    (
        Joint("hip", Link(0.2, 0.7, 0.09, 3e-3), np.pi / 2, 1, None, Spring(18.0, 1.7), Damper(1.0)),
        Joint("knee", Link(0.2, 0.3, 0.08, 1.2e-3), np.pi, -1, None, Spring(2.0, 2.0), Damper(0.12)),
        Joint("ankle", Link(0.16, 0.1, 0.06, 3e-4), np.pi, 1, None, Spring(0.5, 2.4), Damper(0.03)),
    ),
)


def wanted() -> WantedResponse:
    """Two releases of the leg itself."""
    releases = [
        WantedRelease("a", TIME, np.array([0.1, 1.4, -0.5]), np.zeros(3), Conditions()),
        WantedRelease("b", TIME, np.array([0.5, 0.8, -1.0]), np.array([0.0, -2.0, 1.0]), Conditions()),
    ]
    return WantedResponse.of(LEG, releases)


def grid(n_damper: int, n_spring: int, spread: float = 2.5, seed: int = 0) -> list[list[ActingElements]]:
    """Concave dampers and springs about those of the leg, each joint in an order of its own."""
    generator = np.random.default_rng(seed)
    options = []
    for joint in LEG.joints:
        assert joint.spring is not None
        assert joint.damper is not None
        assert joint.damper.rate is not None
        found = []
        for factor in np.geomspace(1.0 / spread, spread, n_damper) * generator.uniform(0.93, 1.07, n_damper):
            damper = Damper(curve=power_law_curve(joint.damper.rate * float(factor) * 2.0, 5.0, 0.7))
            for part in np.geomspace(0.6, 1.7, n_spring) * generator.uniform(0.95, 1.05, n_spring):
                found.append(ActingElements(joint.spring.rate * float(part), damper))
        options.append([found[k] for k in generator.permutation(len(found))])
    return options

"""A target whose links do not make the animal's motion: the design says so first, however near its parts come.

The motion is a bob on a string, tracked in a video: every sample from 0.304 to 2.569 s of
``lab3/report/trial1_rawdata.txt`` of github.com/tylertian123/phy180_lab (time in s, angle in rad), rounded to 1e-3 rad.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from page_reader import page_of
from synth.api.designs import Design
from synth.api.designs import design as design_of
from synth.commands.leg_parts import parts_text
from synth.remarks import severity_of

FRAME = 0.033802817  # s
ANGLES = """
-1.427 -1.408 -1.367 -1.316 -1.246 -1.156 -1.051 -0.934 -0.803 -0.672 -0.527 -0.374 -0.219 -0.058 0.109 0.261
0.415 0.558 0.697 0.827 0.957 1.055 1.148 1.231 1.291 1.336 1.360 1.369 1.367 1.342 1.305 1.246 1.167 1.081
0.976 0.862 0.732 0.595 0.441 0.295 0.135 -0.025 -0.184 -0.340 -0.497 -0.642 -0.773 -0.892 -1.006 -1.092
-1.175 -1.244 -1.289 -1.316 -1.332 -1.332 -1.313 -1.278 -1.225 -1.159 -1.077 -0.987 -0.869 -0.750 -0.625
-0.493 -0.348 -0.201
"""
LEG = """kind: leg
name: {name}
joints:
  - name: pivot
    zero: 0 deg
    sign: +1
    link: {{length: {length} mm, mass: 300 g, com: {com} mm, inertia: {inertia} kg*m^2}}
"""
PROJECT = """kind: leg-design
name: pendulum
source: {leg: bob.leg.yaml, trials: [bob.csv]}
scale: {time: froude}
target: target.leg.yaml
"""


def _designed(folder: Path, com: float, inertia: float) -> tuple[Design, dict[str, Any]]:
    """The design and its JSON, stored in ``out``, for a link of 200 mm; ``com`` in mm, ``inertia`` in kg m^2."""
    (folder / "bob.leg.yaml").write_text(LEG.format(name="bob", length=735, com=716, inertia=2e-5))
    (folder / "target.leg.yaml").write_text(LEG.format(name="target", length=200, com=com, inertia=inertia))
    angles = np.array(ANGLES.split(), float)
    rows = [f"{FRAME * i:.6f},{angle}" for i, angle in enumerate(angles.tolist())]
    (folder / "bob.csv").write_text("\n".join(["time [s],pivot [rad]", *rows]) + "\n")
    (folder / "leg-design.yaml").write_text(PROJECT)
    made = design_of(folder / "leg-design.yaml", solids=False)
    made.save(folder / "out")
    return made, json.loads((folder / "out" / "design.json").read_text())


@pytest.mark.filterwarnings("ignore")
def test_links_that_do_not_make_the_motion_are_said_first(tmp_path: Path) -> None:
    """A link that swings 1.2 times too fast: of the whole recording, 4 deg were told first, and 45 in a note."""
    made, document = _designed(tmp_path, com=100, inertia=1.2e-3)
    (said,) = [text for _, text in made.design.warnings if "no nearer to the scaled motion" in text]
    assert severity_of(said) == "decide"
    assert "the motion that is wanted of its parts is another one" in said
    found = document["response"]["animal_to_wanted"]
    assert found["another_motion"] == ["pivot"]
    off = found["joints"]["pivot"]["value"]
    assert off > 10.0
    assert f"The wanted motion is not the animal's, which the robot's links do not make: {off:.3g} deg" in parts_text(
        document
    )
    assert "at pivot not the animal's" in made.headline
    html, _ = page_of(tmp_path / "out" / "report.html")
    assert "but that is not the animal" in html.split("<nav")[0]


@pytest.mark.filterwarnings("ignore")
def test_links_that_make_the_motion_are_not(tmp_path: Path) -> None:
    made, document = _designed(tmp_path, com=190, inertia=4e-5)
    found = document["response"]["animal_to_wanted"]
    assert found["another_motion"] == []
    assert found["joints"]["pivot"]["value"] < 6.0
    assert "not the animal's" not in parts_text(document) + made.headline

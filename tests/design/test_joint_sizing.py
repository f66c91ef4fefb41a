"""What is told of a joint that grew until it bore its loads."""

from __future__ import annotations

from dataclasses import replace

from cad_joints import cleared
from synth.cad import (
    AdapterDimensions,
    DamperDimensions,
    JointDimensions,
    LoadDimensions,
    PrintDimensions,
    SpringDimensions,
    sized,
)
from synth.design.joint_sizing import _grown

KNEE = JointDimensions("knee", SpringDimensions(3.429, 26.035, 7.17, 120.0), 111.0, 119.0)


def test_the_note_of_a_grown_joint_names_the_adapter_s_grip() -> None:
    """It grew without a word."""
    damper = DamperDimensions(adapter=AdapterDimensions(form="d"))
    asked = cleared(replace(KNEE, damper=damper, loads=LoadDimensions(2.0, 6.0)))
    grown = sized(asked, PrintDimensions())
    assert grown.damper.adapter is not None
    grip = grown.damper.adapter.output_grip
    assert grip > 12.0
    assert f"damper's shaft in the adapter {grip:g} mm instead of 12" in _grown(asked, grown)
    assert _grown(asked, asked) == []

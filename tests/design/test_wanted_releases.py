"""The wanted releases that a fit provides."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from synth.design.stages import releases


def test_a_trial_whose_free_angle_shifted_is_wanted_about_the_common_one() -> None:
    """The release turns by as much as the free angle shifted, in the sense of q."""
    common = {"hip": 1.5, "knee": 2.0}
    joints = {name: SimpleNamespace(free_angle=SimpleNamespace(value=value)) for name, value in common.items()}
    leg = SimpleNamespace(joint_names=("hip", "knee"), sign=np.array([1.0, -1.0]))
    trial = SimpleNamespace(rotation=np.array([0.3, -0.4]), rate=np.array([1.0, 2.0]), free_angle=np.array([1.45, 2.1]))
    recording = SimpleNamespace(name="one.csv", time=np.arange(3.0), conditions=None)
    (found,) = releases([recording], SimpleNamespace(leg=leg, joints=joints, trials=[trial]))  # type: ignore[list-item, arg-type]
    np.testing.assert_allclose(found.rotation, [0.35, -0.3], atol=1e-15)
    np.testing.assert_array_equal(found.rate, [1.0, 2.0])

"""MuJoCo's warnings, which it otherwise adds to a file ``MUJOCO_LOG.TXT`` in the folder that the user is in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def heard_warnings(mujoco: Any) -> Iterator[list[str]]:
    """The warnings of the module ``mujoco`` until the end of the block, as they come."""
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        yield heard
    finally:
        mujoco.set_mju_user_warning(before)

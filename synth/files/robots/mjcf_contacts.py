"""Contacts that an MJCF file allows: which bodies may touch by MuJoCo's rules (Computation, *Collision detection*)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.files.robots.robot_tree import RobotContact


def contacts_of(mujoco: Any, model: Any) -> tuple[RobotContact, ...]:
    """Pairs of bodies that move relative to each other and have shapes that may collide, each pair once.

    Two shapes may if the type of either meets the affinity of the other, except between a body and its parent (unless
    that is fixed in the world) and in excluded pairs; pairs that the file lists may in any case.
    """
    disabled = mujoco.mjtDisableBit
    flags = int(model.opt.disableflags)
    if flags & (int(disabled.mjDSBL_CONTACT) | int(disabled.mjDSBL_CONSTRAINT)):
        return ()
    body, weld = np.array(model.geom_bodyid), np.array(model.body_weldid)
    parent = weld[np.array(model.body_parentid)[weld]]
    own, excluded = weld[body], {int(each) for each in model.exclude_signature}
    found: dict[tuple[int, int], tuple[int, int]] = {}
    for geom in np.flatnonzero(own != 0):  # what is fixed in the world touches nothing by itself
        meets = (model.geom_contype[geom] & model.geom_conaffinity) | (
            model.geom_conaffinity[geom] & model.geom_contype
        )
        may = (meets != 0) & (own != own[geom])
        if not flags & int(disabled.mjDSBL_FILTERPARENT):
            may &= (own == 0) | ((own != parent[own[geom]]) & (parent[own] != own[geom]))
        for other in np.flatnonzero(may & ((own == 0) | (own > own[geom]))):
            if not {_signature(body[geom], body[other]), _signature(body[other], body[geom])} & excluded:
                found.setdefault((int(body[geom]), _place(own, body, int(other))), (int(geom), int(other)))
    for geom, other in zip(model.pair_geom1, model.pair_geom2, strict=True):
        one, two = (geom, other) if own[geom] and not 0 < own[other] < own[geom] else (other, geom)
        if own[one] != own[two]:
            found.setdefault((int(body[one]), _place(own, body, two)), (int(one), int(two)))
    return tuple(
        RobotContact(int(body[one]) - 1, -1 if own[two] == 0 else int(body[two]) - 1, _title(mujoco, model, two))
        for one, two in found.values()
    )


def _place(own: NDArray[np.int32], body: NDArray[np.int32], geom: int) -> int:
    """A number of the body that the shape is on; of each shape that is fixed in the world another one, below 0."""
    return int(body[geom]) if own[geom] else -1 - int(geom)


def _signature(one: int, other: int) -> int:
    """MuJoCo's number of an excluded pair of bodies."""
    return (int(one) << 16) + int(other)


def _title(mujoco: Any, model: Any, geom: int) -> str:
    """The shape's name or else its body's, which of the world is "world"."""
    kinds = mujoco.mjtObj
    body = int(model.geom_bodyid[geom])
    own = mujoco.mj_id2name(model, kinds.mjOBJ_GEOM, int(geom)) if int(model.body_weldid[body]) == 0 else ""
    return own or mujoco.mj_id2name(model, kinds.mjOBJ_BODY, body) or f"body {body}"

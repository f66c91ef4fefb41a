"""The same drawing gives the same bytes, in whatever order a set is gone through."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from synth.cad.dxf import drawing


def written(path: Path) -> bytes:
    with drawing(path) as (_, space):
        space.add_circle((0.0, 0.0), 2.0)
        space.add_lwpolyline([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], close=True)
    return path.read_bytes()


@pytest.mark.parametrize("order", [sorted, lambda names: sorted(names, reverse=True)])
def test_classes_stand_in_an_order_of_their_own(
    order: Callable[[Any], list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ezdxf.entitydb import EntityDB

    usual = written(tmp_path / "usual.dxf")
    in_use = EntityDB.dxf_types_in_use
    monkeypatch.setattr(EntityDB, "dxf_types_in_use", lambda self: order(in_use(self)))
    assert written(tmp_path / "other.dxf") == usual

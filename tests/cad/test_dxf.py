"""A drawing gives the same bytes whatever the iteration order of sets."""

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
def test_dxf_classes_are_written_in_a_fixed_order(
    order: Callable[[Any], list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ezdxf.entitydb import EntityDB

    usual = written(tmp_path / "usual.dxf")
    in_use = EntityDB.dxf_types_in_use
    monkeypatch.setattr(EntityDB, "dxf_types_in_use", lambda self: order(in_use(self)))
    assert written(tmp_path / "other.dxf") == usual

"""Parts that a leg file names, looked up in the catalogues."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Literal

from synth.errors import UserError
from synth.swing.leg_model import Damper

if TYPE_CHECKING:
    from synth.parts.catalogs import Catalogue


def resolver(catalogue: Catalogue | None = None) -> Callable[[Literal["spring", "damper"], str], float | Damper]:
    """The part lookup of ``read_leg``: a spring's rate in N m/rad, or the damper with its default law.

    ``catalogue`` None: the built-in ones, loaded on first use, since most legs name no part.
    """

    @cache
    def searched() -> Catalogue:
        from synth.parts.catalogs import Catalogue  # local: most legs name no part, and loading takes time

        return Catalogue.load() if catalogue is None else catalogue

    def resolve(kind: Literal["spring", "damper"], part: str) -> float | Damper:
        if kind == "damper":
            row = searched().find_damper(part)
            if row.max_torque is None or row.speed is None:
                raise UserError(f"damper {row.part} ({row.place}) cannot be used: {row.status}")
            return row.damper()
        spring = searched().find_spring(part)
        if spring.rate is None:
            raise UserError(f"spring {spring.part} ({spring.place}) cannot be used: {spring.status}")
        return spring.rate

    return resolve

"""The file of ``synth catalog show``: the requirements of one joint for its spring and damper.

  kind: part-wish
  spring: {rate: 2.2 N*m/rad, rate_tolerance: 5 %, included_angle: 120 deg, max_outer_diameter: 1.25 in, travel: 40 deg}
  damper: {torque: 0.1 N*m, speed: 10 rpm, torque_tolerance: 50 %, ratios: [1, 2]}
  catalogs: [my_parts/*.csv]
  vendors: [Lee Spring]

Keys of ``spring`` and ``damper`` are those of a leg design's ``select`` that apply to bought parts, plus the
values that a fit would give.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from synth.files.named_files import ProjectReader
from synth.files.project_options import DamperBounds, PartsOptions, Share, SpringBounds
from synth.files.spring_words import System
from synth.files.validate import Quantity, Title

Names = Annotated[list[str], Field(examples=["[Lee Spring]"])]


@dataclass(frozen=True)
class RequestedSpring(SpringBounds):
    """A spring and its rate, N m/rad; None: any."""

    rate: Annotated[float | None, Quantity("N*m/rad", above=0)] = None


@dataclass(frozen=True)
class RequestedDamper(DamperBounds):
    """A damper and its wanted torque, N m, at a speed of the joint, rad/s; None: any."""

    torque: Annotated[float | None, Quantity("N*m", above=0), Field(examples=["0.1 N*m"])] = None
    speed: Annotated[float | None, Quantity("rad/s", above=0)] = None
    torque_tolerance: Share = 0.5


@dataclass(frozen=True)
class PartRequest:
    """The wish; ``spring`` or ``damper`` None: not requested."""

    path: Path
    spring: RequestedSpring | None
    damper: RequestedDamper | None
    catalogs: tuple[Path, ...]
    parts: PartsOptions


@dataclass(frozen=True)
class _RequestFile:
    kind: str
    name: Title | None = None
    spring: Any = None
    damper: Any = None
    catalogs: list[str] = field(default_factory=list)
    vendors: Names = field(default_factory=list)
    without: Names = field(default_factory=list)
    system: System | None = None


def read_part_request(path: str | Path) -> PartRequest:
    """Read a file of kind ``part-wish``.

    Raises
    ------
    UserError
        With every mistake of the file.
    """
    reader = ProjectReader.open(path, "part-wish")
    written = reader.written
    file = reader.entry(_RequestFile, (), written)
    spring = damper = None
    if written.get("spring") is not None:
        spring = reader.entry(RequestedSpring, ("spring",), written["spring"])
    if written.get("damper") is not None:
        damper = reader.entry(RequestedDamper, ("damper",), written["damper"])
    if "spring" not in written and "damper" not in written:
        reader.refuse('requests nothing: write "spring" or "damper", such as spring: {rate: 2.2 N*m/rad}', ("kind",))
    if damper is not None and (damper.torque is None) != (damper.speed is None):
        reader.refuse("torque and speed belong together: give both or neither", ("damper",))
    catalogs = reader.matched(file.catalogs, ("catalogs",)) if file is not None else ()
    reader.finish()
    assert file is not None
    parts = PartsOptions(tuple(file.vendors), tuple(file.without), file.system)
    return PartRequest(reader.document.path, spring, damper, catalogs, parts)

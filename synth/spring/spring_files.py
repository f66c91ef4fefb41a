"""The output files of ``synth spring``: result, solid, winding sheet, request for quotation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.compiling.solid_kernel import load_cadquery
from synth.errors import Problem, UserError
from synth.files.output import umask, write_bytes_whole, write_json
from synth.files.shown_units import METRIC, ShownUnits
from synth.files.text_forms import json_text, plain
from synth.spring.spring_result import SpringDesign
from synth.spring.unit_text import in_units
from synth.spring.winding_sheet import JointTravel, request_lines, winding_sheet

if TYPE_CHECKING:
    from synth.cad import SpringDimensions

FORMAT = '"format": "synth/spring/'  # near the start of every file that may be replaced


def write_result(path: Path, content: Mapping[str, Any]) -> str:
    """Write the JSON atomically. An earlier result is replaced, any other file is not.

    Raises
    ------
    UserError
        If a file of another kind has that name, or the file cannot be written.
    """
    name = str(path)
    if "\0" in name:
        raise UserError(Problem("cannot be written: embedded null byte; name another place with --json", name))
    try:
        if path.exists() and not (path.is_file() and _is_result(path)):
            raise UserError(Problem("exists and is no result of synth spring; name another with --json", name))
        text = json_text(plain(content, ""), 0) + "\n"
        write_bytes_whole(path, text.encode(), 0o666 & ~umask())
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(Problem(f"cannot be written: {reason}; name another place with --json", name)) from None
    return name


def write_spring(
    spring: SpringDesign | None, content: Mapping[str, Any], folder: Path, shown: ShownUnits = METRIC
) -> None:
    """Write ``spring.json`` and, if there is a spring, its winding sheet, request for quotation and solid.

    The solid of a spring that cannot be drawn is left out; see ``reasons_not_drawn``.
    """
    write_json(folder / "spring.json", content)
    if spring is None:
        return
    from synth.reports import write_winding_sheet

    write_winding_sheet(folder, None if shown.system == "metric" else _in_units(spring, content, shown))
    (folder / "winding_sheet.txt").write_text(winding_sheet(spring, shown), encoding="utf-8")
    write_request(spring, shown, folder / "request_for_quotation.dxf")
    if not reasons_not_drawn(spring):
        write_solid(spring, folder)


def _in_units(spring: SpringDesign, content: Mapping[str, Any], shown: ShownUnits) -> dict[str, Any]:
    """The result's content in the displayed units, its sentences too, which are metric in the file."""
    said = {str(text): in_units(text, shown) for text in (*spring.warnings, *(v.text for v in spring.violations))}

    def worded(item: Any) -> Any:
        if isinstance(item, Mapping):
            return {name: worded(value) for name, value in item.items()}
        if isinstance(item, (list, tuple)):
            return [worded(value) for value in item]
        return said.get(str(item), str(item)) if isinstance(item, str) else item

    made: dict[str, Any] = worded(shown.throughout(content))
    return made


def write_request(
    spring: SpringDesign,
    shown: ShownUnits,
    path: Path,
    joint: JointTravel | None = None,
    hands: Sequence[str] = (),
) -> None:
    """Write the dimensioned drawing for a spring maker's quotation; ``joint`` and ``hands`` as in ``request_lines``."""
    from synth.cad.spring_request import SpringRequest, write_spring_request

    request = SpringRequest(
        wire=spring.wire_diameter * 1e3,
        mean=spring.mean_diameter * 1e3,
        coils=spring.body_coils,
        body=spring.body_length * 1e3,
        included_angle=math.degrees(spring.included_angle),
        arms=(spring.arm_lengths[0] * 1e3, spring.arm_lengths[1] * 1e3),
        hand=spring.hand,
        mirrored=len(set(hands)) > 1,
        lines=request_lines(spring, shown, joint, hands),
    )
    write_spring_request(request, path)


def reasons_not_drawn(spring: SpringDesign) -> list[str]:
    """Why there is no solid of a spring: its legs, or sizes beyond those that are drawn; empty if it can be drawn."""
    if spring.convention != "tangent":
        return [f"{spring.convention} legs cannot be drawn; tangent ones can"]
    return [f"it cannot be drawn: {problem}" for problem in _dimensions(spring).problems()]


def _dimensions(spring: SpringDesign) -> SpringDimensions:
    """The free spring as it is drawn."""
    from synth.cad import SpringDimensions

    return SpringDimensions(
        wire_diameter=spring.wire_diameter * 1e3,
        mean_diameter=spring.mean_diameter * 1e3,
        coils=spring.body_coils,
        included_angle=math.degrees(spring.included_angle),
        hand=spring.hand,
    )


def write_solid(spring: SpringDesign, folder: Path) -> None:
    """Draw the free spring, check the solid's volume by its closed form, write ``spring.step`` and ``spring.stl``.

    For a spring that can be drawn, see ``reasons_not_drawn``.
    """
    dimensions, arm = _dimensions(spring), spring.arm_lengths[0] * 1e3
    load_cadquery()
    import cadquery as cq

    from synth.cad.checks import check_part, require
    from synth.cad.export import write_step, write_stl
    from synth.cad.parts import BuiltPart, Mesh
    from synth.cad.torsion_spring import build_spring, spring_mesh, spring_volume

    solid = build_spring(dimensions, arm)
    mesh = Mesh(*spring_mesh(dimensions, arm))
    exact = spring_volume(dimensions, arm)
    part = BuiltPart("spring", "spring", "spring", solid, mesh, False, exact, "wound")
    require(tuple(check_part(part)))
    assembly = cq.Assembly(name="spring_part").add(solid, name="spring", color=cq.Color(*part.colour))
    write_step(assembly, folder / "spring.step")
    write_stl([mesh], folder / "spring.stl")


def _is_result(path: Path) -> bool:
    with path.open(encoding="utf-8", errors="replace") as stream:
        return FORMAT in stream.read(200)  # characters: the format is the first key

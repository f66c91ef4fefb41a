"""A picture of each failed check: the joint at that angle, the fault in red, everything else transparent."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from synth.cad.fittings import PrintDimensions
from synth.cad.joint import BuiltJoint
from synth.cad.leg_joints import BuiltLeg
from synth.cad.parts import Array, BuiltPart, Mesh
from synth.cad.preview import Camera, Item
from synth.cad.printing import WAYS_UP, hanging_faces, plan_part, thin_points
from synth.cad.results import CheckResult
from synth.cad.travel import OVERLAP_LIMIT, manifold

RED = (0.86, 0.10, 0.12)  # RGB of the fault in a picture
GLASS = 0.25  # opacity of everything else: the failed part shows through
MARK = 1.0  # mm, half the size of the mark at a thin place: some 8 of a picture's 800 pixels


def draw_failures(leg: BuiltLeg, checks: Sequence[CheckResult], folder: Path) -> dict[str, CheckResult]:
    """Write ``<part>_<check>.png`` for each failed check that can be drawn; return file name -> check.

    Raises
    ------
    PreviewError
        if this machine cannot draw.
    """
    failed = [check for check in checks if not check.passed]
    if not failed:
        return {}
    folder.mkdir(parents=True, exist_ok=True)
    camera = Camera()
    written: dict[str, CheckResult] = {}
    try:
        for check in failed:
            joint = next((j for j in leg.joints if any(p.name == check.part for p in j.parts)), None)
            if joint is None:
                continue
            name = _file_name(check, written)
            camera.draw(failure_items(joint, check, leg.dimensions.printing), folder / name,
                        view=(0.55, 0.35, 0.76 * joint.layout.flips[1]))  # fmt: skip
            written[name] = check
    finally:
        camera.close()
    return written


def _file_name(check: CheckResult, taken: dict[str, CheckResult]) -> str:
    words = "".join(c if c.isalnum() else "_" for c in f"{check.part}_{check.name}")
    stem = "_".join(word for word in words.split("_") if word)
    number = sum(name.startswith(stem) for name in taken)
    return f"{stem}{f'_{number + 1}' if number else ''}.png"


def failure_items(joint: BuiltJoint, check: CheckResult, printing: PrintDimensions) -> list[Item]:
    """The drawing of a failed check."""
    part = next(part for part in joint.parts if part.name == check.part)
    if check.angle is not None:
        return _show_meeting(joint, check.angle)
    if check.name == "print: wall":
        marks = _marks(thin_points(part.mesh, printing.thinnest))
        return [(part.mesh, part.colour, GLASS), *([(marks, RED, 1.0)] if len(marks.faces) else [])]
    if check.name == "print: support":
        faces = hanging_faces(part.mesh, WAYS_UP[plan_part(joint, part, printing).up], printing.overhang)
        return [(part.mesh, part.colour, GLASS), (Mesh(part.mesh.vertices, part.mesh.faces[faces]), RED, 1.0)]
    angle = joint.dimensions.rest_angle
    others: list[Item] = [(joint.mesh_at(p, angle), p.colour, GLASS) for p in joint.parts if p is not part]
    return [*others, (joint.mesh_at(part, angle), RED, 1.0)]


def _show_meeting(joint: BuiltJoint, angle: float) -> list[Item]:
    """The joint at an angle, and in red the common volume of two of its parts."""
    placed = [(part, joint.mesh_at(part, angle)) for part in joint.parts]
    items: list[Item] = [(mesh, part.colour, GLASS) for part, mesh in placed]
    solids = {part.name: manifold(mesh) for part, mesh in placed}
    for index, (first, _) in enumerate(placed):
        for second, _ in placed[index + 1 :]:
            if _is_fixed(first, second):
                continue
            shared = solids[first.name] ^ solids[second.name]
            if shared.volume() > OVERLAP_LIMIT:
                found = shared.to_mesh()
                vertices = np.asarray(found.vert_properties, dtype=np.float64)[:, :3]
                items.append((Mesh(vertices, np.asarray(found.tri_verts, dtype=np.int64)), RED, 1.0))
    return items


def _is_fixed(first: BuiltPart, second: BuiltPart) -> bool:
    return first.group == second.group


def _marks(points: Array) -> Mesh:
    """An octahedron at each point; its faces share no corners, so that no drawn edges cover its colour."""
    corners = MARK * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    sides = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    vertices = (points[:, None, None, :] + corners[sides]).reshape(-1, 3)
    return Mesh(vertices, np.arange(len(vertices), dtype=np.int64).reshape(-1, 3))

"""Export: STEP with names and colours, STL, pictures. The same leg gives the same STEP and STL bytes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from synth.cad.assembly import exploded_view, numbers_at
from synth.cad.checks import check_leg
from synth.cad.dxf import flat_brackets, write_flat
from synth.cad.joint import BuiltJoint
from synth.cad.leg_joints import BuiltLeg
from synth.cad.parts import BuiltPart, Mesh, file_name
from synth.cad.preview import Camera, Colour, PreviewError
from synth.cad.print_file import plates, write_3mf
from synth.cad.printing import plan_part
from synth.cad.results import CheckResult, require
from synth.cad.scene_file import write_glb
from synth.cad.step_text import normalised_step

Kind = Literal["step", "stl", "3mf", "glb", "dxf", "png"]
PART_FILES: tuple[Kind, ...] = ("step", "stl")
PICTURED = ("upper", "lower", "damper_bracket", "damper_adapter", "encoder_seat", "seat", "cap", "spring")
# Beginnings of the names of parts that cover the spring; the picture of the open joint leaves them out.
BEFORE_SPRING = ("upper", "seat", "encoder", "bearing_b", "collar_b", "thrust_washer_b")


@dataclass(frozen=True)
class ExportedFile:
    """One written file: its path relative to the folder, its kind, and its part or assembly."""

    path: str
    kind: Kind
    part: str


def export_leg(
    leg: BuiltLeg,
    folder: Path,
    *,
    checks: tuple[CheckResult, ...] | None = None,
    pictures: bool = True,
) -> list[ExportedFile]:
    """Write every part, every joint and the leg, after all checks have passed.

    Parts are written in their positions at the joint's free angle, in the joint's frame (mm, hinge axis on z, upper
    link along +y). Assemblies have every joint at its free angle, with the springs unloaded. A joint whose free angle
    lies beyond a stop is at the end of its travel instead: its spring is bent in the assembly's STL, and not in the
    STEP, which has no bent wire. GLB and pictures of the leg are in the rest pose, with bent springs. ``checks``: the
    results of the checks, if the caller has them.

    Raises
    ------
    GateError
        if a check fails, before anything is written.
    PreviewError
        if this machine cannot draw, after the parts are written; ``pictures=False`` leaves pictures out.
    OSError
        if the folder cannot be written.
    """
    require(check_leg(leg) if checks is None else checks)
    folder.mkdir(parents=True, exist_ok=True)
    written = [file for index in range(len(leg.joints)) for file in write_parts(leg, index, folder)]
    written += [file for index in range(len(leg.joints)) for file in write_assembly(leg, index, folder)]
    written += write_whole(leg, folder)
    if pictures:
        written += draw_leg(leg, folder)
    return written


def write_parts(leg: BuiltLeg, index: int, folder: Path) -> list[ExportedFile]:
    """STEP and STL of each part of one joint and of its link."""
    joint, link, written = leg.joints[index], leg.links[index], []
    angle = joint.dimensions.filed_angle
    for part in (*joint.parts, link):
        write_step(_assembly_of_part(part, joint.solid_at(part, angle)), folder / f"{part.name}.step")
        write_stl([joint.filed_mesh(part)], folder / f"{part.name}.stl")
        written += [ExportedFile(f"{part.name}.{kind}", kind, part.name) for kind in PART_FILES]
    return written


def write_whole(leg: BuiltLeg, folder: Path) -> list[ExportedFile]:
    """The leg's assembly, and the files for printing, viewing and cutting."""
    return [*write_assembly(leg, None, folder), *write_for_others(leg, folder)]


def write_for_others(leg: BuiltLeg, folder: Path) -> list[ExportedFile]:
    """The printed parts as 3MF, one file per plate of the bed's size; the leg as GLB; the flat brackets as DXF."""
    printing = leg.dimensions.printing
    plans = [(part, plan_part(joint, part, printing)) for joint in leg.joints for part in joint.parts if part.printed]
    write_glb(leg, folder / "leg.glb")
    written = [ExportedFile("leg.glb", "glb", "leg")]
    for number, plate in enumerate(plates(plans, printing.bed), start=1):
        name = f"leg_print_{number}.3mf"
        write_3mf(plate, folder / name, f"{leg.dimensions.name}, plate {number}")
        written.append(ExportedFile(name, "3mf", "leg"))
    for joint in leg.joints:
        for bracket in flat_brackets(joint):
            write_flat(bracket, folder / f"{bracket.name}.dxf")
            written.append(ExportedFile(f"{bracket.name}.dxf", "dxf", bracket.name))
    return written


def draw_leg(leg: BuiltLeg, folder: Path) -> list[ExportedFile]:
    """Pictures: each printed part and spring, each joint complete, open with its spring to be seen, and apart; the leg.

    Raises
    ------
    PreviewError
        when this machine cannot draw.
    """
    with _camera() as camera:
        written = [file for index in range(len(leg.joints)) for file in draw_joint(leg, index, folder, camera)]
        return [*written, *draw_whole(leg, folder, camera)]


@contextmanager
def _camera(given: Camera | None = None) -> Iterator[Camera]:
    """The given camera, or one that is closed at the end."""
    camera = given or Camera()
    try:
        yield camera
    finally:
        if given is None:
            camera.close()


def draw_joint(leg: BuiltLeg, index: int, folder: Path, given: Camera | None = None) -> list[ExportedFile]:
    """Pictures of one joint and of its parts, as ``draw_leg``."""
    joint, written = leg.joints[index], []
    name, flip = file_name(joint.dimensions.name), joint.layout.flips[1]

    with _camera(given) as camera:

        def draw(title: str, part: str, items: list[tuple[Mesh, Colour]]) -> None:
            camera.draw(items, folder / f"{title}.png", view=(0.55, 0.35, 0.76 * flip), closed=True)
            written.append(ExportedFile(f"{title}.png", "png", part))

        for part in joint.parts:
            if part.family in PICTURED:
                draw(part.name, part.name, [(part.mesh, part.colour)])
        together = _joint_items(joint)
        draw(name, name, [item for _, item in together])
        draw(f"{name}_inside", name, [item for part, item in together if not part.startswith(BEFORE_SPRING)])
        apart = exploded_view(joint)
        camera.draw([(mesh, part.colour) for part, mesh, _ in apart], folder / f"{name}_exploded.png",
                    view=(0.85, 0.25, 0.45 * flip), labels=numbers_at(apart), closed=True)  # fmt: skip
    written.append(ExportedFile(f"{name}_exploded.png", "png", name))
    return written


def draw_whole(leg: BuiltLeg, folder: Path, given: Camera | None = None) -> list[ExportedFile]:
    """The picture of the whole leg."""
    with _camera(given) as camera:
        items = [(mesh, part.colour) for part, mesh in leg.rest_meshes()]
        camera.draw(items, folder / "leg.png", view=(0.55, 0.35, 0.76), closed=True)
    return [ExportedFile("leg.png", "png", "leg")]


def _joint_items(joint: BuiltJoint) -> list[tuple[str, tuple[Mesh, Colour]]]:
    """The joint at rest: each part's mesh and colour, with its name without the joint's."""
    angle, prefix = joint.dimensions.rest_angle, joint.part("upper").name.removesuffix("upper")
    return [(part.name.removeprefix(prefix), (joint.mesh_at(part, angle), part.colour)) for part in joint.parts]


def write_assembly(leg: BuiltLeg, only: int | None, folder: Path) -> list[ExportedFile]:
    """STEP and STL of one joint in its own frame without its link, or (None) of the whole leg in the leg's frame."""
    import cadquery as cq

    name = "leg" if only is None else file_name(leg.joints[only].dimensions.name)
    stem = f"{name}_assembly"
    assembly = cq.Assembly(name=stem)
    meshes: list[Mesh] = []
    places = leg.placements(filed=True)
    for index in range(len(leg.joints)) if only is None else [only]:
        joint, link, place = leg.joints[index], leg.links[index], places[index]
        turn, shift = (place.turn, (place.x, place.y, 0.0)) if only is None else (0.0, (0.0, 0.0, 0.0))
        angle, unloaded = joint.dimensions.filed_angle, joint.dimensions.rests_free
        for part in (*joint.parts, *([link] if only is None else [])):
            if unloaded or part.group != "spring":
                solid = joint.solid_at(part, angle)
                if only is None:
                    solid = solid.rotate((0, 0, 0), (0, 0, 1), turn).translate(shift)
                assembly.add(solid, name=part.name, color=cq.Color(*part.colour))
            meshes.append(joint.mesh_at(part, angle).turned(turn, shift))
    write_step(assembly, folder / f"{stem}.step")
    write_stl(meshes, folder / f"{stem}.stl")
    return [ExportedFile(f"{stem}.{kind}", kind, name) for kind in ("step", "stl")]


def _assembly_of_part(part: BuiltPart, solid: Any) -> Any:
    """A single part, wrapped so that its name and colour reach the file."""
    import cadquery as cq

    return cq.Assembly(name=f"{part.name}_part").add(solid, name=part.name, color=cq.Color(*part.colour))


def write_step(assembly: Any, path: Path) -> None:
    """Write a cadquery Assembly as STEP AP214 (mm), without text that changes between runs."""
    assembly.export(str(path))
    path.write_text(normalised_step(path.read_text(encoding="utf-8")), encoding="utf-8", newline="\n")


def write_stl(meshes: list[Mesh], path: Path) -> None:
    """Binary STL (mm) of one or more meshes: 80 bytes of title, a count, 50 bytes per triangle."""
    layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    blocks = []
    for mesh in meshes:
        # A zero may be written as 0 or 1e-17, depending on the order in which the kernel processed the surfaces.
        vertices = np.where(np.abs(mesh.vertices) < 1e-9, 0.0, mesh.vertices).astype("<f4").astype(float)
        corners = vertices[mesh.faces]  # as they are written, so that the normals follow from the file
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        block = np.zeros(len(corners), dtype=layout)
        block["normal"] = normals / np.where(lengths > 0, lengths, 1.0)
        block["corners"] = corners
        blocks.append(block)
    triangles = np.concatenate(blocks)
    title = path.stem.encode("ascii", "replace")[:80].ljust(80)
    path.write_bytes(title + np.uint32(len(triangles)).tobytes() + triangles.tobytes())


__all__ = ["ExportedFile", "PreviewError", "draw_leg", "export_leg", "write_step", "write_stl"]

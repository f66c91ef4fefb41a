"""Printed parts as 3MF files, one per plate: named, coloured, in millimetres, in their best orientations.

3MF core specification 1.3: a zip archive of XML. Written here rather than by a library so that the same parts give
the same bytes; the format's own reader (lib3mf) accepts it.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from synth.cad.parts import BuiltPart, Mesh
from synth.cad.printing import WAYS_UP, PrintPlan

SPACE = 5.0  # mm between parts on the bed
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"


def laid(mesh: Mesh, up: str) -> Mesh:
    """The mesh turned so that ``up`` (a key of WAYS_UP) points along +z, moved to x, y, z >= 0, resting at 0."""
    z = np.array(WAYS_UP[up])
    x = np.roll(np.abs(z), 1)
    rotation = np.array([x, np.cross(z, x), z])  # rows: a right-handed frame
    vertices = mesh.vertices @ rotation.T
    return Mesh(vertices - vertices.min(axis=0), mesh.faces)


def plates(
    items: Sequence[tuple[BuiltPart, PrintPlan]], bed: tuple[float, float, float]
) -> list[list[tuple[BuiltPart, Mesh]]]:
    """Parts placed on beds of the printer's size, each in its best orientation, the deepest first, in rows.

    Rows run along the bed's longer side. A part that is larger than the bed (which a check reports) has a plate of its
    own.
    """
    wide, deep = max(bed[:2]), min(bed[:2])
    laid_out = []
    for part, plan in items:
        mesh = laid(part.mesh, plan.up)
        x, y = mesh.vertices.max(axis=0)[:2].tolist()
        if y > x:
            mesh = _quarter_turned(mesh)
            mesh = Mesh(mesh.vertices - mesh.vertices.min(axis=0), mesh.faces)
        laid_out.append((part, mesh))
    laid_out.sort(key=lambda item: (-float(item[1].vertices[:, 1].max()), item[0].name))
    found: list[list[tuple[BuiltPart, Mesh]]] = [[]]
    x = y = row = 0.0
    for part, mesh in laid_out:
        size = mesh.vertices.max(axis=0)
        if x > 0.0 and x + size[0] > wide:
            x, y, row = 0.0, y + row + SPACE, 0.0
        if y + size[1] > deep and found[-1]:
            found.append([])
            x = y = row = 0.0
        found[-1].append((part, Mesh(mesh.vertices + np.array([x, y, 0.0]), mesh.faces)))
        x, row = x + size[0] + SPACE, max(row, float(size[1]))
    return [_along_y(plate) for plate in found] if bed[1] > bed[0] else found


def _quarter_turned(mesh: Mesh) -> Mesh:
    """The mesh turned by a quarter about z: x becomes y."""
    return Mesh(mesh.vertices @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), mesh.faces)


def _along_y(plate: Sequence[tuple[BuiltPart, Mesh]]) -> list[tuple[BuiltPart, Mesh]]:
    """A plate whose rows run along x, turned as a whole so that they run along y, at x, y >= 0."""
    deep = max((float(mesh.vertices[:, 1].max()) for _, mesh in plate), default=0.0)
    turned = [(part, _quarter_turned(mesh)) for part, mesh in plate]
    return [(part, Mesh(mesh.vertices + np.array([deep, 0.0, 0.0]), mesh.faces)) for part, mesh in turned]


def write_3mf(parts: Iterable[tuple[BuiltPart, Mesh]], path: Path, title: str) -> None:
    """Write meshes (mm) as one 3MF model, an object and a build item each."""
    contents = {
        "[Content_Types].xml": _text(_types()),
        "_rels/.rels": _text(_relations()),
        "3D/3dmodel.model": _model(parts, title),
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in contents.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))  # the clock would change the bytes
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)


def _text(root: Element) -> bytes:
    return bytes(tostring(root, encoding="UTF-8", xml_declaration=True))


def _types() -> Element:
    """What kind of file each ending is."""
    root = Element("Types", {"xmlns": f"{_PACKAGE}/content-types"})
    kinds = {
        "rels": "application/vnd.openxmlformats-package.relationships+xml",
        "model": "application/vnd.ms-package.3dmanufacturing-3dmodel+xml",
    }
    for ending, kind in kinds.items():
        SubElement(root, "Default", {"Extension": ending, "ContentType": kind})
    return root


def _relations() -> Element:
    """Where the archive's model is."""
    root = Element("Relationships", {"xmlns": f"{_PACKAGE}/relationships"})
    kind = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    SubElement(root, "Relationship", {"Target": "/3D/3dmodel.model", "Id": "rel0", "Type": kind})
    return root


def _model(parts: Iterable[tuple[BuiltPart, Mesh]], title: str) -> bytes:
    """The model: a colour's material, then the parts as objects, then a build item each."""
    listed = list(parts)
    root = Element("model", {"unit": "millimeter", "xml:lang": "en", "xmlns": _CORE})
    for name, text in (("Title", title), ("Application", "synth")):
        SubElement(root, "metadata", {"name": name}).text = text
    resources = SubElement(root, "resources")
    materials = SubElement(resources, "basematerials", {"id": "1"})
    colours = sorted({part.colour for part, _ in listed})
    for index, colour in enumerate(colours):
        SubElement(materials, "base", {"name": f"colour {index + 1}", "displaycolor": _hex(colour)})
    build = SubElement(root, "build")
    for number, (part, _) in enumerate(listed, start=2):
        names = {"id": str(number), "type": "model", "name": part.name, "pid": "1"}
        shape = SubElement(resources, "object", names | {"pindex": str(colours.index(part.colour))})
        SubElement(shape, "mesh")
        SubElement(build, "item", {"objectid": str(number)})
    # The meshes have a hundred thousand lines: as XML elements they would take ten times as long as text.
    pieces = _text(root).split(b"<mesh />")
    found = [pieces[0]]
    for (_, mesh), rest in zip(listed, pieces[1:], strict=True):
        found += [_mesh_text(mesh).encode(), rest]
    return b"".join(found)


def _mesh_text(mesh: Mesh) -> str:
    """The mesh's vertices and triangles as an element."""
    # Rounded to 1e-5 mm and merged, so that coincident points are one: a mesh must be closed by its indices.
    points, index = np.unique(np.round(mesh.vertices, 5) + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces]
    kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    vertices = "".join([f'<vertex x="{x:.5f}" y="{y:.5f}" z="{z:.5f}" />' for x, y, z in points.tolist()])
    triangles = "".join([f'<triangle v1="{a}" v2="{b}" v3="{c}" />' for a, b, c in faces[kept].tolist()])
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def _hex(colour: tuple[float, float, float]) -> str:
    return "#" + "".join(f"{round(255 * value):02X}" for value in colour)

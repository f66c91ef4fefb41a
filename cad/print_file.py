"""All printed parts in one 3MF file: named, coloured, in millimetres, each laid on the bed in its best way up.

3MF core specification 1.3: a zip archive of XML. Written here rather than by a library so that the same parts give
the same bytes; the format's own reader (lib3mf) accepts it.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from cad.parts import BuiltPart, Mesh
from cad.printing import WAYS_UP, PrintPlan

SPACE = 5.0  # mm between parts on the bed
_NAMESPACE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n'
)
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
)


def laid(mesh: Mesh, up: str) -> Mesh:
    """The mesh turned so that ``up`` (a key of WAYS_UP) points along +z, moved to x, y, z >= 0 with its foot at 0."""
    z = np.array(WAYS_UP[up])
    x = np.roll(np.abs(z), 1)
    rotation = np.array([x, np.cross(z, x), z])  # rows: a right-handed frame
    vertices = mesh.vertices @ rotation.T
    return Mesh(vertices - vertices.min(axis=0), mesh.faces)


def on_the_bed(items: Sequence[tuple[BuiltPart, PrintPlan]], width: float) -> list[tuple[BuiltPart, Mesh]]:
    """Parts in rows of at most ``width`` mm, one row behind the other; a slicer packs them better."""
    placed: list[tuple[BuiltPart, Mesh]] = []
    x = y = depth = 0.0
    for part, plan in items:
        mesh = laid(part.mesh, plan.up)
        size = mesh.vertices.max(axis=0)
        if x > 0.0 and x + size[0] > width:
            x, y, depth = 0.0, y + depth + SPACE, 0.0
        placed.append((part, Mesh(mesh.vertices + np.array([x, y, 0.0]), mesh.faces)))
        x, depth = x + size[0] + SPACE, max(depth, float(size[1]))
    return placed


def write_3mf(parts: Iterable[tuple[BuiltPart, Mesh]], path: Path, title: str) -> None:
    """Write meshes (mm) as one 3MF model, an object and a build item each."""
    listed = list(parts)
    colours = sorted({part.colour for part, _ in listed})
    materials = "".join(
        f'<base name={quoteattr(f"colour {index + 1}")} displaycolor="{_hex(colour)}"/>'
        for index, colour in enumerate(colours)
    )
    objects = "".join(
        _object(number, part, mesh, colours.index(part.colour)) for number, (part, mesh) in enumerate(listed, start=2)
    )
    items = "".join(f'<item objectid="{number}"/>' for number in range(2, len(listed) + 2))
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xml:lang="en" xmlns="{_NAMESPACE}">'
        f'<metadata name="Title">{_escaped(title)}</metadata><metadata name="Application">synth</metadata>'
        f'<resources><basematerials id="1">{materials}</basematerials>{objects}</resources>'
        f"<build>{items}</build></model>\n"
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        contents = (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS), ("3D/3dmodel.model", model))
        for name, text in contents:
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))  # the clock would change the bytes
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)


def _object(number: int, part: BuiltPart, mesh: Mesh, colour: int) -> str:
    # Rounded to 1e-5 mm, so that points which should coincide do, then merged: a mesh must be closed by its indices.
    points, index = np.unique(np.round(mesh.vertices, 5) + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces]
    kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    vertices = "".join(f'<vertex x="{x:.5f}" y="{y:.5f}" z="{z:.5f}"/>' for x, y, z in points.tolist())
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces[kept].tolist())
    return (
        f'<object id="{number}" type="model" name={quoteattr(part.name)} pid="1" pindex="{colour}">'
        f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>"
    )


def _hex(colour: tuple[float, float, float]) -> str:
    return "#" + "".join(f"{round(255 * value):02X}" for value in colour)


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")

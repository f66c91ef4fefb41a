"""The leg in its rest pose as GLB: one named, coloured mesh a part, metres, y up as glTF has it.

glTF 2.0 (ISO/IEC 12113:2022): a header, then the scene as JSON, then all numbers in one binary block.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from synth.cad.leg_joints import BuiltLeg
from synth.cad.parts import BuiltPart

FLOAT, UNSIGNED = 5126, 5125  # of 32 bits each
POINTS, INDICES = 34962, 34963  # what a view is for
JSON, BINARY = b"JSON", b"BIN\0"


class _Scene:
    """The scene's lists, and the binary block that they refer to."""

    def __init__(self) -> None:
        self.block = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.materials: dict[str, dict[str, Any]] = {}  # by family, in order of appearance

    def add(self, part: BuiltPart, vertices: Any, faces: Any) -> None:
        """A part with vertices (n, 3), float32 m, and faces (k, 3)."""
        ends = {"min": vertices.min(axis=0).tolist(), "max": vertices.max(axis=0).tolist()}
        points = self._numbers(
            vertices, POINTS, {"componentType": FLOAT, "type": "VEC3", "count": len(vertices), **ends}
        )
        corners = faces.astype("<u4").reshape(-1)
        place = self._numbers(corners, INDICES, {"componentType": UNSIGNED, "type": "SCALAR", "count": len(corners)})
        self.materials.setdefault(part.family, _material(part))
        drawn = {"attributes": {"POSITION": points}, "indices": place, "mode": 4}  # triangles
        drawn["material"] = list(self.materials).index(part.family)
        self.meshes.append({"name": part.name, "primitives": [drawn]})

    def _numbers(self, values: Any, target: int, accessor: dict[str, Any]) -> int:
        """Append numbers of four bytes to the block; the number of their accessor."""
        text = values.tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.block), "byteLength": len(text), "target": target})
        self.block += text
        self.accessors.append({"bufferView": len(self.views) - 1, **accessor})
        return len(self.accessors) - 1

    def as_json(self) -> dict[str, Any]:
        """The scene without its numbers."""
        count = len(self.meshes)
        return {
            "asset": {"version": "2.0", "generator": "synth"},
            "scene": 0,
            "scenes": [{"nodes": list(range(count))}],
            "nodes": [{"name": mesh["name"], "mesh": k} for k, mesh in enumerate(self.meshes)],
            "meshes": self.meshes,
            "materials": list(self.materials.values()),
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.block)}],
        }


def _material(part: BuiltPart) -> dict[str, Any]:
    surface = {"baseColorFactor": [*part.colour, 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.7}
    return {"name": part.family, "pbrMetallicRoughness": surface, "doubleSided": False}


def write_glb(leg: BuiltLeg, path: Path) -> None:
    """Write the scene; the same leg gives the same bytes."""
    scene = _Scene()
    for part, mesh in leg.rest_meshes():
        vertices = np.where(np.abs(mesh.vertices) < 1e-9, 0.0, mesh.vertices) * 1e-3
        scene.add(part, vertices.astype("<f4"), mesh.faces)
    words = json.dumps(scene.as_json(), separators=(",", ":")).encode()
    words += b" " * (-len(words) % 4)
    body = b"".join(
        len(text).to_bytes(4, "little") + kind + text for kind, text in ((JSON, words), (BINARY, bytes(scene.block)))
    )
    path.write_bytes(b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body)

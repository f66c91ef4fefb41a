"""The leg in its rest pose as GLB: one named, coloured mesh a part, metres, y up as glTF has it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.cad.leg_joints import BuiltLeg


def write_glb(leg: BuiltLeg, path: Path) -> None:
    """Write the scene; the same leg gives the same bytes."""
    import trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    scene = trimesh.Scene()
    for part, mesh in leg.rest_meshes():
        vertices = np.where(np.abs(mesh.vertices) < 1e-9, 0.0, mesh.vertices) * 1e-3
        body = trimesh.Trimesh(vertices, mesh.faces, process=False)
        colour = [*part.colour, 1.0]
        material = PBRMaterial(
            name=part.family, baseColorFactor=colour, metallicFactor=0.1, roughnessFactor=0.7, doubleSided=False
        )
        body.visual = TextureVisuals(material=material)
        scene.add_geometry(body, node_name=part.name, geom_name=part.name)
    path.write_bytes(scene.export(file_type="glb"))

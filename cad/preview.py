"""Pictures of parts and assemblies, drawn off-screen from their meshes."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from synth.cad.palette_png import write_png
from synth.cad.parts import Array, Mesh

Colour = tuple[float, float, float]
Item = tuple[Mesh, Colour] | tuple[Mesh, Colour, float]  # the last: opacity, default 1
VIEW = (0.55, 0.35, 0.76)  # direction from the part to the eye: from the front right, a little above
LABEL_SIZE = 15  # points: a choice
LABEL_AHEAD = 1.0  # mm, of the labels before the nearest part: a part that stood before its own hid a number
FEATURE_ANGLE = 25.0  # deg; sharper edges are drawn


class PreviewError(RuntimeError):
    """No picture can be drawn on this machine; parts and checks are unaffected."""


class Camera:
    """One off-screen window, kept open because opening it costs more than a picture."""

    def __init__(self, width: int = 800, height: int = 600) -> None:
        _require_a_way_to_draw()
        try:
            self._renderer, self._window = _renderer_and_window()
        except ImportError as error:
            raise PreviewError(f"no pictures: vtk cannot be loaded ({error})") from error
        self._renderer.SetBackground(1.0, 1.0, 1.0)
        self._window.SetOffScreenRendering(1)
        self._window.SetSize(width, height)
        self._window.SetMultiSamples(0)  # smoothed edges take three times as long to draw
        self._window.AddRenderer(self._renderer)
        self._drawn: dict[tuple[int, Colour], tuple[Mesh, list[Any]]] = {}

    def draw(
        self,
        items: Sequence[Item],
        path: Path,
        view: tuple[float, float, float] = VIEW,
        up: tuple[float, float, float] = (0.0, 1.0, 0.0),
        labels: Sequence[tuple[str, tuple[float, float, float]]] = (),
        *,
        closed: bool = False,
    ) -> None:
        """Write a PNG of coloured meshes seen from ``view``; ``labels``: words with their places, mm.

        ``closed``: every mesh is an opaque body. The faces that it hides from the viewer are left out, and a mesh that
        an earlier picture showed is not prepared again.

        Raises
        ------
        PreviewError
            if the picture is blank, which a faulty graphics driver can cause.
        """
        self._renderer.RemoveAllViewProps()
        for item in items:
            for actor in self._body(item[0], item[1]) if closed else _actors(*item):
                self._renderer.AddActor(actor)
        meshes = [item[0] for item in items]
        towards = np.array(view) / np.linalg.norm(view)
        front = max((float((mesh.vertices @ towards).max()) for mesh in meshes), default=0.0) + LABEL_AHEAD
        for words, place in labels:
            at = np.array(place)  # moved along the view: the projection is parallel, and shows it at its part
            self._renderer.AddActor(_label(words, at + (front - float(at @ towards)) * towards))
        self._frame(meshes, view, up)
        self._renderer.ResetCameraClippingRange()
        self._window.Render()
        self._write(path)

    def _body(self, mesh: Mesh, colour: Colour) -> list[Any]:
        """Surface and edges of an opaque body, from the earlier pictures if they showed it."""
        key = (id(mesh), colour)
        if key not in self._drawn:
            self._drawn[key] = (mesh, _actors(mesh, colour, closed=True))  # with the mesh, whose id no other one gets
        return self._drawn[key][1]

    def _frame(self, meshes: list[Mesh], view: tuple[float, float, float], up: tuple[float, float, float]) -> None:
        """The tightest parallel projection that contains every vertex."""
        towards = np.array(view) / np.linalg.norm(view)
        right = np.cross(up, towards)
        right /= np.linalg.norm(right)
        axes = np.array([right, np.cross(towards, right), towards])
        seen = np.vstack([mesh.vertices for mesh in meshes]) @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        centre = (low + high) / 2 @ axes
        width, height = self._window.GetSize()
        camera = self._renderer.GetActiveCamera()
        camera.SetParallelProjection(True)
        camera.SetFocalPoint(*centre)
        camera.SetPosition(*(centre + towards * (high[2] - low[2] + 1.0)))
        camera.SetViewUp(*up)
        camera.SetParallelScale(0.53 * max(high[1] - low[1], (high[0] - low[0]) * height / width))

    def _write(self, path: Path) -> None:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

        grab = vtkWindowToImageFilter()
        grab.SetInput(self._window)
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        grab.Update()
        pixels = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())
        # 0.2 % of the pixels darker than almost white (250 of 255): less is a blank picture.
        if np.mean(np.minimum.reduce([pixels[:, k] for k in range(3)]) < 250) < 0.002:
            raise PreviewError("no pictures: the off-screen window stays blank on this machine")
        width, height, _ = grab.GetOutput().GetDimensions()
        write_png(np.ascontiguousarray(pixels[:, :3].reshape(height, width, 3)[::-1]), path)

    def close(self) -> None:
        """Free the window's memory."""
        self._window.Finalize()


def _renderer_and_window() -> tuple[Any, Any]:
    """A renderer and a window; without a display a headless one, to which vtk falls back only after warnings."""
    from vtkmodules import vtkRenderingOpenGL2
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

    headless = not os.environ.get("DISPLAY") and hasattr(vtkRenderingOpenGL2, "vtkEGLRenderWindow")
    return vtkRenderer(), vtkRenderingOpenGL2.vtkEGLRenderWindow() if headless else vtkRenderWindow()


def _require_a_way_to_draw() -> None:
    """Raise PreviewError if vtk cannot draw off-screen.

    Without EGL vtk opens an X window and crashes if there is no screen. That crash cannot be caught, so the library is
    looked for first.
    """
    if not sys.platform.startswith("linux") or os.environ.get("DISPLAY"):
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        text = "no pictures: the system library libEGL.so.1 is missing. Debian: apt-get install libegl1"
        raise PreviewError(text) from None


def _actors(mesh: Mesh, colour: Colour, opacity: float = 1.0, *, closed: bool = False) -> list[Any]:
    """The shaded surface and its sharp edges; of a ``closed`` mesh only the faces towards the viewer are drawn."""
    from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkPolyDataNormals
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    data = _poly_data(mesh)
    normals = vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SetFeatureAngle(FEATURE_ANGLE)
    normals.ConsistencyOff()
    surface = vtkPolyDataMapper()
    surface.SetInputConnection(normals.GetOutputPort())
    body = vtkActor()
    body.SetMapper(surface)
    body.GetProperty().SetColor(*colour)
    body.GetProperty().SetSpecular(0.15)
    body.GetProperty().SetOpacity(opacity)
    body.GetProperty().SetBackfaceCulling(closed)
    edges = vtkFeatureEdges()
    edges.SetInputData(data)
    edges.SetFeatureAngle(FEATURE_ANGLE)
    edges.BoundaryEdgesOff()
    edges.NonManifoldEdgesOff()
    edges.ColoringOff()
    lines = vtkPolyDataMapper()
    lines.SetInputConnection(edges.GetOutputPort())
    lines.SetResolveCoincidentTopologyToPolygonOffset()
    outline = vtkActor()
    outline.SetMapper(lines)
    outline.GetProperty().SetColor(0.1, 0.1, 0.12)
    outline.GetProperty().SetLineWidth(1.2)
    outline.GetProperty().SetOpacity(max(opacity, 0.5))
    return [body, outline]


def _label(words: str, place: Array) -> Any:
    """A label that faces the viewer, at ``place`` (3,) mm."""
    from vtkmodules import vtkRenderingFreeType  # noqa: F401  # it draws letters
    from vtkmodules.vtkRenderingCore import vtkBillboardTextActor3D

    actor = vtkBillboardTextActor3D()
    actor.SetInput(words)
    actor.SetPosition(*place)
    style = actor.GetTextProperty()
    style.SetFontSize(LABEL_SIZE)
    style.SetColor(0.0, 0.0, 0.0)
    style.SetBackgroundColor(1.0, 1.0, 0.85)
    style.SetBackgroundOpacity(0.85)
    style.BoldOn()
    return actor


def _poly_data(mesh: Mesh) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.vertices), deep=True))
    corners = np.ascontiguousarray(mesh.faces, dtype=np.int64).ravel()
    starts = np.arange(0, len(corners) + 1, 3, dtype=np.int64)
    triangles = vtkCellArray()
    triangles.SetData(numpy_to_vtkIdTypeArray(starts, deep=True), numpy_to_vtkIdTypeArray(corners, deep=True))
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(triangles)
    return data

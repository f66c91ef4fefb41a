"""The solids' kernel, loaded without what nothing here uses."""

from __future__ import annotations

from synth.compiling.modules import left_empty


def load_cadquery() -> None:
    """Import ``cadquery``; before a module of ``synth.cad`` that imports it, this takes a quarter less time.

    The kernel's Python package imports all of ``vtk`` and uses nothing of it: its users import the modules of
    ``vtkmodules`` that they need.
    """
    with left_empty("vtk"):
        import cadquery  # noqa: F401

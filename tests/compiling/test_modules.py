"""Modules that are left empty while another one is imported."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import synth
from synth.compiling.modules import left_empty

EXAMPLES = Path(synth.__file__).parent / "examples"


def test_an_empty_module_is_unknown_afterwards_and_a_loaded_one_stays():
    with left_empty("this_is_not_there"):
        empty = importlib.import_module("this_is_not_there")
        assert not [name for name in vars(empty) if not name.startswith("__")]
    with pytest.raises(ImportError):
        importlib.import_module("this_is_not_there")
    with left_empty("subprocess"):
        assert sys.modules["subprocess"] is subprocess


def test_the_kernel_is_loaded_without_all_of_vtk_which_can_still_be_loaded():
    """In a fresh process, as a side process begins; a solid is drawn, whose pictures use modules of vtkmodules."""
    program = (
        "import sys; from synth.design.solid_work import load_kernel; load_kernel(); "
        "few = sum(name.startswith('vtkmodules') for name in sys.modules); assert 'vtk' not in sys.modules; "
        "import cadquery; assert abs(cadquery.Solid.makeBox(1, 2, 3).Volume() - 6.0) < 1e-9; "
        "assert cadquery.Solid.makeBox(1, 2, 3).toVtkPolyData(0.1).GetNumberOfCells() > 0; "
        "import vtk; assert hasattr(vtk, 'vtkPolyData'); "
        "assert few < 0.5 * sum(name.startswith('vtkmodules') for name in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize(
    ("command", "without"),
    [
        (("gap", "gap/gap.yaml"), "scipy.optimize"),  # 0.2 s, for clocks in doubt alone
        (
            ("leg", "leg/leg-design.yaml", "--no-cad", "--no-cache"),
            "scipy.optimize",
        ),  # 0.4 s, for legs not tangent alone
        (("leg", "leg/leg-design.yaml", "--no-cad", "--no-cache"), "synth.batch.folder"),  # 0.2 s, for folders alone
        (("spring", "--rate", "1.7 N*m/rad", "--travel", "40 deg"), "vtk"),
    ],
)
def test_a_command_does_not_load_what_takes_long_and_is_not_needed(
    command: tuple[str, ...], without: str, tmp_path: Path
):
    """In a fresh process, to the command's end."""
    words = [str(EXAMPLES / word) if word.endswith(".yaml") else word for word in command]
    program = (
        "import sys; from synth.cli import main; "
        f"assert main({[*words, '--out', str(tmp_path / 'made')]!r}) == 0; assert {without!r} not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)

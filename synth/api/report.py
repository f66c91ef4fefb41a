"""The interface of every result: table, figure, notebook view, files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.errors import UserError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from synth.arrays import Array

Cell = str | float | int | bool | None
IN_CODE = Path("a leg made in code")  # the place of a mistake that is in no file
# A context manager that names a stage of the work; the command line shows its duration.
Stage = Callable[[str], AbstractContextManager[None]]


def silent(text: str) -> AbstractContextManager[None]:
    """A stage without output."""
    return nullcontext()


@contextmanager
def stage_by_stage(stage: Stage) -> Iterator[Callable[[str], None]]:
    """Within the block, a call with a text ends the stage that the last one began, and begins the next."""
    with ExitStack() as current:

        def begin(text: str) -> None:
            current.close()
            current.enter_context(stage(text))

        yield begin


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over one axis: name -> (x, y), each (m,), in the units of the labels. ``dots``: names of point series."""

    title: str
    x_label: str
    y_label: str
    curves: Mapping[str, tuple[Array, Array]]
    dots: frozenset[str] = frozenset()


class Report(ABC):
    """A result with a table, a figure and files.

    Subclasses define the abstract methods below, and are dataclasses with ``repr=False``.
    """

    @property
    @abstractmethod
    def headline(self) -> str:
        """The result in one sentence."""

    @abstractmethod
    def columns(self) -> dict[str, list[Cell]]:
        """The result's table: header with its unit in brackets -> cells."""

    @abstractmethod
    def panels(self) -> Sequence[Panel]:
        """The figure's panels; the first is the most informative."""

    @abstractmethod
    def write(self, folder: Path) -> None:
        """Write the result's files into an empty folder, as the command does."""

    @abstractmethod
    def inputs(self) -> tuple[list[Path], list[str]]:
        """The files that it was made of, and the SHA-256 of those whose place is not known: ``save`` keeps both."""

    def to_frame(self) -> DataFrame:
        """The table as a pandas DataFrame; headers carry units.

        Raises
        ------
        UserError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise UserError("to_frame needs pandas: pip install limb-synth[notebook]") from None
        return pandas.DataFrame(self.columns())

    def plot(self, which: int = 0) -> Figure:
        """One panel as a matplotlib figure, for the caller to show or save.

        Raises
        ------
        UserError
            If matplotlib is not installed, or there is no such panel.
        """
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise UserError("plot needs matplotlib: pip install limb-synth[notebook]") from None
        panels = self.panels()
        if not 0 <= which < len(panels):
            raise UserError(f"there is no panel {which}: this result has {len(panels)}, counted from 0")
        panel = panels[which]
        figure = Figure(figsize=(7.0, 3.5), layout="constrained")
        axes = figure.add_subplot()
        for name, (x, y) in panel.curves.items():
            axes.plot(x, y, "." if name in panel.dots else "-", label=name, markersize=3)
        axes.set(title=panel.title, xlabel=panel.x_label, ylabel=panel.y_label)
        axes.grid(alpha=0.3)
        if panel.curves:
            axes.legend(fontsize="small")
        return figure

    def write_compared(self, folder: Path) -> tuple[str, str] | None:
        """Write what a comparison reads, and give its kind, as of a result's folder, and a title.

        None: it cannot be compared.
        """
        return None

    def save(self, folder: str | Path) -> Path:
        """Write the command's files into a folder, complete or not at all, and return the folder.

        Raises
        ------
        UserError
            If the folder holds other files than an earlier run's, one that was changed since or that the result was
            made of, or cannot be written.
        """
        from synth.files.output import output_folder

        files, contents = self.inputs()
        with output_folder(folder, inputs=files, contents=contents) as made:
            self.write(made)
        return Path(folder)

    def __repr__(self) -> str:
        """Class, headline and a short table: a dataclass's would list every sample."""
        from synth.reports.notebook import notebook_text

        return notebook_text(f"{type(self).__name__}: {self.headline}", self.columns())

    def _repr_html_(self) -> str:
        """Headline, table and a small figure for notebooks."""
        from synth.reports.notebook import notebook_html

        panels = self.panels()
        drawn: dict[str, Any] | None = None
        if panels:
            first = panels[0]
            curves = {name: (x.tolist(), y.tolist()) for name, (x, y) in first.curves.items()}
            labels = {"title": first.title, "x_label": first.x_label, "y_label": first.y_label}
            drawn = {**labels, "curves": curves, "dots": first.dots}
        return notebook_html(self.headline, self.columns(), drawn)

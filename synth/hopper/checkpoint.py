"""A sweep's chunks on disk, so that a run that was killed goes on where it stopped, with the same bytes at the end."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError

MANIFEST = "sweep.json"


class Checkpoint:
    """The folder ``.NAME.sweep`` beside the folder that a run is to write.

    Parameters
    ----------
    target : the folder that the run is to write.
    identity : what the chunks depend on, as text by name; a folder of another identity is refused.

    Raises
    ------
    UserError : it holds an interrupted sweep of another project, or cannot be written.
    """

    def __init__(self, target: Path, identity: dict[str, str]) -> None:
        whole = target.resolve()
        self.folder = whole.parent / f".{whole.name}.sweep"
        self._identity = identity
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            manifest = self.folder / MANIFEST
            if manifest.exists():
                self._compare(json.loads(manifest.read_text(encoding="utf-8")))
            elif any(self.folder.iterdir()):
                text = "holds what is no interrupted sweep; move it away"
                raise UserError(Problem(text, str(self.folder)))
            else:
                self._replace(manifest, json.dumps(identity, indent=1).encode())
        except OSError as error:
            raise UserError(Problem(f"cannot be written: {error.strerror}", str(self.folder))) from None
        except json.JSONDecodeError:
            raise UserError(Problem("is damaged; remove the folder to start anew", str(self.folder))) from None

    def _compare(self, found: object) -> None:
        if found == self._identity:
            return
        known = found if isinstance(found, dict) else {}
        other = [name for name, value in self._identity.items() if known.get(name) != value]
        text = f"holds an interrupted sweep with another {' and '.join(other)}; run that one to its end,"
        raise UserError(Problem(f"{text} name another --out, or remove the folder", str(self.folder)))

    def load(self, index: int) -> Array | None:
        """A finished chunk; None where there is none."""
        path = self._path(index)
        if not path.exists():
            return None
        with path.open("rb") as stream:
            return np.asarray(np.load(stream, allow_pickle=False))

    def save(self, index: int, values: Array) -> None:
        """Keep a chunk, whole or not at all."""
        handle, temporary = tempfile.mkstemp(dir=self.folder, suffix=".partial")
        with os.fdopen(handle, "wb") as stream:
            np.save(stream, values)
        Path(temporary).replace(self._path(index))

    @property
    def finished(self) -> int:
        """How many chunks are kept."""
        return sum(1 for _ in self.folder.glob("chunk_*.npy"))

    def remove(self) -> None:
        """The run has written its result."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, index: int) -> Path:
        return self.folder / f"chunk_{index:06d}.npy"

    def _replace(self, path: Path, data: bytes) -> None:
        temporary = path.with_suffix(".partial")
        temporary.write_bytes(data)
        temporary.replace(path)

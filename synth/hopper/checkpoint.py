"""A sweep's chunks on disk, so that a killed run can resume with identical output."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.output import write_bytes_whole

MANIFEST = "sweep.json"
_HASH = 32  # bytes of a SHA-256 after a chunk
_OURS = re.compile(r"sweep\.json|chunk_\d+\.npy|.*\.partial")


class Checkpoint:
    """The folder ``.NAME.sweep`` beside the output folder.

    Parameters
    ----------
    target : the output folder.
    identity : the input of the chunks, as text by name; a folder with another identity is refused.

    Raises
    ------
    UserError : it holds an interrupted sweep of another project, or cannot be written.
    """

    def __init__(self, target: Path, identity: dict[str, str]) -> None:
        whole = Path(os.path.realpath(target))
        self.folder = whole.parent / f".{whole.name}.sweep"
        self._identity = identity
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            strange = sorted(path.name for path in self.folder.iterdir() if not _OURS.fullmatch(path.name))
            if strange:
                text = f"contains other files than an interrupted sweep's ({', '.join(strange[:3])}); move it away"
                raise UserError(Problem(text, str(self.folder)))
            for left in self.folder.glob("*.partial"):  # of a killed run, or of one on a full disk
                left.unlink()
            found = self._manifest()
            if found is None:
                self._begin()
            else:
                self._compare(found)
        except OSError as error:
            with suppress(OSError):
                self.folder.rmdir()  # if it is empty
            raise UserError(Problem(f"cannot be written: {error.strerror}", str(self.folder))) from None

    def _manifest(self) -> object:
        """The input of the stored chunks; None if it was never written completely."""
        try:
            return json.loads((self.folder / MANIFEST).read_text(encoding="utf-8"))
        except (FileNotFoundError, ValueError):
            return None

    def _begin(self) -> None:
        """Start anew: chunks without known input are useless."""
        for chunk in self.folder.glob("chunk_*.npy"):
            chunk.unlink()
        write_bytes_whole(self.folder / MANIFEST, json.dumps(self._identity, indent=1).encode())

    def _compare(self, found: object) -> None:
        if found == self._identity:
            return
        known = found if isinstance(found, dict) else {}
        other = [name for name, value in self._identity.items() if known.get(name) != value]
        text = f"holds an interrupted sweep with another {' and '.join(other)}; finish that run,"
        raise UserError(Problem(f"{text} name another --out, or remove the folder", str(self.folder)))

    def load(self, index: int) -> Array | None:
        """A finished chunk; None if there is none, or if it is damaged (then deleted)."""
        path = self._path(index)
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return None
        content = data[:-_HASH]
        if sha256(content).digest() != data[-_HASH:]:
            path.unlink()
            return None
        return np.asarray(np.load(io.BytesIO(content), allow_pickle=False))

    def save(self, index: int, values: Array) -> None:
        """Store a chunk followed by its hash, complete or not at all."""
        stream = io.BytesIO()
        np.save(stream, values, allow_pickle=False)
        content = stream.getvalue()
        try:
            write_bytes_whole(self._path(index), content + sha256(content).digest())
        except OSError:
            if not self.finished:  # nothing to resume
                self.remove()
            raise

    @property
    def finished(self) -> int:
        """Number of stored chunks."""
        return sum(1 for _ in self.folder.glob("chunk_*.npy"))

    def remove(self) -> None:
        """Remove the checkpoint after the run has written its result."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, index: int) -> Path:
        return self.folder / f"chunk_{index:06d}.npy"

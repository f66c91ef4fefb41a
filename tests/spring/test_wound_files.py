"""Files of wound samples that are no files of samples: refused, and not waited for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from synth.errors import UserError
from synth.spring.wound_samples import read_calibration, read_samples


@pytest.mark.parametrize("read", [read_samples, read_calibration])
def test_a_pipe_a_folder_and_what_is_no_text_are_refused(tmp_path: Path, read: object) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "deep").write_text("[" * 100_000)
    for name in ("pipe", "bytes", "deep", ".", "gone"):
        with pytest.raises(UserError):
            read(tmp_path / name)  # type: ignore[operator]


def test_counts_need_no_unit(tmp_path: Path) -> None:
    said = []
    for turns, coils in (("turns [1]", "coils [1]"), ("turns", "coils"), ("Turns [turns]", "Coils [coils]")):
        path = tmp_path / "samples.csv"
        path.write_text(f"mandrel [mm],wire [mm],{turns},{coils}\n10,2,6,5.25\n", encoding="utf-8")
        said.append(read_samples(path))
    assert said[0] == said[1] == said[2]
    path.write_text("mandrel [mm],wire [mm],turns,coils [mm]\n10,2,6,5.25\n", encoding="utf-8")
    with pytest.raises(UserError, match="coils"):
        read_samples(path)

"""Pictures with a palette: the colours, the format, and repeatable bytes."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from synth.cad.palette_png import SIGNATURE, STEP, palette_of, write_png


def shaded(width: int = 160, height: int = 120) -> np.ndarray:
    """A white ground with two shaded cylinders."""
    pixels = np.full((height, width, 3), 255, dtype=np.uint8)
    shade = 0.4 + 0.6 * np.sin(np.linspace(0.2, np.pi - 0.2, 60))
    for first, colour in ((10, (200, 90, 40)), (90, (60, 110, 190))):
        pixels[20:100, first : first + 60] = (shade[:, None] * np.array(colour)).astype(np.uint8)
    return pixels


def test_a_picture_keeps_its_colours() -> None:
    pixels = shaded()
    palette, index = palette_of(pixels)
    assert np.abs(palette[index].astype(int) - pixels).max() <= STEP
    assert (palette[index][0, 0] == 255).all()


def test_the_png_follows_the_specification(tmp_path: Path) -> None:
    """Read back by the specification alone: header, palette, rows with filter 0; the first row on top."""
    pixels = shaded()
    pixels[0] = (10, 20, 30)
    write_png(pixels, tmp_path / "a.png")
    data, chunks = (tmp_path / "a.png").read_bytes(), {}
    assert data.startswith(SIGNATURE)
    at = len(SIGNATURE)
    while at < len(data):
        (size,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + body)
        chunks[kind], at = body, at + 12 + size
    assert struct.unpack(">IIBBBBB", chunks[b"IHDR"]) == (160, 120, 8, 3, 0, 0, 0)
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), dtype=np.uint8).reshape(120, 161)
    assert not rows[:, 0].any()
    palette = np.frombuffer(chunks[b"PLTE"], dtype=np.uint8).reshape(-1, 3)
    assert np.abs(palette[rows[0, 1:]].astype(int) - (10, 20, 30)).max() <= STEP
    write_png(pixels, tmp_path / "b.png")
    assert (tmp_path / "b.png").read_bytes() == data


def test_pillow_reads_the_same_picture(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    pixels = shaded()
    write_png(pixels, tmp_path / "a.png")
    seen = np.asarray(image.open(tmp_path / "a.png").convert("RGB")).astype(int)
    assert np.abs(seen - pixels).max() <= STEP

"""Pictures as PNG with a palette: a third of the bytes of three channels, without visible difference.

Shaded solids have a few hundred shades of a dozen colours. The most frequent shades are the palette; every other pixel,
from the smoothing of edges, takes the nearest of these. PNG specification, 3rd ed. (W3C 2025), colour type 3.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

SHADES = 128  # palette size: half as many give visible steps on a shaded cylinder, twice as many larger files
STEP = 4  # of 256 levels a channel, below which two shades are one
SIGNATURE = b"\x89PNG\r\n\x1a\n"

Pixels = NDArray[np.uint8]


def palette_of(pixels: Pixels) -> tuple[Pixels, Pixels]:
    """Palette (n, 3) and indices (height, width) of pixels (height, width, 3)."""
    height, width, _ = pixels.shape
    coarse = np.minimum(255, (pixels.reshape(-1, 3).astype(np.int64) + STEP // 2) // STEP * STEP)  # the largest byte
    code = coarse @ np.array([65536, 256, 1])
    codes, inverse, counts = np.unique(code, return_inverse=True, return_counts=True)
    colours = np.stack([codes >> 16, (codes >> 8) & 255, codes & 255], axis=1)
    kept = np.sort(np.argsort(-counts, kind="stable")[:SHADES])
    palette = colours[kept]
    distance = ((colours[:, None, :] - palette[None, :, :]) ** 2).sum(axis=2)
    index = distance.argmin(axis=1)[inverse]
    return palette.astype(np.uint8), index.reshape(height, width).astype(np.uint8)


def write_png(pixels: Pixels, path: Path) -> None:
    """Write pixels (height, width, 3), the top row first; the same pixels give the same bytes."""
    palette, index = palette_of(pixels)
    height, width = index.shape
    rows = b"".join(b"\x00" + row.tobytes() for row in index)  # filter 0: palette indices have no slope to predict
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"PLTE", palette.tobytes()), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")]
    path.write_bytes(SIGNATURE + b"".join(_chunk(kind, data) for kind, data in chunks))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

"""Pictures that notebooks show."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np

__all__ = ["Picture"]


class Picture(np.ndarray):
    """A picture: an array (height, width, 3 or 4) uint8, sRGB from the upper left corner, which notebooks show.

    The fourth channel is how much of a pixel is covered. Parts of a picture are of this class too; numbers that are computed of it
    are numpy's own.
    """

    def __array_wrap__(self, array: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        # Otherwise even the brightest level would be a picture.
        return np.asarray(array)[()]

    def _repr_png_(self) -> bytes | None:
        if self.dtype != np.uint8 or self.ndim != 3 or self.shape[2] not in (3, 4) or self.size == 0:
            return None
        height, width, channels = self.shape
        # Each row begins with its filter's number: none.
        rows = np.zeros((height, 1 + width * channels), np.uint8)
        rows[:, 1:] = self.reshape(height, -1)
        header = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
        chunks = [(b"IHDR", header), (b"sRGB", b"\0"), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b"")]
        return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks)


def _chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

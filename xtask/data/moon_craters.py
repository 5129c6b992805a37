"""The Moon's craters: assets/moon/craters.bin, see SOURCE.md there.

NOMENCLATURE   Debian stellarium-data 0.22.2-1, usr/share/stellarium/data/nomenclature.dat (text under gzip)

python3.11 xtask/data/moon_craters.py NOMENCLATURE      (numpy 2.4, pillow 13)

Six bytes a crater, the widest first, little-endian: latitude in 1/360 degree (i16), east longitude in 1/65536 of a turn (u16),
diameter in 1/50 km (u16, its lower 15 bits), and in the highest bit whether its floor is lava.
"""

import gzip
import sys
from pathlib import Path

import numpy as np
from PIL import Image

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "moon"
RADIUS_KM = 1737.4

# Narrower ones are below a texel of the map.
LEAST_KM = 3.0
# Maria have normal albedos of 0.07-0.10, highlands of 0.11-0.18 [heiken1991]: 0.085 to 0.145 in the middle. A floor is lava that
# is darker than the ground around its crater by more than half of that ratio (in logarithms).
LAVA = (0.085 / 0.145) ** 0.5
# Narrower floors are a few texels of the albedo's map.
LAVA_LEAST_KM = 40.0

raw = Path(sys.argv[1]).read_bytes()
text = (gzip.decompress(raw) if raw[:2] == b"\x1f\x8b" else raw).decode()
albedo = np.asarray(Image.open(FOLDER / "albedo.jpg")).astype(float)
rows, columns = albedo.shape


def mean_albedo(latitude, longitude, from_km, to_km):
    """Of the ground between two distances from a place."""
    n = 48
    distance = np.sqrt(np.linspace(from_km**2, to_km**2, n))[:, None] / RADIUS_KM
    azimuth = (np.arange(n) + 0.5)[None, :] * 2 * np.pi / n
    phi = np.radians(latitude)
    sin = np.sin(phi) * np.cos(distance) + np.cos(phi) * np.sin(distance) * np.cos(azimuth)
    east = np.arctan2(np.sin(azimuth) * np.sin(distance) * np.cos(phi), np.cos(distance) - np.sin(phi) * sin)
    x = ((longitude + np.degrees(east) + 180) % 360) / 360 * columns
    y = (90 - np.degrees(np.arcsin(sin))) / 180 * rows
    return albedo[np.clip(y.astype(int), 0, rows - 1), x.astype(int) % columns].mean()


craters = []
for line in text.splitlines():
    parts = line.split("\t")
    if len(parts) != 7 or parts[0] != "Moon" or parts[3] not in ("AA", "SF"):
        continue
    latitude, longitude, diameter = map(float, parts[4:])
    if diameter < LEAST_KM:
        continue
    name = parts[2].split('"')[1]
    lava = False
    if diameter >= LAVA_LEAST_KM and abs(latitude) < 65:
        # Pike's floor (1977), and the ground beyond the foot of the rim.
        floor = min(0.187 * diameter**1.249, 0.8 * diameter) / 2
        foot = diameter / 2 + 0.467 * diameter**0.836
        lava = mean_albedo(latitude, longitude, 0, 0.9 * floor) < LAVA * mean_albedo(
            latitude, longitude, foot, foot + diameter / 4
        )
    craters.append((diameter, latitude, longitude % 360, lava, name))
craters.sort(key=lambda crater: (-crater[0], crater[1], crater[2]))

table = np.zeros(len(craters), dtype=[("latitude", "<i2"), ("longitude", "<u2"), ("diameter", "<u2")])
for row, (diameter, latitude, longitude, lava, _) in zip(table, craters):
    row["latitude"] = round(latitude * 360)
    row["longitude"] = round(longitude / 360 * 65536) % 65536
    row["diameter"] = round(diameter * 50) | (0x8000 if lava else 0)
(FOLDER / "craters.bin").write_bytes(table.tobytes())
print(len(craters), "craters,", table.nbytes, "bytes")
print("lava:", ", ".join(f"{name} {diameter:.0f} km" for diameter, _, _, lava, name in craters if lava))

"""The Moon's albedo: assets/moon/albedo.jpg, see SOURCE.md there.

MOON_4K   Debian stellarium-data 0.22.2-1, usr/share/stellarium/textures/moon_4k.jpg

python3.11 xtask/data/moon.py MOON_4K      (numpy 2.4, pillow 13)
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "moon"

# The picture's codes are not albedo: they span 67 (Mare Tranquillitatis) to 149 (central highlands), 1 : 2.2, where
# normal albedos are about 1 : 1.8 (maria 0.07-0.10, highlands 0.11-0.18, Heiken et al. 1991). This power makes it so.
POWER = 0.75
# The map is drawn by hand beyond these latitudes: between them it fades into its mean.
FADE_DEG = (65.0, 70.0)

codes = np.asarray(Image.open(sys.argv[1]).convert("RGB")).astype(float).mean(axis=2)
rows, columns = codes.shape
assert (rows, columns) == (2048, 4096), codes.shape
latitude = 90 - (np.arange(rows) + 0.5) / rows * 180
albedo = (codes / 255) ** POWER
band = (np.abs(latitude) > 50) & (np.abs(latitude) < FADE_DEG[0])
fade = np.clip((np.abs(latitude) - FADE_DEG[0]) / (FADE_DEG[1] - FADE_DEG[0]), 0, 1)[:, None]
for side in (latitude > 0, latitude <= 0):
    mean = albedo[band & side].mean()
    albedo[side] = (albedo * (1 - fade) + mean * fade)[side]
FOLDER.mkdir(parents=True, exist_ok=True)
Image.fromarray(np.round(albedo * 255).astype(np.uint8)).save(FOLDER / "albedo.jpg", quality=88, optimize=True)
print((FOLDER / "albedo.jpg").stat().st_size, "bytes")

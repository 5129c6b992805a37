#!/usr/bin/env python3.11
"""Writes tests/truth/air_numba_mc.csv and air_numba_mc_day.csv: the sky of `bruneton2017` by a backward Monte Carlo in a sphere.

Needs:  pip install numba==0.68.1 numpy==2.4.6
Run:    python3.11 xtask/data/air_numba_mc.py              (from the repository root; about twelve minutes of one core)
        python3.11 xtask/data/air_numba_mc.py day          (the second table; four minutes)
        python3.11 xtask/data/air_numba_mc.py check        (first order by quadrature; depth towards the Sun; flat air)

Written apart from himmel's reference tracer and by other means: null collisions. A flight proposes collisions with a
majorant that is constant in bands of altitude and no smaller than a given number of proposals per flight. Every proposal
scores the sunlight scattered there, weighted by the ratios of null collisions so far; the first proposal that is real
(with probability extinction / majorant) is where the path turns. The ground scores in the same way and reflects with the
probability of its albedo. Paths end by absorption of the weight (Russian roulette below 0.1) or in space: no order is cut.
One path answers for all places of the Sun at once; its error is the spread between paths. The depth towards the Sun is
read from a table of slant columns over (altitude, cosine), within 1e-4 of quadrature.
"""

import sys
import time
from pathlib import Path

import numba
import numpy as np

TRUTH = Path(__file__).resolve().parents[2] / "tests/truth"
TOP = 60e3
GROUND_ALBEDO = 0.1
AEROSOL_G = 0.8
AEROSOL_ALBEDO = 0.9
BANDS = np.array([0, 250, 500, 750, 1000, 1500, 2000, 3000, 4000, 6000, 8000, 10e3, 13e3, 16e3, 20e3, 25e3, 30e3, 35e3, 40e3,
                  50e3, TOP])
SUN_ZENITH_DEG = [80, 90, 92, 94, 96]
AZIMUTH_DEG = [0, 90, 180]

# Slant columns towards the top, divided by the extinction at the ground: per component, altitude and cosine >= 0.
COLUMN_H = np.concatenate([np.arange(0, 10e3, 125.0), np.arange(10e3, TOP + 1, 250.0)])
COLUMN_X = np.linspace(0, 1, 401)          # cosine = x^2: dense near the horizon


def coefficients(nm):
    """Extinction per metre: molecules at the ground, aerosol at the ground, ozone at 25 km."""
    ozone_m2 = {680: 1.209e-25, 550: 3.5e-25, 440: 1.582e-26}[nm]
    return np.array([1.24062e-6 * (nm / 1000) ** -4, 4.44e-6, 5.374e18 * ozone_m2])


@numba.njit
def shape(k, h):
    """Profile of component k."""
    if k == 0:
        return np.exp(-h / 8000.0)
    if k == 1:
        return np.exp(-h / 1200.0)
    return max(0.0, 1 - abs(h - 25e3) / 15e3)


@numba.njit
def slant(radius, h0, cosine, k, nodes, weights):
    """Integral of the profile from altitude h0 along a ray that climbs, to the top; piecewise Gauss in altitude^(1/2)."""
    r0 = radius + h0
    total = 0.0
    last = h0
    for edge in (1e3, 2e3, 4e3, 7e3, 10e3, 15e3, 20e3, 25e3, 30e3, 40e3, 50e3, 60e3):
        if edge <= last:
            continue
        # u = sqrt(h - h0) takes the singularity of a horizontal start away: dh = 2 u du.
        a, b = np.sqrt(last - h0), np.sqrt(edge - h0)
        for x, w in zip(nodes, weights):
            u = (a + b) / 2 + (b - a) / 2 * x
            rise = u * u
            # r^2 - b^2 = (r0 mu)^2 + (r - r0)(r + r0)
            root = np.sqrt((r0 * cosine) ** 2 + rise * (2 * r0 + rise))
            total += w * (b - a) / 2 * 2 * u * (r0 + rise) / root * shape(k, h0 + rise)
        last = edge
    return total


@numba.njit
def tabulate(radius, heights, xs, nodes, weights):
    """log of column / profile for the exponentials, the column itself for the tent."""
    out = np.zeros((3, len(heights), len(xs)))
    for i in range(len(heights)):
        for j in range(len(xs)):
            for k in range(3):
                c = slant(radius, min(heights[i], 59.999e3), xs[j] ** 2, k, nodes, weights)
                out[k, i, j] = c if k == 2 else np.log(c / shape(k, heights[i]))
    return out


@numba.njit
def read(table, k, h, x):
    """Bilinear reading of a column."""
    if h < 10e3:
        f = max(h, 0.0) / 125.0
    else:
        f = 80 + (min(h, 59.99e3) - 10e3) / 250.0
    i = int(f)
    f -= i
    g = x * 400
    j = min(int(g), 399)
    g -= j
    t = table[k]
    value = (1 - f) * ((1 - g) * t[i, j] + g * t[i, j + 1]) + f * ((1 - g) * t[i + 1, j] + g * t[i + 1, j + 1])
    return value if k == 2 else np.exp(value) * shape(k, h)


@numba.njit
def towards_sun(radius, table, ext, r, cosine):
    """Transmittance to space; 0 where the ground is in the way."""
    h = r - radius
    x = np.sqrt(abs(cosine))
    if cosine >= 0:
        depth = ext[0] * read(table, 0, h, x) + ext[1] * read(table, 1, h, x) + ext[2] * read(table, 2, h, x)
        return np.exp(-depth)
    tangent = r * np.sqrt(1 - cosine * cosine) - radius
    if tangent < 0:
        return 0.0
    depth = 0.0
    for k in range(3):
        depth += ext[k] * (2 * read(table, k, tangent, 0.0) - read(table, k, h, x))
    return np.exp(-max(depth, 0.0))


@numba.njit
def rayleigh(c):
    return 3 / (16 * np.pi) * (1 + c * c)


@numba.njit
def aerosol(c):
    g = AEROSOL_G
    s = 1 + g * g - 2 * g * c
    return 3 / (8 * np.pi) * (1 - g * g) * (1 + c * c) / ((2 + g * g) * s * np.sqrt(s))


@numba.njit
def turn(d, cosine):
    """A direction at the given angle from d, azimuth at random."""
    phi = 2 * np.pi * np.random.random()
    sine = np.sqrt(max(0.0, 1 - cosine * cosine))
    x, y, z = d
    if abs(z) < 0.9:
        n = np.sqrt(x * x + y * y)
        ax, ay, az = -y / n, x / n, 0.0
    else:
        n = np.sqrt(y * y + z * z)
        ax, ay, az = 0.0, -z / n, y / n
    bx, by, bz = y * az - z * ay, z * ax - x * az, x * ay - y * ax
    c, s = np.cos(phi) * sine, np.sin(phi) * sine
    x, y, z = x * cosine + ax * c + bx * s, y * cosine + ay * c + by * s, z * cosine + az * c + bz * s
    n = np.sqrt(x * x + y * y + z * z)
    return x / n, y / n, z / n


@numba.njit
def sample_cosine(which):
    """By rejection: 1 + c^2 over the uniform and over Henyey-Greenstein."""
    while True:
        if which == 0:
            c = 2 * np.random.random() - 1
        else:
            g = AEROSOL_G
            t = (1 - g * g) / (1 - g + 2 * g * np.random.random())
            c = (1 + g * g - t * t) / (2 * g)
        if 2 * np.random.random() < 1 + c * c:
            return c


@numba.njit
def trace(radius, table, ext, majorant, bands, altitude, view, suns, paths, proposals, later, orders, seed):
    """Sum and sum of squares of the paths' scores for each Sun."""
    np.random.seed(seed)
    count = len(suns)
    total, squares, score = np.zeros(count), np.zeros(count), np.zeros(count)
    top = radius + bands[-1]
    for _ in range(paths):
        score[:] = 0
        px, py, pz = 0.0, 0.0, radius + altitude
        dx, dy, dz = view[0], view[1], view[2]
        weight = 1.0
        order = 0
        while True:
            order += 1
            r0 = np.sqrt(px * px + py * py + pz * pz)
            along = px * dx + py * dy + pz * dz
            # Impact parameter without the cancellation of r0^2 - along^2: |p x d|.
            cx, cy, cz = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
            impact = np.sqrt(cx * cx + cy * cy + cz * cz)
            lowest = -along                      # distance at which the ray is nearest the centre
            hits = lowest > 0 and impact < radius
            if hits:
                end = lowest - np.sqrt((radius - impact) * (radius + impact))
            else:
                end = lowest + np.sqrt((top - impact) * (top + impact))
            floor = (proposals if order == 1 else later) / max(end, 1.0)
            t = 0.0
            through = 1.0
            collided = False
            at = 0.0
            band = min(max(np.searchsorted(bands, r0 - radius, side="right") - 1, 0), len(bands) - 2)
            if lowest > 0 and band > 0 and r0 - radius <= bands[band]:
                band -= 1
            while t < end:
                # Where the ray leaves this band.
                low = radius + bands[band]
                if t < lowest and impact < low and band > 0:
                    leave, step = lowest - np.sqrt((low - impact) * (low + impact)), -1
                elif t < lowest and impact < low:
                    leave, step = end, 0
                else:
                    high = radius + bands[band + 1]
                    leave, step = lowest + np.sqrt(max(0.0, (high - impact) * (high + impact))), 1
                leave = min(leave, end)
                bound = max(majorant[band], floor)
                t -= np.log(1 - np.random.random()) / bound
                if t >= leave:
                    t = leave
                    band += step
                    if leave >= end or band > len(bands) - 2:
                        break
                    continue
                x, y, z = px + t * dx, py + t * dy, pz + t * dz
                r = np.sqrt(x * x + y * y + z * z)
                h = r - radius
                s0 = ext[0] * shape(0, h)
                e1 = ext[1] * shape(1, h)
                s1 = AEROSOL_ALBEDO * e1
                extinction = s0 + e1 + ext[2] * shape(2, h)
                for n in range(count):
                    sx, sy, sz = suns[n, 0], suns[n, 1], suns[n, 2]
                    sun = towards_sun(radius, table, ext, r, (x * sx + y * sy + z * sz) / r)
                    if sun > 0:
                        c = dx * sx + dy * sy + dz * sz
                        score[n] += weight * through * sun * (s0 * rayleigh(c) + s1 * aerosol(c)) / bound
                real = extinction / bound
                if not collided and np.random.random() < real:
                    collided, at = True, t
                through *= 1 - real
            if hits:
                x, y, z = px + end * dx, py + end * dy, pz + end * dz
                for n in range(count):
                    c = (x * suns[n, 0] + y * suns[n, 1] + z * suns[n, 2]) / radius
                    if c > 0:
                        sun = towards_sun(radius, table, ext, radius, c)
                        score[n] += weight * through * GROUND_ALBEDO / np.pi * c * sun
            if orders > 0 and order >= orders:
                break
            if collided:
                px, py, pz = px + at * dx, py + at * dy, pz + at * dz
                h = np.sqrt(px * px + py * py + pz * pz) - radius
                s0 = ext[0] * shape(0, h)
                e1 = ext[1] * shape(1, h)
                s1 = AEROSOL_ALBEDO * e1
                weight *= (s0 + s1) / (s0 + e1 + ext[2] * shape(2, h))
                if weight < 0.1:
                    if np.random.random() > weight:
                        break
                    weight = 1.0
                which = 0 if np.random.random() * (s0 + s1) < s0 else 1
                dx, dy, dz = turn((dx, dy, dz), sample_cosine(which))
            elif hits:
                if np.random.random() > GROUND_ALBEDO:
                    break
                px, py, pz = px + end * dx, py + end * dy, pz + end * dz
                n = np.sqrt(px * px + py * py + pz * pz)
                dx, dy, dz = turn((px / n, py / n, pz / n), np.sqrt(np.random.random()))
                # A hair above the ground, so that the ray does not start below it.
                px, py, pz = px * (radius + 1e-3) / n, py * (radius + 1e-3) / n, pz * (radius + 1e-3) / n
            else:
                break
        for n in range(count):
            total[n] += score[n]
            squares[n] += score[n] * score[n]
    return total, squares


def unit(zenith_deg, azimuth_deg):
    z, a = np.radians(zenith_deg), np.radians(azimuth_deg)
    return np.array([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)])


class Tracer:
    def __init__(self, nm, radius=6360e3):
        self.ext, self.radius = coefficients(nm), radius
        nodes, weights = np.polynomial.legendre.leggauss(12)
        self.gauss = nodes, weights
        self.table = tabulate(radius, COLUMN_H, COLUMN_X, nodes, weights)
        # Each band's extinction is bounded by the sum of its components' bounds.
        low, high = BANDS[:-1], BANDS[1:]
        peak = np.array([shape(2, min(max(25e3, a), b)) for a, b in zip(low, high)])
        self.majorant = self.ext[0] * np.exp(-low / 8000) + self.ext[1] * np.exp(-low / 1200) + self.ext[2] * peak

    def radiance(self, altitude, view_zenith, suns, paths, proposals=4.0, later=4.0, orders=0, seed=1):
        """Means and standard errors for Suns given as (zenith, azimuth)."""
        directions = np.array([unit(z, a) for z, a in suns])
        total, squares = trace(self.radius, self.table, self.ext, self.majorant, BANDS, float(altitude),
                               unit(view_zenith, 0), directions, paths, float(proposals), float(later), orders, seed)
        mean = total / paths
        return mean, np.sqrt(np.maximum(squares / paths - mean * mean, 0) / paths)


HEAD = "altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm,radiance_per_sr,standard_error_per_sr"


def write_day(seconds):
    """High Suns, views up and down; each view has the same time."""
    rows = []
    views = [(a, v) for a in [0, 10000, 30000] for v in [0, 30, 60, 80, 87] + ([100, 120, 150, 180] if a else [])]
    for nm in [550, 440]:
        tracer = Tracer(nm)
        for altitude, view in views:
            suns = [(z, a) for z in [0, 45, 70, 80, 85, 88] for a in ([0, 90, 180] if z and view % 180 else [0])]
            tracer.radiance(altitude, view, suns, 10)
            clock = time.process_time()
            tracer.radiance(altitude, view, suns, 8000)
            paths = int(8000 * seconds / 46 / (time.process_time() - clock))
            mean, error = tracer.radiance(altitude, view, suns, paths, seed=nm * 1000 + view + altitude // 100 + 3)
            for (z, a), m, e in zip(suns, mean, error):
                if view or z:
                    rows.append(f"{altitude},{z},{view},{a},{nm},{m:.6e},{e:.2e}")
            print(nm, altitude, view, f"{paths} paths, worst error {100 * np.max(error / mean):.2f} %", flush=True)
    (TRUTH / "air_numba_mc_day.csv").write_text("\n".join([HEAD, *rows]) + "\n")
    print(f"{len(rows)} rows")


def write(seconds):
    """Give each view the same time, three quarters of it to the Suns that lie deepest."""
    rows = []
    start = time.time()
    for nm in [550, 440]:
        tracer = Tracer(nm)
        for altitude in [0, 10000]:
            for view in [0, 45, 75, 85, 89]:
                for zeniths, share in [((80, 90, 92), 0.25), ((94, 96), 0.75)]:
                    suns = [(z, a) for z in zeniths for a in AZIMUTH_DEG]
                    tracer.radiance(altitude, view, suns, 10)
                    clock = time.process_time()
                    tracer.radiance(altitude, view, suns, 8000)
                    paths = int(8000 * seconds / 20 * share / (time.process_time() - clock))
                    seed = nm * 1000 + view + altitude // 100 + 7 * zeniths[0]
                    mean, error = tracer.radiance(altitude, view, suns, paths, seed=seed)
                    if view == 0:
                        # The azimuth means nothing at the zenith.
                        suns = [(z, 0) for z in zeniths]
                        mean, error = mean[::3], error[::3]
                    for (z, a), m, e in zip(suns, mean, error):
                        rows.append(f"{altitude},{z},{view},{a},{nm},{m:.6e},{e:.2e}")
                    print(nm, altitude, view, zeniths, f"{paths} paths, {time.process_time() - clock:.0f} s, errors %",
                          np.array2string(100 * error / mean, precision=2, max_line_width=200), flush=True)
    (TRUTH / "air_numba_mc.csv").write_text("\n".join([HEAD, *rows]) + "\n")
    print(f"{len(rows)} rows, {time.time() - start:.0f} s")


def check():
    tracer = Tracer(440)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    random = np.random.default_rng(1)
    worst = 0.0
    for _ in range(2000):
        h, cosine = random.uniform(0, 59e3), random.uniform(-0.12, 0.4)
        r = tracer.radius + h
        ours = towards_sun(tracer.radius, tracer.table, tracer.ext, r, cosine)
        if ours <= 0:
            continue
        tangent = r * np.sqrt(1 - cosine**2) - tracer.radius
        depth = 0.0
        for k in range(3):
            up = slant(tracer.radius, h, abs(cosine), k, nodes, weights)
            depth += tracer.ext[k] * (up if cosine >= 0 else 2 * slant(tracer.radius, tangent, 0.0, k, nodes, weights) - up)
        worst = max(worst, abs(ours - np.exp(-depth)))
    print(f"transmittance towards the Sun: worst error {worst:.1e}")
    # First order by quadrature along the view (100,000 midpoints), the Sun's depth by quadrature too.
    for altitude, view, sun in [(0, 45, (90, 90)), (10000, 89, (94, 0)), (0, 0, (96, 0))]:
        d, s = unit(view, 0), unit(*sun)
        p = np.array([0, 0, tracer.radius + altitude])
        along = p @ d
        end = -along + np.sqrt(along**2 + (tracer.radius + TOP) ** 2 - p @ p)
        t = (np.arange(20000) + 0.5) * end / 20000
        q = p + t[:, None] * d
        r = np.linalg.norm(q, axis=1)
        h = r - tracer.radius
        e = [tracer.ext[k] * np.array([shape(k, x) for x in h]) for k in range(3)]
        depth = np.cumsum(sum(e)) * end / 20000 - sum(e) / 2 * end / 20000
        sunlight = np.zeros(len(t))
        for i in range(len(t)):
            cosine = q[i] @ s / r[i]
            tangent = r[i] * np.sqrt(1 - cosine**2) - tracer.radius
            if cosine < 0 and tangent < 0:
                continue
            for k in range(3):
                up = slant(tracer.radius, h[i], abs(cosine), k, *tracer.gauss)
                sunlight[i] += tracer.ext[k] * (up if cosine >= 0 else
                                                2 * slant(tracer.radius, tangent, 0.0, k, *tracer.gauss) - up)
            sunlight[i] = np.exp(-sunlight[i])
        c = d @ s
        exact = np.sum(np.exp(-depth) * sunlight * (e[0] * rayleigh(c) + AEROSOL_ALBEDO * e[1] * aerosol(c))) * end / 20000
        mean, error = tracer.radiance(altitude, view, [sun], 400000, orders=1)
        print(f"first order {altitude} {view} {sun}: quadrature {exact:.5e}, {mean[0] / exact - 1:+.2e} +- {error[0] / exact:.1e}")
    # Flat air: a planet a thousand times as large against tests/truth/air_disort_bruneton2017.csv.
    table = {}
    for line in (TRUTH / "air_disort_bruneton2017.csv").read_text().splitlines()[1:]:
        f = [float(x) for x in line.split(",")]
        table[tuple(f[:5])] = f[5]
    for nm in [550, 440]:
        flat = Tracer(nm, 6360e6)
        for altitude, view in [(0, 0), (0, 30), (0, 80), (10000, 60), (10000, 100), (10000, 150), (30000, 180)]:
            suns = [(z, a) for z in [30, 60, 75, 85] for a in [45, 180] if (altitude, z, view, a, nm) in table]
            suns = suns or [(z, 0) for z in [30, 60, 75]]
            mean, error = flat.radiance(altitude, view, suns, 300000)
            for (z, a), m, e in zip(suns, mean, error):
                exact = table.get((altitude, z, view, a, nm))
                if exact:
                    print(f"flat {nm} {altitude} view {view} Sun {z} azimuth {a}: {m / exact - 1:+.2e} +- {e / exact:.1e}")


if __name__ == "__main__":
    if "check" in sys.argv:
        check()
    elif "day" in sys.argv:
        write_day(200.0)
    else:
        write(660.0)

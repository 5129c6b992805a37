#!/usr/bin/env python3.11
"""Writes tests/truth/air_sasktran_*.csv: light scattered once in spherical air.

Needs:  pip install sasktran2==2026.10.1 numpy==2.4.6
Run:    python3.11 xtask/data/air_sasktran.py              (from the repository root; two minutes)
        python3.11 xtask/data/air_sasktran.py converge     (the figures of tests/truth/SOURCE.md)
        python3.11 xtask/data/air_sasktran.py multiple     (why the orders beyond the first are left out)

`bruneton2017` and `earth-haze` on their sphere, scalar, without refraction: the program's exact single scattering along the
ray, and sunlight reflected once by the ground. Extinction, albedo and 96 moments are given on a grid of altitudes and
interpolated linearly by the program.

Its multiple scattering (`SuccessiveOrders`, and `SuccessiveOrdersLegacy`) is no truth for us: it does not converge to the plane-parallel
limit nor to the Monte Carlo of air_numba_mc.py when the Sun is low (tests/truth/SOURCE.md has the figures), whatever the knobs.
"""

import sys
import time
from pathlib import Path

import numpy as np
import sasktran2 as sk

TRUTH = Path(__file__).resolve().parents[2] / "tests/truth"
RADIUS, TOP, ALBEDO = 6360e3, 60e3, 0.1
WAVELENGTHS_NM = np.array([680, 550, 440])
OZONE_M2 = np.array([1.209e-25, 3.5e-25, 1.582e-26])
MOMENTS = 96
ALTITUDES = 600


def cornette_shanks(g):
    return lambda c: 3 / (8 * np.pi) * (1 - g * g) * (1 + c * c) / ((2 + g * g) * (1 + g * g - 2 * g * c) ** 1.5)


def henyey_greenstein(g):
    return lambda c: (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * c) ** 1.5)


# Extinction at the ground, scale height, albedo, phase.
AEROSOL = {
    "bruneton2017": (4.44e-6, 1200.0, 0.9, cornette_shanks(0.8)),
    "earth-haze": (1 / 1500, 1500.0, 0.95, henyey_greenstein(0.76)),
}


def weighted_moments(phase):
    """(2l+1) chi_l."""
    c, w = np.polynomial.legendre.leggauss(2000)
    p = np.polynomial.legendre.Legendre.basis
    return np.array([(2 * l + 1) * 2 * np.pi * np.sum(w * phase(c) * p(l)(c)) for l in range(MOMENTS)])


def grid(count, height):
    """Altitudes dense where the aerosol is, the tent's kinks among them."""
    h = np.linspace(0, TOP, 100001)
    share = (1 - np.exp(-h / height)) / (1 - np.exp(-TOP / height)) + 1 - np.exp(-h / 8000) + h / TOP
    even = np.interp(np.linspace(0, share[-1], count + 1), share, h)
    return np.unique(np.round(np.concatenate([even, [0, 10e3, 25e3, 40e3, TOP]]), 2))


def solve(name, sun_deg, points, altitudes=ALTITUDES, multiple=False, sources=40, columns=3, incoming=110, outgoing=110):
    """Radiance: points x wavelengths."""
    ground, height, albedo, phase = AEROSOL[name]
    h = grid(altitudes, height)
    config = sk.Config()
    config.num_stokes = 1
    config.num_threads = 1
    config.single_scatter_source = sk.SingleScatterSource.Exact
    source = sk.MultipleScatterSource
    config.multiple_scatter_source = source.SuccessiveOrders if multiple else source.NoSource
    config.num_streams = config.num_singlescatter_moments = MOMENTS
    config.num_sza = columns
    config.num_successive_orders_incoming, config.num_successive_orders_outgoing = incoming, outgoing
    config.num_successive_orders_iterations = 100
    coarse = grid(sources, height)
    config.successive_orders_altitude_grid_m = (coarse[1:] + coarse[:-1]) / 2
    cos_sun = np.cos(np.radians(sun_deg))
    geometry = sk.Geometry1D(cos_sun, 0.0, RADIUS, h)
    viewing = sk.ViewingGeometry()
    for altitude, view, azimuth in points:
        viewing.add_ray(sk.SolarAnglesObserverLocation(cos_sun, np.radians(azimuth), np.cos(np.radians(view)), altitude))
    engine = sk.Engine(config, geometry, viewing)
    air = sk.Atmosphere(geometry, config, numwavel=3, calculate_derivatives=False)
    molecules = np.exp(-h / 8000)[:, None] * 1.24062e-6 * (WAVELENGTHS_NM / 1000.0) ** -4
    aerosol = np.exp(-h / height)[:, None] * ground * np.ones(3)
    ozone = np.clip(1 - np.abs(h - 25e3) / 15e3, 0, None)[:, None] * 5.374e18 * OZONE_M2
    extinction, scattering = molecules + aerosol + ozone, molecules + albedo * aerosol
    rayleigh = weighted_moments(lambda c: 3 / (16 * np.pi) * (1 + c * c))
    moments = (molecules * rayleigh[:, None, None] + albedo * aerosol * weighted_moments(phase)[:, None, None]) / scattering
    air["air"] = sk.constituent.Manual(extinction, scattering / extinction, moments)
    air["ground"] = sk.constituent.LambertianSurface(ALBEDO)
    radiance = engine.calculate_radiance(air)["radiance"]
    return radiance.transpose("los", "wavelength", ...).values.reshape(len(points), 3)


def queries(sun_deg):
    for altitude in [0, 2000, 10000, 30000, 100000]:
        views = [0, 30, 60, 80, 87, 89.5] if altitude < TOP else [99.5]
        if altitude >= 10000:
            views += [100, 120, 150, 180]
        for view in views:
            for azimuth in [0] if view in (0, 180) or sun_deg == 0 else [0, 45, 90, 180]:
                if view != sun_deg or azimuth:
                    yield altitude, view, azimuth


def sharp(sun_deg, view, azimuth, radiance):
    """In twilight, rays along the edge of the planet's shadow are left out: their answer hangs on the steps."""
    return sun_deg < 90 or radiance == 0 or (radiance > 1e-5 and (view, azimuth) != (89.5, 180))


def write(name):
    rows = []
    start = time.time()
    for sun_deg in [0, 30, 60, 75, 85, 89, 91, 93, 96]:
        points = list(queries(sun_deg))
        answer = solve(name, sun_deg, points)
        for i, nm in enumerate(WAVELENGTHS_NM):
            rows += [f"{a},{sun_deg},{v},{z},{nm},{r:.6e}" for (a, v, z), r in zip(points, answer[:, i])
                     if sharp(sun_deg, v, z, r)]
    head = "altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm,first_order_per_sr"
    path = TRUTH / f"air_sasktran_{name.replace('-', '_')}.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    print(f"{path}: {len(rows)} rows, {time.time() - start:.0f} s")


def converge():
    for name in AEROSOL:
        for sun_deg in [60, 91]:
            points = list(queries(sun_deg))
            final = solve(name, sun_deg, points)
            for altitudes in [300, 1200]:
                answer = solve(name, sun_deg, points, altitudes)
                lit = final > 1e-9
                change = np.where(lit, np.abs(answer / np.where(lit, final, 1) - 1), 0)
                worst = np.unravel_index(np.argmax(change), change.shape)
                print(f"{name}, Sun {sun_deg}, {altitudes} altitudes: median {np.median(change[lit]):.1e}, worst "
                      f"{change[worst]:.1e} at {points[worst[0]]} {WAVELENGTHS_NM[worst[1]]} nm", flush=True)


def multiple():
    """All orders towards the zenith, from the ground; the plane-parallel radiance of air_disort_bruneton2017.csv beside them."""
    flat = {}
    for line in (TRUTH / "air_disort_bruneton2017.csv").read_text().splitlines()[1:]:
        f = [float(x) for x in line.split(",")]
        flat[tuple(f[:5])] = f[5]
    for sun_deg in [60, 75, 91]:
        for knobs in [dict(), dict(incoming=302), dict(outgoing=302), dict(columns=5)]:
            answer = solve("bruneton2017", sun_deg, [(0, 0, 0)], 120, True, **knobs)[0]
            print(sun_deg, knobs, answer, [flat.get((0, sun_deg, 0, 0, nm)) for nm in WAVELENGTHS_NM], flush=True)


if __name__ == "__main__":
    if "converge" in sys.argv:
        converge()
    elif "multiple" in sys.argv:
        multiple()
    else:
        for name in AEROSOL:
            write(name)

"""Independent tables of events: rise, set and twilights for 100 site-days, lunar eclipses 1950-2050, from DE440 with erfa.

usage: make_truth_events.py DE440_BSP TARGET_FOLDER
Needs PyPI pyerfa, jplephem, numpy, scipy. TARGET_FOLDER is crates/himmel-astro/tests/truth.
"""
import csv
import sys
from pathlib import Path

import erfa
import numpy as np
from scipy.optimize import brentq

from truth_apparatus import AU_KM, CHAIN, C_KM_D, EARTH, apparent, state

target = Path(sys.argv[2])
rng = np.random.default_rng(1950)

KINDS = {"sun": -50 / 60, "civil": -6.0, "nautical": -12.0, "astronomical": -18.0}
with open(target / "rise_set.csv", "w") as f:
    w = csv.writer(f, lineterminator="\n")
    w.writerow(["jd_tt_start", "delta_t_s", "latitude_deg", "longitude_deg", "height_m", "event", "jd_tt"])
    for _ in range(100):
        start = np.floor(rng.uniform(2415021, 2469800)) + 0.5
        dt = round(rng.uniform(0, 70), 3)
        lat = round(np.degrees(np.arcsin(rng.uniform(-0.97, 0.97))), 5)
        lon, h = round(rng.uniform(-180, 180), 5), round(rng.uniform(0, 2500), 1)
        grid = start + np.arange(0, 1 + 1e-9, 1 / 240)

        def altitude(body, tt):
            r = apparent(body, tt, tt - dt / 86400, lat, lon, h)
            return r[3] + (34 / 60 + np.degrees(np.arcsin(1737.4 / r[4])) if body == "moon" else 0.0)

        for body, kinds in (("sun", KINDS), ("moon", {"moon": 0.0})):
            alt = np.array([altitude(body, t) for t in grid])
            for kind, threshold in kinds.items():
                for i in np.nonzero((alt[:-1] > threshold) != (alt[1:] > threshold))[0]:
                    jd = brentq(lambda t: altitude(body, t) - threshold, grid[i], grid[i + 1], xtol=1e-9)
                    w.writerow([repr(float(start)), dt, lat, lon, h,
                                kind + ("_rise" if alt[i + 1] > threshold else "_set"), f"{jd:.8f}"])
                if not ((alt > threshold).any() and (alt < threshold).any()):
                    w.writerow([repr(float(start)), dt, lat, lon, h, kind + ("_up" if alt[0] > threshold else "_down"), ""])


def geocentric(name, tt):
    """Apparent direction by light time and aberration; for the Moon the distance of the same instant."""
    tdb = tt + 0.001657 / 86400 * np.sin(np.radians(357.53 + 0.98560028 * (tt - 2451545)))
    ep, ev = state(EARTH, tdb)
    tau = 0.0
    for _ in range(5):
        body = state(CHAIN[name], tdb - tau)[0]
        tau = np.linalg.norm(body - ep) / C_KM_D
    u = (body - ep) / np.linalg.norm(body - ep)
    beta = ev / C_KM_D
    sun = state(CHAIN["sun"], tdb)[0]
    u = erfa.ab(u, beta, np.linalg.norm(ep - sun) / AU_KM, np.sqrt(1 - beta @ beta))
    return u, np.linalg.norm((state(CHAIN[name], tdb)[0] if name == "moon" else body) - ep)


def shadow(tt):
    """Separation, umbra, penumbra, Moon (radians), Danjon's enlargement."""
    (m, dm), (s, ds) = geocentric("moon", tt), geocentric("sun", tt)
    d = 2 * np.arcsin(np.linalg.norm(m + s) / 2)
    pm, ps, ss = np.arcsin(6378.1366 / dm), np.arcsin(6378.1366 / ds), np.arcsin(695700 / ds)
    return d, 1.01 * pm + ps - ss, 1.01 * pm + ps + ss, np.arcsin(1737.4 / dm)


with open(target / "lunar_eclipses.csv", "w") as f:
    w = csv.writer(f, lineterminator="\n")
    w.writerow(["greatest_jd_tt", "type", "umbral_magnitude", "penumbral_magnitude", "p1", "u1", "u2", "u3", "u4", "p4"])
    k = (2433282.5 - 2451550.09766) // 29.530588861 - 1
    count = 0
    while True:
        k += 1
        guess = 2451550.09766 + 29.530588861 * (k + 0.5)
        if guess > 2469807.5 + 1:
            break
        if min(shadow(guess + x)[0] for x in (-0.6, -0.3, 0, 0.3, 0.6)) > 0.075:
            continue
        coarse = min(np.arange(guess - 0.8, guess + 0.8, 0.05), key=lambda t: shadow(t)[0])
        # The derivative's zero: a minimiser alone finds it only to seconds.
        if shadow(coarse)[0] > 0.04:
            continue
        slope = lambda t: shadow(t + 0.002)[0] ** 2 - shadow(t - 0.002)[0] ** 2
        t0 = brentq(slope, coarse - 0.06, coarse + 0.06, xtol=1e-9)
        if not 2433282.5 <= t0 <= 2469807.5:
            continue
        d, u, p, m = shadow(t0)
        if p + m - d <= 0:
            continue

        def contact(g, side):
            if g(*shadow(t0)) <= 0:
                return ""
            return f"{brentq(lambda t: g(*shadow(t)), t0, t0 + side * 0.19, xtol=1e-9):.8f}"

        P = lambda d, u, p, m: p + m - d
        U = lambda d, u, p, m: u + m - d
        T = lambda d, u, p, m: u - m - d
        kind = "total" if u - m - d > 0 else "partial" if u + m - d > 0 else "penumbral"
        w.writerow([f"{t0:.8f}", kind, f"{(u + m - d) / (2 * m):.6f}", f"{(p + m - d) / (2 * m):.6f}", contact(P, -1),
                    contact(U, -1), contact(T, -1), contact(T, 1), contact(U, 1), contact(P, 1)])
        count += 1
print(count, "lunar eclipses")

# Solar eclipses at places: around each new moon of 1950-2050 near a node, places drawn until one sees an eclipse well above the horizon.


def discs(tt, dt, lat, lon, h):
    s, m = (apparent(b, tt, tt - dt / 86400, lat, lon, h) for b in ("sun", "moon"))
    a1, h1, a2, h2 = (np.radians(x) for x in (s[2], s[3], m[2], m[3]))
    d = 2 * np.arcsin(np.sqrt(np.sin((h1 - h2) / 2) ** 2 + np.cos(h1) * np.cos(h2) * np.sin((a1 - a2) / 2) ** 2))
    return d, np.arcsin(695700 / s[4]), np.arcsin(1737.4 / m[4]), s[3]


def on_the_axis(tt, dt):
    """Latitude and longitude (geocentric, degrees) where the shadow's axis meets a round Earth, or None."""
    (m, dm), (s, ds) = geocentric("moon", tt), geocentric("sun", tt)
    m, s = m * dm, s * ds
    a = (m - s) / np.linalg.norm(m - s)
    half = m @ a
    root = half**2 - (m @ m - 6371.0**2)
    if root < 0:
        return None
    p = m + a * (-half - np.sqrt(root))
    p = erfa.rz(erfa.gst06a(tt - dt / 86400, 0.0, tt, 0.0), np.eye(3)) @ erfa.pnm06a(tt, 0.0) @ p
    return round(np.degrees(np.arcsin(p[2] / np.linalg.norm(p))), 4), round(np.degrees(np.arctan2(p[1], p[0])), 4)


with open(target / "solar_eclipses.csv", "w") as f:
    w = csv.writer(f, lineterminator="\n")
    w.writerow(["latitude_deg", "longitude_deg", "height_m", "delta_t_s", "max_jd_tt", "type", "magnitude", "c1", "c2", "c3", "c4"])
    k, count, kinds = -620.0, 0, {}
    while count < 40:
        k += 1
        guess = 2451550.09766 + 29.530588861 * k
        grid = [guess + x for x in np.arange(-0.7, 0.71, 0.1)]
        sep = [2 * np.arcsin(np.linalg.norm(geocentric("moon", t)[0] - geocentric("sun", t)[0]) / 2) for t in grid]
        if min(sep) > 0.017:
            continue
        conjunction = grid[int(np.argmin(sep))]
        for _ in range(40):
            lat = round(np.degrees(np.arcsin(rng.uniform(-0.95, 0.95))), 4)
            lon, h, dt = round(rng.uniform(-180, 180), 4), round(rng.uniform(0, 2000), 1), round(rng.uniform(30, 70), 2)
            if count % 2:  # every second one near the path of a central eclipse
                point = on_the_axis(conjunction + rng.uniform(-0.08, 0.08), dt)
                if point is None:
                    continue
                lat, lon = point
            times = conjunction + np.arange(-0.2, 0.2, 1 / 96)
            ds = [discs(t, dt, lat, lon, h) for t in times]
            i = int(np.argmin([d[0] for d in ds]))
            if 0 < i < len(ds) - 1 and ds[i][0] < 0.75 * (ds[i][1] + ds[i][2]) and ds[i][3] > 15:
                slope = lambda t: discs(t + 0.002, dt, lat, lon, h)[0] ** 2 - discs(t - 0.002, dt, lat, lon, h)[0] ** 2
                t0 = brentq(slope, times[i - 1], times[i + 1], xtol=1e-9)
                break
        else:
            continue

        def touch(g, side):
            at = lambda t: g(*discs(t, dt, lat, lon, h)[:3])
            return f"{brentq(at, t0, t0 + side * 0.11, xtol=1e-9):.8f}" if at(t0) > 0 else ""

        d, s, m, _ = discs(t0, dt, lat, lon, h)
        outer, inner = (lambda d, s, m: s + m - d), (lambda d, s, m: abs(m - s) - d)
        kind = "partial" if inner(d, s, m) <= 0 else "total" if m >= s else "annular"
        kinds[kind] = kinds.get(kind, 0) + 1
        w.writerow([lat, lon, h, dt, f"{t0:.8f}", kind, f"{(s + m - d) / (2 * s):.6f}", touch(outer, -1), touch(inner, -1),
                    touch(inner, 1), touch(outer, 1)])
        count += 1
print(count, "solar eclipses at places", kinds)

from skyfield import magnitudelib as ml
from skyfield.api import load, load_file, wgs84
from skyfield.functions import angle_between

ts, planets = load.timescale(), load_file(sys.argv[1])
with open(target / "magnitudes.csv", "w") as f:
    w = csv.writer(f, lineterminator="\n")
    w.writerow(["body", "jd_tt", "jd_ut1", "latitude_deg", "longitude_deg", "height_m", "magnitude", "phase_angle_deg"])
    for _ in range(30):
        t = ts.tt_jd(rng.uniform(2415021, 2469800))
        observer = (planets["earth"] + wgs84.latlon(0, 0)).at(t)
        # skyfield's planetary_magnitude takes the barycentre for the Sun; its formulae get the true Sun here.
        sun = planets["sun"].at(t).xyz.au
        for name in ("mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"):
            key = name if name in ("mercury", "venus") else name + " barycenter"
            to_planet = observer.observe(planets[key]).xyz.au
            from_sun = observer.xyz.au + to_planet - sun
            r, delta = np.linalg.norm(from_sun), np.linalg.norm(to_planet)
            phase = np.degrees(angle_between(from_sun, to_planet))
            formula, more = getattr(ml, f"_{name}_magnitude"), []
            if name in ("saturn", "uranus"):
                pole = ml._SATURN_POLE if name == "saturn" else ml._URANUS_POLE
                more = [np.degrees(angle_between(pole, v)) - 90.0 for v in (from_sun, to_planet)]
            elif name == "neptune":
                more = [t.J]
            m = float(formula(r, delta, phase, *more))
            if np.isfinite(m):
                w.writerow([name, repr(float(t.tt)), repr(float(t.ut1)), 0, 0, 0, f"{m:.5f}", f"{phase:.5f}"])

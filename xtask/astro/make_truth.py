"""Independent tables for the truth tests: apparent topocentric places by skyfield and by erfa, from DE440.

usage: make_truth.py DE440_BSP HIP2_DAT TARGET_FOLDER
Needs PyPI skyfield, pyerfa, jplephem, numpy. TARGET_FOLDER is crates/himmel-astro/tests/truth.
"""
import csv
import sys
from pathlib import Path

import erfa
import numpy as np
from jplephem.spk import SPK

bsp, hip2, target = sys.argv[1], sys.argv[2], Path(sys.argv[3])
rng = np.random.default_rng(440)
kernel = SPK.open(bsp)
C_KM_D = 299792.458 * 86400
AU_KM = 149597870.7
CHAIN = {
    "sun": [(0, 10)], "moon": [(0, 3), (3, 301)], "mercury": [(0, 1), (1, 199)], "venus": [(0, 2), (2, 299)],
    "mars": [(0, 4)], "jupiter": [(0, 5)], "saturn": [(0, 6)], "uranus": [(0, 7)], "neptune": [(0, 8)], "pluto": [(0, 9)],
}
EARTH = [(0, 3), (3, 399)]


def state(chain, jd):
    """Barycentric position km and velocity km/day."""
    p, v = np.zeros(3), np.zeros(3)
    for c, t in chain:
        a, b = kernel[c, t].compute_and_differentiate(jd)
        p += a[:3]
        v += b[:3]
    return p, v


def site(lat, lon, height, tt, ut1):
    """GCRS position km and velocity km/day of a place, IAU 2006/2000A, no polar motion."""
    bpn = erfa.pnm06a(tt, 0.0)
    gast = erfa.gst06(ut1, 0.0, tt, 0.0, bpn)
    r3 = erfa.rz(gast, np.eye(3))
    xyz = erfa.gd2gc(1, np.radians(lon), np.radians(lat), height) / 1e3
    omega = 2 * np.pi * 1.00273781191135448
    m = (r3 @ bpn).T
    return m @ xyz, m @ np.array([-xyz[1], xyz[0], 0]) * omega, bpn, gast


def angles(u, lat, lon, bpn, gast):
    e = bpn @ u
    ra, dec = np.arctan2(e[1], e[0]) % (2 * np.pi), np.arcsin(e[2])
    h = gast + np.radians(lon) - ra
    az, alt = erfa.hd2ae(h, dec, np.radians(lat))
    return [np.degrees(x) for x in (ra, dec, az, alt)]


def apparent(name, tt, ut1, lat, lon, height):
    tdb = tt + (0.001657 * np.sin(np.radians(357.53 + 0.98560028 * (tt - 2451545)))
                + 0.000022 * np.sin(np.radians(246.11 + 0.90251792 * (tt - 2451545)))) / 86400
    ep, ev = state(EARTH, tdb)
    sp, sv, bpn, gast = site(lat, lon, height, tt, ut1)
    op, ov = ep + sp, ev + sv
    sun = state(CHAIN["sun"], tdb)[0]
    tau = 0.0
    for _ in range(6):
        body = state(CHAIN[name], tdb - tau)[0]
        tau = np.linalg.norm(body - op) / C_KM_D
    d = np.linalg.norm(body - op)
    u = (body - op) / d
    if name not in ("sun", "moon"):
        q = (body - sun) / np.linalg.norm(body - sun)
        e = (op - sun) / np.linalg.norm(op - sun)
        u = erfa.ld(1.0, u, q, e, np.linalg.norm(op - sun) / AU_KM, 1e-6)
    beta = ov / C_KM_D
    u = erfa.ab(u, beta, np.linalg.norm(op - sun) / AU_KM, np.sqrt(1 - beta @ beta))
    if name == "moon":
        d = np.linalg.norm(state(CHAIN["moon"], tdb)[0] - op)
    return angles(u, lat, lon, bpn, gast) + [d]


def places(n, first, last):
    for _ in range(n):
        year = rng.uniform(first, last)
        tt = 2451545.0 + (year - 2000) * 365.25
        ut1 = tt - (30 + rng.uniform(-30, 50)) / 86400
        lat = np.degrees(np.arcsin(rng.uniform(-1, 1)))
        yield tt, ut1, lat, rng.uniform(-180, 180), rng.uniform(0, 3000)


HEAD = ["body", "jd_tt", "jd_ut1", "latitude_deg", "longitude_deg", "height_m", "ra_deg", "dec_deg", "azimuth_deg", "altitude_deg"]
with open(target / "bodies.csv", "w") as f:
    w = csv.writer(f, lineterminator="\n")
    w.writerow(HEAD + ["distance_km"])
    for tt, ut1, lat, lon, h in places(120, 1900, 2053):
        for name in CHAIN:
            r = apparent(name, tt, ut1, lat, lon, h)
            w.writerow([name, repr(tt), repr(ut1), f"{lat:.9f}", f"{lon:.9f}", f"{h:.3f}"]
                       + [f"{x:.8f}" for x in r[:4]] + [f"{r[4]:.4f}"])

stars = {}
for line in open(hip2):
    f = line.split()
    stars[int(f[0])] = f
wanted = [32349, 30438, 69673, 71683, 91262, 24436, 37279, 27989, 7588, 68702, 97649, 21421, 65474, 80763, 37826, 11767, 54061, 8102, 104214]
with open(target / "stars.csv", "w") as f:
    w = csv.writer(f, lineterminator="\n")
    w.writerow(HEAD)
    for tt, ut1, lat, lon, h in places(30, 1900, 2053):
        tdb = tt
        ep, ev = state(EARTH, tdb)
        sp, sv, bpn, gast = site(lat, lon, h, tt, ut1)
        op, ov = ep + sp, ev + sv
        sun = state(CHAIN["sun"], tdb)[0]
        for hip in wanted:
            row = stars[hip]
            ra, dec, plx, pmra, pmdec = (float(x) for x in row[4:9])
            epoch = 2448349.0625
            s = erfa.pmpx(ra, dec, pmra * 1e-3 / 206264.80624709636 / np.cos(dec), pmdec * 1e-3 / 206264.80624709636,
                          plx * 1e-3, 0.0, (tdb - epoch) / 365.25, op / AU_KM)
            e = (op - sun) / np.linalg.norm(op - sun)
            u = erfa.ld(1.0, s, s, e, np.linalg.norm(op - sun) / AU_KM, 1e-6)
            beta = ov / C_KM_D
            u = erfa.ab(u, beta, np.linalg.norm(op - sun) / AU_KM, np.sqrt(1 - beta @ beta))
            w.writerow([f"HIP {hip}", repr(tt), repr(ut1), f"{lat:.9f}", f"{lon:.9f}", f"{h:.3f}"]
                       + [f"{x:.8f}" for x in angles(u, lat, lon, bpn, gast)])

# The same apparatus against skyfield, which shares nothing with it but DE440: printed, not stored.
from skyfield.api import load_file, wgs84, load
ts = load.timescale()
planets = load_file(bsp)
worst = 0.0
for tt, ut1, lat, lon, h in places(20, 1973, 2020):
    for name in CHAIN:
        t = ts.tt_jd(tt)
        ut1 = float(t.ut1)
        key = {"sun": "sun", "moon": "moon", "mercury": "mercury", "venus": "venus"}.get(name, name + " barycenter")
        place = planets["earth"] + wgs84.latlon(lat, lon, h)
        alt, az, _ = place.at(t).observe(planets[key]).apparent().altaz()
        ours = apparent(name, tt, ut1, lat, lon, h)
        d = np.hypot((ours[3] - alt.degrees), ((ours[2] - az.degrees + 180) % 360 - 180) * np.cos(alt.radians)) * 3600
        worst = max(worst, d)
print(f"erfa against skyfield: largest difference {worst:.4f} arcseconds")

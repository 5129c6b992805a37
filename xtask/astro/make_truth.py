"""Independent tables for the truth tests: apparent topocentric places from DE440 with erfa, compared with skyfield.

usage: make_truth.py DE440_BSP HIP2_DAT TARGET_FOLDER
Needs PyPI skyfield, pyerfa, jplephem, numpy. TARGET_FOLDER is crates/himmel-astro/tests/truth.
"""
import csv
import sys
from pathlib import Path

import erfa
import numpy as np

from truth_apparatus import AU_KM, CHAIN, C_KM_D, EARTH, angles, apparent, site, state

bsp, hip2, target = sys.argv[1], sys.argv[2], Path(sys.argv[3])
rng = np.random.default_rng(440)


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

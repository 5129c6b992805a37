"""Shown by 1 of issue 3: `himmel ephemeris` against skyfield and DE440, 300 instants x nine bodies and a star.

usage: check_ephemeris.py HIMMEL DE440_BSP HIP2_DAT
HIMMEL is the binary. Prints, for both levels, the largest differences: horizontal and equatorial (arcseconds), distance (relative).
"""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from skyfield.api import Star, load, load_file, wgs84

himmel, bsp, hip2 = sys.argv[1:4]
rng = np.random.default_rng(7)
eph = load_file(bsp)
stars = {}
for line in open(hip2):
    f = line.split()
    stars[int(f[0])] = [float(x) for x in f[4:9]]
BODIES = {"sun": "sun", "moon": "moon", "mercury": "mercury", "venus": "venus", "mars": "mars barycenter",
          "jupiter": "jupiter barycenter", "saturn": "saturn barycenter", "uranus": "uranus barycenter",
          "neptune": "neptune barycenter"}
HIPS = [32349, 71683, 104214, 11767, 91262, 24436, 27989]
rows, truth = [], []
for i in range(300):
    delta_t = rng.uniform(0, 90)
    tt = float(rng.uniform(2415021, 2470900))
    t = load.timescale(delta_t=delta_t).tt_jd(tt)
    lat, lon, h = (float(x) for x in (np.degrees(np.arcsin(rng.uniform(-1, 1))), rng.uniform(-180, 180), rng.uniform(0, 4000)))
    site = (eph["earth"] + wgs84.latlon(lat, lon, elevation_m=h)).at(t)
    targets = [(name, eph[key]) for name, key in BODIES.items()]
    hip = HIPS[i % len(HIPS)]
    ra, dec, parallax, pm_ra, pm_dec = stars[hip]
    targets.append((f"HIP {hip}", Star(ra_hours=np.degrees(ra) / 15, dec_degrees=np.degrees(dec), ra_mas_per_year=pm_ra,
                                       dec_mas_per_year=pm_dec, parallax_mas=parallax, epoch=2448349.0625)))
    for name, target in targets:
        seen = site.observe(target).apparent()
        alt, az, distance = seen.altaz()
        ra_, dec_, _ = seen.radec("date")
        km = np.linalg.norm((eph["moon"].at(t) - site).xyz.km) if name == "moon" else distance.km
        rows.append([name, repr(tt), repr(float(tt - delta_t / 86400)), repr(lat), repr(lon), repr(h)])
        truth.append((az.degrees, alt.degrees, ra_._degrees, dec_.degrees, km))


def separation(lon1, lat1, lon2, lat2):
    return np.hypot(((lon1 - lon2 + 180) % 360 - 180) * np.cos(np.radians(lat1)), lat1 - lat2) * 3600


with tempfile.TemporaryDirectory() as folder:
    questions, answers = Path(folder) / "q.csv", Path(folder) / "a.csv"
    with open(questions, "w") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(["body", "jd_tt", "jd_ut1", "latitude_deg", "longitude_deg", "height_m"])
        w.writerows(rows)
    for level in ("precise", "fast"):
        subprocess.run([himmel, "ephemeris", "--input", questions, "--output", answers, "--level", level], check=True)
        worst = {}
        for r, t in zip(csv.DictReader(open(answers)), truth):
            v = {k: float(r[k]) for k in ("azimuth_deg", "altitude_deg", "ra_deg", "dec_deg", "distance_km")}
            name = "star" if r["body"].startswith("HIP") else r["body"]
            now = (separation(v["azimuth_deg"], v["altitude_deg"], t[0], t[1]), separation(v["ra_deg"], v["dec_deg"], t[2], t[3]),
                   abs(v["distance_km"] / t[4] - 1))
            worst[name] = tuple(max(a, b) for a, b in zip(worst.get(name, (0, 0, 0)), now))
        for name, (horizontal, equatorial, distance) in worst.items():
            print(f"{level:8} {name:8} {horizontal:.4f} {equatorial:.4f} arcsec, distance {distance:.1e}")

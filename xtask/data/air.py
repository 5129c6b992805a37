#!/usr/bin/env python3.11
"""Writes the ozone tables under assets/air/ from the numbers below, and checks them.

Needs:  nothing beyond Python 3.11
Run:    python3.11 xtask/data/air.py          (from the repository root)

The numbers are copied from the sources that assets/air/SOURCE.md names.
"""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOLECULES_PER_M2_AND_DOBSON = 2.687e20

# 360 nm and on, every 10 nm, m2 per molecule, 233 K: each the mean over the ten nanometres that begin at its wavelength.
CROSS_SECTION_M2 = """
1.18e-27 2.182e-28 2.818e-28 6.636e-28 1.527e-27 2.763e-27 5.52e-27 8.451e-27 1.582e-26 2.316e-26 3.669e-26 4.924e-26
7.752e-26 9.016e-26 1.48e-25 1.602e-25 2.139e-25 2.755e-25 3.091e-25 3.5e-25 4.266e-25 4.672e-25 4.398e-25 4.701e-25
5.019e-25 4.305e-25 3.74e-25 3.215e-25 2.662e-25 2.238e-25 1.852e-25 1.473e-25 1.209e-25 9.423e-26 7.455e-26 6.566e-26
5.105e-26 4.15e-26 4.228e-26 3.237e-26 2.451e-26 2.801e-26 2.534e-26 1.624e-26 1.465e-26 2.078e-26 1.383e-26 7.105e-27
""".split()

# 2 km and on, every 2 km, cm-3.
NUMBER_DENSITY_PER_CM3 = """
6.8e11 5.8e11 5.7e11 6.5e11 1.13e12 2.02e12 2.35e12 2.95e12 4.04e12 4.77e12 4.86e12 4.54e12 4.03e12 3.24e12 2.52e12
2.03e12 1.58e12 1.22e12 8.73e11 6.07e11 3.98e11 2.74e11 1.69e11 1.03e11 6.64e10 3.84e10 2.55e10 1.61e10 1.12e10 7.33e9
4.81e9 3.17e9 1.72e9 7.5e8 5.4e8 2.2e8 1.7e8
""".split()


def write(path, header, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([header, *rows]) + "\n", encoding="ascii")
    print(f"{path.relative_to(ROOT)}: {len(rows)} rows")


def cross_section():
    table = {360 + 10 * i: float(v) for i, v in enumerate(CROSS_SECTION_M2)}
    assert len(table) == 48
    write(ROOT / "assets/air/ozone_cross_section.csv", "wavelength_nm,cross_section_m2",
          [f"{nm},{m2:.4g}" for nm, m2 in table.items()])
    for nm, depth in ((600, 0.0404), (550, 2.82135e-2), (680, 9.7457e-3), (440, 1.2753e-3)):
        found = table[nm] * 300 * MOLECULES_PER_M2_AND_DOBSON
        print(f"  vertical depth of 300 DU at {nm} nm: {found:.5e} (expected {depth})")
        assert abs(found / depth - 1) < 2e-3


def profile():
    # At the ground the 2 km value is held, as the AFGL profiles do: the standard begins at 2 km.
    density = [float(v) * 1e6 for v in [NUMBER_DENSITY_PER_CM3[0], *NUMBER_DENSITY_PER_CM3]]
    assert len(density) == 38
    write(ROOT / "assets/air/ozone_profile_us1976.csv", "altitude_m,number_density_per_m3",
          [f"{2000 * i},{n:.3g}" for i, n in enumerate(density)])
    column = sum((a + b) / 2 * 2000 for a, b in zip(density, density[1:])) / MOLECULES_PER_M2_AND_DOBSON
    above_2_km = column - density[0] * 2000 / MOLECULES_PER_M2_AND_DOBSON
    print(f"  column: {column:.2f} DU, above 2 km {above_2_km:.2f} DU")
    assert 340 < column < 350


if __name__ == "__main__":
    cross_section()
    profile()

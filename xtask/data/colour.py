#!/usr/bin/env python3.11
"""Writes the colour and sunlight tables under assets/ from the package colour-science.

Needs:  pip install colour-science==0.4.7 numpy==2.4.6
Run:    python3.11 xtask/data/colour.py          (from the repository root)

Writes
  assets/colour/cie1931_2deg.csv    the published 5 nm values, untouched
  assets/colour/cie1951_scotopic.csv    V′ every 5 nm, untouched
  tests/truth/illuminants.csv       CIE illuminants A and D65 every 5 nm, untouched
  assets/light/sun_astm_g173.csv    averages over bins 5 nm wide, centred on each wavelength,
                                    of the straight lines that join the published points
and fails loudly when the tables do not have the properties that they are known for.
"""

import sys
import warnings
from pathlib import Path

import numpy as np

sys.path = [p for p in sys.path if Path(p or ".").resolve() != Path(__file__).resolve().parent]  # `import colour` is not us
warnings.filterwarnings("ignore")  # the package warns that it can neither plot nor use SciPy; neither is needed

from colour.colorimetry import MSDS_CMFS, SDS_ILLUMINANTS, SDS_LEFS_SCOTOPIC  # noqa: E402
from colour.plotting.datasets import SD_ASTMG173_ETR  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
LUMENS_PER_WATT = 683.0
BIN_NM = 5.0


def bin_average(wavelength_nm, value, low_nm, high_nm):
    """The mean over [low, high] of the straight lines that join the points, exact (trapezoids)."""
    inside = (wavelength_nm > low_nm) & (wavelength_nm < high_nm)
    x = np.concatenate([[low_nm], wavelength_nm[inside], [high_nm]])
    y = np.interp(x, wavelength_nm, value)
    return np.trapezoid(y, x) / (high_nm - low_nm)


def write(path, header, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([header, *rows]) + "\n", encoding="ascii")
    print(f"{path.relative_to(ROOT)}: {len(rows)} rows")


def colour_matching():
    observer = MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    nm = np.asarray(observer.wavelengths)
    xyz = np.asarray(observer.values)
    keep = np.isclose(nm % 5.0, 0.0) & (nm >= 360) & (nm <= 830)
    nm, xyz = nm[keep], xyz[keep]
    rows = [f"{w:.0f},{x:.12g},{y:.12g},{z:.12g}" for w, (x, y, z) in zip(nm, xyz)]
    write(ROOT / "assets/colour/cie1931_2deg.csv", "wavelength_nm,x_bar,y_bar,z_bar", rows)

    sums = xyz.sum(axis=0)
    print("  sums of x, y, z over 5 nm:", sums, " peak of y:", xyz[:, 1].max(), "at", nm[xyz[:, 1].argmax()], "nm")
    assert len(nm) == 95
    assert np.isclose(xyz[nm == 555][0][1], 1.0)
    assert np.ptp(sums) / sums.mean() < 1e-3, "equal energy must be white"
    return nm, xyz


def scotopic():
    efficiency = SDS_LEFS_SCOTOPIC["CIE 1951 Scotopic Standard Observer"]
    nm, value = np.asarray(efficiency.wavelengths), np.asarray(efficiency.values)
    keep = np.isclose(nm % 5.0, 0.0)
    nm, value = nm[keep], value[keep]
    rows = [f"{w:.0f},{v:.12g}" for w, v in zip(nm, value)]
    write(ROOT / "assets/colour/cie1951_scotopic.csv", "wavelength_nm,v_prime", rows)
    assert len(nm) == 81 and np.isclose(value[nm == 555][0], 0.402), "683/1699, where rods and cones agree"


def illuminants():
    nm = np.arange(380.0, 781.0, 5.0)
    rows = []
    for w in nm:
        rows.append(f"{w:.0f}," + ",".join(f"{SDS_ILLUMINANTS[name][w]:.12g}" for name in ("A", "D65")))
    write(ROOT / "tests/truth/illuminants.csv", "wavelength_nm,a,d65", rows)


def sunlight(nm, xyz):
    wavelength_nm = np.asarray(SD_ASTMG173_ETR.wavelengths)
    irradiance = np.asarray(SD_ASTMG173_ETR.values)
    centres = np.arange(300.0, 1000.0 + BIN_NM / 2, BIN_NM)
    averages = np.array([bin_average(wavelength_nm, irradiance, c - BIN_NM / 2, c + BIN_NM / 2) for c in centres])
    rows = [f"{c:.0f},{a:.6f}" for c, a in zip(centres, averages)]
    write(ROOT / "assets/light/sun_astm_g173.csv", "wavelength_nm,irradiance_w_m2_nm", rows)

    total = np.trapezoid(irradiance, wavelength_nm)
    seen = averages[(centres >= 360) & (centres <= 830)]
    illuminance = LUMENS_PER_WATT * (seen * xyz[:, 1]).sum() * BIN_NM
    print(f"  280 to 4000 nm: {total:.2f} W/m2   illuminance above the air: {illuminance:.0f} lx")
    assert 1.32e5 < illuminance < 1.34e5
    # The three numbers that the project quotes are plain means of the ten published points of each bin.
    for start, expected in ((680.0, 1.474), (550.0, 1.850), (440.0, 1.912)):
        inside = (wavelength_nm >= start) & (wavelength_nm < start + 10.0)
        mean = irradiance[inside].mean()
        print(f"  mean of the points {start:.0f} to {start + 9:.0f} nm: {mean:.4f} (expected {expected})")
        assert abs(mean - expected) < 6e-4


if __name__ == "__main__":
    scotopic()
    illuminants()
    sunlight(*colour_matching())

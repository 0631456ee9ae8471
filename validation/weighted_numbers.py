#!/usr/bin/env python3
"""Weighted numbers by other programs: `data/weighted_numbers.json`.

    pip install colour-science==0.4.7 colormath==3.0.0 pvlib==0.16.1
    python3 validation/weighted_numbers.py

Spectra are formulas, printed in the file. Solar reflectances are sums over the rows of pvlib's table of ASTM G173
(trapezoidal rule), densities are colormath's, whiteness, tint and yellowness colour-science's from X, Y, Z summed every nm
over its tables.
"""

import csv
import json
import math
import pathlib
import warnings

warnings.filterwarnings("ignore")
import colour  # noqa: E402
import numpy as np  # noqa: E402
import pvlib  # noqa: E402
from colormath import density_standards as density  # noqa: E402
from colormath.density import ansi_density  # noqa: E402
from colormath.color_objects import SpectralColor  # noqa: E402

DATA = pathlib.Path(__file__).resolve().parent / "data"


def edge(nm, at, width):
    return 1.0 / (1.0 + np.exp(-(nm - at) / width))


def bell(nm, at, width):
    return np.exp(-0.5 * ((nm - at) / width) ** 2)


SPECTRA = {
    "grey_0.1": lambda nm: 0.1 + 0.0 * nm,
    "grey_0.5": lambda nm: 0.5 + 0.0 * nm,
    "white_paint": lambda nm: 0.05 + 0.85 * edge(nm, 395.0, 8.0) - 0.15 * edge(nm, 1400.0, 200.0),
    "yellow_ink": lambda nm: 0.04 + 0.85 * edge(nm, 505.0, 14.0),
    "blue_white": lambda nm: 0.80 + 0.10 * bell(nm, 450.0, 25.0) - 0.03 * bell(nm, 600.0, 60.0),
}
STATUS = {
    "status_e_red": density.ANSI_STATUS_E_RED, "status_e_green": density.ANSI_STATUS_E_GREEN,
    "status_e_blue": density.ANSI_STATUS_E_BLUE, "status_t_red": density.ANSI_STATUS_T_RED,
    "status_t_green": density.ANSI_STATUS_T_GREEN, "status_t_blue": density.ANSI_STATUS_T_BLUE,
    "iso_visual": density.ISO_VISUAL,
}
PARTS = {"all": (280.0, 2500.0), "uv": (280.0, 400.0), "visible": (400.0, 700.0), "nir": (700.0, 2500.0)}
CONDITIONS = {"D65/2": ("D65", "CIE 1931 2 Degree Standard Observer"),
              "D65/10": ("D65", "CIE 1964 10 Degree Standard Observer"),
              "C/2": ("C", "CIE 1931 2 Degree Standard Observer")}


def sun():
    path = pathlib.Path(pvlib.__file__).parent / "data" / "ASTMG173.csv"
    rows = np.array([[float(x) for x in row] for row in list(csv.reader(path.open()))[2:]])
    return rows[:, 0], rows[:, 2]


def solar(f):
    nm, light = sun()
    out = {}
    for part, (first, last) in PARTS.items():
        keep = (nm >= first) & (nm <= last)
        out[part] = np.trapezoid(light[keep] * f(nm[keep]), nm[keep]) / np.trapezoid(light[keep], nm[keep])
    return out


def densities(f):
    nm = np.arange(340.0, 840.0, 10.0)
    sample = SpectralColor(**{f"spec_{int(x)}nm": y for x, y in zip(nm, f(nm))})
    return {name: ansi_density(sample, table) for name, table in STATUS.items()}


def xyz(f, condition):
    illuminant, observer = CONDITIONS[condition]
    nm = np.arange(380.0, 781.0)
    shape = colour.SpectralShape(380, 780, 1)
    light = colour.SDS_ILLUMINANTS[illuminant].copy().interpolate(shape, interpolator=colour.LinearInterpolator)[nm]
    eye = colour.MSDS_CMFS[observer].copy().align(shape)[nm]
    return 100.0 * (eye * (light * f(nm))[:, None]).sum(0) / (eye[:, 1] * light).sum()


def whiteness(f, condition):
    value, white = xyz(f, condition), xyz(lambda nm: 1.0 + 0.0 * nm, condition)
    return [float(x) for x in colour.colorimetry.whiteness_CIE2004(
        value[:2] / value.sum(), value[1], white[:2] / white.sum(), CONDITIONS[condition][1])]


def yellowness(f, condition):
    illuminant, observer = CONDITIONS[condition]
    c_xz = colour.colorimetry.YELLOWNESS_COEFFICIENTS_ASTME313[observer][illuminant]
    return float(colour.colorimetry.yellowness_ASTME313(xyz(f, condition), c_xz))


def main():
    spectra = []
    for name, f in SPECTRA.items():
        spectra.append({
            "name": name, "solar_g173": solar(f), "density": densities(f),
            "whiteness": {key: whiteness(f, key) for key in ("D65/2", "D65/10")},
            "yellowness": {key: yellowness(f, key) for key in CONDITIONS},
        })
    doc = (f"Made by weighted_numbers.py with colour-science {colour.__version__}, colormath 3.0.0 and pvlib {pvlib.__version__}. "
           "Spectra are the formulas there; whiteness is [W, T].")
    text = json.dumps({"doc": doc, "spectra": spectra}, indent=1, ensure_ascii=False)
    assert not math.isnan(sum(s["solar_g173"]["all"] for s in spectra))
    (DATA / "weighted_numbers.json").write_text(text + "\n")


main()

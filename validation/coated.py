"""Arrays of coated spheres: `data/coated.json` (numpy, scipy and treams; no line of the program).

Scalar: the coefficients of one sphere follow from u and its slope across every interface, from the core outwards; the
array from lattice sums by Ewald's method (treams) and the addition theorem. The half-spaces are the host, so there are
no faces. Maxwell's equations: treams, by python/adapters/treams_tmatrix.py, whose coated spheres are those of Bohren and
Huffman, chapter 8. Digits are the changes from fewer multipoles.

    python3 validation/coated.py > validation/data/coated.json
"""

import json
import pathlib
import subprocess
import sys

import numpy as np
from scipy.special import sph_harm_y, spherical_jn, spherical_yn
from treams import lattice
from treams.special import wigner3j

ADAPTER = pathlib.Path(__file__).parents[1] / "python/adapters/treams_tmatrix.py"
CENTRE, BINDER = [0.2, 0.2, 0.3], {"H": 0.6, "n_in": 1.0, "n_out": 1.3, "eta_binder": [1.558, 0.0]}
LIGHT = {"wavelength": 0.55, "sigma_deg": 20.0, "phi_deg": 30.0, "L": 0.5}
HOST = {"H": 0.6, "n_in": 1.5, "n_out": 1.5, "eta_binder": [1.5, 0.0]}


def grain(*layers):
    return {"spheres": [{"center": CENTRE, "radius": r, "eta": [n, k]} for r, n, k in layers]}


CASES = [
    ("coat01", "scalar", {**LIGHT, **HOST, **grain((0.15, 1.8, 0.0), (0.1, 1.3, 0.1))}),
    ("coat02", "scalar", {**LIGHT, **HOST, **grain((0.18, 1.6, 0.0), (0.15, 1.4, 0.05), (0.12, 1.0, 0.0))}),
    ("vcoat01", "vector", {**LIGHT, **BINDER, **grain((0.15, 1.7, 0.0), (0.1, 1.4, 0.1))}),
    ("vcoat02", "vector", {**LIGHT, **BINDER, **grain((0.16, 1.5, 0.0), (0.13, 1.65, 0.02), (0.1, 1.45, 0.0))}),
]


def radial(degree, k, r):
    """Values and slopes of j and y, as rows."""
    bessel = (spherical_jn, spherical_yn)
    return np.array([[f(degree, k * r) for f in bessel], [k * f(degree, k * r, derivative=True) for f in bessel]])


def single(degree, k0, layers, host):
    """The outgoing coefficient of one sphere for a regular incident wave of coefficient 1."""
    (core, eta), *around = layers
    inside = radial(degree, k0 * eta, core)[:, 0]
    for (inner, _), (outer, eta) in zip(layers, around):
        inside = radial(degree, k0 * eta, outer) @ np.linalg.solve(radial(degree, k0 * eta, inner), inside)
    outside = radial(degree, k0 * host, layers[-1][0])
    regular, outgoing = outside[:, 0], outside @ [1, 1j]
    value, slope = inside
    return -(regular[1] * value - slope * regular[0]) / (outgoing[1] * value - slope * outgoing[0])


def coupling(degree, k, kpar, period):
    """What the outgoing waves of all other spheres are about one of them: addition theorem and lattice sums."""
    waves = [(l, m) for l in range(degree + 1) for m in range(-l, l + 1)]
    sums = {(l, m): complex(lattice.lsumsw2d(l, m, k, kpar, np.diag(period), [0.0, 0.0], 0.0))
            for l in range(2 * degree + 1) for m in range(-l, l + 1) if (l + m) % 2 == 0}
    matrix = np.zeros((len(waves),) * 2, complex)
    for column, (l, m) in enumerate(waves):
        for row, (n, o) in enumerate(waves):
            for s in range(abs(l - n), l + n + 1):
                if (s, m - o) in sums and (l + n + s) % 2 == 0:
                    three = wigner3j(l, n, s, 0, 0, 0) * wigner3j(l, n, s, m, -o, o - m) * (-1) ** m
                    size = np.sqrt(4 * np.pi * (2 * l + 1) * (2 * n + 1) * (2 * s + 1))
                    matrix[row, column] += size * three * 1j ** (n + s - l) * sums[s, m - o]
    return waves, matrix


def scalar(case, degree, t=None):
    """All propagating orders of the scalar wave; `t` replaces the T-matrix of the spheres."""
    k0, host = 2 * np.pi / case["wavelength"], case["n_in"]
    k, period, height = k0 * host, np.array([case["L"]] * 2), case["H"]
    polar, azimuth = np.radians([case["sigma_deg"], case["phi_deg"]])
    incident = k * np.array([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)])
    layers = sorted((s["radius"], complex(*s["eta"])) for s in case.get("spheres", []))
    waves, others = coupling(degree, k, incident[:2], period)
    if t is None:
        single_of = [single(l, k0, layers, host) for l in range(degree + 1)]
        t = np.diag([single_of[l] for l, _ in waves])
    here = np.array([4 * np.pi * 1j**l * np.conj(sph_harm_y(l, m, polar, azimuth)) for l, m in waves])
    here = here * np.exp(1j * incident @ CENTRE)
    outgoing = np.linalg.solve(np.eye(len(waves)) - t @ others, t @ here)
    orders = []
    for m in range(-3, 4):
        for n in range(-3, 4):
            lateral = incident[:2] + 2 * np.pi * np.array([m, n]) / period
            if lateral @ lateral >= k * k:
                continue
            kz = np.sqrt(k * k - lateral @ lateral)
            for side, travel in (("reflected", -1), ("transmitted", 1)):
                to = [np.arccos(travel * kz / k), np.arctan2(lateral[1], lateral[0])]
                far = sum(c * (-1j) ** (l + 1) / k * sph_harm_y(l, o, *to) for c, (l, o) in zip(outgoing, waves))
                away = CENTRE[2] if travel < 0 else height - CENTRE[2]
                wave = 2j * np.pi * far / (kz * period.prod()) * np.exp(1j * (kz * away - lateral @ CENTRE[:2]))
                straight = np.exp(1j * kz * height) if (m, n, travel) == (0, 0, 1) else 0
                value = wave + straight
                orders.append({"m": m, "n": n, "side": side, "amplitude": [value.real, value.imag]})
    return orders


def vector(case, degree):
    question = json.dumps({"case": "coated", "inputs": case, "wave": "vector", "knob": str(degree)})
    answer = subprocess.run([sys.executable, ADAPTER], input=question, capture_output=True, text=True, check=True)
    return json.loads(answer.stdout)["orders"]


def numbers(orders):
    return np.array([value for order in orders for value in np.ravel(
        [list(a.values()) for a in order["amplitude"].values()] if isinstance(order["amplitude"], dict)
        else order["amplitude"])])


if __name__ == "__main__":
    cases = []
    for name, wave, inputs in CASES:
        solve = {"scalar": scalar, "vector": vector}[wave]
        coarse, fine = (solve(inputs, degree) for degree in (8, 10))
        change = np.abs(numbers(fine) - numbers(coarse)).max()
        cases.append({"id": name, "wave": wave, "inputs": inputs, "change": float(f"{change:.1e}"), "orders": fine})
    print(json.dumps({"cases": cases}, indent=1))

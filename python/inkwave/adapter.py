"""What the adapters share: question and answer, the orders of a case, polarisations, and the case on voxels."""

import contextlib
import json
import sys
import time
from importlib.metadata import version as version_of

import numpy as np


class Refusal(Exception):
    """Why the program does not solve a case."""


class Case:
    """A case of inkwave in numbers: lengths in µm, time factor exp(-iωt), angles in degrees in the file only."""

    def __init__(self, question):
        inputs = question["inputs"]
        self.inputs, self.wave, self.knob = inputs, question["wave"], question["knob"]
        if inputs.get("from", "incident") != "incident":
            raise Refusal("light from the exit side")
        self.k0 = 2 * np.pi / inputs["wavelength"]
        period = inputs.get("L", 1.0)
        self.period = np.array(period if isinstance(period, list) else [period, inputs.get("Ly", period)], float)
        self.n = [index(inputs.get(key, inputs.get(key.replace("n_", "eta_"), 1.0))) for key in ("n_in", "n_out")]
        self.films = [(f["thickness"], index(f.get("eta", f.get("eta_background"))), f.get("bars", []))
                      for f in inputs.get("layers_from_z0") or inputs.get("sublayers_from_z0") or []]
        self.films = self.films or [(inputs["H"], index(inputs["eta_binder"]), [])]
        self.height = sum(film[0] for film in self.films)
        self.spheres, self.cylinders = inputs.get("spheres") or [], inputs.get("cylinders") or []
        bars = any(film[2] for film in self.films)
        self.uniform_y = not self.spheres
        self.uniform_x = self.uniform_y and not self.cylinders and not bars
        polar, azimuth = np.radians([inputs.get("sigma_deg", 0.0), inputs.get("phi_deg", 0.0)])
        self.azimuth, self.polar = azimuth, polar
        self.kpar = self.k0 * self.n[0].real * np.sin(polar) * np.array([np.cos(azimuth), np.sin(azimuth)])

    def orders(self):
        """(m, n), lateral wavevector and normal wavenumber on both sides of all orders that propagate."""
        reach = (self.k0 * max(abs(n) for n in self.n) + np.abs(self.kpar)) * self.period / (2 * np.pi)
        most = [0 if self.uniform_x else int(reach[0]) + 1, 0 if self.uniform_y else int(reach[1]) + 1]
        for m in range(-most[0], most[0] + 1):
            for n in range(-most[1], most[1] + 1):
                k = self.kpar + 2 * np.pi * np.array([m, n]) / self.period
                kz = [np.sqrt((self.k0 * side) ** 2 - k @ k + 0j) for side in self.n]
                if max(z.real for z in kz) > 0:
                    yield m, n, k, kz

    def polarised(self, k, kz, side, travel, field):
        """Amplitudes s and p of the field (Ex, Ey) of an order that travels towards +z (1) or -z (-1)."""
        q = np.hypot(*k)
        p = k / q if q > 1e-9 * self.k0 else np.array([np.cos(self.azimuth), np.sin(self.azimuth)])
        along, across = field[0] * p[0] + field[1] * p[1], field[1] * p[0] - field[0] * p[1]
        return np.array([across, travel * along * self.k0 * self.n[side] / kz])

    def answer(self, reflected, transmitted, incident):
        """Orders from the fields (Ex, Ey) of both excitations: dictionaries of (m, n), and the incident pair itself.

        Scalar cases take the s amplitude of excitation 0, whose sign turns with kx, or numbers instead of fields.
        """
        orders = []
        for m, n, k, kz in self.orders():
            for side, travel, fields in ((0, -1, reflected), (1, 1, transmitted)):
                if kz[side].real > 0:
                    amplitude = self._amplitude(fields[m, n], incident, (k, kz[side], side, travel))
                    orders.append({"m": m, "n": n, "side": ["reflected", "transmitted"][side], "amplitude": amplitude})
        return orders

    def _amplitude(self, fields, incident, place):
        if self.wave == "scalar":
            return pair(fields / incident)
        kz = self.k0 * self.n[0] * np.cos(self.polar)
        sources = np.array([self.polarised(self.kpar, kz, 0, 1, field) for field in incident]).T
        outgoing = np.array([self.polarised(*place, field) for field in fields]).T @ np.linalg.inv(sources)
        return {a: {b: pair(outgoing[j, i]) for j, b in enumerate("sp")} for i, a in enumerate("sp")}

    def permittivity(self, x, y, z):
        """ε at the points of a grid (axes x, y, z), without averaging."""
        x, y, z = np.meshgrid(x, y, z, indexing="ij")
        eta = np.where(z < 0, self.n[0], self.n[1]).astype(complex)
        top = 0.0
        for thickness, background, bars in self.films:
            inside = (z >= top) & (z < top + thickness)
            eta[inside] = background
            for bar in bars:
                wrapped = bar["x0"] + (x - bar["x0"]) % self.period[0]
                eta[inside & (wrapped < bar["x1"])] = index(bar["eta"])
            top += thickness
        near = lambda a, centre, axis: (a - centre + self.period[axis] / 2) % self.period[axis] - self.period[axis] / 2
        for c in self.cylinders:
            eta[near(x, c["x"], 0) ** 2 + (z - c["z"]) ** 2 < c["radius"] ** 2] = index(c["eta"])
        for s in sorted(self.spheres, key=lambda s: -s["radius"]):  # inner spheres displace those around them
            dx, dy, dz = near(x, s["center"][0], 0), near(y, s["center"][1], 1), z - s["center"][2]
            eta[dx**2 + dy**2 + dz**2 < s["radius"] ** 2] = index(s["eta"])
        return eta**2


def program(name):
    """Name and version of an installed package."""
    return f"{name} {version_of(name)}"


def index(value):
    """A refractive index from a number or [re, im]."""
    return complex(*value) if isinstance(value, list) else complex(value)


def pair(z):
    return [float(np.real(z)), float(np.imag(z))]


def averaged(case, axes, samples=3):
    """ε averaged over the voxels around the points of a uniform grid."""
    steps = [axis[1] - axis[0] if len(axis) > 1 else 0.0 for axis in axes]
    shifts = (np.arange(samples) + 0.5) / samples - 0.5
    total = 0
    for dx in shifts if steps[0] else [0.0]:
        for dy in shifts if steps[1] else [0.0]:
            for dz in shifts:
                total = total + case.permittivity(axes[0] + dx * steps[0], axes[1] + dy * steps[1], axes[2] + dz * steps[2])
    return total / (samples * (samples if steps[0] else 1) * (samples if steps[1] else 1))


def main(description, solve):
    """Describes the program, or answers the question on standard input; `solve(case)` returns the orders."""
    if "--describe" in sys.argv:
        return print(json.dumps(description))
    question = json.load(sys.stdin)
    answer = {"case": question["case"]}
    try:
        with contextlib.redirect_stdout(sys.stderr):
            case = Case(question)
            clock = time.perf_counter()
            answer["orders"] = solve(case)
            answer["seconds"] = time.perf_counter() - clock
    except Refusal as reason:
        answer["refusal"] = str(reason)
    print(json.dumps(answer))

"""Birefringent spheres in a periodic layer of their host, by coupled dipoles: writes validation/data/crystals.json.

    python validation/crystals.py          # needs NumPy and SciPy; some minutes on one core

Nothing here is shared with the program. The spheres are cubes of edge d, each a dipole with the polarisability of
Clausius and Mossotti of its own tensor (of the mean permittivity where the sphere's surface cuts it) and the corrections
of order (kd)^2 and (kd)^3 of Draine and Flatau (J. Opt. Soc. Am. A 11 (1994) 1491, their equation 14 with the mean index).
Dipoles see each other through the Green dyadic of the square lattice, summed by Ewald's method. The amplitudes of two
edges d are extrapolated to d = 0 with d^2; the step beyond the finer one is the stated error.

Conventions are those of the program: exp(-i omega t), s = z x p, P(+-) = (+-kz p - q z)/k, reflected amplitudes at z = 0,
transmitted ones at z = H.
"""

import json
import pathlib

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres
from scipy.special import wofz

ERFC = lambda z: np.exp(-z * z) * wofz(1j * z)


def times_erfc(exponent, z):
    """exp(exponent) erfc(z) without overflow."""
    return np.where(z.real >= 0, np.exp(exponent - z * z) * wofz(1j * z),
                    2 * np.exp(exponent) - np.exp(exponent - z * z) * wofz(-1j * z))


def dyadics(place, k, bloch, side, count=4):
    """(k^2 + grad grad) of the lattice's Green function at places (N, 3), without the dipole itself at 0: (N, 3, 3)."""
    ewald = np.sqrt(np.pi) / side
    out = np.zeros((len(place), 3, 3), complex)
    x, y, z = place.T.astype(complex)
    zero = np.linalg.norm(place, axis=1) < 1e-12
    eye = np.eye(3)
    for m in range(-count, count + 1):
        for n in range(-count, count + 1):
            q = bloch + 2 * np.pi / side * np.array([m, n])
            gamma = np.sqrt(q @ q - k * k + 0j)
            gamma = -1j * np.sqrt(k * k - q @ q) if q @ q < k * k else gamma
            p = times_erfc(gamma * z, gamma / (2 * ewald) + z * ewald)
            o = times_erfc(-gamma * z, gamma / (2 * ewald) - z * ewald)
            gauss = np.exp(-gamma**2 / (4 * ewald**2) - z**2 * ewald**2)
            phase = np.exp(1j * (q[0] * x + q[1] * y)) / (4 * side**2 * gamma)
            f, f1 = p + o, gamma * (p - o)
            f2 = gamma**2 * f - 4 * gamma * ewald / np.sqrt(np.pi) * gauss
            for i in range(2):
                for j in range(2):
                    out[:, i, j] -= q[i] * q[j] * f * phase
                out[:, i, 2] += 1j * q[i] * f1 * phase
                out[:, 2, i] += 1j * q[i] * f1 * phase
            out[:, 2, 2] += f2 * phase
            out += (k * k * f * phase)[:, None, None] * eye
            # images
            shift = side * np.array([m, n, 0.0])
            rest = place - shift
            r = np.linalg.norm(rest, axis=1)
            own = r < 1e-12
            r = np.where(own, 1.0, r)
            turn = np.exp(1j * (bloch @ shift[:2]))
            plus = times_erfc(1j * k * r, r * ewald + 1j * k / (2 * ewald))
            minus = times_erfc(-1j * k * r, r * ewald - 1j * k / (2 * ewald))
            gauss = np.exp(-r**2 * ewald**2 + k**2 / (4 * ewald**2))
            u = plus + minus
            u1 = 1j * k * (plus - minus) - 4 * ewald / np.sqrt(np.pi) * gauss
            u2 = -k * k * u + 8 * ewald**3 * r / np.sqrt(np.pi) * gauss
            h, h1 = u / (8 * np.pi * r), (u1 - u / r) / (8 * np.pi * r)
            h2 = (u2 - 2 * u1 / r + 2 * u / r**2) / (8 * np.pi * r)
            unit = rest / r[:, None]
            outer = unit[:, :, None] * unit[:, None, :]
            dyad = (k * k * h + h1 / r)[:, None, None] * eye + (h2 - h1 / r)[:, None, None] * outer
            dyad[own] = 0
            out += turn * dyad
    v1 = -2j * k * ERFC(np.array(-1j * k / (2 * ewald))) - 4 * ewald / np.sqrt(np.pi) * np.exp(k**2 / (4 * ewald**2))
    v3 = -k * k * v1 + 8 * ewald**3 / np.sqrt(np.pi) * np.exp(k**2 / (4 * ewald**2))
    out[zero] += (k * k * v1 + v3 / 3) / (8 * np.pi) * eye
    return out


def permittivity(sphere):
    axis = np.array(sphere["optic_axis"]) / np.linalg.norm(sphere["optic_axis"])
    o, e = [complex(*sphere[key]) ** 2 for key in ("eta", "eta_extraordinary")]
    return o * np.eye(3) + (e - o) * np.outer(axis, axis)


def solved(case, n):
    """Amplitudes of every propagating order with n dipoles along the period: {(m, n): {R, T: [in][out]}}."""
    side, height, host = case["L"], case["H"], case["eta_binder"][0]
    d = side / n
    planes = round(height / d)
    k = 2 * np.pi / case["wavelength"] * host
    theta, phi = np.radians([case["sigma_deg"], case["phi_deg"]])
    bloch = k * np.sin(theta) * np.array([np.cos(phi), np.sin(phi)])
    # mean permittivity of every cube, of 6^3 points
    fine = (np.arange(6) + 0.5) / 6 * d
    grid = np.stack(np.meshgrid(*[np.arange(c) * d for c in (n, n, planes)], indexing="ij"), -1)
    step = np.zeros((n, n, planes, 3, 3), complex)
    share = np.zeros((n, n, planes))
    for sphere in case["spheres"]:
        inside = np.zeros((n, n, planes))
        for a in fine:
            for b in fine:
                for c in fine:
                    rest = grid + np.array([a, b, c]) - np.array(sphere["center"])
                    rest[..., :2] -= side * np.round(rest[..., :2] / side)
                    inside += (np.sum(rest**2, -1) < sphere["radius"] ** 2) / 216
        step += inside[..., None, None] * (permittivity(sphere) / host**2 - np.eye(3))
        share += inside
    used = np.argwhere(share > 0)
    epsilon = np.eye(3) + step[tuple(used.T)]
    mossotti = 3 * d**3 * np.linalg.solve(epsilon + 2 * np.eye(3), epsilon - np.eye(3))
    mean = np.trace(epsilon, axis1=1, axis2=2) / 3
    correction = ((-1.891531 + 0.1648469 * mean) * (k * d) ** 2 - 2j / 3 * (k * d) ** 3) / (4 * np.pi * d**3)
    inverse = np.linalg.inv(mossotti) + correction[:, None, None] * np.eye(3)
    alpha = np.linalg.inv(inverse)
    # kernel over all displacements, circulant in the plane but for the Bloch phase, which is taken out
    shifts = np.arange(-(planes - 1), planes)
    at = np.stack(np.meshgrid(np.arange(n) * d, np.arange(n) * d, shifts * d, indexing="ij"), -1).reshape(-1, 3)
    kernel = dyadics(at, k, bloch, side) * np.exp(-1j * at[:, :2] @ bloch)[:, None, None]
    kernel = kernel.reshape(n, n, len(shifts), 3, 3)
    padded = np.zeros((n, n, 2 * planes, 3, 3), complex)
    padded[:, :, :planes] = kernel[:, :, planes - 1:]
    padded[:, :, planes + 1:] = kernel[:, :, :planes - 1]
    spectrum = np.fft.fftn(padded, axes=(0, 1, 2))
    centre = (used + 0.5) * d
    phase = np.exp(1j * centre[:, :2] @ bloch)

    def product(p):
        dipoles = p.reshape(-1, 3)
        whole = np.zeros((n, n, 2 * planes, 3), complex)
        whole[tuple(used.T)] = dipoles / phase[:, None]
        field = np.fft.ifftn(np.einsum("xyzij,xyzj->xyzi", spectrum, np.fft.fftn(whole, axes=(0, 1, 2))), axes=(0, 1, 2))
        field = field[tuple(used.T)] * phase[:, None]
        return (dipoles - np.einsum("nij,nj->ni", alpha, field)).ravel()

    size = 3 * len(used)
    operator = LinearOperator((size, size), matvec=product, dtype=complex)
    normal = lambda q: np.sqrt(k * k - q @ q + 0j)
    def basis(q, sign):
        along = np.array([np.cos(phi), np.sin(phi)]) if np.linalg.norm(q) < 1e-12 else q / np.linalg.norm(q)
        s = np.array([-along[1], along[0], 0])
        p = np.array([*(sign * normal(q).real * along), -np.linalg.norm(q)]) / k
        return [s, p]
    incoming = basis(bloch, 1)
    orders = {}
    for source, vector in enumerate(incoming):
        wave = np.exp(1j * (centre[:, :2] @ bloch + normal(bloch) * centre[:, 2]))[:, None] * vector
        right = np.einsum("nij,nj->ni", alpha, wave).ravel()
        dipoles, status = gmres(operator, right, rtol=1e-9, restart=60, maxiter=50)
        assert status == 0
        dipoles = dipoles.reshape(-1, 3)
        for m in range(-3, 4):
            for l in range(-3, 4):
                q = bloch + 2 * np.pi / side * np.array([m, l])
                if q @ q >= k * k * 0.999:
                    continue
                kz = normal(q)
                entry = orders.setdefault((m, l), {"R": [None, None], "T": [None, None]})
                for key, sign in (("R", -1), ("T", 1)):
                    full = np.array([*q, sign * kz.real])
                    total = (dipoles * np.exp(-1j * centre @ full)[:, None]).sum(0)
                    field = 1j / (2 * side**2 * kz) * (k * k * total - full * (full @ total))
                    if key == "T":
                        field = field * np.exp(1j * kz * height)
                        if (m, l) == (0, 0):
                            field = field + vector * np.exp(1j * kz * height)
                    entry[key][source] = [complex(field @ e) for e in basis(q, sign)]
    return orders


BASE = {"wavelength": 0.6, "L": 0.5, "n_in": 1.5, "n_out": 1.5, "eta_binder": [1.5, 0.0]}
BIG = {"center": [0.2, 0.25, 0.2], "radius": 0.15, "eta": [1.75, 0.0], "eta_extraordinary": [2.05, 0.02], "optic_axis": [0.48, 0.36, 0.8]}
SMALL = {"center": [0.4, 0.1, 0.4], "radius": 0.1, "eta": [2.0, 0.0], "eta_extraordinary": [1.7, 0.0], "optic_axis": [-0.6, 0.8, 0.0]}
CASES = {
    "sphere": BASE | {"H": 0.4, "sigma_deg": 20.0, "phi_deg": 30.0, "spheres": [BIG]},
    "pair": BASE | {"H": 0.55, "sigma_deg": 35.0, "phi_deg": 110.0, "spheres": [BIG, SMALL]},
}
EDGES = [30, 40]


def main():
    cases = []
    for name, case in CASES.items():
        runs = [solved(case, n) for n in EDGES]
        rows, worst = [], 0.0
        for order in sorted(runs[0]):
            row = {"m": order[0], "n": order[1]}
            for side in "RT":
                values = np.array([run[order][side] for run in runs])
                edges = 1.0 / np.array(EDGES[-2:])
                step = (values[-1] - values[-2]) * edges[-1] ** 2 / (edges[-2] ** 2 - edges[-1] ** 2)
                line = values[-1] + step
                worst = max(worst, np.abs(step).max())
                row[side] = [[[round(v.real, 7), round(v.imag, 7)] for v in line_row] for line_row in line]
            rows.append(row)
        print(name, "orders", len(rows), "last step of the extrapolation", worst)
        cases.append({"id": name, "inputs": case, "error": round(float(worst), 5), "orders": rows})
    path = pathlib.Path(__file__).parent / "data" / "crystals.json"
    path.write_text(json.dumps({"made_by": "validation/crystals.py", "cases": cases}, indent=1) + "\n")


if __name__ == "__main__":
    main()

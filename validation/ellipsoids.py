"""Arrays of ellipsoids: `data/ellipsoids.json` (numpy, scipy and treams; no line of the program).

The T-matrix of one ellipsoid by the null-field method (Waterman 1965; scalar: u and its slope are continuous), with
quadrature over the whole surface, so that any axes and any tilt are allowed; arrays as in `coated.py`. Digits are the
changes from fewer multipoles and points.

    python3 validation/ellipsoids.py > validation/data/ellipsoids.json
"""

import contextlib
import io
import json
import runpy
import sys

import coated
import numpy as np
import treams
from scipy.special import sph_harm_y, spherical_jn, spherical_yn
from treams.special import vsw_M, vsw_N, vsw_rM, vsw_rN

AXIS, TURN = [0.4, -0.3, 0.8], 25.0
UPRIGHT = {"shape": {"kind": "ellipsoid", "axes": [0.2, 0.2, 0.3]}, "eta": [1.8, 0.0]}
TILTED = {"shape": {"kind": "ellipsoid", "axes": [0.3, 0.24, 0.2]}, "axis": AXIS, "turn_deg": TURN, "eta": [1.75, 0.05]}
FLAT = {"shape": {"kind": "ellipsoid", "axes": [0.3, 0.3, 0.2]}, "axis": AXIS, "eta": [1.3, 0.0]}
CASES = [("ell01", "scalar", UPRIGHT), ("ell02", "scalar", TILTED),
         ("vell01", "vector", UPRIGHT), ("vell02", "vector", TILTED), ("vell03", "vector", FLAT)]


def surface(body, count):
    """Points of the surface as r, θ, φ, and normals times areas along r, θ and φ; count × 2 count points."""
    z, weight = np.polynomial.legendre.leggauss(count)
    z, phi = (a.ravel() for a in np.meshgrid(z, np.pi * np.arange(2 * count) / count, indexing="ij"))
    weight = np.repeat(weight, 2 * count) * np.pi / count
    ball = np.array([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z])
    axis, turn = np.array(body.get("axis", [0, 0, 1.0])), np.radians(body.get("turn_deg", 0.0))
    a, b, c = axis / np.linalg.norm(axis)
    tilt = np.array([[1 - a * a / (1 + c), -a * b / (1 + c), a], [-a * b / (1 + c), 1 - b * b / (1 + c), b], [-a, -b, c]])
    about = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    image = tilt @ about @ np.diag(np.array(body["shape"]["axes"]) / 2)
    x, y, z = points = image @ ball
    normal = weight * np.linalg.det(image) * (np.linalg.inv(image).T @ ball)
    r, theta, phi = np.linalg.norm(points, axis=0), np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    s, c, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    frame = np.array([[s * cp, s * sp, c], [c * cp, c * sp, -s], [-sp, cp, 0 * s]])
    return (r, theta, phi), np.einsum("ijp,jp->ip", frame, normal)


def scalar_t(k0, host, body, degree):
    """Its T-matrix over all (l, m) up to a degree."""
    (r, theta, phi), normal = surface(body, 4 * degree + 8)

    def waves(k, outgoing):
        """Values, and slopes along the normal times areas, of all regular or outgoing waves."""
        values, slopes = [], []
        for l in range(degree + 1):
            j, y = ([f(l, k * r), k * f(l, k * r, derivative=True)] for f in (spherical_jn, spherical_yn))
            radial, slope = np.array(j) + 1j * np.array(y) if outgoing else j
            for m in range(-l, l + 1):
                angular = sph_harm_y(l, m, theta, phi)
                above = sph_harm_y(l, m + 1, theta, phi) if m < l else 0
                turned = m * angular / np.tan(theta) + np.sqrt((l - m) * (l + m + 1)) * np.exp(-1j * phi) * above
                values.append(radial * angular)
                along = normal[0] * slope * angular + normal[1] * radial * turned / r
                slopes.append(along + normal[2] * radial * 1j * m * angular / (r * np.sin(theta)))
        return np.array(values), np.array(slopes)

    inside, steep = waves(k0 * complex(*body["eta"]), False)
    regular, outgoing = waves(k0 * host, False), waves(k0 * host, True)
    # radial functions stay, angular ones are conjugated: h Y* = (2 j Y − h Y)*
    dual = [[r.conj() for r in regular], [(2 * r - o).conj() for r, o in zip(regular, outgoing)]]
    null = [slope @ inside.T - value @ steep.T for value, slope in dual]
    return -null[0] @ np.linalg.inv(null[1])


def vector_t(k0, host, body, degree):
    """Its T-matrix in the parity basis of treams."""
    place, normal = surface(body, 4 * degree + 8)
    basis = treams.SphericalWaveBasis.default(degree)
    modes = [(int(l), int(m), int(pol)) for _, l, m, pol in basis]

    def waves(k, kinds):
        """Fields of all waves and their curls, as modes × components × points."""
        x = k * place[0]
        field = {(l, m, pol): kinds[pol](l, m, x, *place[1:]).T for l, m, pol in modes}
        return [np.array([field[mode] for mode in modes]), k * np.array([field[l, m, 1 - pol] for l, m, pol in modes])]

    regular, outgoing = waves(k0 * host, (vsw_rM, vsw_rN)), waves(k0 * host, (vsw_M, vsw_N))
    inside, curled = waves(k0 * complex(*body["eta"]), (vsw_rM, vsw_rN))
    dual = [[r.conj() for r in regular], [(2 * r - o).conj() for r, o in zip(regular, outgoing)]]

    def product(a, b):
        """∮ n · a × b for all pairs."""
        crossed = np.cross(normal.T[None], np.moveaxis(a, 1, 2))
        return np.moveaxis(crossed, 2, 1).reshape(len(a), -1) @ b.reshape(len(b), -1).T

    null = [product(curl, inside) + product(value, curled) for value, curl in dual]
    return -null[0] @ np.linalg.inv(null[1]), basis


def scalar(inputs, body, degree):
    k0 = 2 * np.pi / inputs["wavelength"]
    return coated.scalar(inputs, degree, scalar_t(k0, inputs["n_in"], body, degree))


def vector(inputs, body, degree):
    """As the adapter of treams solves a sphere, whose T-matrix is replaced."""
    def t_matrix(lmax, k0, radii, materials):
        own, basis = vector_t(k0, np.sqrt(materials[-1].epsilon).real, body, lmax)
        return treams.TMatrix(own, k0=k0, basis=basis, material=materials[-1])

    treams.TMatrix.sphere = staticmethod(t_matrix)
    radius = max(body["shape"]["axes"]) / 2
    around = {**inputs, "spheres": [{"center": coated.CENTRE, "radius": radius, "eta": body["eta"]}]}
    sys.stdin = io.StringIO(json.dumps({"case": "ellipsoid", "inputs": around, "wave": "vector", "knob": str(degree)}))
    sys.path.insert(0, str(coated.ADAPTER.parent))
    with contextlib.redirect_stdout(io.StringIO()) as answer:
        runpy.run_path(str(coated.ADAPTER))
    return json.loads(answer.getvalue())["orders"]


if __name__ == "__main__":
    cases = []
    for name, wave, body in CASES:
        inputs = {**coated.LIGHT, **(coated.HOST if wave == "scalar" else coated.BINDER)}
        solve = {"scalar": scalar, "vector": vector}[wave]
        coarse, fine = (solve(inputs, body, degree) for degree in (8, 10))
        change = np.abs(coated.numbers(fine) - coated.numbers(coarse)).max()
        inputs = {**inputs, "bodies": [{**body, "center": coated.CENTRE}]}
        cases.append({"id": name, "wave": wave, "inputs": inputs, "change": float(f"{change:.1e}"), "orders": fine})
    print(json.dumps({"cases": cases}, indent=1))

"""Applies the operator of `inkwave solve --export-operator FILE.npz` to its solution: NumPy alone, no line of inkwave.

The equation is u + A⁻¹V u = A⁻¹ b. A is the mean medium, one tridiagonal system along z for each harmonic, with the exact
waves of each cell; V is the contrast, a product at the points of every plane. Prints the residual, and the one of the solver.
"""
import sys
import numpy as np

f = np.load(sys.argv[1])
h = np.diff(f["nodes_um"])[:, None]
degree, cells, exact = len(f["element_points"]) - 1, len(h), f["exact_cells"][0]
planes, ny, nx = f["moments"].shape[1:] if f["moments"].size else (degree * cells + 1, 1, 1)
node, inner = degree * np.arange(cells + 1), range(1, degree)
kz2 = f["mean_k2"][:, None] - (f["lateral"] ** 2).sum(1)[None, :]  # cells × harmonics
kz = np.sqrt(kz2 + 0j)

def share(t):  # the wave of a cell that is 1 at its first node and 0 at the second, at the fraction t
    return np.sin(kz * h * (1 - t)) / np.sin(kz * h) if exact else (1 - t) * np.ones_like(kz)

# Couplings of the nodes, and the dense matrices of all harmonics.
off, own = (kz / np.sin(kz * h), -kz / np.tan(kz * h)) if exact else (1 / h + 0 * kz, h * kz2 / 2 - 1 / h)
matrix = np.zeros((kz.shape[1], cells + 1, cells + 1), complex)
for j in range(cells):
    matrix[:, [j, j + 1], [j, j + 1]] += own[j][:, None]
    matrix[:, [j, j + 1], [j + 1, j]] += off[j][:, None]
matrix[:, [0, cells], [0, cells]] += 1j * f["kappa"].T
bubble = [kz2 * h * ratio - 1 / h for ratio in f["bubble_lambda"]]
# W_p = ∫ ψ_p (k² − ⟨k²⟩) dz at the points of every plane.
weights = np.zeros((planes, ny, nx), complex)
for j, shift in enumerate((f["background_k2"] - f["mean_k2"]) * h[:, 0]):
    weights[node[j]:node[j + 1] + 1] += (shift * f["element_weights"])[:, None, None]
weights += np.einsum("c,cpyx->pyx", f["contrasts"], f["moments"])
for (a, b), field in zip(f["folded_pairs"], f["folded"]):
    weights += f["contrasts"][a] * f["contrasts"][b] * (1 if a == b else 2) * field

def solve(loads):  # A⁻¹ for right-hand sides of nodes and bubbles
    out = loads.copy()
    out[node] = np.linalg.solve(matrix, loads[node].T[:, :, None])[:, :, 0].T
    for i in inner:
        out[node[:-1] + i] = loads[node[:-1] + i] / bubble[i - 1]
    return out

def contrast(u):  # V u: values on planes, product at points, and the transpose of the first step
    x, y = f["harmonics"][:, 0] % nx, f["harmonics"][:, 1] % ny
    first, last, values, spectrum = node[:-1], node[1:], u.copy(), np.zeros((planes, ny, nx), complex)
    for p, t in zip(inner, f["element_points"][1:]):
        values[first + p] = share(t) * u[first] + share(1 - t) * u[last]
        values[first + p] += sum(f["bubble_values"][i - 1, p - 1] * u[first + i] for i in inner)
    spectrum[:, y, x] = values
    loads = np.fft.fft2(weights * np.fft.ifft2(spectrum))[:, y, x]
    out = np.where(np.isin(np.arange(planes), node)[:, None], loads, 0)
    for p, t in zip(inner, f["element_points"][1:]):
        np.add.at(out, first, share(t) * loads[first + p])
        np.add.at(out, last, share(1 - t) * loads[first + p])
        for i in inner:
            out[first + i] += f["bubble_values"][i - 1, p - 1] * loads[first + p]
    return out

background = solve(f["source"])
residual = background - f["solution"] - solve(contrast(f["solution"]))
print(np.linalg.norm(residual) / np.linalg.norm(background), f["residual"][0])

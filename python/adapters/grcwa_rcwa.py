"""Adapter of grcwa: films, gratings and spheres in slices by coupled waves. The knob is the number of harmonics."""

import grcwa
import numpy as np
from common import Refusal, main, program

DESCRIPTION = {"program": program("grcwa"), "knob": "number of harmonics",
               "conventions": "exp(-iwt), no factorisation rules; cylinders and spheres in slices"}
# Points of the grid on which ε of a slice is given, along a direction in which it changes, and samples averaged for each.
POINTS = {1: (2048, 16), 2: (128, 3)}
SLICES_PER_UM = 30


def slices(case):
    """Thickness, and ε of a film or its values on a grid, from the incident side on."""
    bottom = 0.0
    count, samples = POINTS[1 if case.uniform_y else 2]
    points, parts = zip(*((1, 1) if uniform else (count, samples) for uniform in (case.uniform_x, case.uniform_y)))
    # The package's points are at multiples of their distance, each in the middle of its samples.
    axes = [(np.arange(p * q) + 0.5 - q / 2) * period / (p * q) for p, q, period in zip(points, parts, case.period)]
    for thickness, eta, bars in case.films:
        round_bodies = case.spheres or case.cylinders
        slices = int(np.ceil(SLICES_PER_UM * thickness)) if round_bodies else 1
        for k in range(slices):
            z = np.array([bottom + (k + 0.5) * thickness / slices])
            values = np.array([[eta**2]])
            if round_bodies or bars:
                values = case.permittivity(*axes, z).reshape(points[0], parts[0], points[1], parts[1]).mean((1, 3))
            yield thickness / slices, eta**2 if np.ptp(values.real) + np.ptp(values.imag) == 0 else values
        bottom += thickness


def solve(case):
    if case.wave == "scalar" and not (case.uniform_y and abs(case.kpar[1]) < 1e-12 or case.uniform_x):
        raise Refusal("the scalar wave is Maxwell's s light only where nothing changes along y")
    count = 3 if case.uniform_x else int(case.knob or (41 if case.uniform_y else 101))
    # A short period keeps harmonics along a direction without structure out of the truncation.
    period = [1e-3 if uniform else p for uniform, p in zip((case.uniform_x, case.uniform_y), case.period)]
    solver = grcwa.obj(count, [period[0], 0], [0, period[1]], case.k0 / (2 * np.pi), case.polar, case.azimuth, verbose=0)
    grids = []
    solver.Add_LayerUniform(0.0, case.n[0] ** 2)
    for thickness, epsilon in slices(case):
        if isinstance(epsilon, np.ndarray):
            solver.Add_LayerGrid(thickness, *epsilon.shape)
            grids.append(epsilon.flatten())
        else:
            solver.Add_LayerUniform(thickness, epsilon)
    solver.Add_LayerUniform(0.0, case.n[1] ** 2)
    solver.Init_Setup()
    if grids:
        solver.GridLayer_geteps(np.concatenate(grids))
    labels = [(int(m), int(n)) for m, n in solver.G]
    last = solver.Layer_N - 1
    incident, reflected, transmitted = [], [], []
    for s, p in ((1, 0), (0, 1)):
        solver.MakeExcitationPlanewave(p, 0, s, 0)
        incident.append(fields(solver, labels, 0, solver.a0, 0)[0, 0])
        reflected.append(fields(solver, labels, 0, 0, solver.GetAmplitudes(0, 0.0)[1]))
        transmitted.append(fields(solver, labels, last, solver.GetAmplitudes(last, 0.0)[0], 0))
    both = lambda sides: {key: [side[key] for side in sides] for key in sides[0]}
    if case.wave == "vector":
        return case.answer(both(reflected), both(transmitted), incident)
    # Of the two excitations the one with E along s.
    s = np.array([-np.sin(case.azimuth), np.cos(case.azimuth)])
    k = int(np.argmax([abs(s @ field) for field in incident]))
    along = lambda sides: {key: s @ field for key, field in sides[k].items()}
    return case.answer(along(reflected), along(transmitted), s @ incident[k])


def fields(solver, labels, layer, forward, backward):
    """(Ex, Ey) of every harmonic of the waves in one half-space."""
    steps = (forward - backward) / solver.omega / solver.q_list[layer]
    field = solver.kp_list[layer] @ (solver.phi_list[layer] @ steps)
    return {label: np.array([field[solver.nG + i], -field[i]]) for i, label in enumerate(labels)}


main(DESCRIPTION, solve)

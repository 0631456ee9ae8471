"""Adapter of meanas: finite differences in the frequency domain. The knob is the number of cells per µm, 20 without one."""

import numpy as np
from common import Refusal, main, program
from meanas.fdfd import operators, scpml
from meanas.fdmath import vec, unvec
from scipy.sparse.linalg import splu
from volume import Volume

DESCRIPTION = {"program": program("meanas"), "waves": ["vector"], "knob": "cells per um",
               "conventions": "exp(+iwt), conjugated by the adapter; perfectly matched layers of 12 cells, direct solve"}
ABSORBER = 12
# Unknowns beyond which the direct factorisation needs more memory than a comparison grants.
MOST = 150_000
# Places of Ex, Ey and Ez in a cell of the Yee grid, from its centre in parts of an edge.
PLACES = ((0.0, -0.5, -0.5), (-0.5, 0.0, -0.5), (-0.5, -0.5, 0.0))


def solve(case):
    if case.wave == "scalar":
        raise Refusal("Maxwell's equations only")
    volume = Volume(case, 1.0 / (case.knob or 20.0))
    if len(volume.x) * len(volume.y) * (len(volume.z) + 2 * ABSORBER) * 3 > MOST:
        raise Refusal(f"more than {MOST} unknowns: the factorisation does not fit")
    pad = ((0, 0), (0, 0), (ABSORBER, ABSORBER))
    permittivity = [np.pad(volume.permittivity(place), pad, mode="edge") for place in PLACES]
    shape = permittivity[0].shape
    omega = case.k0 * volume.edge
    cells = [[np.ones(count) for count in shape] for _ in range(2)]
    for polarity, eta in ((1, case.n[0]), (-1, case.n[1])):
        cells = scpml.stretch_with_scpml(cells, axis=2, polarity=polarity, omega=omega,
                                         epsilon_effective=eta.real**2, thickness=ABSORBER)
    # The time factor of the package is exp(+iwt): conjugate media, source and fields.
    matrix = splu(operators.e_full(omega, cells, vec(np.conj(permittivity))).tocsc())
    runs = []
    for axis in (0, 1):
        current = np.zeros((3, *shape), complex)
        current[axis, :, :, ABSORBER] = np.conj(volume.source(PLACES[axis]))
        field = unvec(matrix.solve(-1j * omega * vec(current)), shape)
        runs.append([np.conj(field[k])[..., ABSORBER:shape[2] - ABSORBER] for k in (0, 1)])
    return volume.answer(runs, PLACES[:2])


main(DESCRIPTION, solve)

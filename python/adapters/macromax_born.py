"""Adapter of MacroMax: modified Born series on voxels. The knob is the number of voxels per µm, 40 without one."""

import macromax
import numpy as np
from common import Refusal, main, program
from volume import Volume

DESCRIPTION = {"program": program("macromax"), "knob": "voxels per um",
               "conventions": "exp(-iwt); absorbing layers of 5 um before and behind, residual norm 1e-4"}
# Thickness of the absorbing layers, um: with 1.5 films settle at 3e-3, whatever the voxels.
BOUNDARY = 5.0
# Relative norm of the residual, as MacroMax states it.
RESIDUAL = 1e-4
MOST_ITERATIONS = 20000


def solve(case):
    volume = Volume(case, 1.0 / (case.knob or 40.0))
    if case.n[0] != case.n[1] and max(case.n[0].imag, case.n[1].imag) > 0:
        raise Refusal("absorbing half-spaces")
    permittivity = volume.permittivity()
    absorbing = int(BOUNDARY / volume.edge)
    permittivity = np.pad(permittivity, ((0, 0), (0, 0), (absorbing, absorbing)), mode="edge")
    shape = permittivity.shape
    ranges = macromax.Grid(shape=shape, step=volume.edge)
    bound = macromax.bound.LinearBound(ranges, thickness=[[0, 0], [0, 0], [BOUNDARY] * 2], max_extinction_coefficient=0.25)
    scalar = case.wave == "scalar"
    runs = []
    for axis in (0,) if scalar else (0, 1):
        source = np.zeros((1 if scalar else 3, *shape), complex)
        source[axis, :, :, absorbing] = volume.source()
        solution = macromax.solve(
            ranges, vectorial=not scalar, vacuum_wavelength=case.inputs["wavelength"], source_distribution=source,
            epsilon=permittivity, bound=bound, callback=lambda s: s.iteration < MOST_ITERATIONS and s.residue > RESIDUAL,
        )
        if not solution.residue <= RESIDUAL:
            raise Refusal(f"not converged: residual norm {float(solution.residue):.1e} after {MOST_ITERATIONS} iterations")
        field = np.asarray(solution.E).reshape(1 if scalar else 3, *shape)[..., absorbing:shape[2] - absorbing]
        runs.append(field[0] if scalar else field[:2])
    return volume.answer(runs)


main(DESCRIPTION, solve)

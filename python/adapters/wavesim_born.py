"""Adapter of WaveSim: convergent Born iteration on voxels. The knob is the number of voxels per µm, 30 without one."""

from common import Refusal, main, program
import numpy as np
from volume import Volume
from wavesim.simulate import simulate

DESCRIPTION = {"program": program("wavesim"), "knob": "voxels per um",
               "conventions": "exp(-iwt); absorbing layers of 5 um before and behind, residual norm 1e-4"}
# Thickness of the absorbing layers, um: with 1.5 films settle at 3e-3, whatever the voxels.
BOUNDARY = 5.0
# Relative norm of the residual; WaveSim's threshold is the square of this norm.
RESIDUAL = 1e-4
MOST_ITERATIONS = 20000


def solve(case):
    volume = Volume(case, 1.0 / (case.knob or 30.0))
    permittivity = volume.permittivity().astype(np.complex64)
    if (permittivity.real < 0).any():
        raise Refusal("metals: the iteration would not converge")
    scalar = case.wave == "scalar"
    sheet = volume.source()[:, :, None].astype(np.complex64)
    runs = []
    for axis in (None,) if scalar else (0, 1):
        source = (sheet, (0, 0, 0)) if scalar else (sheet[None], (axis, 0, 0, 0))
        field, _, squared_norm = simulate(
            permittivity, [source], wavelength=case.inputs["wavelength"], pixel_size=volume.edge,
            boundary_width=np.array([0, 0, BOUNDARY]), periodic=(True, True, False), use_gpu=False,
            threshold=RESIDUAL**2, max_iterations=MOST_ITERATIONS,
        )
        if not squared_norm < RESIDUAL**2:
            raise Refusal(f"not converged: residual norm {float(squared_norm) ** 0.5:.1e} after {MOST_ITERATIONS} iterations")
        shape = permittivity.shape if scalar else (3, *permittivity.shape)
        field = np.asarray(field).reshape(shape)
        runs.append(field if scalar else field[:2])
    return volume.answer(runs)


main(DESCRIPTION, solve)

"""Adapter of WaveSim: convergent Born iteration on voxels. The knob is the number of voxels per µm, 25 without one."""

from common import Refusal, main, program
import numpy as np
from volume import Volume
from wavesim.simulate import simulate

DESCRIPTION = {"program": program("wavesim"), "knob": "voxels per um",
               "conventions": "exp(-iwt); absorbing layers of 1.5 um before and behind, residual 1e-4"}
BOUNDARY = 1.5
RESIDUAL = 1e-4


def solve(case):
    volume = Volume(case, 1.0 / (case.knob or 25.0))
    permittivity = volume.permittivity().astype(np.complex64)
    if (permittivity.real < 0).any():
        raise Refusal("metals: the iteration would not converge")
    scalar = case.wave == "scalar"
    sheet = volume.source()[:, :, None].astype(np.complex64)
    runs = []
    for axis in (None,) if scalar else (0, 1):
        source = (sheet, (0, 0, 0)) if scalar else (sheet[None], (axis, 0, 0, 0))
        field, _, _ = simulate(
            permittivity, [source], wavelength=case.inputs["wavelength"], pixel_size=volume.edge,
            boundary_width=np.array([0, 0, BOUNDARY]), periodic=(True, True, False), use_gpu=False, threshold=RESIDUAL,
        )
        shape = permittivity.shape if scalar else (3, *permittivity.shape)
        field = np.asarray(field).reshape(shape)
        runs.append(field if scalar else field[:2])
    return volume.answer(runs)


main(DESCRIPTION, solve)

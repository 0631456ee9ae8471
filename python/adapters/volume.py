"""Cases on voxels, for programs that solve fields in a box with periodic sides: grid, source and orders."""

import numpy as np
from common import Refusal, averaged

# Half-space beside the layer on which the waves are separated by their direction of travel, µm.
MARGIN = 0.4
# Largest number of voxels along one period.
MOST = 400


class Volume:
    """Cubic voxels of about the given edge, a whole number of them along both periods, and faces of voxels at z = 0."""

    def __init__(self, case, edge):
        steps = case.kpar * case.period / (2 * np.pi)
        if np.abs(steps - np.rint(steps)).max() > 1e-6:
            raise Refusal("periodic sides: only light from directions of the reciprocal lattice")
        uniform = np.array([case.uniform_x, case.uniform_y]) & (np.abs(case.kpar) < 1e-9)
        lengths = np.where(uniform, 0.0, case.period)
        longest = max(lengths.max(), edge)
        for count in range(max(1, round(longest / edge)), MOST):
            self.edge = longest / count
            counts = lengths / self.edge
            if np.abs(counts - np.rint(counts)).max() < 1e-9:
                break
        else:
            raise Refusal("no cubic voxels fit both periods")
        self.case, self.counts = case, np.maximum(np.rint(counts).astype(int), 1)
        side = round(MARGIN / self.edge)
        layer = int(np.ceil(case.height / self.edge))
        self.z = (np.arange(-side, layer + side) + 0.5) * self.edge
        self.x, self.y = ((np.arange(count) + 0.5) * self.edge for count in self.counts)
        self.margin = side

    def permittivity(self, shift=(0.0, 0.0, 0.0)):
        """ε averaged over the voxels, whose centres may be shifted by parts of an edge."""
        axes = [axis + part * self.edge for axis, part in zip((self.x, self.y, self.z), shift)]
        return averaged(self.case, axes)

    def source(self, shift=(0.0, 0.0)):
        """The phase of the incident light on a plane."""
        kx, ky = self.case.kpar
        x, y = self.x + shift[0] * self.edge, self.y + shift[1] * self.edge
        return np.exp(1j * (kx * x[:, None] + ky * y[None, :]))

    def waves(self, field, shift=(0.0, 0.0, 0.0)):
        """Incident amplitude at z = 0, and dictionaries of the orders reflected at z = 0 and transmitted at z = H."""
        case, first = self.case, 3
        before, after = slice(first, self.margin), slice(len(self.z) - self.margin, len(self.z) - first)
        reflected, transmitted = {}, {}
        x, y, z = (axis + part * self.edge for axis, part in zip((self.x, self.y, self.z), shift))
        for m, n, k, kz in case.orders():
            plane = np.exp(-1j * (k[0] * x[:, None] + k[1] * y[None, :])) / (len(x) * len(y))
            values = np.einsum("xy,xyz->z", plane, field)
            up, down = split(values[before], z[before], kz[0])
            reflected[m, n] = down
            transmitted[m, n] = split(values[after], z[after] - case.height, kz[1])[0]
            if (m, n) == (0, 0):
                incident = up
        return incident, reflected, transmitted

    def answer(self, runs, shifts=((0.0, 0.0, 0.0),) * 2):
        """Orders from the fields of one scalar run, or (Ex, Ey) of two runs."""
        if self.case.wave == "scalar":
            incident, reflected, transmitted = self.waves(runs[0])
            return self.case.answer(reflected, transmitted, incident)
        waves = [[self.waves(component, shift) for component, shift in zip(run, shifts)] for run in runs]
        side = lambda k: {key: [np.array([w[k][key] for w in run]) for run in waves] for key in waves[0][0][k]}
        return self.case.answer(side(1), side(2), [np.array([w[0] for w in run]) for run in waves])


def split(values, z, kz):
    """Amplitudes at z = 0 of the waves towards +z and towards -z."""
    if abs(kz) < 1e-9:
        return values.mean(), 0.0
    waves = np.exp(1j * np.outer(z, [kz, -kz]))
    return np.linalg.lstsq(waves, values, rcond=None)[0]

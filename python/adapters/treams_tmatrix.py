"""Adapter of treams: spheres between plane faces by T-matrices. The knob is the largest multipole order, 6 without one."""

import numpy as np
import treams
from common import Refusal, index, main, program
from treams.special import vpw_M, vpw_N

treams.config.POLTYPE = "parity"
DESCRIPTION = {"program": program("treams"), "waves": ["vector"], "shapes": ["films", "spheres", "nested_spheres"],
               "knob": "largest multipole order", "conventions": "exp(-iwt), parity basis of vpw_M and vpw_N"}
# Gap between a sphere and a face below which evanescent orders couple them so strongly that the expansion diverges.
CLOSEST = 0.005


def material(eta):
    return treams.Material(eta**2)


def layered(case):
    """The spheres of every centre, from the innermost outwards."""
    grains = {}
    for s in sorted(case.spheres, key=lambda s: s["radius"]):
        grains.setdefault(tuple(s["center"]), []).append(s)
    for one, inside in ((a[-1], b[-1]) for a in grains.values() for b in grains.values() if a is not b):
        if np.linalg.norm(np.subtract(one["center"], inside["center"])) < one["radius"] + inside["radius"] - 1e-9:
            raise Refusal("spheres inside others about one centre only")
    return list(grains.values())


def solve(case):
    if case.wave == "scalar" or case.cylinders or any(film[2] for film in case.films):
        raise Refusal("spheres and films under Maxwell's equations only")
    if case.spheres and len(case.films) > 1:
        raise Refusal("spheres in one film only")
    degree = int(case.knob or 6)
    half = case.height / 2
    gap = min([min(s["center"][2], case.height - s["center"][2]) - s["radius"] for s in case.spheres], default=1.0)
    if gap < CLOSEST:
        raise Refusal(f"a sphere {gap:.3f} µm from a face: plane-wave expansions need a gap")
    lattice = treams.Lattice.rectangular(*case.period)
    # Evanescent orders that reach from the spheres to the faces and back.
    reach = case.k0 * max(abs(film[1]) for film in case.films) + 0.6 * degree / max(gap, 0.05) if case.spheres else 0.0
    basis = treams.PlaneWaveBasisByComp.diffr_orders(case.kpar, lattice, reach)
    smatrices, k0 = treams.SMatrices, case.k0
    media = [case.n[0], *(film[1] for film in case.films), case.n[1]]
    stack = []
    for below, above, film in zip(media, media[1:], [*case.films, None]):
        stack.append(smatrices.interface(basis, k0, [material(below), material(above)]))
        if film and case.spheres:
            binder = material(film[1])
            grains = layered(case)
            single = [treams.TMatrix.sphere(degree, k0, [s["radius"] for s in grain],
                                            [material(index(s["eta"])) for s in grain] + [binder]) for grain in grains]
            places = [np.subtract(grain[0]["center"], [0, 0, half]) for grain in grains]
            cluster = treams.TMatrix.cluster(single, places).latticeinteraction.solve(lattice, case.kpar)
            propagation = smatrices.propagation([0, 0, half], basis, k0, binder)
            stack += [propagation, smatrices.from_array(cluster, basis), propagation]
        elif film:
            stack.append(smatrices.propagation([0, 0, film[0]], basis, k0, material(film[1])))
    total = smatrices.stack(stack)
    waves = list(zip(np.real(basis.kx), np.real(basis.ky), basis.pol))

    def fields(coefficients, side, travel):
        """(Ex, Ey) of every order."""
        found = {}
        for (kx, ky, pol), a in zip(waves, coefficients):
            m, n = np.rint((np.array([kx, ky]) - case.kpar) * case.period / (2 * np.pi)).astype(int)
            kz = travel * np.sqrt((k0 * case.n[side]) ** 2 - kx * kx - ky * ky + 0j)
            wave = vpw_N if pol == 1 else vpw_M
            found[m, n] = found.get((m, n), 0) + a * wave(kx, ky, kz, 0.0, 0.0, 0.0)[:2]
        return found

    specular = [i for i, (kx, ky, _) in enumerate(waves) if np.allclose([kx, ky], case.kpar)]
    up, down, incident = [], [], []
    for excited in specular:
        illumination = np.eye(len(waves))[excited]
        above, below = total.illuminate(illumination)
        up.append(fields(np.asarray(above), 1, 1))
        down.append(fields(np.asarray(below), 0, -1))
        incident.append(fields(illumination, 0, 1)[0, 0])
    both = lambda sides: {key: [side[key] for side in sides] for key in sides[0]}
    return case.answer(both(down), both(up), incident)


main(DESCRIPTION, solve)

"""Stacks of a library's plates, composed with NumPy: thousands at once, without the program.

The formulas are those of the program (`inkwave compose`), whose documentation explains them; the same numbers
(`validation/data/library-golden.json`) judge both, and the page of a library besides.
"""

from __future__ import annotations

import base64
import copy
import functools
import json
import math
import pathlib
from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from ._files import Path
from ._program import InputError, remark

__all__ = ["Composed", "Library"]

FORM = 5
_FAINT = 1e-9
_NOTHING = 1e-9
_PIECE, _PIECES, _MOST_FRINGES = 8, 16, 200.0
_MOST_SLABS = 4096.0
_BLACK, _WHITE = 0.0, 0.8
_PRINT_SINE = math.sin(math.radians(45.0))
_PENCIL, _LEAST, _SMALL = 1e-10, 1e-12, 1e-6
_LOSSLESS, _SAME_INDEX = 1e-12, 1e-9
_STEP_NM, _SHORTEST_NM, _CUT_NM, _LONGEST_NM = 5.0, 300.0, 420.0, 780.0
_AT_ONCE, _WITHIN_CACHE, _MOST_FILMS = 256, 1 << 14, 1024
_MOST_INKS = 6
# Clear slabs keep their light within 1e-4; fluxes that were not balanced are far from it.
_UNBALANCED = 1e-3
# what scattered light changes without its highest moment, over what more directions would change
_THINNED = 3.0
# Lamps of the conditions of instruments; none: that of the illuminant.
_CONDITIONS = {None: None, "M0": "A", "M1": "D50", "M2": "D50"}
_SCALAR_SURFACE = ("the scalar wave crosses the paper's surface as s light, and the paper between the dots is seen in unpolarised light: "
                   "a clear layer of its index, {}, does not look quite like bare paper; `inkwave compose` says by how much, and plates "
                   "solved with light.wave = \"unpolarised\" have both alike")
_NODES, _MEAN_ERROR, _FRINGES_OF_A_PIECE, _MOST_HALVINGS, _ROUNDS, _FURTHEST, _NARROWEST, _LITTLE = (16, 11), 1e-7, 4.0, 48, 12, 1.0, 1e-3, 0.02


class _Flux(NamedTuple):
    """Reflection from both sides, transmission onward and back: arrays that end in (to, from)."""

    ra: np.ndarray
    rb: np.ndarray
    tab: np.ndarray
    tba: np.ndarray

    def then(self, behind: "_Flux") -> "_Flux":
        """This in front of another: (1 − ba)⁻¹ = 1 + b (1 − ab)⁻¹ a, so that one solve does."""
        onward = self.tab.shape[-1]
        both = _beside(self.tab, self.rb @ behind.tba)
        found = _bounced(self.rb, behind.ra, both)
        down, up = found[..., :onward], behind.tba + behind.ra @ found[..., onward:]
        return _Flux(self.ra + self.tba @ (behind.ra @ down), behind.rb + behind.tab @ (self.rb @ up), behind.tab @ down,
                     self.tba @ up)

    def turned(self) -> "_Flux":
        """Turned over."""
        return _Flux(self.rb, self.ra, self.tba, self.tab)

    def moved(self, by: float) -> "_Flux":
        """With `by` more of the light reflected and less transmitted, as far as there is any."""
        if by == 0.0:
            return self
        parts = []
        for r, t in ((self.ra, self.tab), (self.rb, self.tba)):
            back, onward = r.sum(-2, keepdims=True), t.sum(-2, keepdims=True)
            moves = (back > by) & (onward > by)
            more = np.where(moves, (back + by) / np.where(moves, back, 1.0), 1.0)
            less = np.where(moves, (onward - by) / np.where(moves, onward, 1.0), 1.0)
            parts.append((r * more, t * less))
        return _Flux(parts[0][0], parts[1][0], parts[0][1], parts[1][1])

    def repeated(self, count: float, weights: np.ndarray) -> "_Flux":
        """This number of them, of which the last may be a part; weights are étendues of the states."""
        if count == 1.0:
            return self
        n = self.ra.shape[-1]
        none, all_ = np.zeros_like(self.ra), np.broadcast_to(np.eye(n), self.ra.shape)
        total, power, whole = _Flux(none, none, all_, all_), self, int(max(count, 0.0))
        while whole > 0:
            if whole % 2:
                total = total.then(power)
            whole //= 2
            if whole:
                power = power.then(power)
        part = max(count, 0.0) % 1.0
        return total if part == 0.0 else total.then(self.fraction(part, weights))

    def fraction(self, part: float, weights: np.ndarray) -> "_Flux":
        """A part of a slab that is alike from both sides."""
        node = weights > 0.0
        etendue = np.where(node, weights, _PENCIL)
        scale = np.sqrt(etendue[..., None, :] / etendue[..., :, None])

        def even(m: np.ndarray) -> np.ndarray:
            scaled = m * scale
            other = np.swapaxes(scaled, -1, -2)
            to, of = node[..., :, None], node[..., None, :]
            return np.where(to & ~of, scaled, np.where(~to & of, other, 0.5 * (scaled + other)))

        def of(m: np.ndarray, f: Any) -> np.ndarray:
            values, vectors = np.linalg.eigh(m)
            return np.asarray((vectors * f(values)[..., None, :]) @ np.swapaxes(vectors, -1, -2))

        r, t = even(self.ra), even(self.tab)
        y = of(r + t, lambda c: np.maximum((1 - c) / np.maximum(1 + c, _LEAST), 0))
        x = of(r - t, lambda c: np.maximum((1 + c) / np.maximum(1 - c, _LEAST), 0))
        root = of(y, lambda v: np.sqrt(np.maximum(v, 0)))
        product = root @ x @ root
        part_y = root @ of(product, lambda v: _shrunk(part, v)) @ root
        part_x = part * x + x @ root @ of(product, lambda v: _shrunk_further(part, v)) @ root @ x
        alike = of(part_y, lambda v: (1 - v) / (1 + np.maximum(v, 0)))
        opposite = of(part_x, lambda v: (v - 1) / (np.maximum(v, 0) + 1))
        into_beam = ~node[..., :, None] & node[..., None, :]
        back, onward = (np.where(into_beam, 0.0, 0.5 * (alike + sign * opposite) / scale) for sign in (1.0, -1.0))
        return _Flux(back, back, onward, onward)


def _beside(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Columns of both, for as many stacks as either has."""
    many = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    return np.concatenate([np.broadcast_to(x, many + x.shape[-2:]) for x in (a, b)], axis=-1)


def _bounced(a: np.ndarray, b: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.linalg.solve(np.eye(a.shape[-1]) - a @ b, x)


def _shrunk(part: float, theta: np.ndarray) -> np.ndarray:
    theta = np.clip(theta, 0.0, 1.0 - _LEAST)
    root = np.sqrt(np.maximum(theta, _SMALL))
    return np.where(theta < _SMALL, part + theta * part * (1 - part * part) / 3, np.tanh(part * np.arctanh(root)) / root)


def _shrunk_further(part: float, theta: np.ndarray) -> np.ndarray:
    far = np.maximum(theta, _SMALL)
    return np.where(theta < _SMALL, part * (1 - part * part) / 3, (_shrunk(part, far) - part) / np.minimum(far, 1.0))


class _Film(NamedTuple):
    """Amplitudes of the mean wave, from in front and from behind, and through."""

    ra: np.ndarray
    rb: np.ndarray
    t: np.ndarray

    def then(self, behind: "_Film") -> "_Film":
        """This in front of another; of powers (real arrays) without interference."""
        least = 1.0 - self.rb * behind.ra
        many = 1.0 / (least if np.iscomplexobj(self.t) else np.maximum(least, _FAINT))
        return _Film(self.ra + self.t**2 * behind.ra * many, behind.rb + behind.t**2 * self.rb * many, self.t * behind.t * many)

    def powers(self) -> "_Film":
        """Squared moduli."""
        return _Film(*(np.abs(x) ** 2 for x in self))

    def where(self, here: np.ndarray, other: "_Film") -> "_Film":
        """This in some places, in the others another."""
        return self if here.all() else _Film(*(np.where(here, x, y) for x, y in zip(self, other))) if here.any() else other

    def repeated(self, count: Any, part_of: Callable[[Any], "_Film"]) -> "_Film":
        """This number of them one behind another, or several numbers (number, 1, 1), and behind the whole ones a part of one."""
        count = np.asarray(count, float)
        if (count == 1.0).all():
            return self
        zero = np.zeros_like(self.t)
        total, power, whole = _Film(zero, zero, zero + 1.0), self, np.floor(count).astype(int)
        while whole.any():
            total = total.then(power).where(whole % 2 == 1, total)
            whole = whole // 2
            if whole.any():
                power = power.then(power)
        part = count % 1.0
        total = total.then(part_of(part)).where(part > 0.0, total) if part.any() else total
        return self.where(count == 1.0, total)

    def powers_repeated(self, count: Any) -> "_Film":
        """The same of powers, without interference (Stokes)."""
        if np.equal(count, 1.0).all():
            return self
        mirrored = 0.5 * (self.ra + self.rb)
        there, loses = mirrored >= _LOSSLESS, 1 - mirrored - self.t >= _LOSSLESS
        some = np.where(there, mirrored, 1.0)
        half = (1 + some**2 - self.t**2) / (2 * some)
        own = np.where(there, 1 / (half + np.sqrt(np.maximum(half * half - 1, 0.0))), 0.0)
        onward = (self.t / (1 - own * mirrored)) ** count
        many = 1 / (1 - (own * onward) ** 2)
        back = own * (1 - onward**2) * many
        lossy = _Film(back, back, onward * (1 - own**2) * many)
        through = self.t / (self.t + count * mirrored)
        return self.where(np.equal(count, 1.0), lossy.where(loses | ~there, _Film(1 - through, 1 - through, through)))


class _Once(NamedTuple):
    """One slab as the mean wave meets it, whatever their number: the logarithm of the way through its medium, where it mirrors
    (wavelength, 1), the film that it is there, that of a part of it, and its powers as composing has them, where they are not the film's."""

    way: np.ndarray
    mirrors: np.ndarray
    film: Optional[_Film] = None
    part_of: Callable[[Any], _Film] = lambda part: _Film(part, part, part)
    solved: Optional[_Film] = None

    def repeated(self, count: Any, kind: int = 0) -> _Film:
        """Amplitudes (kind 0) or powers (1) of this number of them, or of several numbers (number, 1, 1)."""
        if kind and self.solved is not None:
            return self.solved.powers_repeated(count)
        film = None
        if self.film is not None:
            film = self.film.powers().powers_repeated(count) if kind else self.film.repeated(count, self.part_of)
            if self.mirrors.all():
                return film
        through = np.exp(self.way * count)
        plain = _Film(np.zeros_like(through), np.zeros_like(through), through)
        plain = plain.powers() if kind else plain
        return plain if film is None else film.where(self.mirrors, plain)


def _normal(index: Any, sine: np.ndarray) -> np.ndarray:
    root = np.sqrt(np.asarray(index * index - sine * sine, complex))
    return np.asarray(np.where(root.imag < 0, -root, root))


def _plane(before: Any, behind: Any, sine: np.ndarray, p: int) -> _Film:
    a, b = (_normal(n, sine) / (1.0 if p == 0 else n * n) for n in (before, behind))
    r = (a - b) / (a + b)
    return _Film(r, -r, np.sqrt(1 - r * r))


def _own_passage(step: np.ndarray, through: np.ndarray) -> np.ndarray:
    """t of a slab between half-spaces of its own medium over the `through` that it has between those to which both faces have this step."""
    passes = 1 - step * step
    return np.asarray(2 / (passes + np.sqrt(passes * passes + 4 * (step * through) ** 2)))


def _even_slab(step: np.ndarray, through: np.ndarray) -> np.ndarray:
    """What a slab with this t between half-spaces mirrors, both of whose faces have this step."""
    own = (through * _own_passage(step, through)) ** 2
    return np.asarray(step * (1 - own) / (1 - step * step * own))


def _lagrange(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Weights (x, point) of the polynomial through values at the points."""
    weights = np.ones((x.size, points.size))
    for i, own in enumerate(points):
        for j, other in enumerate(points):
            if j != i:
                weights[:, i] *= (x - other) / (own - other)
    return weights


class _States(NamedTuple):
    """A portion at all wavelengths: fluxes, and amplitudes (wavelength, side, direction, polarisation, lobe)."""

    flux: _Flux
    amplitudes: np.ndarray


@dataclass(frozen=True)
class _Portion:
    position: str
    halved: bool
    thickness_um: float
    grid_error: float
    between: np.ndarray
    states: List[_States]  # the mean, then those that leave out one cell each

    @property
    def cells(self) -> int:
        return len(self.states) - 1

    def mirrors(self, within: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Whether the medium ends at the front and at the back (wavelength): also within a layer, between half-spaces of another index."""
        inside = self.between[:, 0 if self.position == "back" else 1]
        stepped = (self.position != "whole") & (np.abs(inside - within) > _SAME_INDEX)
        return stepped | (self.position in ("front", "whole")), stepped | (self.position in ("back", "whole"))


class _Change(NamedTuple):
    """What is changed of the ensembles: (plate, portion, cell) left out, the grid's error, half slabs, fewer directions
    of fringes, scattered light without the highest moment that its directions resolve."""

    left_out: Optional[Tuple[int, int, int]] = None
    grid: bool = False
    halved: bool = False
    fewer: bool = False
    thinned: bool = False


class _Print(NamedTuple):
    """A print in dots: numbers of the layers on every kind of area, their shares, the spread of the light."""

    kinds: Tuple[Tuple[int, ...], ...]
    shares: np.ndarray
    spread: float


class _Light(NamedTuple):
    """A paper that fluoresces, under a light, at the wavelengths of the sum over excitation; the light also at those of the library."""

    albedo: np.ndarray
    power: np.ndarray
    matrix: np.ndarray
    seen: np.ndarray


@dataclass(frozen=True)
class _Job:
    layers: Tuple[Tuple[int, float], ...]
    albedo: np.ndarray
    contact: bool
    printed: Optional[_Print]
    light: Optional[_Light]
    change: _Change


class _Stack(NamedTuple):
    """Layers by number of plate and count of slabs, whether a paper touches them, and what is changed of the ensembles."""

    layers: Tuple[Tuple[int, float], ...]
    contact: bool
    change: _Change


@dataclass(frozen=True)
class Composed:
    """What compositions look like: arrays over compositions, then wavelengths or L*, a*, b*.

    `errors` has the standard errors of the same names, where bars were asked for. Colours are not a number where the library's
    wavelengths carry none.
    """

    wavelengths_nm: np.ndarray
    reflectance_normal: np.ndarray
    transmittance_normal: np.ndarray
    natural_light: np.ndarray
    lit_at_45: np.ndarray
    over_black: np.ndarray
    over_white: np.ndarray
    lab_natural_light: np.ndarray
    lab_lit_at_45: np.ndarray
    contrast_ratio: np.ndarray
    factors: np.ndarray
    lab: np.ndarray
    errors: Optional[Dict[str, np.ndarray]] = None


# before the name of factors: the parts of them that a paper emits
_EMITTED = "emitted: "
_SPECTRA = ("reflectance_normal", "transmittance_normal", "natural_light", "lit_at_45", "over_black", "over_white", "factors")
_COLOURS = ("lab_natural_light", "lab_lit_at_45", "contrast_ratio", "lab")

Composition = Mapping[str, Any]


class Library:
    """A library of plates that `inkwave library` has written.

    >>> import inkwave as iw
    >>> library = iw.Library("library.json")                                                        # doctest: +SKIP
    >>> seen = library.compose([{"layers": ["yellow 0.4", "blue 0.4"], "paper": {"albedo": 0.9}}])  # doctest: +SKIP
    >>> seen.lab.shape                                                                              # doctest: +SKIP
    (1, 3)
    """

    def __init__(self, source: Union[Path, Mapping[str, Any]]):
        content = dict(source) if isinstance(source, Mapping) else _read(source)
        form = content.get("inkwave_library")
        if not isinstance(form, int):
            raise InputError("found no library; allowed is a file that `inkwave library` has written")
        if form > FORM:
            raise InputError(f"inkwave_library: found form {form}; allowed up to {FORM}: read it with a newer inkwave")
        try:
            self._read(content, form)
        except InputError:
            raise
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"found a library that is damaged ({type(error).__name__}: {error}); gather it again") from None

    def _read(self, content: Mapping[str, Any], form: int) -> None:
        joint = content["joint"]
        self.wavelengths_nm = np.array(content["wavelengths_nm"], float)
        self.joint_index = float(joint["index"])
        self._sines, self._weights = np.array(joint["sines"]), np.array(joint["weights"])
        self._polarisations = int(joint["polarisations"])
        self._directions = [int(count) for count in joint["directions"]]
        self._near = self._directions[0]
        # files before form 3 keep amplitudes of the directions from which light reaches air alone
        self._kept_directions = 1 + (self._sines.size if form >= 3 else self._near)
        self._wave = content["wave"]
        # weights of factors, and how those of what a paper emits under a lamp with lines differ
        self._eyes = {(eye["illuminant"], eye["observer"]): np.hstack([eye["weights"], np.subtract(eye.get("emitted") or eye["weights"], eye["weights"])])
                      for eye in content["eyes"]}
        self._plates = content["plates"]
        self._numbers = {plate["name"]: k for k, plate in enumerate(self._plates)}
        if len(self._numbers) != len(self._plates):
            raise InputError("plates: found two of one name; allowed are names of their own: gather the library again")
        self._portions = [[self._portion(plate["name"], portion) for portion in plate["portions"]] for plate in self._plates]
        for plate, portions in zip(self._plates, self._portions):
            for flux in (portion.states[0].flux for portion in portions):
                kept = np.r_[(flux.ra.sum(-2) + flux.tab.sum(-2)).ravel(), (flux.rb.sum(-2) + flux.tba.sum(-2)).ravel()]
                if kept.min() < -_UNBALANCED or kept.max() > 1 + _UNBALANCED:
                    raise InputError(f"plate {plate['name']!r}: found {kept.min():.3g} to {kept.max():.3g} of the light reflected and passed on; "
                                     "allowed 0 to 1: solve its layer again")
        self._lights = {light["illuminant"]: np.array(light["powers"], float) for light in content.get("lights", [])}
        self._means_of_lines = {light["illuminant"]: np.array(light["seen_powers"], float)
                                for light in content.get("lights", []) if light.get("seen_powers")}
        first, last = math.ceil(max(self.wavelengths_nm[0], _SHORTEST_NM) / _STEP_NM), math.floor(self.wavelengths_nm[-1] / _STEP_NM)
        self._summed_nm = _STEP_NM * np.arange(first, last + 1)
        self._layers: Dict[Any, _Flux] = {}
        self._films: Dict[Any, List[Tuple[_Film, _Film]]] = {}
        self._once: Dict[Any, _Once] = {}
        self._fringes: Dict[Any, List[Tuple[np.ndarray, np.ndarray]]] = {}
        self._turned_back: Dict[Any, _TrappedSlab] = {}
        p = self._polarisations
        self._shares = {"scalar": [1.0], "s": [1.0, 0.0], "p": [0.0, 1.0]}.get(self._wave, [1.0 / p] * p)
        near = np.r_[0.0, self._sines[: self._near]]
        self._known, self._places = near, np.sqrt(1.0 - near * near)

    @property
    def plates(self) -> List[str]:
        """Names of the plates."""
        return list(self._numbers)

    def __repr__(self) -> str:
        return f"Library of {len(self._plates)} plates at {self.wavelengths_nm.size} wavelengths: {', '.join(self.plates)}"

    def _portion(self, name: str, portion: Mapping[str, Any]) -> _Portion:
        all_states = portion["states"]
        if len(all_states) != self.wavelengths_nm.size:
            raise InputError(f"plate {name!r}: found {len(all_states)} wavelengths; allowed {self.wavelengths_nm.size}: gather it again")
        means = [np.frombuffer(base64.b64decode(at["mean"]), "<f8") for at in all_states]
        kinds = [self._unpacked(np.array([x]), at["states"]) for x, at in zip(means, all_states)]
        cells = min(len(at["replicates"]) for at in all_states)
        rows = [kinds]
        for cell in range(cells):
            row = []
            for mean, at in zip(means, all_states):
                packed = at["replicates"][cell]
                moved = mean + packed["unit"] * np.frombuffer(base64.b64decode(packed["differences"]), "<i2")
                row.append(self._unpacked(moved[None], at["states"]))
            rows.append(row)
        between = np.array([at["between"] for at in all_states])
        return _Portion(portion["position"], portion["halved"], portion["thickness_um"], portion["grid_error"], between,
                        [_joined(row) for row in rows])

    def _unpacked(self, x: np.ndarray, states: Sequence[int]) -> _States:
        m, n = states
        known, p = self._kept_directions, self._polarisations
        if x.shape[-1] != m * m + n * n + 2 * m * n + 8 * known * p or not np.isfinite(x).all():
            raise InputError("a plate whose numbers are incomplete or not finite: gather the library again")
        ends = np.cumsum([m * m, n * n, m * n, m * n])
        ra, rb, tab, tba, rest = np.split(x, ends, axis=-1)
        flux = _Flux(ra.reshape(-1, m, m), rb.reshape(-1, n, n), tab.reshape(-1, n, m), tba.reshape(-1, m, n))
        pairs = rest.reshape(-1, 2, known, p, 2, 2)
        return _States(flux, pairs[..., 0] + 1j * pairs[..., 1])

    def compose(self, compositions: Union[Composition, Sequence[Composition]], bars: bool = False) -> Composed:
        """Composes stacks on paper: one composition, or a list of them, each as `inkwave compose` reads it.

        `bars`: standard errors of all numbers, by chance, halves of layers, grid and directions (as the program's, but for what
        the distance of the wavelengths leaves open of colours).
        """
        listed = [compositions] if isinstance(compositions, Mapping) else list(compositions)
        if not listed:
            raise InputError("found no composition; allowed is one, or a list of one or more: {'layers': [{'plate': NAME}]}")
        jobs = [self._job(composition, number) for number, composition in enumerate(listed)]
        eyes = [self._eye(composition) for composition in listed]
        if self._wave == "scalar" and any(job.contact and job.printed is not None for job in jobs) and self.joint_index != 1.0:
            remark([_SCALAR_SURFACE.format(self.joint_index)])
        with np.errstate(divide="ignore", invalid="ignore"):  # a perfect white below a layer that loses nothing
            return self._composed(jobs, eyes, bars)

    def _composed(self, jobs: Sequence[_Job], eyes: Sequence[np.ndarray], bars: bool) -> Composed:
        values = self._evaluated(jobs)
        found = self._coloured(values, np.array(eyes))
        errors = None
        if bars:
            each = [self._errors(job, eye, {name: x[k] for name, x in found.items()}) for k, (job, eye) in enumerate(zip(jobs, eyes))]
            errors = {name: np.array([one[name] for one in each]) for name in found}
        return Composed(self.wavelengths_nm, **found, errors=errors)

    def _eye(self, composition: Mapping[str, Any]) -> np.ndarray:
        name = (composition.get("illuminant", "D65"), composition.get("observer", "2"))
        if not self._eyes:
            lamps, observers = sorted(self._lights) or [name[0]], ["2", "10"]
            if name[0] not in lamps or name[1] not in observers:
                raise InputError(f"illuminant, observer: found {name[0]}, {name[1]}; allowed are {', '.join(lamps)} and {', '.join(observers)}")
            return np.full((self.wavelengths_nm.size, 6), np.nan)
        if name not in self._eyes:
            known = ", ".join("/".join(eye) for eye in self._eyes)
            raise InputError(f"illuminant, observer: found {name[0]}, {name[1]}; allowed are those of the library: {known}")
        eye = self._eyes[name]
        # under an instrument's light what is emitted is a part of factors like others
        return eye if composition.get("condition") is None else np.hstack([eye[:, :3], 0 * eye[:, 3:]])

    def _job(self, composition: Composition, number: int) -> _Job:
        layers = composition.get("layers") if isinstance(composition, Mapping) else None
        if layers is None or np.size(layers) == 0:
            raise InputError(f"composition {number}: found no layers; allowed is {{'layers': [{{'plate': NAME}}, …]}}")
        where = f"composition {number}: "
        _judge_keys(composition, ("layers", "paper", "dots", "illuminant", "observer", "condition"), where)
        if composition.get("condition") not in _CONDITIONS:
            raise InputError(f"{where}condition: found {composition['condition']!r}; allowed are M0, M1, M2, or none for the "
                             "illuminant's light: leave the key out for that")
        if isinstance(composition["layers"], (str, Mapping)):
            raise InputError(f"{where}layers: found no list; allowed is [{{'plate': NAME}}, …]: put a single layer in brackets")
        layers = tuple(self._layer(layer, f"{where}layers[{k}]") for k, layer in enumerate(composition["layers"]))
        paper = composition.get("paper", {})
        _judge_keys(paper, ("albedo", "contact", "fluorescence"), f"{where}paper.")
        contact = paper.get("contact", False)
        if not isinstance(contact, (bool, np.bool_)):
            raise InputError(f"{where}paper.contact: found {contact!r}; allowed are True and False: write them without quotation marks")
        albedo = self._albedo(paper.get("albedo", 0.9), self.wavelengths_nm, where)
        light = None
        if paper.get("fluorescence") is not None:
            kernel, absorbed = _fluorescence(paper["fluorescence"], self.wavelengths_nm[0], where)
            grid = self._summed_nm
            elastic = self._albedo(paper.get("albedo", 0.9), grid, where) * (1 - absorbed(grid))
            albedo = albedo * (1 - absorbed(self.wavelengths_nm))
            light = _Light(elastic, self._power(composition, where), _matrix(kernel, grid), self._seen(composition, where))
            if paper["fluorescence"].get("yield", 0.0) > 0 and absorbed(grid).any() and not light.matrix.any():
                raise InputError(f"{where}paper.fluorescence.emission: found a yield of {paper['fluorescence']['yield']}, and nothing emitted "
                                 f"from {self.wavelengths_nm[0]:g} to {self.wavelengths_nm[-1]:g} nm; allowed is emission at longer waves than "
                                 "the excitation, within the library's: correct the rows; yield = 0 only absorbs")
            self._judge_quanta(kernel, elastic, where)
        return _Job(layers, albedo, bool(contact), _printed(composition, where), light, _Change())

    def _albedo(self, given: Any, nm: np.ndarray, where: str) -> np.ndarray:
        try:
            albedo = np.array(given, float)
        except (TypeError, ValueError):
            raise InputError(f"{where}paper.albedo: found {given!r}; allowed is a number, or rows of nm and albedo: "
                             "numpy.loadtxt reads such rows") from None
        if albedo.ndim == 2:
            if albedo.shape[1] != 2 or not (np.diff(albedo[:, 0]) > 0).all():
                raise InputError(f"{where}paper.albedo: found {albedo.tolist()}; allowed are rows of nm and albedo, with rising nm: "
                                 "sort them")
            if not (albedo[0, 0] <= self.wavelengths_nm[0] and albedo[-1, 0] >= self.wavelengths_nm[-1]):
                raise InputError(f"{where}paper.albedo: found {albedo[0, 0]} to {albedo[-1, 0]} nm; extend the table")
            albedo = np.interp(nm, albedo[:, 0], albedo[:, 1])
        if albedo.ndim > 2 or albedo.ndim == 1 and albedo.size not in (1, nm.size):
            raise InputError(f"{where}paper.albedo: found {albedo.size} values; allowed is one, or rows of nm and albedo")
        if not ((albedo >= 0) & (albedo <= 1)).all():
            raise InputError(f"{where}paper.albedo: found {albedo}; allowed 0 to 1: divide percentages by 100")
        return np.array(np.broadcast_to(albedo, nm.shape))

    def _power(self, composition: Mapping[str, Any], where: str) -> np.ndarray:
        """Power of the light that excites, at the wavelengths of the sum."""
        condition = composition.get("condition")
        lamp = {**_CONDITIONS, None: composition.get("illuminant", "D65")}[condition]
        if lamp not in self._lights:
            known = ", ".join(self._lights) or "none: gather the library again"
            raise InputError(f"{where}found no power of {lamp}, which excites; allowed are those of the library: {known}")
        return np.where(self._summed_nm < _CUT_NM, 0.0, self._lights[lamp]) if condition == "M2" else self._lights[lamp]

    def _seen(self, composition: Mapping[str, Any], where: str) -> np.ndarray:
        """Power of the light with which emission is compared, at the library's wavelengths: of a lamp with lines that of all light about each."""
        means = self._means_of_lines.get(composition.get("illuminant", "D65")) if composition.get("condition") is None else None
        return np.interp(self.wavelengths_nm, self._summed_nm, self._power(composition, where)) if means is None else means

    def _judge_quanta(self, kernel: Any, elastic: np.ndarray, where: str) -> None:
        grid = self._summed_nm
        longer = np.arange(grid[-1] + _STEP_NM, _LONGEST_NM + 1e-9, _STEP_NM)
        all_nm = np.r_[grid, longer]
        quanta = (_matrix(kernel, all_nm) * all_nm[:, None] / all_nm).sum(0)[: grid.size] + elastic
        if quanta.max() > 1 + 1e-9:
            raise InputError(f"{where}paper.fluorescence: found {quanta.max():.3f} quanta reflected and emitted for each that comes in; "
                             "allowed at most 1: lower yield or excitation, or the albedo at the wavelengths that excite")

    def _layer(self, layer: Union[str, Mapping[str, Any]], where: str) -> Tuple[int, float]:
        layer = {"plate": layer} if isinstance(layer, str) else layer
        _judge_keys(layer, ("plate", "thickness_um", "coverage"), f"{where}.")
        if layer.get("plate") not in self._numbers:
            raise InputError(f"{where}.plate: found {layer.get('plate')!r}; allowed are {', '.join(self._numbers)}: "
                             "gather a library that has it")
        number = self._numbers[layer["plate"]]
        plate, um = self._plates[number], layer.get("thickness_um")
        own = plate["thickness_um"]
        if um is None:
            return number, 2.0 if plate["slabs"] else 1.0
        if not _is_number(um):
            raise InputError(f"{where}.thickness_um: found {um!r}; allowed is a number, µm: give it without its unit")
        if not plate["slabs"]:
            if abs(um - own) > 1e-6 * own:
                raise InputError(f"{where}.thickness_um: found {um} µm of {plate['name']!r}; allowed {own:.6g}, as which it was solved whole: "
                                 "take another plate of the ink, or solve it in slabs")
            return number, 1.0
        count = um / own
        count = float(round(count)) if abs(count - round(count)) < 1e-9 * count else count
        if not 2.0 <= count <= _MOST_SLABS:
            raise InputError(f"{where}.thickness_um: found {um} µm of {plate['name']!r}; allowed from {2 * own:.6g} µm, two slabs: "
                             "solve thinner slabs for thinner layers")
        return number, count

    # one layer as fluxes and as a film

    def _places_of(self, count: float, change: _Change) -> List[Tuple[str, float]]:
        count = 2.0 * count if change.halved else count
        if count <= 1.0:
            return [("whole", 1.0)]
        places = [("front", 1.0), ("inner", count - 2.0), ("back", 1.0)]
        return [place for place in places if place[1] > 0.0]

    def _part(self, number: int, position: str, change: _Change) -> Tuple[int, int]:
        """Number of a plate's portion, and of its states: 0 of the mean, then of those that leave out one cell each."""
        for k, portion in enumerate(self._portions[number]):
            if portion.position == position and portion.halved == change.halved:
                out = change.left_out
                return k, out[2] + 1 if out is not None and out[:2] == (number, k) else 0
        raise InputError(f"plate {self._plates[number]['name']!r}: lacks a portion; gather the library again")

    def _state(self, number: int, position: str, change: _Change) -> Tuple[_Portion, _States]:
        k, cell = self._part(number, position, change)
        portion = self._portions[number][k]
        return portion, portion.states[cell]

    def _own(self, number: int, change: _Change) -> _Change:
        """The change as far as it is one of this plate's."""
        out = change.left_out
        return change if out is None or out[0] == number else change._replace(left_out=None)

    def _layer_flux(self, number: int, count: float, change: _Change) -> _Flux:
        key = (number, count, self._own(number, change)._replace(fewer=False))
        if key not in self._layers:
            whole: Optional[_Flux] = None
            for position, times in self._places_of(count, change):
                portion, states = self._state(number, position, change)
                flux = states.flux.moved(portion.grid_error if change.grid else 0.0)
                flux = self._thinned(portion, flux, states.amplitudes) if change.thinned else flux
                if times != 1.0:
                    flux = flux.repeated(times, self._etendues(portion.between[:, 1], flux.ra.shape[-1]))
                whole = flux if whole is None else whole.then(flux)
            assert whole is not None
            self._layers[key] = whole
        return self._layers[key]

    def _thinned(self, portion: _Portion, flux: _Flux, amplitudes: np.ndarray) -> _Flux:
        """A portion whose scattered light lacks the highest moment that its directions resolve; what goes straight on stays."""
        p, many = self._polarisations, (flux.ra.shape[-1], flux.rb.shape[-1])
        ends = np.minimum(portion.between, self.joint_index)
        # where zones of the media end elsewhere, light of one is shared among the other's directions
        lost = (np.abs(ends[:, 0] - ends[:, 1]) > _SAME_INDEX)[:, None]
        powers = np.moveaxis(np.abs(amplitudes[:, :, 1:]) ** 2, -1, 2)
        powers = powers.reshape(*powers.shape[:3], -1)
        filters = [np.array([self._filter(index, many[side]) for index in portion.between[:, side]]) for side in (0, 1)]

        def of(m: np.ndarray, side: int, lobe: int) -> np.ndarray:
            states = np.arange(1, min(1 + powers.shape[-1], *m.shape[-2:]))
            straight = np.zeros_like(m)
            kept = np.where(lost & (lobe == 1) & (states > self._near * p), 0.0, powers[:, side, lobe, : states.size])
            straight[:, states, states] = np.minimum(kept, m[:, states, states])
            return np.asarray(straight + filters[side if lobe == 0 else 1 - side] @ (m - straight))

        return _Flux(of(flux.ra, 0, 0), of(flux.rb, 1, 0), of(flux.tab, 0, 1), of(flux.tba, 1, 1))

    def _filter(self, index: float, states: int) -> np.ndarray:
        """Fluxes of a medium's states without the highest moment of every zone of directions."""
        p, found, first = self._polarisations, np.eye(states), 1
        for count in self._directions[:1] + self._directions[1:] * (1 + int(self.joint_index < index - 1e-3)):
            zone = np.kron(_without_highest_moment(count), np.eye(p))
            found[first: first + count * p, first: first + count * p] = zone
            first += count * p
        return found

    def _etendues(self, indices: np.ndarray, states: int) -> np.ndarray:
        """Étendues of the states of media, (wavelength, state)."""
        p = self._polarisations
        rows = np.zeros((indices.size, states))
        for row, index in zip(rows, indices):
            nodes = np.repeat(_etendues(index, self.joint_index, self._directions), p)
            row[1: 1 + nodes.size] = nodes
        return rows

    def _layer_film(self, number: int, count: float, change: _Change, sines: np.ndarray, tag: Any,
                    faces: Tuple[bool, bool] = (False, False)) -> List[Tuple[_Film, _Film]]:
        """A layer with and without interference between its elements, per polarisation: arrays (wavelength, sine); with the face to
        air in front, behind."""
        key = (number, count, self._own(number, change)._replace(grid=False, thinned=False), tag, faces)
        if key not in self._films:
            found = []
            for p in range(self._polarisations):
                elements = self._elements(number, count, change, (p, tag), sines)
                films = [(once.repeated(times), once.repeated(times, 1)) for once, times in elements]
                if faces[0]:
                    front = _plane(1.0, self.joint_index, sines[None, :], p)
                    films.insert(0, (front, front.powers()))
                if faces[1]:
                    back = _plane(self.joint_index, 1.0, sines[None, :], p)
                    films.append((back, back.powers()))
                whole, powers = films[0]
                for film, own in films[1:]:
                    whole, powers = whole.then(film), powers.then(own)
                found.append((whole, powers))
            if len(self._films) >= _MOST_FILMS:
                self._films.clear()
            self._films[key] = found
        return self._films[key]

    def _elements(self, number: int, count: float, change: _Change, seen: Tuple[int, Any], sines: np.ndarray) -> List[Tuple[_Once, float]]:
        """The elements of a layer, and how many there are of each; `seen` is a polarisation and a name of the sines."""
        found = []
        for position, times in self._places_of(count, change):
            key = (number, self._part(number, position, change), change.fewer, seen)
            if key not in self._once:
                if len(self._once) >= _MOST_FILMS:
                    self._once.clear()
                portion, states = self._state(number, position, change)
                plate = self._plates[number]
                within = np.array(plate["within"])
                squared = within**2 + 1j * np.array(plate.get("loss", np.zeros_like(within)))
                self._once[key] = self._element(portion, states, squared, seen[0], change.fewer, sines)
            found.append((self._once[key], times))
        return found

    def _turns(self, number: int, count: float, change: _Change, p: int) -> List[Tuple[np.ndarray, np.ndarray]]:
        """Fringes over the hemisphere of every element, and what of the light passes it at 0° and comes back."""
        key = (number, count, self._own(number, change)._replace(grid=False, thinned=False), p)
        if key in self._fringes:
            return self._fringes[key]
        elements = self._elements(number, count, change, (p, "normal"), np.array([0.0]))
        within = np.array(self._plates[number]["within"])
        found = self._fringes[key] = []
        for (position, times), (once, _) in zip(self._places_of(count, change), elements):
            portion, _ = self._state(number, position, change)
            per_um = 2 * (within - np.sqrt(np.maximum(within**2 - 1.0, 0.0))) / (1e-3 * self.wavelengths_nm)
            found.append((per_um * portion.thickness_um * times, once.repeated(times, 1).t[:, 0]))
        return found

    def _trapped_slab(self, number: int, part: Tuple[int, int], p: int) -> "_TrappedSlab":
        """Of a part of a plate: the mean alone, or at once of all that leave out one cell each."""
        k, cell = part
        if (number, part, p) not in self._turned_back:
            portion, within = self._portions[number][k], np.array(self._plates[number]["within"])
            cells = [0] if cell == 0 else range(1, len(portion.states))
            slabs = _TrappedSlab(self, portion, [portion.states[c] for c in cells], within, p)
            self._turned_back.update(((number, (k, c), p), slabs.one(row)) for row, c in enumerate(cells))
        return self._turned_back[number, part, p]

    def _element(self, portion: _Portion, states: _States, squared: np.ndarray, p: int, fewer: bool, sines: np.ndarray) -> _Once:
        """`squared` is the permittivity of the even medium within, at every wavelength."""
        within = np.sqrt(squared.real)
        um, index = portion.thickness_um, within[:, None]
        k0 = 2 * np.pi / (1e-3 * self.wavelengths_nm[:, None])
        before, behind = portion.between[:, :1], portion.between[:, 1:]
        first, last = (mirrors[:, None] for mirrors in portion.mirrors(within))
        mirrors = first | last
        depth = 0.5 + 0.5 * (last & ~first) - 0.5 * (first & ~last)

        def phase(sine: np.ndarray, part: Any = 1.0) -> np.ndarray:
            return np.asarray(k0 * _normal(index, sine) * (um * part))

        def even(sine: np.ndarray, passed: Any, part: Any = 1.0) -> _Film:
            way = np.exp(1j * phase(sine, part) + passed)
            zero = np.zeros_like(way)
            through = _Film(zero, zero, way)
            if not mirrors.any():
                return through
            return _plane(before, index, sine, p).then(through).then(_plane(index, behind, sine, p)).where(mirrors, through)

        def depths(sine: np.ndarray, passed: np.ndarray, part: Any = 1.0) -> List[np.ndarray]:
            once = phase(sine, part).real + passed.imag
            return [np.exp(2j * side * once) for side in (depth, 1.0 - depth)]

        known = self._known[None, :]
        near = states.amplitudes[:, :, : self._known.size]
        onward, back = near[:, 0, :, p, 1], near[:, 1, :, p, 1]
        root = np.sqrt(onward * back)
        root = np.where((np.conj(root) * onward).real < 0, -root, root)
        ratio = root / even(known, 0.0).t
        passed = np.where(np.abs(ratio) > _FAINT, np.log(np.where(np.abs(ratio) > _FAINT, ratio, 1.0)), math.log(_FAINT) + 0j)
        for d in range(1, passed.shape[1]):
            turns = np.round((passed[:, d].imag - passed[:, d - 1].imag) / (2 * np.pi))
            passed[:, d] -= 2j * np.pi * turns
        film, phases = even(known, passed), depths(known, passed)
        beyond = [(near[:, side, :, p, 0] - (film.ra, film.rb)[side]) * np.conj(phases[side]) for side in (0, 1)]
        kept = [d for d in range(known.size) if not (fewer and d == known.size // 2)]
        weights = _lagrange(self._places[kept], np.sqrt(np.maximum(1.0 - sines * sines, 0.0))).T
        here = passed[:, kept] @ weights
        here = np.minimum(here.real, passed[:, kept].real.max(1, keepdims=True)) + 1j * here.imag
        sine = sines[None, :]
        way = 1j * phase(sine) + here
        # from the half-spaces of the solves to the medium itself, which may absorb
        step = _plane(index, np.sqrt(squared[:, None]), sine, p).where(squared.imag[:, None] != 0, _plane(index, index, sine, p))
        through = np.exp(way)
        mirrored = np.abs(_even_slab(step.ra, through)) ** 2
        as_solved = _Film(mirrored, mirrored, np.abs(through) ** 2)
        way = way + np.log(_own_passage(step.ra, through))
        if not mirrors.any():
            return _Once(way, mirrors, solved=as_solved)
        further = [more[:, kept] @ weights for more in beyond]

        def slab(part: Any) -> _Film:
            passed = part * here
            film, phases = even(sine, passed, part), depths(sine, passed, part)
            ra, rb = (r + part * more * by for r, more, by in zip((film.ra, film.rb), further, phases))
            return _Film(ra, rb, even(sine, 0.0, part).t * np.exp(passed))

        one = slab(1.0)
        own = one.then(step).where(first & ~last, one)
        own = _Film(step.rb, step.ra, step.t).then(one).where(last & ~first, own)
        return _Once(way, mirrors, own, slab, one.powers().where(mirrors, as_solved))

    # many stacks

    def _evaluated(self, jobs: Sequence[_Job]) -> Dict[str, np.ndarray]:
        """Spectra (job, wavelength) of all jobs; equal stacks are composed once."""
        numbers: Dict[_Stack, int] = {}

        def number(layers: Tuple[Tuple[int, float], ...], job: _Job) -> int:
            out = job.change.left_out
            change = job.change if out is None or any(plate == out[0] for plate, _ in layers) else job.change._replace(left_out=None)
            return numbers.setdefault(_Stack(layers, job.contact, change), len(numbers))

        solid = np.array([number(job.layers, job) for job in jobs])
        kinds = [[number(tuple(job.layers[k] for k in kind), job) if kind else -1 for kind in job.printed.kinds]
                 if job.printed else [] for job in jobs]
        optics = self._optics(list(numbers))
        return _on_paper(self, jobs, {name: x[solid] for name, x in optics.items()}, (optics, kinds))

    def _optics(self, stacks: Sequence[_Stack]) -> Dict[str, np.ndarray]:
        """What stacks are to light (stack, wavelength), whatever the paper; those of as many layers and fringes together."""
        out: Dict[str, np.ndarray] = {}
        groups: Dict[Any, List[int]] = {}
        for k, stack in enumerate(stacks):
            fringes = np.stack([self._fringes_of(stack, turned) for turned in (False, True)])
            most = fringes[fringes <= _MOST_FRINGES].max(initial=0.0)
            pieces = _PIECES + 8 + 4 * int(np.ceil(most / 2))
            all_interfere = bool((fringes <= _MOST_FRINGES).all())
            groups.setdefault((len(stack.layers), stack.contact, stack.change.fewer, pieces, all_interfere), []).append(k)
        for (_, _, _, pieces, _), places in groups.items():
            for start in range(0, len(places), _AT_ONCE):
                some = places[start: start + _AT_ONCE]
                for name, values in _Optics(self, [stacks[k] for k in some], pieces).found().items():
                    out.setdefault(name, np.empty((len(stacks), self.wavelengths_nm.size)))[some] = values
        return out

    def _fringes_of(self, stack: _Stack, turned: bool) -> np.ndarray:
        """Fringes over the hemisphere at every wavelength, as many as light goes through and back; the largest of polarisations."""
        most = np.zeros(self.wavelengths_nm.size)
        face = 1.0 - ((1.0 - self.joint_index) / (1.0 + self.joint_index)) ** 2
        for pol in range(self._polarisations):
            elements = [turn for number, count in stack.layers for turn in self._turns(number, count, stack.change, pol)]
            seen = np.ones(most.size) * (1.0 if turned and stack.contact else face)
            fringes = np.zeros(most.size)
            for turns, passed in reversed(elements) if turned else elements:
                fringes += np.where(seen >= _FAINT, turns, 0.0)
                seen = seen * passed
            most = np.maximum(most, fringes)
        return most

    def _flux_of(self, stacks: Sequence[_Stack]) -> _Flux:
        """Fluxes of all stacks: arrays (stack, wavelength, to, from)."""
        count = len(stacks[0].layers)
        whole: Optional[_Flux] = None
        for place in range(count):
            faces = (place == 0, place == count - 1 and not stacks[0].contact)
            all_ = [self._faced_flux(*stack.layers[place], stack.change, faces) for stack in stacks]
            part = _Flux(*(np.array(x) for x in zip(*all_)))
            whole = part if whole is None else whole.then(part)
        assert whole is not None
        return whole

    def _faced_flux(self, number: int, count: float, change: _Change, faces: Tuple[bool, bool]) -> _Flux:
        """A layer with the face to air in front, behind."""
        if not any(faces):
            return self._layer_flux(number, count, change)
        key = (number, count, self._own(number, change)._replace(fewer=False), faces)
        if key not in self._layers:
            flux = self._layer_flux(number, count, change)
            flux = self._face(oblique=True).then(flux) if faces[0] else flux
            self._layers[key] = flux.then(self._face(oblique=False).turned()) if faces[1] else flux
        return self._layers[key]

    def _face(self, oblique: bool) -> _Flux:
        """The plane face between air and the joint's medium."""
        p, near, index = self._polarisations, self._near, self.joint_index
        n = 1 + p * self._sines.size
        air = 1 + p * (near + int(oblique))
        ra, rb = np.zeros((air, air)), np.eye(n)
        tab, tba = np.zeros((n, air)), np.zeros((air, n))

        def mirrored(sine: float, pol: int) -> float:
            a, b = (math.sqrt(max(m * m - sine * sine, 0.0)) / (1.0 if pol == 0 else m * m) for m in (1.0, index))
            return ((a - b) / (a + b)) ** 2

        for d, sine in enumerate(self._known):
            for pol in range(1 if d == 0 else p):
                state, m = (0 if d == 0 else 1 + (d - 1) * p + pol), mirrored(sine, pol)
                ra[state, state] = rb[state, state] = m
                tab[state, state] = tba[state, state] = 1.0 - m
        if oblique:
            shares = _lagrange(self._places[1:], np.array([math.sqrt(1.0 - _PRINT_SINE**2)]))[0]
            for pol in range(p):
                m, column = mirrored(_PRINT_SINE, pol), 1 + near * p + pol
                for node, share in enumerate(shares):
                    ra[1 + node * p + pol, column] += share * m
                    tab[1 + node * p + pol, column] += share * (1.0 - m)
        return _Flux(ra, rb, tab, tba)

    def _coloured(self, values: Dict[str, np.ndarray], eyes: np.ndarray) -> Dict[str, np.ndarray]:
        """Spectra with their colours; eyes are (job, wavelength, weights of factors and more of them for what is emitted)."""
        weights, further = eyes[..., :3], eyes[..., 3:]
        white = weights.sum(1)

        def xyz(name: str) -> np.ndarray:
            whole = np.einsum("jw,jwc->jc", values[name], weights)
            return np.asarray(whole + np.einsum("jw,jwc->jc", values[_EMITTED + name], further) if _EMITTED + name in values else whole)

        found = {name: x for name, x in values.items() if not name.startswith(_EMITTED)}
        found["lab_natural_light"] = lab(xyz("natural_light"), white)
        found["lab_lit_at_45"] = lab(xyz("lit_at_45"), white)
        found["contrast_ratio"] = xyz("over_black")[:, 1] / xyz("over_white")[:, 1]
        found["lab"] = lab(xyz("factors"), white)
        return found

    def _errors(self, job: _Job, eye: np.ndarray, base: Mapping[str, np.ndarray]) -> Dict[str, np.ndarray]:
        plates = sorted({number for number, _ in job.layers})
        changes = [_Change(halved=True), _Change(grid=True), _Change(fewer=True), _Change(thinned=True)]
        cells = {halved: [(number, k, portion.cells) for number in plates for k, portion in enumerate(self._portions[number])
                          if portion.halved == halved] for halved in (False, True)}
        for halved, portions in cells.items():
            changes += [_Change(left_out=(number, k, r), halved=halved) for number, k, count in portions if count > 1 for r in range(count)]
        jobs = [replace(job, change=change) for change in changes]
        many = self._coloured(self._evaluated(jobs), np.broadcast_to(eye, (len(jobs), *eye.shape)))
        known = all(count > 1 for portions in cells.values() for _, _, count in portions)
        errors = {}
        for name, value in base.items():
            all_, at, variance = many[name], 4, []
            for portions in cells.values():
                total = np.zeros_like(value)
                for _, _, count in portions:
                    if count > 1:
                        some = all_[at: at + count]
                        total = total + (count - 1) / count * ((some - some.mean(0)) ** 2).sum(0)
                        at += count
                variance.append(total)
            chance = variance[0]
            beyond = (all_[0] - value) ** 2 - (variance[0] + variance[1] if known else 0.0)
            directions = (all_[2] - value) ** 2 + ((all_[3] - value) / _THINNED) ** 2
            if name in _SPECTRA and name != "factors":
                beyond, near = (np.array([x[max(w - 2, 0): w + 3].mean() for w in range(x.size)]) for x in (beyond, directions))
                # at single wavelengths fringes change nothing by accident
                directions = np.maximum(directions, near)
            model = np.maximum(beyond, 0.0) / 4.0
            errors[name] = np.sqrt(chance + model + (all_[1] - value) ** 2 + directions)
        return errors


def _going_on(squared: np.ndarray, sine: np.ndarray) -> np.ndarray:
    """n cos θ in media of these squared indices: going on, or decaying."""
    root = np.sqrt(np.asarray(squared - sine * sine, complex))
    return np.asarray(np.where((root.imag < 0) & (root.real < -root.imag), -root, root))


def _face_between(before: Any, behind: Any, sine: np.ndarray, p: int) -> _Film:
    """A plane face between media of these squared indices."""
    a, b = (_going_on(n, sine) / (1.0 if p == 0 else n) for n in (before, behind))
    r = (a - b) / (a + b)
    return _Film(r, -r, np.sqrt(1 - r * r))


def _log(x: np.ndarray) -> np.ndarray:
    there = np.abs(x) > _FAINT
    return np.where(there, np.log(np.where(there, x, 1.0)), math.log(_FAINT) + 0j)


class _Lit(NamedTuple):
    """Sines in a zone beyond the critical angle of air by a name of theirs, and weights (sine, direction) of the directions kept there."""

    tag: Any
    kept: Tuple[int, ...]
    weights: np.ndarray


class _TrappedSlab:
    """A portion as light from the paper meets it beyond the critical angle of air, turned over: the even film of a complex index that
    has its phase and its loss in every direction, and what is left over (wavelength, direction). At first of many means together, which
    leave out other cells."""

    def __init__(self, library: Library, portion: _Portion, states: Sequence[_States], within: np.ndarray, p: int):
        self.p, self.um = p, portion.thickness_um
        self.k0 = 2 * np.pi / (1e-3 * library.wavelengths_nm[:, None])
        self.squared_index = (within**2)[:, None]
        self.before, self.behind = portion.between[:, 1:] ** 2, portion.between[:, :1] ** 2
        behind, front = (mirrors[:, None] for mirrors in portion.mirrors(within))
        self.faces, self.mirrors = (front, behind), front | behind
        self.depth = 0.5 + 0.5 * (behind & ~front) - 0.5 * (front & ~behind)
        self.both = np.ones_like(front), np.ones_like(front)
        self._seen: Dict[Any, _Once] = {}
        self.least = np.minimum(portion.between.min(1), within)[:, None]
        self.goes_on = self.least[:, 0] > library.joint_index - _NARROWEST
        own = np.stack([one.amplitudes[..., p, :] for one in states])
        onward = own[..., 1, :, 1]
        root = np.sqrt(onward * own[..., 0, :, 1])
        measured = np.where((np.conj(root) * onward).real < 0, -root, root)
        sines, near = np.r_[0.0, library._sines], library._near
        turned = np.zeros(measured.shape[:-1])
        known = []
        with np.errstate(all="ignore"):
            for d, sine in enumerate(sines):
                if d <= near:
                    turned = self._logarithm(measured[..., d], 0.0, sine, turned).imag
                    continue
                squared, further, turned = self._even_of(measured[..., d], sine, turned)
                at = np.array([sine])
                film, phases = self.film(squared[..., None], at, self.both), self._depths(squared[..., None], at)
                differences = [(own[..., 1 - side, d, 0] - r[..., 0]) * np.conj(phases[side][..., 0]) for side, r in enumerate((film.ra, film.rb))]
                known.append(np.array([squared, further, *differences]))
        # (what, mean, wavelength, direction)
        self.known = np.stack(known, -1)
        # powers of the mean wave as it was solved, from the paper's side (mean, wavelength, direction)
        near_ones = slice(near + 1, sines.size)
        powers = _Film(*(np.abs(x[..., near_ones]) ** 2 for x in (own[..., 1, :, 0], own[..., 0, :, 0], measured)))
        with np.errstate(all="ignore"):
            self.solved = self._steps_alone(powers, self.film(self.known[0], sines[near_ones], self.both).powers())
        if not self.goes_on.all():
            self._carry_on(measured[..., 0], sines[near_ones])

    def _steps_alone(self, solved: _Film, even: _Film) -> _Film:
        """Of slabs whose medium goes on, the steps to the half-spaces of their solves, without what noise of few realisations mirrors."""
        return solved.where(self.mirrors, _Film(np.minimum(solved.ra, even.ra), np.minimum(solved.rb, even.rb), solved.t))

    def _carry_on(self, measured: np.ndarray, sines: np.ndarray) -> None:
        """Where light decays in it, the slab is an even film of the index that it has at 0°."""
        with np.errstate(all="ignore"):
            squared = self._even_of(measured, 0.0, np.zeros(measured.shape))[0]
            even = self.film(squared[..., None], sines, self.both).powers()
        in_front, behind = self.before > sines**2, self.behind > sines**2
        turned_back = _Film(np.where(in_front, np.minimum(even.ra, 1.0), 1.0), 0 * even.ra + 1.0, 0 * even.ra)
        even = self._steps_alone(even.where(in_front & behind, turned_back), even)
        here = self.goes_on[:, None]
        self.known = np.where(here, self.known, np.array([squared, *np.zeros((3, *squared.shape))])[..., None])
        self.solved = self.solved.where(here, even)

    def one(self, row: int) -> "_TrappedSlab":
        """One of the means."""
        slab = copy.copy(self)
        slab.known, slab.solved, slab._seen = self.known[:, row], _Film(*(x[row] for x in self.solved)), {}
        return slab

    def phase(self, further: Any, sine: np.ndarray, part: Any = 1.0) -> np.ndarray:
        """i k_z d of one way, or of a part of it."""
        return np.asarray(1j * self.k0 * _going_on(self.squared_index + further, sine) * (self.um * part))

    def film(self, further: Any, sine: np.ndarray, faces: Tuple[np.ndarray, np.ndarray], part: Any = 1.0) -> _Film:
        """The even film with or without its faces to the half-spaces, or a part of its thickness."""
        squared = self.squared_index + further
        way = np.exp(self.phase(further, sine, part))
        film = _Film(np.zeros_like(way), np.zeros_like(way), way)
        if faces[0].any():
            film = _face_between(self.before, squared, sine, self.p).then(film).where(faces[0], film)
        if faces[1].any():
            film = film.then(_face_between(squared, self.behind, sine, self.p)).where(faces[1], film)
        return film

    def _depths(self, further: Any, sine: np.ndarray, part: Any = 1.0) -> List[np.ndarray]:
        once = self.phase(further, sine, part).imag
        return [np.exp(2j * side * once) for side in (self.depth, 1.0 - self.depth)]

    def _logarithm(self, measured: np.ndarray, further: Any, sine: float, near: np.ndarray) -> np.ndarray:
        at = np.array([sine])
        further = np.asarray(further)[..., None] if np.ndim(further) else further
        faces = self.film(further, at, self.both).t / np.exp(self.phase(further, at))
        log = _log(measured / (faces * np.exp(self.phase(0.0, at)))[..., 0])
        return np.asarray(log - 2j * np.pi * np.round((log.imag - near) / (2 * np.pi)))

    def _even_of(self, measured: np.ndarray, sine: float, near: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        at = np.array([sine])
        plain = self.phase(0.0, at)[:, 0]
        first = log = self._logarithm(measured, 0.0, sine, near)
        squared = np.zeros(measured.shape, complex)
        sound = np.ones(measured.shape, bool)
        for _ in range(_ROUNDS):
            going = (plain + log) / (1j * self.k0[:, 0] * self.um)
            squared = np.where(sound, going * going + sine * sine - self.squared_index[:, 0], squared)
            sound &= np.isfinite(squared) & (np.abs(squared) < _FURTHEST)
            squared = np.where(sound, squared, 0.0)
            log = np.where(sound, self._logarithm(measured, squared, sine, log.imag), first)
        left = _log(measured / self.film(squared[..., None], at, self.both).t[..., 0])
        sound &= np.abs(left) < 0.1 * np.abs(first) + _FAINT
        return np.where(sound, squared, 0.0), np.where(sound, left, first), np.where(sound, log.imag, first.imag)

    def at(self, sine: np.ndarray, lit: _Lit) -> _Once:
        """One of them at sines."""
        if lit.tag not in self._seen:
            if len(self._seen) >= _MOST_FILMS:
                self._seen.clear()
            self._seen[lit.tag] = self._found(sine, lit)
        return self._seen[lit.tag]

    def _found(self, sine: np.ndarray, lit: _Lit) -> _Once:
        kept, weights = list(lit.kept), lit.weights
        own = self.known[..., kept]
        squared, further, first, second = own @ weights.T
        least = np.maximum(own[0].imag.min(1, keepdims=True), 0.0)
        squared = squared.real + 1j * np.maximum(squared.imag, least)
        further = np.minimum(further.real, own[1].real.max(1, keepdims=True)) + 1j * further.imag
        sine = sine[None, :]
        way = self.phase(squared, sine) + further
        if not self.mirrors.any():
            return _Once(way, self.mirrors)

        def slab(part: Any) -> _Film:
            film, phases = self.film(squared, sine, self.faces, part), self._depths(squared, sine, part)
            ra, rb = (r + part * more * by for r, more, by in zip((film.ra, film.rb), (first, second), phases))
            return _Film(ra, rb, film.t * np.exp(part * further))

        return _Once(way, self.mirrors, slab(1.0), slab)

    def solved_powers(self, times: Any) -> _Film:
        """Powers of this number of them, or of several, in the known directions, as they were solved."""
        return self.solved.powers_repeated(times)


class _TrappedStacks:
    """Light from a paper in contact beyond the critical angle of air, in stacks of as many layers: it goes through, is turned back at the
    air, and interferes with itself. Arrays are over stacks, wavelengths and sines."""

    def __init__(self, library: Library, stacks: Sequence[_Stack], p: int):
        self.library, self.stacks, self.p, self.joint = library, stacks, p, library.joint_index
        self.sines = library._sines[library._near:]
        self.places = self._place(self.sines)
        fewer = stacks[0].change.fewer and self.sines.size > 1
        self.kept = tuple(d for d in range(self.sines.size) if not (fewer and d == self.sines.size // 2))
        self.alike = [self._alike(place) for place in range(len(stacks[0].layers))]
        self.shape = len(stacks), library.wavelengths_nm.size
        # where light of a known direction decays in a layer (stack, wavelength, direction)
        self.decays = np.zeros((*self.shape, self.sines.size), bool)
        for groups in self.alike:
            for some, slabs in groups:
                self.decays[some] |= np.any([slab.least <= self.sines[None, :] for slab, _ in slabs], axis=0)

    def _place(self, sine: np.ndarray) -> np.ndarray:
        return np.asarray(np.sqrt(np.maximum(self.joint**2 - sine * sine, 0.0)))

    def _lit(self, sine: np.ndarray, tag: Any) -> _Lit:
        return _Lit((tag, self.kept), self.kept, _lagrange(self.places[list(self.kept)], self._place(sine)))

    def _alike(self, place: int) -> List[Tuple[np.ndarray, List[Tuple[_TrappedSlab, np.ndarray]]]]:
        """The layers at one place by the slabs that they are made of: numbers of the stacks, and from the air on their slabs with how
        many there are of each (stack, 1, 1)."""
        groups: Dict[Any, List[Tuple[int, List[float]]]] = {}
        for k, stack in enumerate(self.stacks):
            number, count = stack.layers[place]
            positions, times = zip(*self.library._places_of(count, stack.change))
            parts = tuple(self.library._part(number, position, stack.change) for position in positions)
            groups.setdefault((number, parts), []).append((k, times))
        found = []
        for (number, parts), members in groups.items():
            times = np.array([own for _, own in members])[..., None, None]
            slabs = [(self.library._trapped_slab(number, part, self.p), times[:, k]) for k, part in enumerate(parts)]
            found.append((np.array([k for k, _ in members]), slabs))
        return found

    def _turned_back(self, some: np.ndarray, face: np.ndarray, kind: int, film_of: Any) -> np.ndarray:
        """What comes back to the paper in some of the stacks, of waves (kind 0) or powers (1): from the air on every slab is put before
        what lies behind it; `film_of` a slab and numbers of it are its amplitudes or powers."""
        row = np.full(len(self.stacks), -1)
        row[some] = np.arange(some.size)
        back = np.array(np.broadcast_to(face, (some.size, self.shape[1], face.shape[-1])))
        for groups in self.alike:
            for members, slabs in groups:
                here = row[members] >= 0
                if not here.any():
                    continue
                rows = row[members[here]]
                own = back[rows]
                for slab, times in slabs:
                    film = film_of(slab, 1.0 if (times == 1.0).all() else times[here])
                    least = 1 - film.rb * own
                    own = film.ra + film.t**2 * own / (np.maximum(least, _FAINT) if kind else least)
                back[rows] = own
        return back

    def _field(self, some: np.ndarray, sine: np.ndarray, kind: int, lit: _Lit) -> np.ndarray:
        """R of the mean field of some of the stacks, with interference (kind 0) or without it (1)."""
        face = _face_between(self.joint**2, 1.0, sine[None, :], self.p)

        def film_of(slab: _TrappedSlab, times: Any) -> _Film:
            film = slab.at(sine, lit).repeated(times)
            if not kind:
                return film
            powers = film.powers()
            return powers.where(slab.least > sine[None, :], _Film(0 * powers.ra + 1.0, 0 * powers.ra + 1.0, 0 * powers.ra))

        r = self._turned_back(some, (face.powers() if kind else face).ra, kind, film_of)
        r = r if kind else np.abs(r) ** 2
        return np.minimum(np.where(np.isfinite(r), r, 1.0), 1.0)

    def _solved(self) -> np.ndarray:
        """R of the mean field without interference between the slabs, as they were solved (stack, wavelength, direction)."""
        face = _face_between(self.joint**2, 1.0, self.sines[None, :], self.p).powers()
        every = np.arange(len(self.stacks))
        return np.minimum(self._turned_back(every, face.ra, 1, _TrappedSlab.solved_powers), 1.0)

    def _fringes(self) -> Tuple[np.ndarray, np.ndarray]:
        """Fringes over the zone, and what of the light comes to the air (stack, wavelength)."""
        edge = np.array([1.0])
        lit = self._lit(edge, "edge")
        fringes, seen = np.zeros(self.shape), np.ones(self.shape)
        for groups in self.alike:
            for some, slabs in groups:
                for slab, times in slabs:
                    phases = [_going_on(slab.squared_index[:, 0], np.array(sine)).real for sine in (1.0, self.joint)]
                    fringes[some] += times[..., 0] * 2 * (phases[0] - phases[1]) * slab.um * slab.k0[:, 0] / (2 * np.pi)
                    passed = np.abs(slab.at(edge, lit).repeated(times).t[..., 0]) ** 2
                    seen[some] *= np.where(slab.goes_on, passed, 1.0)
        return fringes, seen

    def change(self, columns: Tuple[np.ndarray, np.ndarray]) -> Tuple[np.ndarray, np.ndarray]:
        """What interference changes of R and T of this light as ∫ 2s ds; columns are R and T as composed (stack, wavelength, direction)."""
        with np.errstate(all="ignore"):
            return self._change(columns)

    def _change(self, columns: Tuple[np.ndarray, np.ndarray]) -> Tuple[np.ndarray, np.ndarray]:
        r, t = columns
        field = self._solved()
        lost = 1 - field
        safe = np.where(lost < _NOTHING, 1.0, lost)
        together = np.maximum((r + t - field) / safe, 0.0)
        back = np.minimum(np.maximum((r - field) / safe, 0.0), together)
        shares = [np.where(lost < _NOTHING, x, y) for x, y in ((r, back), (t, together - back))]
        # where composing lets no light come to what scatters it, nothing of it comes back
        shares = [np.where(self.decays & (lost < _LITTLE), 0.0, x)[..., list(self.kept)] for x in shares]
        fringes, seen = self._fringes()
        interferes = (seen >= _FAINT) & (fringes <= _MOST_FRINGES)
        begun = np.where(interferes, np.maximum(np.ceil(fringes / _FRINGES_OF_A_PIECE), 1.0), 1.0)
        width = math.sqrt(self.joint**2 - 1.0)
        rules = [np.polynomial.legendre.leggauss(count) for count in _NODES]
        nodes = np.concatenate([0.5 * (1 + x) for x, _ in rules])
        weights = [0.5 * w for _, w in rules]
        total = np.zeros((2, *self.shape))
        # pieces of the zone with the stacks and wavelengths that they are of, as the program halves them
        pieces = [(k / n, 1.0 / n, begun == n) for n in np.unique(begun) for k in range(int(n))]
        count = begun.copy()
        while pieces:
            start, size, of = pieces.pop(0)
            some = np.flatnonzero(of.any(1))
            angle = 0.5 * np.pi * (start + size * nodes)
            place = width * np.cos(angle)
            sine = np.sqrt(np.maximum(self.joint**2 - place * place, 0.0))
            lit, coherent = self._lit(sine, (start, size)), interferes[some]
            kinds = [kind for kind, any_ in enumerate(((of[some] & coherent).any(), (of[some] & ~coherent).any())) if any_]
            fields = [self._field(some, sine, kind, lit) for kind in kinds]
            mean = np.where(coherent[..., None], fields[0], fields[-1])
            by = lit.weights.T
            reflected = np.clip(shares[0][some] @ by, 0.0, 1.0)
            transmitted = np.minimum(np.maximum(shares[1][some] @ by, 0.0), 1.0 - reflected)
            found = 0.5 * np.pi * width * width * np.sin(2 * angle) * np.array([mean + (1 - mean) * reflected, (1 - mean) * transmitted])
            sums, check = size * found[..., : _NODES[0]] @ weights[0], size * found[..., _NODES[0]:] @ weights[1]
            halved = np.zeros_like(of)
            halved[some] = of[some] & (np.abs(sums - check).max(0) > _MEAN_ERROR) & (count[some] < begun[some] + _MOST_HALVINGS)
            total[:, some] += np.where((of & ~halved)[some], sums, 0.0)
            count += halved
            if halved.any():
                pieces += [(start, 0.5 * size, halved), (start + 0.5 * size, 0.5 * size, halved)]
        own = self.library._weights[self.library._near:]
        changes = [x - y @ own for x, y in zip(total, (r, t))]
        return changes[0], changes[1]


class _Optics:
    """What stacks of as many layers are to light: their fluxes, and what interference changes of them."""

    def __init__(self, library: Library, stacks: Sequence[_Stack], pieces: int):
        self.library, self.stacks = library, stacks
        self.fewer, self.contact = stacks[0].change.fewer, stacks[0].contact
        self.index = library.joint_index if self.contact else 1.0
        self.near, self.pieces = library._near, pieces
        self.plate = library._flux_of(stacks)
        places = library._places
        self.kept = [d for d in range(places.size) if not (self.fewer and d == places.size // 2)]
        # of both sides, per polarisation: with interference and without it at 0°, the nodes and 45°
        self.sines = np.r_[library._known, _PRINT_SINE]
        self.between = self._fields(self.sines, "known", self.fewer)
        self.exact = self._fields(self.sines, "known", False) if self.fewer else self.between
        p = library._polarisations
        self.shares = [[self._shares(side, pol) for pol in range(p)] for side in (0, 1)]
        self.over_hemisphere = self._hemisphere()

    def _chain(self, stacks: Sequence[_Stack], pol: int, sines: np.ndarray, tag: Any, fewer: bool, kind: int) -> _Film:
        """Amplitudes (kind 0) or powers (kind 1) of stacks: arrays (stack, wavelength, sine)."""
        library, count = self.library, len(stacks[0].layers)
        whole: Optional[_Film] = None
        for place in range(count):
            faces = (place == 0, place == count - 1 and not self.contact)
            films = [library._layer_film(*stack.layers[place], stack.change._replace(fewer=fewer), sines, tag, faces)[pol][kind]
                     for stack in stacks]
            part = _Film(*(np.array(x) for x in zip(*films)))
            whole = part if whole is None else whole.then(part)
        assert whole is not None
        return whole

    def _fields(self, sines: np.ndarray, tag: Any, fewer: bool) -> List[Tuple[_Film, _Film]]:
        """Per polarisation powers with interference and without it."""
        return [(self._chain(self.stacks, pol, sines, tag, fewer, 0).powers(), self._chain(self.stacks, pol, sines, tag, fewer, 1))
                for pol in range(self.library._polarisations)]

    def _hemisphere(self) -> List[List[Tuple[np.ndarray, np.ndarray]]]:
        """R and T of diffuse light with interference, per side and polarisation (stack, wavelength)."""
        library = self.library
        x, weight = np.polynomial.legendre.leggauss(_PIECE)
        place = ((np.arange(self.pieces)[:, None] + 0.5 * (1 + x)) / self.pieces).ravel()
        quadrature = 2 * place * np.tile(0.5 * weight, self.pieces) / self.pieces
        sines = np.sqrt(np.maximum(1 - place * place, 0.0))
        of_loss = quadrature[:, None] * _lagrange(library._places[self.kept], place)
        size = max(1, _WITHIN_CACHE // (library.wavelengths_nm.size * sines.size))
        found = []
        for side in (0, 1):
            fringes = np.stack([library._fringes_of(stack, side == 1) for stack in self.stacks])
            found.append((fringes <= _MOST_FRINGES)[..., None])
        out: List[List[List[Tuple[np.ndarray, np.ndarray]]]] = [[[] for _ in range(library._polarisations)] for _ in (0, 1)]
        for start in range(0, len(self.stacks), size):
            some = slice(start, start + size)
            for pol in range(library._polarisations):
                films = self._chain(self.stacks[some], pol, sines, self.pieces, self.fewer, 0).powers()
                powers = None if all(x[some].all() for x in found) else self._chain(
                    self.stacks[some], pol, sines, self.pieces, self.fewer, 1)
                for side in (0, 1):
                    r, t = _passive(films, side)
                    if powers is not None:
                        r, t = (np.where(found[side][some], a, b) for a, b in zip((r, t), _passive(powers, side)))
                    lost = (1 - r - t) @ of_loss
                    shares = [x[some][..., self.kept] for x in self.shares[side][pol]]
                    out[side][pol].append(tuple(x @ quadrature + (share * lost).sum(-1) for x, share in zip((r, t), shares)))
        return [[(np.concatenate([r for r, _ in of_pol]), np.concatenate([t for _, t in of_pol])) for of_pol in of_side] for of_side in out]

    def _lobes(self, fields: List[Tuple[_Film, _Film]], side: int, pol: int, kind: int) -> Tuple[np.ndarray, np.ndarray]:
        return _passive(fields[pol][kind], side)

    def _states(self, pol: int) -> List[int]:
        return [0] + [1 + node * self.library._polarisations + pol for node in range(self.near)]

    def _shares(self, side: int, pol: int) -> Tuple[np.ndarray, np.ndarray]:
        """Shares of the loss that go back and on, at 0° and the nodes."""
        n = self.near + 1
        field_r, field_t = (x[..., :n] for x in self._lobes(self.exact, side, pol, 1))
        r, t = (x.sum(-2)[..., self._states(pol)] for x in self._matrices(side))
        lost = 1 - field_r - field_t
        safe = np.where(lost < _NOTHING, 1.0, lost)
        together = np.maximum((r + t - field_r - field_t) / safe, 0.0)
        mirrored = np.minimum(np.maximum((r - field_r) / safe, 0.0), together)
        return np.where(lost < _NOTHING, r, mirrored), np.where(lost < _NOTHING, t, together - mirrored)

    def _matrices(self, side: int) -> Tuple[np.ndarray, np.ndarray]:
        return (self.plate.rb, self.plate.tba) if side else (self.plate.ra, self.plate.tab)

    def _shares_at(self, side: int, pol: int, k: int) -> List[np.ndarray]:
        """The same at one of the sines."""
        place = np.sqrt(1 - self.sines[k: k + 1] ** 2)
        weights = _lagrange(self.library._places[self.kept], place)[0]
        return [x[..., self.kept] @ weights for x in self.shares[side][pol]]

    def _of_diffuse(self, side: int, pol: int) -> Tuple[np.ndarray, np.ndarray]:
        """What interference changes of diffuse light."""
        n, weights = self.near + 1, self.library._weights[: self.near]
        without = tuple(x[..., :n] for x in self._lobes(self.exact, side, pol, 1))
        known = _with_loss(without, self.shares[side][pol])
        density = self.index**2 if side else 1.0
        beyond = self._of_trapped(pol) if side else (0.0, 0.0)
        return tuple((x - (k[..., 1:] * weights).sum(-1) + y) / density
                     for x, k, y in zip(self.over_hemisphere[side][pol], known, beyond))

    def _of_trapped(self, pol: int) -> Tuple[Any, Any]:
        """What interference changes of light from a paper in contact beyond the critical angle of air (stack, wavelength)."""
        library = self.library
        nodes = range(self.near, library._sines.size)
        if not self.contact or not len(nodes) or library._kept_directions < 1 + library._sines.size:
            return 0.0, 0.0
        states = [1 + node * library._polarisations + pol for node in nodes]
        r, t = (x.sum(-2)[..., states] for x in self._matrices(1))
        return _TrappedStacks(library, self.stacks, pol).change((r, t))

    def _at(self, pol: int, k: int, kind: int) -> List[np.ndarray]:
        """R and T at one of the sines, with the loss shared."""
        lobes = [x[..., k] for x in self._lobes(self.between, 0, pol, kind)]
        return list(_with_loss(lobes, self._shares_at(0, pol, k)))

    def found(self) -> Dict[str, np.ndarray]:
        """All that the series of a paper takes (stack, wavelength)."""
        library, plate, near = self.library, self.plate, self.near
        p, shares, lit = library._polarisations, library._shares, self.near + 1
        onto_sums, through_sums = plate.ra.sum(-2), plate.tab.sum(-2)
        normal = (onto_sums[..., 0], through_sums[..., 0])
        node_shares = _lagrange(library._places[1:], np.sqrt(1 - self.sines[lit: lit + 1] ** 2))[0]
        change_0, change_45, slanted = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
        by_nodes: Any = 0.0
        for pol, share in enumerate(shares):
            if share == 0.0:
                continue
            change_0 = [x + share * (a - b) for x, a, b in zip(change_0, self._at(pol, 0, 0), self._at(pol, 0, 1))]
            with_ = self._at(pol, lit, 0)
            change_45 = [x + share * (a - b) for x, a, b in zip(change_45, with_, self._shared(pol, node_shares))]
            column = 1 + near * p + pol
            slanted = [x + share * of[..., column] for x, of in zip(slanted, (onto_sums, through_sums))]
            by_nodes = by_nodes + share * sum(w * through_sums[..., 1 + node * p + pol] for node, w in enumerate(node_shares))
        changed, changed_45 = _changed(normal, change_0), _changed(slanted, change_45)
        weights = library._weights[:near]
        behind = np.r_[0.0, np.repeat(library._weights if self.contact else weights, p)]
        back = [(x.sum(-2) * behind).sum(-1) / behind.sum() for x in self._matrices(1)]
        each = [self._of_diffuse(0, pol) for pol in range(p)]
        leaving = self._diffuse(each, [1 / p] * p)
        from_behind = [sum(x) / p for x in zip(*(self._of_diffuse(1, pol) for pol in range(p)))]
        reflected = np.clip(np.minimum(sum(back) + sum(from_behind), 1.0) - back[1] * leaving[1], 0.0, 1.0)
        up = plate.tba @ (behind / behind.sum())  # what leaves of a unit flux from the paper
        towards = np.zeros(up.shape[-1])
        for pol in range(p):
            for node in range(near):
                towards[1 + node * p + pol] = p * shares[pol] * node_shares[node] / weights[node]
        return {
            "reflectance": changed[0], "transmittance": changed[1], "entering": normal[1],
            "through_normal": _ratio(changed[1], normal[1]), "through_45": _ratio(changed_45[1], by_nodes),
            "slanted": changed_45[1], "diffuse": self._diffuse(each, shares)[0], "leaving": leaving[1],
            "alone": plate.ra[..., 0] @ towards, "back": back[0], "reflected": reflected,
            "up": up.sum(-1), "up_at_45": up @ towards,
        }

    def _diffuse(self, changes: Sequence[Tuple[np.ndarray, np.ndarray]], shares: Sequence[float]) -> Tuple[np.ndarray, np.ndarray]:
        """T of diffuse light from in front with these shares of the polarisations, and its factor by interference."""
        p, weights = self.library._polarisations, self.library._weights[: self.near]
        all_ = np.zeros(self.plate.ra.shape[-1])
        for pol, share in enumerate(shares):
            all_[1 + pol: 1 + self.near * p: p] = share * weights
        onto = [(x.sum(-2) * all_).sum(-1) / all_.sum() for x in self._matrices(0)]
        change = [sum(share * of[k] for share, of in zip(shares, changes)) for k in (0, 1)]
        through = _changed(onto, change)[1]
        return through, _ratio(through, onto[1])

    def _shared(self, pol: int, node_shares: np.ndarray) -> List[np.ndarray]:
        """R and T at 45° without interference, of light that the front face shares among the nodes."""
        sines, index = self.sines, self.library.joint_index
        face = _plane(1.0, index, sines, pol).powers()
        lit = self.near + 1
        r, t = self._lobes(self.between, 0, pol, 1)
        within = [np.zeros(r.shape[:-1]), np.zeros(r.shape[:-1])]
        for node, share in enumerate(node_shares, start=1):
            by = share / max(float(face.t[node]), _FAINT)
            within = [within[0] + by * (r[..., node] - face.ra[node]), within[1] + by * t[..., node]]
        composed = [face.ra[lit] + face.t[lit] * within[0], face.t[lit] * within[1]]
        return list(_with_loss(composed, self._shares_at(0, pol, lit)))


def _passive(powers: _Film, side: int) -> Tuple[np.ndarray, np.ndarray]:
    r, t = (powers.rb if side else powers.ra), powers.t
    whole = np.maximum(r + t, 1.0)
    return r / whole, t / whole


def _with_loss(lobes: Any, shares: Any) -> Tuple[np.ndarray, np.ndarray]:
    lost = 1 - lobes[0] - lobes[1]
    return lobes[0] + lost * shares[0], lobes[1] + lost * shares[1]


def _changed(lobes: Any, by: Any) -> Tuple[np.ndarray, np.ndarray]:
    r, t = lobes[0] + by[0], lobes[1] + by[1]
    whole = np.clip(r + t, 0.0, 1.0)
    reflected = np.minimum(np.maximum(r, 0.0), whole)
    return reflected, whole - reflected


def _ratio(changed: Any, composed: Any) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        quotient = changed / composed
    return np.where(np.isfinite(quotient), quotient, 1.0)


def _on_paper(library: Library, jobs: Sequence[_Job], solid: Dict[str, np.ndarray],
              areas: Tuple[Dict[str, np.ndarray], List[List[int]]]) -> Dict[str, np.ndarray]:
    """Spectra (job, wavelength) of stacks on their papers; `areas` are the optics of stacks, and which of them every kind of area bears."""
    albedo = np.array([job.albedo for job in jobs])
    indices = np.array([library.joint_index if job.contact else 1.0 for job in jobs])
    back, reflected = solid["back"], solid["reflected"]

    def on(value: Any, seen: np.ndarray) -> np.ndarray:
        """What the paper returns of light at 0°, as `seen` from in front."""
        returns = _ratio(1 - value * back, 1 - value * reflected)
        return np.asarray(returns * seen * value * solid["entering"] / (1 - value * back))

    through = solid["through_normal"] * solid["through_45"]
    found = {"reflectance_normal": solid["reflectance"], "transmittance_normal": solid["transmittance"],
             "natural_light": solid["reflectance"] + solid["through_normal"] * solid["leaving"] * on(albedo, solid["up"])}
    for name, value in (("lit_at_45", albedo), ("over_black", _BLACK), ("over_white", _WHITE)):
        found[name] = solid["alone"] + through * on(value, solid["up_at_45"])
    lit = found["lit_at_45"]
    area = _areas(solid, albedo, indices[:, None], lit)
    glowing = [k for k, job in enumerate(jobs) if job.light is not None]
    if glowing:
        leaving = area[2][glowing] / ((1 - albedo[glowing]) + albedo[glowing] * area[3][glowing])
        for name, entering in (("lit_at_45", area[1]), ("natural_light", solid["diffuse"])):
            kinds = np.stack([area[0], entering, area[2], area[3]])[:, glowing, None, :]
            whole = np.ones((len(glowing), 1)), np.ones((len(glowing), 1))
            part = np.zeros_like(found[name])
            part[glowing] = leaving * _emitted(library, [jobs[k] for k in glowing], kinds, whole)[:, 0]
            found[name], found[_EMITTED + name] = found[name] + part, part
        lit = found["lit_at_45"]
        found[_EMITTED + "factors"] = found[_EMITTED + "lit_at_45"].copy()
    found["factors"] = lit.copy()
    groups: Dict[Any, List[int]] = {}
    for k, job in enumerate(jobs):
        if job.printed is not None:
            groups.setdefault((len(job.printed.kinds), job.light is not None), []).append(k)
    optics, numbers = areas
    for (_, glows), places in groups.items():
        some = [jobs[k] for k in places]
        kinds = _kinds(library, some, optics, [numbers[k] for k in places], albedo[places])
        mix = (np.array([job.printed.shares for job in some if job.printed]),
               np.array([[job.printed.spread] for job in some if job.printed]))
        emitted = _emitted(library, some, kinds, mix) if glows else np.zeros(kinds.shape[1:])
        up = _rising(kinds, albedo[places], emitted, mix)
        found["factors"][places] = (mix[0][..., None] * kinds[0] + kinds[2] * up).sum(1)
        if glows:
            found[_EMITTED + "factors"][places] = (kinds[2] * (up - _rising(kinds, albedo[places], np.zeros_like(emitted), mix))).sum(1)
        elif _EMITTED + "factors" in found:
            found[_EMITTED + "factors"][places] = 0.0
    return found


def _areas(optics: Dict[str, np.ndarray], albedo: np.ndarray, index: Any, lit: np.ndarray) -> Tuple[np.ndarray, ...]:
    """Stacks as light between them and their paper meets them: own, entering, leaving, lost."""
    out = optics["transmittance"] / index**2
    lost = 1 - optics["reflected"]
    series = optics["slanted"] * out * albedo / ((1 - albedo) + albedo * lost)
    return optics["alone"], optics["slanted"], out * _ratio(lit - optics["alone"], series), lost


def _kinds(library: Library, jobs: Sequence[_Job], optics: Dict[str, np.ndarray], numbers: List[List[int]],
           albedo: np.ndarray) -> np.ndarray:
    """The kinds of area of prints: (own, entering, leaving, lost) × (job, kind, wavelength)."""
    all_ = np.array(numbers)
    here = {name: x[np.maximum(all_, 0)] for name, x in optics.items()}
    rho, index = albedo[:, None], np.array([library.joint_index if job.contact else 1.0 for job in jobs])[:, None, None]
    returns = _ratio(1 - rho * here["back"], 1 - rho * here["reflected"])
    paper = returns * here["up_at_45"] * rho * here["entering"] / (1 - rho * here["back"])
    lit = here["alone"] + here["through_normal"] * here["through_45"] * paper
    kinds = np.stack(_areas(here, rho, index, lit))
    for k, job in enumerate(jobs):
        for kind in np.flatnonzero(all_[k] < 0):
            kinds[:, k, kind] = np.array(_bare(library.joint_index if job.contact else 1.0))[:, None]
    return kinds


def _fluxes(kinds: np.ndarray, albedo: np.ndarray, power: Any, emitted: np.ndarray, mix: Tuple[np.ndarray, np.ndarray]) -> List[np.ndarray]:
    """Light onto and from the paper below every kind of area (job, kind), at one wavelength; `kinds` are the four parts of each."""
    shares, spread = mix
    _, entering, _, lost = kinds
    back = 1 - lost
    divisor = (1 - albedo) + albedo * (lost + spread * back)
    lit = albedo * shares * entering * power + emitted
    all_ = (lit / divisor).sum(1, keepdims=True) / (1 - (albedo * spread * shares * back / divisor).sum(1, keepdims=True))
    own = (lit + albedo * back * spread * shares * all_) / divisor
    rising = (1 - spread) * own + spread * shares * all_
    return [shares * entering * power + back * rising, rising]


def _rising(kinds: np.ndarray, albedo: np.ndarray, emitted: np.ndarray, mix: Tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Light of power 1 that rises from the paper below every kind of area (job, kind, wavelength)."""
    return np.stack([_fluxes(kinds[..., w], albedo[:, w: w + 1], 1.0, emitted[..., w], mix)[1] for w in range(albedo.shape[1])], -1)


def _emitted(library: Library, jobs: Sequence[_Job], kinds: np.ndarray, mix: Tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """What papers emit below every kind of area, relative to their light (job, kind, wavelength)."""
    nm, grid = library.wavelengths_nm, library._summed_nm
    lights = [job.light for job in jobs if job.light is not None]
    albedo, power, matrix, seen = (np.array([light[k] for light in lights]) for k in range(4))
    onto_grid = np.array([np.interp(grid, nm, row) for row in np.eye(nm.size)])
    from_grid = np.array([np.interp(nm, grid, row) for row in np.eye(grid.size)])
    parts = kinds @ onto_grid
    below, all_ = np.zeros(parts.shape[1:]), np.zeros(parts.shape[1:])
    for i in range(grid.size):
        all_[..., i] = np.einsum("jg,jkg->jk", matrix[:, i, :i], below[..., :i])
        below[..., i] = _fluxes(parts[..., i], albedo[:, i: i + 1], power[:, i: i + 1], all_[..., i], mix)[0]
    there = seen[:, None]
    return np.where(there > 0, all_ @ from_grid / np.where(there > 0, there, 1.0), 0.0)


def _fluorescence(given: Mapping[str, Any], from_nm: float, where: str) -> Tuple[Any, Any]:
    """The kernel f(to, from) of a brightener, 1/nm, and the share of the light that it takes before the albedo acts."""
    field = f"{where}paper.fluorescence"
    if set(given) == {"excitation", "emission", "yield"}:
        excitation, emission = (np.array(given[key], float) for key in ("excitation", "emission"))
        for key, rows, most in (("excitation", excitation, 1.0), ("emission", emission, np.inf)):
            sound = rows.ndim == 2 and rows.shape[1:] == (2,) and len(rows) >= 2 and (np.diff(rows[:, 0]) > 0).all()
            if not (sound and ((rows[:, 1] >= 0) & (rows[:, 1] <= most)).all()):
                raise InputError(f"{field}.{key}: found {given[key]}; allowed are two or more rows [nm, value], rising, values from 0: "
                                 "sort them, and set noise below 0 to 0")
        if not 0 <= given["yield"] <= 1:
            raise InputError(f"{field}.yield: found {given['yield']}; allowed 0 to 1, quanta emitted for each absorbed: divide percentages by 100")
        area = float((0.5 * np.diff(emission[:, 0]) * (emission[1:, 1] + emission[:-1, 1])).sum())
        scale = given["yield"] / area if area > 0 else 0.0
        active = _active(excitation[:, 1] > 0)

        def absorbed(nm: np.ndarray) -> np.ndarray:
            return np.asarray(np.interp(nm, excitation[:, 0], excitation[:, 1], left=0.0, right=0.0))

        def kernel(to: np.ndarray, of: np.ndarray) -> np.ndarray:
            shape = np.interp(to, emission[:, 0], emission[:, 1], left=0.0, right=0.0)
            return np.asarray(scale * shape * absorbed(of) * of / to)

        excited = excitation[active, 0]
    elif set(given) == {"excitation_nm", "emission_nm", "factors"}:
        light, sent, factors = (np.array(given[key], float) for key in ("excitation_nm", "emission_nm", "factors"))
        widths = np.diff(light)
        sound = light.size > 1 and sent.size > 1 and (widths > 0).all() and np.allclose(widths, widths[0], rtol=1e-6) and (np.diff(sent) > 0).all()
        if not (sound and factors.shape == (sent.size, light.size) and (factors >= 0).all()):
            raise InputError(f"{field}: found {light.size} wavelengths of the light, {sent.size} emitted, factors of shape {factors.shape}; "
                             "allowed are rising ones (of the light in equal steps) and a factor of 0 or more for each pair")
        factors = np.where(sent[:, None] > light, factors, 0.0)

        def absorbed(nm: np.ndarray) -> np.ndarray:
            return np.zeros_like(nm)

        def kernel(to: np.ndarray, of: np.ndarray) -> np.ndarray:
            across = np.array([np.interp(np.ravel(of), light, row, left=0.0, right=0.0) for row in factors])
            down = np.array([np.interp(np.ravel(to), sent, column, left=0.0, right=0.0) for column in across.T])
            return np.asarray(down.T / widths[0])

        excited = light[(factors != 0).any(0)]
    else:
        raise InputError(f"{field}: found {sorted(given)}; allowed are excitation, emission, yield, or excitation_nm, emission_nm, factors")
    if excited.size and from_nm > max(excited[0], _SHORTEST_NM) + _STEP_NM:
        raise InputError(f"{field}: found excitation from {excited[0]} nm, a library from {from_nm} nm; allowed is a library that holds the "
                         f"light that excites: solve its layers again with light.from_nm = {max(excited[0], _SHORTEST_NM)}")
    return kernel, absorbed


def _active(there: np.ndarray) -> np.ndarray:
    """Rows that are not 0, and their neighbours."""
    return np.asarray(there | np.r_[there[1:], False] | np.r_[False, there[:-1]])


def _matrix(kernel: Any, nm: np.ndarray) -> np.ndarray:
    """F(λ_i, λ_j) for j below i."""
    return np.tril(_STEP_NM * kernel(nm[:, None], nm[None, :]), -1)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _judge_keys(table: Any, allowed: Sequence[str], where: str) -> None:
    """Refuses what is no table, and keys that it cannot have, as `inkwave compose` does."""
    if not isinstance(table, Mapping):
        raise InputError(f"{where.rstrip('. :')}: found {table!r}; allowed is a dictionary of {', '.join(allowed)}")
    unknown = [key for key in table if key not in allowed]
    if unknown:
        raise InputError(f"{where}{unknown[0]}: found an unknown key; allowed are {', '.join(allowed)}: correct or remove it")


def _printed(composition: Mapping[str, Any], where: str) -> Optional[_Print]:
    """Kinds of area of a composition in dots."""
    dots, layers = composition.get("dots"), composition["layers"]
    inks = [(k, layer["coverage"]) for k, layer in enumerate(layers) if isinstance(layer, Mapping) and layer.get("coverage") is not None]
    if dots is None:
        if inks:
            raise InputError(f"{where}layers[{inks[0][0]}].coverage: found one without a screen; allowed beside dots: "
                             "add 'dots': {'ruling_per_cm': 60, 'spread_um': 40}")
        return None

    def judge(name: str, value: Any, least: float, most: float) -> None:
        if not _is_number(value) or not least <= value <= most:
            raise InputError(f"{where}{name}: found {value}; allowed {least} to {most}")

    _judge_keys(dots, ("coverage", "ruling_per_cm", "spread_um"), f"{where}dots.")

    judge("dots.ruling_per_cm", dots.get("ruling_per_cm"), 1.0, 1000.0)
    judge("dots.spread_um", dots.get("spread_um"), 0.0, 1e4)
    for k, coverage in inks:
        judge(f"layers[{k}].coverage", coverage, 0.0, 1.0)
    ruling, length = dots["ruling_per_cm"] / 1e4, dots["spread_um"]
    every = tuple(range(len(layers)))
    if dots.get("coverage") is not None:
        coverage = dots["coverage"]
        judge("dots.coverage", coverage, 0.0, 1.0)
        if inks:
            raise InputError(f"{where}dots.coverage: found one beside layers[{inks[0][0]}].coverage; remove one of them")
        return _Print(((), every), np.array([1 - coverage, coverage]), spread_share(coverage, ruling, length))
    if not 1 <= len(inks) <= _MOST_INKS:
        raise InputError(f"{where}dots.coverage: found {len(inks)} coverages; allowed is that of the stack, or layers[…].coverage of 1 to "
                         f"{_MOST_INKS} layers")
    kinds, shares = [], []
    for bits in range(1 << len(inks)):
        bare = {k for ink, (k, _) in enumerate(inks) if not bits >> ink & 1}
        kinds.append(tuple(k for k in every if k not in bare))
        shares.append(math.prod(c if bits >> ink & 1 else 1 - c for ink, (_, c) in enumerate(inks)))
    varying = [c for _, c in inks if 0 < c < 1]
    weights = [c * (1 - c) for c in varying]
    spread = sum(w * spread_share(c, ruling, length) for w, c in zip(weights, varying)) / sum(weights) if varying else 1.0
    return _Print(tuple(kinds), np.array(shares), spread)


def _bare(index: float) -> Tuple[float, float, float, float]:
    """Bare paper at 45:0 in a medium with a plane surface: own, entering, leaving, lost."""

    def transmitted(cosine: np.ndarray) -> np.ndarray:
        inner = np.sqrt(1 - (1 - cosine**2) / index**2)
        s = (cosine - index * inner) / (cosine + index * inner)
        p = (index * cosine - inner) / (index * cosine + inner)
        return 1 - 0.5 * (s * s + p * p)

    if index == 1.0:
        return 0.0, 1.0, 1.0, 1.0
    x, weight = np.polynomial.legendre.leggauss(64)
    s = 0.5 * (1 + x)
    mean = float((0.5 * weight * 4 * s**3 * transmitted(s * s)).sum())
    lit, seen = (float(transmitted(np.array(c))) for c in (math.cos(math.radians(45.0)), 1.0))
    return 0.0, lit, seen / index**2, mean / index**2


def spread_share(coverage: float, ruling_per_um: float, spread_um: float) -> float:
    """Share of the light that a paper spreads over all areas alike, of round dots on a square lattice."""
    area = min(coverage, 1.0 - coverage)
    if spread_um <= 0.0:
        return 0.0
    length = spread_um * ruling_per_um
    radius = math.sqrt(max(area, 1e-6) / math.pi)
    area = math.pi * radius * radius
    reach = min(math.ceil(30.0 / (2 * math.pi * length)), 400)
    m, n = np.meshgrid(np.arange(reach + 1), np.arange(reach + 1), indexing="ij")
    some = (n <= m) & (m > 0)
    m, n = m[some], n[some]
    images = np.where((n == 0) | (n == m), 4.0, 8.0)
    order = np.sqrt(m * m + n * n)
    z = 2 * math.pi * radius * order
    coefficient = area * 2 * _bessel_1(z) / z
    same = float((images * coefficient**2 / (1 + (2 * math.pi * order * length) ** 2) ** 1.5).sum())
    return min(max(1 - same / (area * (1 - area)), 0.0), 1.0)


def _bessel_1(x: np.ndarray) -> np.ndarray:
    y = 1 / (8 * np.maximum(x, 40.0))
    phase = x - 0.75 * math.pi
    p, q = 1 + 7.5 * y * y - 590.625 * y**4, 3 * y - 52.5 * y**3
    far = np.sqrt(2 / (math.pi * np.maximum(x, 40.0))) * (p * np.cos(phase) - q * np.sin(phase))
    tau = 2 * math.pi * (np.arange(104) + 0.5) / 104
    near = np.cos(tau - np.minimum(x, 40.0)[:, None] * np.sin(tau)).mean(-1)
    return np.asarray(np.where(x > 40.0, far, near))


def lab(xyz: np.ndarray, white: np.ndarray) -> np.ndarray:
    """L*, a*, b* of X, Y, Z."""
    t = xyz / white
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], -1)


def _joined(row: Sequence[_States]) -> _States:
    """Portions at single wavelengths as one at all of them; states that a medium lacks at some are without light."""
    m, n = (max(states.flux.ra.shape[-1] for states in row), max(states.flux.rb.shape[-1] for states in row))
    shapes = ((m, m), (n, n), (n, m), (m, n))

    def padded(part: np.ndarray, shape: Tuple[int, int]) -> np.ndarray:
        if part.shape[1:] == shape:
            return part
        whole = np.zeros((part.shape[0], *shape))
        whole[:, : part.shape[1], : part.shape[2]] = part
        return whole

    parts = [np.concatenate([padded(states.flux[k], shape) for states in row]) for k, shape in enumerate(shapes)]
    return _States(_Flux(*parts), np.concatenate([states.amplitudes for states in row]))


def _etendues(index: float, joint: float, directions: Sequence[int]) -> np.ndarray:
    """Étendues of the directions of a medium whose zones end at 1, at the joint's index and at its own."""
    ends = [1.0] + ([joint] if joint < index - 1e-3 else []) + [index]
    weights, start = [], 0.0
    for end in ends:
        weights.append(_radau(directions[0 if start == 0.0 else 1])[::-1] * (end * end - start * start))
        start = end
    return np.concatenate(weights)


@functools.lru_cache(maxsize=None)
def _radau(count: int) -> np.ndarray:
    """Weights of Gauss's rule for the integral of 2v f(v) over 0 < v < 1, with rising nodes (Jacobi's polynomials)."""
    return np.asarray(_jacobi(count)[1][0] ** 2)


def _jacobi(count: int) -> Tuple[np.ndarray, np.ndarray]:
    """Nodes of that rule on -1 to 1, rising, and the orthonormal polynomials there times the roots of the weights (degree, node)."""
    k = np.arange(1, count)
    diagonal = np.array([1 / ((2 * j + 1) * (2 * j + 3)) for j in range(count)])
    off = np.sqrt(k * (k + 1.0)) / (2 * k + 1.0)
    values, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off, 1) + np.diag(off, -1))
    return values, vectors


@functools.lru_cache(maxsize=None)
def _without_highest_moment(count: int) -> np.ndarray:
    """Fluxes of a zone's nodes, from the normal outwards, without the part orthogonal to polynomials of lower degree than the last."""
    if count == 1:
        return np.eye(1)
    _, vectors = _jacobi(count)
    root, last = vectors[0, ::-1], vectors[-1, ::-1]
    return np.asarray(np.eye(count) - np.outer(root * last, last / root))


def _read(path: Path) -> Dict[str, Any]:
    try:
        found = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: found no library ({error}); allowed is a file that `inkwave library` has written") from None
    if not isinstance(found, dict):
        raise InputError(f"{path}: found no library; allowed is a file that `inkwave library` has written")
    return found

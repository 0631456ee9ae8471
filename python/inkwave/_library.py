"""Stacks of a library's plates, composed with NumPy: thousands at once, without the program.

The formulas are those of the program (`inkwave compose`), whose documentation explains them; the same numbers
(`validation/data/library-golden.json`) judge both, and the page of a library besides.
"""

from __future__ import annotations

import base64
import json
import math
import pathlib
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from ._files import Path
from ._program import InputError

__all__ = ["Composed", "Library"]

FORM = 1
_FAINT = 1e-9
_NOTHING = 1e-9
_PIECE, _PIECES, _MOST_FRINGES = 8, 16, 200.0
_MOST_SLABS = 4096.0
_BLACK, _WHITE = 0.0, 0.8
_PRINT_SINE = math.sin(math.radians(45.0))
_PENCIL, _LEAST, _SMALL = 1e-10, 1e-12, 1e-6
_AT_ONCE = 64


class _Flux(NamedTuple):
    """Reflection from both sides, transmission onward and back: arrays that end in (to, from)."""

    ra: np.ndarray
    rb: np.ndarray
    tab: np.ndarray
    tba: np.ndarray

    def then(self, behind: "_Flux") -> "_Flux":
        """This in front of another."""
        down = _bounced(self.rb, behind.ra, self.tab)
        up = _bounced(behind.ra, self.rb, behind.tba)
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
            return (vectors * f(values)[..., None, :]) @ np.swapaxes(vectors, -1, -2)

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


def _normal(index: Any, sine: np.ndarray) -> np.ndarray:
    root = np.sqrt(np.asarray(index * index - sine * sine, complex))
    return np.where(root.imag < 0, -root, root)


def _plane(before: Any, behind: Any, sine: np.ndarray, p: int) -> _Film:
    a, b = (_normal(n, sine) / (1.0 if p == 0 else n * n) for n in (before, behind))
    r = (a - b) / (a + b)
    return _Film(r, -r, np.sqrt(1 - r * r))


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


class _Change(NamedTuple):
    """What is changed of the ensembles: (plate, portion, cell) left out, the grid's error, half slabs, fewer directions."""

    left_out: Optional[Tuple[int, int, int]] = None
    grid: bool = False
    halved: bool = False
    fewer: bool = False


@dataclass(frozen=True)
class _Job:
    layers: Tuple[Tuple[int, float], ...]
    albedo: np.ndarray
    contact: bool
    dots: Optional[Tuple[float, float]]  # coverage, share of the light that is spread
    change: _Change


@dataclass(frozen=True)
class Composed:
    """What compositions look like: arrays over compositions, then wavelengths or L*, a*, b*.

    `errors` has the standard errors of the same names, where bars were asked for.
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
        joint = content["joint"]
        self.wavelengths_nm = np.array(content["wavelengths_nm"], float)
        self.joint_index = float(joint["index"])
        self._sines, self._weights = np.array(joint["sines"]), np.array(joint["weights"])
        self._polarisations = int(joint["polarisations"])
        self._directions = [int(count) for count in joint["directions"]]
        self._near = self._directions[0]
        self._wave = content["wave"]
        self._eyes = {(eye["illuminant"], eye["observer"]): np.array(eye["weights"]) for eye in content["eyes"]}
        self._plates = content["plates"]
        self._numbers = {plate["name"]: k for k, plate in enumerate(self._plates)}
        self._portions = [[self._portion(plate["name"], portion) for portion in plate["portions"]] for plate in self._plates]
        self._layers: Dict[Any, _Flux] = {}
        self._films: Dict[Any, List[Tuple[_Film, _Film]]] = {}
        self._fringes: Dict[Any, List[Tuple[np.ndarray, np.ndarray]]] = {}
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
        known, p = 1 + self._near, self._polarisations
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
        jobs = [self._job(composition, number) for number, composition in enumerate(listed)]
        eyes = [self._eye(composition) for composition in listed]
        values = self._evaluated(jobs)
        found = self._coloured(values, np.array(eyes))
        errors = None
        if bars:
            each = [self._errors(job, eye, {name: x[k] for name, x in found.items()}) for k, (job, eye) in enumerate(zip(jobs, eyes))]
            errors = {name: np.array([one[name] for one in each]) for name in found}
        return Composed(self.wavelengths_nm, **found, errors=errors)

    def _eye(self, composition: Mapping[str, Any]) -> np.ndarray:
        name = (composition.get("illuminant", "D65"), composition.get("observer", "2"))
        if name not in self._eyes:
            known = ", ".join("/".join(eye) for eye in self._eyes) or "none: its wavelengths carry no colour"
            raise InputError(f"illuminant, observer: found {name[0]}, {name[1]}; allowed are those of the library: {known}")
        return self._eyes[name]

    def _job(self, composition: Composition, number: int) -> _Job:
        if not isinstance(composition, Mapping) or not composition.get("layers"):
            raise InputError(f"composition {number}: found no layers; allowed is {{'layers': [{{'plate': NAME}}, …]}}")
        unknown = set(composition) - {"layers", "paper", "dots", "illuminant", "observer"}
        if unknown:
            raise InputError(f"composition {number}: found {sorted(unknown)}; allowed are layers, paper, dots, illuminant, observer")
        layers = tuple(self._layer(layer, f"composition {number}: layers[{k}]") for k, layer in enumerate(composition["layers"]))
        paper = composition.get("paper", {})
        albedo = np.array(paper.get("albedo", 0.9), float)
        if albedo.ndim == 2:
            if not (albedo[0, 0] <= self.wavelengths_nm[0] and albedo[-1, 0] >= self.wavelengths_nm[-1]):
                raise InputError(f"composition {number}: paper.albedo: found {albedo[0, 0]} to {albedo[-1, 0]} nm; extend the table")
            albedo = np.interp(self.wavelengths_nm, albedo[:, 0], albedo[:, 1])
        if not ((albedo >= 0) & (albedo <= 1)).all():
            raise InputError(f"composition {number}: paper.albedo: found {albedo}; allowed 0 to 1")
        dots = composition.get("dots")
        spread = None
        if dots:
            for key, most in (("coverage", 1.0), ("ruling_per_cm", 1000.0), ("spread_um", 1e4)):
                if not 0.0 <= dots.get(key, -1.0) <= most:
                    raise InputError(f"composition {number}: dots.{key}: found {dots.get(key)}; allowed 0 to {most}")
            spread = (dots["coverage"], spread_share(dots["coverage"], dots["ruling_per_cm"] / 1e4, dots["spread_um"]))
        return _Job(layers, np.broadcast_to(albedo, self.wavelengths_nm.shape), bool(paper.get("contact", False)), spread, _Change())

    def _layer(self, layer: Union[str, Mapping[str, Any]], where: str) -> Tuple[int, float]:
        layer = {"plate": layer} if isinstance(layer, str) else layer
        if layer.get("plate") not in self._numbers:
            raise InputError(f"{where}.plate: found {layer.get('plate')!r}; allowed are {', '.join(self._numbers)}")
        number = self._numbers[layer["plate"]]
        plate, um = self._plates[number], layer.get("thickness_um")
        own = plate["thickness_um"]
        if um is None:
            return number, 2.0 if plate["slabs"] else 1.0
        if not plate["slabs"]:
            if abs(um - own) > 1e-6 * own:
                raise InputError(f"{where}.thickness_um: found {um} µm of {plate['name']!r}; allowed {own}, as which it was solved whole: "
                                 "take another plate of the ink, or solve it in slabs")
            return number, 1.0
        count = um / own
        count = float(round(count)) if abs(count - round(count)) < 1e-9 * count else count
        if not 2.0 <= count <= _MOST_SLABS:
            raise InputError(f"{where}.thickness_um: found {um} µm of {plate['name']!r}; allowed from {2 * own} µm, two slabs")
        return number, count

    # one layer as fluxes and as a film

    def _places_of(self, count: float, change: _Change) -> List[Tuple[str, float]]:
        count = 2.0 * count if change.halved else count
        if count <= 1.0:
            return [("whole", 1.0)]
        places = [("front", 1.0), ("inner", count - 2.0), ("back", 1.0)]
        return [place for place in places if place[1] > 0.0]

    def _state(self, number: int, position: str, change: _Change) -> Tuple[_Portion, _States]:
        for k, portion in enumerate(self._portions[number]):
            if portion.position == position and portion.halved == change.halved:
                out = change.left_out
                cell = out[2] + 1 if out is not None and out[:2] == (number, k) else 0
                return portion, portion.states[cell]
        raise InputError(f"plate {self._plates[number]['name']!r}: lacks a portion; gather the library again")

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
                if times != 1.0:
                    flux = flux.repeated(times, self._etendues(portion.between[:, 1], flux.ra.shape[-1]))
                whole = flux if whole is None else whole.then(flux)
            assert whole is not None
            self._layers[key] = whole
        return self._layers[key]

    def _etendues(self, indices: np.ndarray, states: int) -> np.ndarray:
        """Étendues of the states of media, (wavelength, state)."""
        p = self._polarisations
        rows = np.zeros((indices.size, states))
        for row, index in zip(rows, indices):
            nodes = np.repeat(_etendues(index, self.joint_index, self._directions), p)
            row[1: 1 + nodes.size] = nodes
        return rows

    def _layer_film(self, number: int, count: float, change: _Change, sines: np.ndarray, tag: Any) -> List[Tuple[_Film, _Film]]:
        """A layer with and without interference between its elements, per polarisation: arrays (wavelength, sine)."""
        key = (number, count, self._own(number, change)._replace(grid=False), tag)
        if key not in self._films:
            found = []
            for p in range(self._polarisations):
                films = self._elements(number, count, change, p, sines)
                whole, powers = films[0], films[0].powers()
                for film in films[1:]:
                    whole, powers = whole.then(film), powers.then(film.powers())
                found.append((whole, powers))
            self._films[key] = found
        return self._films[key]

    def _elements(self, number: int, count: float, change: _Change, p: int, sines: np.ndarray) -> List[_Film]:
        within = np.array(self._plates[number]["within"])
        films = []
        for position, times in self._places_of(count, change):
            portion, states = self._state(number, position, change)
            films.append(self._element(portion, states, within, times, p, change.fewer, sines))
        return films

    def _turns(self, number: int, count: float, change: _Change, p: int) -> List[Tuple[np.ndarray, np.ndarray]]:
        """Fringes over the hemisphere of every element, and what of the light passes it at 0° and comes back."""
        key = (number, count, self._own(number, change)._replace(grid=False), p)
        if key in self._fringes:
            return self._fringes[key]
        films = self._elements(number, count, change, p, np.array([0.0]))
        within = np.array(self._plates[number]["within"])
        found = self._fringes[key] = []
        for (position, times), film in zip(self._places_of(count, change), films):
            portion, _ = self._state(number, position, change)
            per_um = 2 * (within - np.sqrt(np.maximum(within**2 - 1.0, 0.0))) / (1e-3 * self.wavelengths_nm)
            found.append((per_um * portion.thickness_um * times, np.abs(film.t[:, 0]) ** 2))
        return found

    def _element(self, portion: _Portion, states: _States, within: np.ndarray, times: float, p: int, fewer: bool,
                 sines: np.ndarray) -> _Film:
        um, index = portion.thickness_um, within[:, None]
        k0 = 2 * np.pi / (1e-3 * self.wavelengths_nm[:, None])
        before, behind = portion.between[:, :1], portion.between[:, 1:]
        inner = portion.position == "inner"
        depth = {"front": 0.0, "inner": 0.5, "whole": 0.5, "back": 1.0}[portion.position]

        def phase(sine: np.ndarray) -> np.ndarray:
            return k0 * _normal(index, sine) * um

        def even(sine: np.ndarray, passed: Any) -> _Film:
            way = np.exp(1j * phase(sine) + passed)
            zero = np.zeros_like(way)
            through = _Film(zero, zero, way)
            if inner:
                return through
            return _plane(before, index, sine, p).then(through).then(_plane(index, behind, sine, p))

        def depths(sine: np.ndarray, passed: np.ndarray) -> List[np.ndarray]:
            once = phase(sine).real + passed.imag
            return [np.exp(2j * part * once) for part in (depth, 1.0 - depth)]

        known = self._known[None, :]
        onward, back = states.amplitudes[:, 0, :, p, 1], states.amplitudes[:, 1, :, p, 1]
        root = np.sqrt(onward * back)
        root = np.where((np.conj(root) * onward).real < 0, -root, root)
        ratio = root / even(known, 0.0).t
        passed = np.where(np.abs(ratio) > _FAINT, np.log(np.where(np.abs(ratio) > _FAINT, ratio, 1.0)), math.log(_FAINT) + 0j)
        for d in range(1, passed.shape[1]):
            turns = np.round((passed[:, d].imag - passed[:, d - 1].imag) / (2 * np.pi))
            passed[:, d] -= 2j * np.pi * turns
        film, phases = even(known, passed), depths(known, passed)
        beyond = [(states.amplitudes[:, side, :, p, 0] - (film.ra, film.rb)[side]) * np.conj(phases[side]) for side in (0, 1)]
        kept = [d for d in range(known.size) if not (fewer and d == known.size // 2)]
        weights = _lagrange(self._places[kept], np.sqrt(np.maximum(1.0 - sines * sines, 0.0))).T
        here = passed[:, kept] @ weights
        here = np.minimum(here.real, passed[:, kept].real.max(1, keepdims=True)) + 1j * here.imag
        sine = sines[None, :]
        if inner:
            t = np.exp((1j * phase(sine) + here) * times)
            return _Film(np.zeros_like(t), np.zeros_like(t), t)
        film, phases = even(sine, here), depths(sine, here)
        straight = even(sine, 0.0).t * np.exp(here)
        return _Film(film.ra + (beyond[0][:, kept] @ weights) * phases[0], film.rb + (beyond[1][:, kept] @ weights) * phases[1], straight)

    # many stacks

    def _evaluated(self, jobs: Sequence[_Job]) -> Dict[str, np.ndarray]:
        """Spectra (job, wavelength) of all jobs, those of as many layers and one contact together."""
        out: Dict[str, np.ndarray] = {}
        groups: Dict[Any, List[int]] = {}
        for k, job in enumerate(jobs):
            groups.setdefault((len(job.layers), job.contact, job.change.fewer), []).append(k)
        for places in groups.values():
            for start in range(0, len(places), _AT_ONCE):
                some = places[start: start + _AT_ONCE]
                for name, values in self._together([jobs[k] for k in some]).items():
                    out.setdefault(name, np.empty((len(jobs), self.wavelengths_nm.size)))[some] = values
            self._films.clear()
        return out

    def _together(self, jobs: Sequence[_Job]) -> Dict[str, np.ndarray]:
        plate = self._flux_of(jobs)
        series = _Series(self, jobs, plate)
        return series.spectra()

    def _flux_of(self, jobs: Sequence[_Job]) -> _Flux:
        """Fluxes of all stacks: arrays (job, wavelength, to, from)."""
        whole = self._face(oblique=True)
        for layer in range(len(jobs[0].layers)):
            all_ = [self._layer_flux(*job.layers[layer], job.change) for job in jobs]
            whole = whole.then(_Flux(*(np.array(part) for part in zip(*all_))))
        return whole if jobs[0].contact else whole.then(self._face(oblique=False).turned())

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
        """Spectra with their colours; eyes are (job, wavelength, 3)."""
        white = eyes.sum(1)

        def xyz(name: str) -> np.ndarray:
            return np.einsum("jw,jwc->jc", values[name], eyes)

        found = dict(values)
        found["lab_natural_light"] = lab(xyz("natural_light"), white)
        found["lab_lit_at_45"] = lab(xyz("lit_at_45"), white)
        found["contrast_ratio"] = xyz("over_black")[:, 1] / xyz("over_white")[:, 1]
        found["lab"] = lab(xyz("factors"), white)
        return found

    def _errors(self, job: _Job, eye: np.ndarray, base: Mapping[str, np.ndarray]) -> Dict[str, np.ndarray]:
        plates = sorted({number for number, _ in job.layers})
        changes = [_Change(halved=True), _Change(grid=True), _Change(fewer=True)]
        cells = {halved: [(number, k, portion.cells) for number in plates for k, portion in enumerate(self._portions[number])
                          if portion.halved == halved] for halved in (False, True)}
        for halved, portions in cells.items():
            changes += [_Change(left_out=(number, k, r), halved=halved) for number, k, count in portions if count > 1 for r in range(count)]
        jobs = [_Job(job.layers, job.albedo, job.contact, job.dots, change) for change in changes]
        many = self._coloured(self._evaluated(jobs), np.broadcast_to(eye, (len(jobs), *eye.shape)))
        known = all(count > 1 for portions in cells.values() for _, _, count in portions)
        errors = {}
        for name, value in base.items():
            all_, at, variance = many[name], 3, []
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
            if name in _SPECTRA and name != "factors":
                beyond = np.array([beyond[max(w - 2, 0): w + 3].mean() for w in range(beyond.size)])
            model = np.maximum(beyond, 0.0) / 4.0
            errors[name] = np.sqrt(chance + model + (all_[1] - value) ** 2 + (all_[2] - value) ** 2)
        return errors


class _Series:
    """Stacks on paper: what interference changes of their fluxes, and the series of returns."""

    def __init__(self, library: Library, jobs: Sequence[_Job], plate: _Flux):
        self.library, self.jobs, self.plate = library, jobs, plate
        self.fewer = jobs[0].change.fewer
        self.index = library.joint_index if jobs[0].contact else 1.0
        self.wavelengths = library.wavelengths_nm.size
        known, p = library._known, library._polarisations
        # at 0° and the nodes, exactly as they were solved
        self.at_known = self._fields(known, exact=True)
        self.near = library._near
        fringes = [self._fringes(turned) for turned in (False, True)]
        pieces = _PIECES + int(np.ceil(2 * max(f[f <= _MOST_FRINGES].max(initial=0.0) for f in fringes)))
        x, weight = np.polynomial.legendre.leggauss(_PIECE)
        place = ((np.arange(pieces)[:, None] + 0.5 * (1 + x)) / pieces).ravel()
        self.quadrature = 2 * place * np.tile(0.5 * weight, pieces) / pieces
        self.sines = np.sqrt(np.maximum(1 - place * place, 0.0))
        self.over_hemisphere = self._fields(self.sines)
        self.fringes = fringes  # of either side
        # shares of the loss, per side and polarisation: (job, wavelength, direction)
        self.shares = [[self._shares(side, pol) for pol in range(p)] for side in (0, 1)]

    def _fields(self, sines: np.ndarray, exact: bool = False) -> List[Tuple[np.ndarray, ...]]:
        """Per polarisation [R_a, R_b, T] with interference and without it: arrays (job, wavelength, sine); and the first face's."""
        library, tag = self.library, (sines.size, float(sines[-1]), exact)
        faces = sines[None, None, :]
        found = []
        for pol in range(library._polarisations):
            face = _plane(1.0, library.joint_index, faces, pol)
            whole, powers = face, face.powers()
            for layer in range(len(self.jobs[0].layers)):
                pairs = []
                for job in self.jobs:
                    change = job.change._replace(fewer=False) if exact else job.change
                    pairs.append(library._layer_film(*job.layers[layer], change, sines, tag)[pol])
                whole = whole.then(_Film(*(np.array(part) for part in zip(*(pair[0] for pair in pairs)))))
                powers = powers.then(_Film(*(np.array(part) for part in zip(*(pair[1] for pair in pairs)))))
            if not self.jobs[0].contact:
                back = _plane(library.joint_index, 1.0, faces, pol)
                whole, powers = whole.then(back), powers.then(back.powers())
            found.append((*whole.powers(), *powers, face.powers().ra[0, 0], face.powers().t[0, 0]))
        return found

    def _fringes(self, turned: bool) -> np.ndarray:
        """Fringes over the hemisphere (job, wavelength), as many as light goes through and back; the largest of polarisations."""
        library = self.library
        most = np.zeros((len(self.jobs), self.wavelengths))
        for j, job in enumerate(self.jobs):
            for pol in range(library._polarisations):
                elements = [turn for number, count in job.layers for turn in library._turns(number, count, job.change, pol)]
                face = 1.0 - ((1.0 - library.joint_index) / (1.0 + library.joint_index)) ** 2
                seen = np.ones(self.wavelengths) * (face if not turned or not job.contact else 1.0)
                fringes = np.zeros(self.wavelengths)
                for turns, passed in reversed(elements) if turned else elements:
                    fringes += np.where(seen >= _FAINT, turns, 0.0)
                    seen = seen * passed
                most[j] = np.maximum(most[j], fringes)
        return most

    def _lobes(self, fields: List[Tuple[np.ndarray, ...]], side: int, pol: int, coherent: bool) -> Tuple[np.ndarray, np.ndarray]:
        ra, rb, t = fields[pol][:3] if coherent else fields[pol][3:6]
        r = rb if side else ra
        whole = np.maximum(r + t, 1.0)
        return r / whole, t / whole

    def _columns(self, side: int, pol: int) -> Tuple[np.ndarray, np.ndarray]:
        p = self.library._polarisations
        states = [0] + [1 + node * p + pol for node in range(self.near)]
        r, t = (self.plate.rb, self.plate.tba) if side else (self.plate.ra, self.plate.tab)
        return r.sum(-2)[..., states], t.sum(-2)[..., states]

    def _shares(self, side: int, pol: int) -> Tuple[np.ndarray, np.ndarray]:
        field_r, field_t = self._lobes(self.at_known, side, pol, False)
        r, t = self._columns(side, pol)
        lost = 1 - field_r - field_t
        safe = np.where(lost < _NOTHING, 1.0, lost)
        together = np.maximum((r + t - field_r - field_t) / safe, 0.0)
        mirrored = np.minimum(np.maximum((r - field_r) / safe, 0.0), together)
        return np.where(lost < _NOTHING, r, mirrored), np.where(lost < _NOTHING, t, together - mirrored)

    def _incoherent(self, side: int, pol: int) -> Tuple[np.ndarray, np.ndarray]:
        return _with_loss(self._lobes(self.at_known, side, pol, False), self.shares[side][pol])

    def _shares_at(self, side: int, pol: int, sines: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        places = self.library._places
        kept = [d for d in range(places.size) if not (self.fewer and d == places.size // 2)]
        weights = _lagrange(places[kept], np.sqrt(np.maximum(1 - sines * sines, 0.0))).T
        r, t = self.shares[side][pol]
        return r[..., kept] @ weights, t[..., kept] @ weights

    def _of_diffuse(self, side: int, pol: int) -> Tuple[np.ndarray, np.ndarray]:
        """What interference changes of diffuse light."""
        coherent = self._lobes(self.over_hemisphere, side, pol, True)
        without = self._lobes(self.over_hemisphere, side, pol, False)
        interferes = (self.fringes[side] <= _MOST_FRINGES)[..., None]
        lobes = tuple(np.where(interferes, a, b) for a, b in zip(coherent, without))
        r, t = _with_loss(lobes, self._shares_at(side, pol, self.sines))
        known = self._incoherent(side, pol)
        weights = self.library._weights[: self.near]
        density = self.index**2 if side else 1.0
        return tuple(((x * self.quadrature).sum(-1) - (k[..., 1:] * weights).sum(-1)) / density for x, k in zip((r, t), known))

    def spectra(self) -> Dict[str, np.ndarray]:
        """All numbers (job, wavelength)."""
        library, plate, near = self.library, self.plate, self.near
        p, shares = library._polarisations, library._shares
        lit = np.array([_PRINT_SINE])
        normal = _sums(plate, 0, [0], [1.0])
        normal_change: List[Any] = [0.0, 0.0]
        at_45: List[Any] = [0.0, 0.0]
        zero, nodes = np.array([0.0]), library._sines[:near]
        fields_0, fields_45, fields_nodes = self._fields(zero), self._fields(lit), self._fields(nodes)
        for pol, share in enumerate(shares):
            if share == 0.0:
                continue
            with_, without = self._lobes(fields_0, 0, pol, True), self._lobes(fields_0, 0, pol, False)
            lost = self._shares_at(0, pol, zero)
            change = [a - b for a, b in zip(_with_loss(with_, lost), _with_loss(without, lost))]
            normal_change = [x + share * y[..., 0] for x, y in zip(normal_change, change)]
            at_45 = [x + share * y for x, y in zip(at_45, self._of_shared(pol, fields_45, fields_nodes))]
        normal_changed = _changed(normal, normal_change)
        columns = [1 + near * p + pol for pol in range(p)]
        slanted = _changed(_sums(plate, 0, columns, shares), at_45)
        through_normal = _ratio(normal_changed[1], normal[1])
        node_shares = _lagrange(library._places[1:], np.sqrt(1 - lit * lit))[0]
        by_nodes = sum(share * node_shares[node] * plate.tab.sum(-2)[..., 1 + node * p + pol]
                       for pol, share in enumerate(shares) for node in range(near))
        through_45 = _ratio(slanted[1], by_nodes)
        weights = np.r_[0.0, np.repeat(library._weights[:near], p), np.zeros(p)]
        behind = np.r_[0.0, np.repeat(library._weights if self.jobs[0].contact else library._weights[:near], p)]
        onto = [(x.sum(-2) * weights).sum(-1) / weights.sum() for x in (plate.ra, plate.tab)]
        back = [(x.sum(-2) * behind).sum(-1) / behind.sum() for x in (plate.rb, plate.tba)]
        change = [sum(x) / p for x in zip(*(self._of_diffuse(0, pol) for pol in range(p)))]
        from_behind = [sum(x) / p for x in zip(*(self._of_diffuse(1, pol) for pol in range(p)))]
        leaving = _ratio(_changed(onto, change)[1], onto[1])
        not_absorbed = back[0] + back[1] + from_behind[0] + from_behind[1]
        reflected = np.clip(np.minimum(not_absorbed, 1.0) - back[1] * leaving, 0.0, 1.0)
        up = plate.tba @ (behind / behind.sum())  # what leaves of a unit flux from the paper
        towards = sum(p * shares[pol] * node_shares[node] / library._weights[node] * np.eye(up.shape[-1])[1 + node * p + pol]
                      for pol in range(p) for node in range(near))
        alone = plate.ra[..., 0] @ towards

        def on(albedo: Any, seen: np.ndarray) -> np.ndarray:
            """What the paper returns of light at 0°, as `seen` from in front."""
            returns = _ratio(1 - albedo * back[0], 1 - albedo * reflected)
            return returns * seen * albedo * normal[1] / (1 - albedo * back[0])

        albedo = np.array([job.albedo for job in self.jobs])
        natural = normal_changed[0] + through_normal * leaving * on(albedo, up.sum(-1))
        lit_at = {name: alone + through_normal * through_45 * on(value, up @ towards)
                  for name, value in (("lit_at_45", albedo), ("over_black", _BLACK), ("over_white", _WHITE))}
        out = normal_changed[1] / self.index**2
        lost = 1 - reflected
        series = slanted[1] * out * albedo / ((1 - albedo) + albedo * lost)
        area = (alone, slanted[1], out * _ratio(lit_at["lit_at_45"] - alone, series), lost)
        return {"reflectance_normal": normal_changed[0], "transmittance_normal": normal_changed[1], "natural_light": natural, **lit_at,
                "factors": self._factors(area, albedo, lit_at["lit_at_45"])}

    def _of_shared(self, pol: int, fields_45: Any, fields_nodes: Any) -> List[np.ndarray]:
        """What interference changes of light at 45° that is shared among the nodes."""
        lit = np.array([_PRINT_SINE])
        lost = self._shares_at(0, pol, lit)
        front, through = (fields_45[pol][k][0] for k in (6, 7))
        within = [0.0, 0.0]
        node_shares = _lagrange(self.library._places[1:], np.sqrt(1 - lit * lit))[0]
        known = self._lobes(fields_nodes, 0, pol, False)
        for node, share in enumerate(node_shares):
            own_front, own_through = (fields_nodes[pol][k][node] for k in (6, 7))
            by = share / max(own_through, _FAINT)
            within = [within[0] + by * (known[0][..., node] - own_front), within[1] + by * known[1][..., node]]
        composed = (front + through * within[0], through * within[1])
        composed = _with_loss(composed, tuple(x[..., 0] for x in lost))
        with_ = _with_loss(self._lobes(fields_45, 0, pol, True), lost)
        return [a[..., 0] - b for a, b in zip(with_, composed)]

    def _factors(self, area: Tuple[np.ndarray, ...], albedo: np.ndarray, solid: np.ndarray) -> np.ndarray:
        """At 45:0, in dots where there are any."""
        found = np.array(solid)
        bare = _bare(self.library.joint_index if self.jobs[0].contact else 1.0)
        for k, job in enumerate(self.jobs):
            if job.dots is not None:
                found[k] = _mixed([tuple(x[k] for x in area), bare], job.dots, albedo[k])
        return found


def _with_loss(lobes: Any, shares: Any) -> Tuple[np.ndarray, np.ndarray]:
    lost = 1 - lobes[0] - lobes[1]
    return lobes[0] + lost * shares[0], lobes[1] + lost * shares[1]


def _changed(lobes: Any, by: Any) -> Tuple[np.ndarray, np.ndarray]:
    r, t = lobes[0] + by[0], lobes[1] + by[1]
    whole = np.clip(r + t, 0.0, 1.0)
    reflected = np.minimum(np.maximum(r, 0.0), whole)
    return reflected, whole - reflected


def _sums(plate: _Flux, side: int, states: Sequence[int], shares: Sequence[float]) -> Tuple[np.ndarray, np.ndarray]:
    r, t = (plate.rb, plate.tba) if side else (plate.ra, plate.tab)
    return tuple((x.sum(-2)[..., list(states)] * np.array(shares)).sum(-1) for x in (r, t))  # type: ignore[return-value]


def _ratio(changed: Any, composed: Any) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        quotient = changed / composed
    return np.where(np.isfinite(quotient), quotient, 1.0)


def _mixed(areas: Sequence[Any], dots: Tuple[float, float], albedo: np.ndarray) -> np.ndarray:
    """Radiance factor of areas of ink and of bare paper: (own, entering, leaving, lost) each."""
    coverage, spread = dots
    given = shared = 0.0
    parts = []
    for (own, entering, leaving, lost), share in zip(areas, (coverage, 1.0 - coverage)):
        back = 1 - lost
        divisor = (1 - albedo) + albedo * (lost + spread * back)
        parts.append((share, own, entering, leaving, back, divisor))
        given = given + albedo * share * entering / divisor
        shared = shared + albedo * spread * share * back / divisor
    total = given / (1 - shared)
    factor = np.zeros_like(albedo)
    for share, own, entering, leaving, back, divisor in parts:
        kept = (albedo * share * entering + albedo * back * spread * share * total) / divisor
        factor = factor + share * own + leaving * ((1 - spread) * kept + spread * share * total)
    return factor


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
    return np.where(x > 40.0, far, near)


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
        return np.pad(part, ((0, 0), (0, shape[0] - part.shape[1]), (0, shape[1] - part.shape[2])))

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


def _radau(count: int) -> np.ndarray:
    """Weights of Gauss's rule for the integral of 2v f(v) over 0 < v < 1, with rising nodes (Jacobi's polynomials)."""
    k = np.arange(1, count)
    diagonal = np.array([1 / ((2 * j + 1) * (2 * j + 3)) for j in range(count)])
    off = np.sqrt(k * (k + 1.0)) / (2 * k + 1.0)
    _, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off, 1) + np.diag(off, -1))
    return np.asarray(vectors[0] ** 2)


def _read(path: Path) -> Dict[str, Any]:
    try:
        found = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: found no library ({error}); allowed is a file that `inkwave library` has written") from None
    if not isinstance(found, dict):
        raise InputError(f"{path}: found no library; allowed is a file that `inkwave library` has written")
    return found

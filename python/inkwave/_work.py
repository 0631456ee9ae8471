"""The program's commands: run, pack, sweep, fit, design. Each takes a path, a dictionary or a builder."""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
import re
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from ._files import Layer, Path, Study, input_file, plain, table_of
from ._program import InkwaveError, call, remark
from ._results import Design, Fit, Ink, Sweep
from ._tables import Table, read_table

__all__ = ["design", "fit", "pack", "run", "sweep"]


def _named(study: Study, settings: Mapping[str, Any]) -> str:
    """Name of the folder under `out`: the title, or a part of the content's checksum, so that two inks never share one."""
    if not isinstance(study, (Mapping, Layer)):
        return pathlib.Path(study).stem
    table = plain(table_of(study, settings))
    title = re.sub(r"[^\w.-]+", "-", str(table.get("title", ""))).strip("-.")
    content = hashlib.sha256(json.dumps(table, sort_keys=True).encode()).hexdigest()[:8]
    return f"{title}-{content}" if title else f"study-{content}"


def _worked(command: str, study: Study, settings: Mapping[str, Any], output: Optional[Path], end: str = "",
            **options: Any) -> Tuple[pathlib.Path, str]:
    """Runs a command on a file; the folder of its results, and what it printed."""
    made = isinstance(study, (Mapping, Layer)) or bool(settings)
    folder = output
    if folder is None and made:
        folder = pathlib.Path("out") / (_named(study, settings) + end)
    progress = options.pop("progress", None)
    more: List[object] = []
    for name, value in options.items():
        if value is not None and value is not False:
            more += ["--" + name.replace("_", "-")] + ([] if value is True else [value])
    if folder is not None:
        more += ["--output", os.fspath(folder)]
    with input_file(study, settings, "study" if folder is None else pathlib.Path(folder).name or "study") as path:
        try:
            said = call(command, path, *more, show=progress)
        except InkwaveError as error:
            error.folder = None if folder is None or not os.path.isdir(folder) else pathlib.Path(folder)
            raise
    if folder is None:
        page = re.findall(r"^(?:Report|report|Comparison): (.*)$", said, re.MULTILINE)
        if not page:
            raise InkwaveError(f"inkwave {command} did not say where its results are: give output=…\n{said}")
        folder = pathlib.Path(page[-1]).parent
    return pathlib.Path(folder), said


def run(study: Study, output: Optional[Path] = None, *, jobs: Optional[int] = None, memory_gb: Optional[float] = None,
        progress: Optional[bool] = None, **settings: Any) -> Ink:
    """Runs or resumes a study and returns its results.

    `study` is a path, a dictionary with the keys of a study file, or a `Layer`. Settings change it: `paper` (albedo), `delta_e`,
    `realisations`, `seed`, `accuracy`, `wavelength_nm`, `polar_deg`, `wave`, `thickness_um`, `period_um`, or whole tables such as
    `run={"seed": 2}`. Results are in `output`, by default `out/TITLE-CHECKSUM`, or `out/NAME` of a file NAME.toml.

    >>> from inkwave import Layer, Pigment
    >>> ink = Layer(0.3, pigments=[Pigment(d_nm=200, share=0.1, index="yellow")], title="Thin yellow", more={"period_um": 0.8})
    >>> r = run(ink, "thin", wavelength_nm=range(400, 701, 50), realisations=2, accuracy=0.05)
    >>> r.spectra["wavelength_nm"][:3].tolist(), r.lab.shape, r.status
    ([400, 450, 500], (3,), 'complete')
    """
    folder, _ = _worked("run", study, settings, output, jobs=jobs, memory_gb=memory_gb, progress=progress)
    return Ink(folder)


def pack(study: Study, output: Optional[Path] = None, realisations: Optional[int] = None, *, seed: Optional[int] = None,
         progress: Optional[bool] = None, **settings: Any) -> List[Table]:
    """Packs a study without solving: the grains of each packing, one table for each realisation.

    `center_um` (x, y, z), `radius_um`, `pigment` (its place in the study's list) and `grain` (the rigid body) have one
    entry for each sphere.

    >>> from inkwave import Layer, Pigment
    >>> spheres = pack(Layer(0.3, pigments=[Pigment(d_nm=200, share=0.1)], more={"period_um": 0.8}), "packed", realisations=1)[0]
    >>> spheres["center_um"].shape[1], spheres["pigment"].tolist()[:2]
    (3, [0, 0])
    """
    folder, _ = _worked("pack", study, settings, output, "-packing", realisations=realisations, seed=seed, progress=progress)
    tables = []
    for path in sorted(folder.glob("grains_*.csv")):
        table = read_table(path, index=())
        table._columns["center_um"] = np.column_stack([table[name] for name in ("x_um", "y_um", "z_um")])
        tables.append(table)
    return tables


# Words of axes for fields of a study.
_FIELDS = {"d_nm": "pigment[0].diameter_nm", "share": "pigment[0].volume_fraction", "thickness_um": "layer.thickness_um",
           "paper": "paper.albedo", "shape": "pigment[0].shape", "seed": "run.seed"}


def sweep(study: Study, output: Optional[Path] = None, *, axes: Optional[Mapping[str, Sequence[Any]]] = None,
          jobs: Optional[int] = None, memory_gb: Optional[float] = None, progress: Optional[bool] = None, **words: Any) -> Sweep:
    """Runs or resumes a sweep: one table over its axes, one row for each variant.

    `study` is a sweep (a path or a dictionary), or a study to vary: lists of `d_nm`, `share`, `thickness_um`, `paper`, `shape` or
    `seed` are axes, and `axes={"pigment[0].diameter_nm": [150, 250]}` names any field. Other words are settings as of `run`.

    >>> from inkwave import Layer, Pigment
    >>> ink = Layer(0.3, pigments=[Pigment(d_nm=200, share=0.1, index="yellow")], more={"period_um": 0.8})
    >>> s = sweep(ink, "swept", share=[0.1, 0.2], wavelength_nm=range(400, 701, 50), realisations=2, accuracy=0.05)
    >>> s["share"].tolist(), s.variants, s.spectra.index
    ([0.1, 0.2], ['0.1', '0.2'], ['share', 'polar_deg', 'wavelength_nm'])
    """
    table = sweep_table(study, axes, words)
    folder, _ = _worked("sweep", study if table is None else table, {}, output, jobs=jobs, memory_gb=memory_gb, progress=progress)
    return Sweep(folder)


def sweep_table(study: Study, axes: Optional[Mapping[str, Sequence[Any]]], words: Mapping[str, Any]) -> Optional[Dict[str, Any]]:
    """A sweep as a dictionary; None where the file is one as it stands."""
    if not words and not axes and not isinstance(study, Layer):
        return None
    lists = {name: value for name, value in words.items() if name in _FIELDS and np.ndim(value) == 1}
    settings = {name: value for name, value in words.items() if name not in lists}
    base = table_of(study, settings)
    rows = [{"name": name, "field": _FIELDS[name], "values": list(values)} for name, values in lists.items()]
    rows += [{"field": field, "values": list(values)} for field, values in (axes or {}).items()]
    return {**_title(base), "base": base, "axis": rows}


Card = Union[str, "os.PathLike[str]", Tuple[Path, float], Mapping[str, Any]]
_FIT_KEYS = ("pigment", "prior", "noise", "also", "n", "kappa")


def fit(study: Study, output: Optional[Path] = None, *, white: Optional[Card] = None, black: Optional[Card] = None,
        measured: Sequence[Card] = (), jobs: Optional[int] = None, memory_gb: Optional[float] = None,
        progress: Optional[bool] = None, **words: Any) -> Fit:
    """Fits a pigment's index to spectra of drawdowns, or resumes; a warning where n is not determined.

    Spectra that contradict the study are an InkwaveError; `Fit(error.folder)` reads what was found, without errors.

    `study` is a fit (a path or a dictionary), or the study of the drawdowns with `white=("white.csv", 0.85)` and
    `black=("black.csv", 0.04)`: files and albedos of the cards; `measured` lists others. `pigment`, `prior`, `noise`, `also`, `n` and
    `kappa` are those of a fit file, other words settings as of `run`.
    """
    cards = [card for card in (white, black, *measured) if card is not None]
    table: Study = study
    if cards or words or isinstance(study, Layer):
        own = {name: value for name, value in words.items() if name in _FIT_KEYS}
        base = table_of(study, {name: value for name, value in words.items() if name not in own})
        table = {**_title(base), "base": base, "measured": [_card(card) for card in cards], **({"fit": own} if own else {})}
    folder, _ = _worked("fit", table, {}, output, jobs=jobs, memory_gb=memory_gb, progress=progress)
    return Fit(folder)


def _title(base: Mapping[str, Any]) -> Dict[str, Any]:
    return {"title": base["title"]} if "title" in base else {}


def _card(card: Card) -> Dict[str, Any]:
    if isinstance(card, Mapping):
        return dict(card)
    if isinstance(card, tuple):
        return {"file": os.fspath(card[0]), "backing": card[1]}
    return {"file": os.fspath(card)}


def design(study: Study, output: Optional[Path] = None, *, target: Union[Sequence[float], Mapping[str, Any], None] = None,
           vary: Optional[Mapping[str, Tuple[float, float]]] = None, jobs: Optional[int] = None,
           memory_gb: Optional[float] = None, progress: Optional[bool] = None, **words: Any) -> Design:
    """Looks for recipes of a target colour, or resumes; a warning where none reaches it, and `["met"]` is then False.

    `study` is a design (a path or a dictionary), or the study of all recipes with `target=(L, a, b)` and
    `vary={"pigment[0].diameter_nm": (140, 300)}`; the words of `sweep` name fields, too. `delta_e`, `variants`, `verifications` and
    `realisations` are those of a design file.
    """
    table: Study = study
    if target is not None or vary or words or isinstance(study, Layer):
        own = {name: value for name, value in words.items() if name in ("delta_e", "variants", "verifications", "realisations")}
        base = table_of(study, {name: value for name, value in words.items() if name not in own})
        goal = {} if target is None else dict(target) if isinstance(target, Mapping) else {"lab": list(target)}
        ranges = [{"field": _FIELDS.get(name, name), "from": low, "to": high} for name, (low, high) in (vary or {}).items()]
        table = {**_title(base), "base": base, "target": goal, "vary": ranges, **({"design": own} if own else {})}
    try:
        folder, _ = _worked("design", table, {}, output, jobs=jobs, memory_gb=memory_gb, progress=progress)
    except InkwaveError as error:  # how near it comes is an answer, too
        if error.folder is None or "target is not reached" not in str(error):
            raise
        remark([str(error)])
        folder = error.folder
    return Design(folder)

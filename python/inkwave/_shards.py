"""A sweep divided among processes or machines, by engines that exist: a pool of this machine, submitit, dask."""

from __future__ import annotations

import importlib
import pathlib
from concurrent.futures import ThreadPoolExecutor
from typing import Any, List, Mapping, Optional, Sequence

from ._files import Layer, Path, Study, table_of, written
from ._program import call
from ._results import Sweep
from ._work import _named, sweep_table

__all__ = ["Submitted", "submit"]


def solve_shard(file: str, folder: str, shard: int, shards: int, jobs: Optional[int] = None) -> str:
    """Runs one shard of a sweep: what an engine calls, in whichever process. The folder of its results."""
    more: List[object] = [] if jobs is None else ["--jobs", jobs]
    call("sweep", file, "--output", folder, "--shard", f"{shard}/{shards}", *more, show=False)
    return folder


class Submitted:
    """Shards under way. `result()` waits for all, merges them and returns the sweep; `done()` does not wait."""

    def __init__(self, futures: Sequence[Any], folder: pathlib.Path, own: Optional[ThreadPoolExecutor] = None):
        self.futures, self.folder, self._own = list(futures), folder, own

    def done(self) -> bool:
        """Whether all shards have ended."""
        return all(future.done() for future in self.futures)

    def result(self) -> Sweep:
        """Waits, merges and returns the sweep. A shard that failed raises; the others stay, and `submit` resumes them."""
        shards = [future.result() for future in self.futures]
        if self._own is not None:
            self._own.shutdown()
        call("merge", "--output", self.folder, *shards, show=False)
        return Sweep(self.folder)

    def __repr__(self) -> str:
        ended = sum(bool(future.done()) for future in self.futures)
        return f"{ended} of {len(self.futures)} shards ended, merged into {self.folder}"


def submit(study: Study, shards: int, output: Optional[Path] = None, *, engine: Any = "local", workers: Optional[int] = None,
           jobs: Optional[int] = None, axes: Optional[Mapping[str, Sequence[Any]]] = None, **words: Any) -> Submitted:
    """Hands the shards of a sweep to an engine and returns at once; `.result()` merges them.

    `study` and the words are those of `sweep`; a study without axes is a sweep of one variant, whose realisations are divided.
    `engine` is "local" (`workers` processes at a time on this machine, two when left out), "submitit" (Slurm, or this machine where there
    is none), "dask" (a local cluster), or any object with `submit(function, *arguments)` that returns futures: a submitit executor
    with your partition and time, a dask client of your cluster, an executor of `concurrent.futures`. The folder must be one that all
    machines see.

    >>> from inkwave import Layer, Pigment
    >>> ink = Layer(0.3, pigments=[Pigment(d_nm=200, share=0.1, index="yellow")], more={"period_um": 0.8})
    >>> job = submit(ink, 2, "sharded", share=[0.1, 0.2], wavelength_nm=range(400, 701, 50), realisations=2, accuracy=0.05)
    >>> job.result().variants
    ['0.1', '0.2']
    """
    if shards < 1:
        raise ValueError(f"shards: found {shards}, at least 1")
    table = sweep_table(study, axes, words)
    whole = table_of(study if table is None else table, {})
    name = pathlib.Path(study).stem if table is None and "base" in whole and not isinstance(study, (Mapping, Layer)) else None
    if "base" not in whole:
        whole = {"base": whole}
    if not whole.get("axis"):
        seed = whole["base"].get("run", {}).get("seed", 1) if isinstance(whole["base"], Mapping) else 1
        whole["axis"] = [{"name": "seed", "field": "run.seed", "values": [seed]}]
    folder = pathlib.Path(output) if output is not None else pathlib.Path("out") / (name or _named(whole, {}))
    parts = folder.with_name(folder.name + "-shards").resolve()
    parts.mkdir(parents=True, exist_ok=True)
    file = parts / "sweep.toml"
    file.write_text(written(whole), encoding="utf-8")
    pool, own = _engine(engine, workers, parts)
    futures = [pool.submit(solve_shard, str(file), str(parts / f"shard-{i}"), i, shards, jobs) for i in range(1, shards + 1)]
    return Submitted(futures, folder, own)


def _engine(engine: Any, workers: Optional[int], folder: pathlib.Path) -> Any:
    """An object with `submit`, and the pool to close afterwards."""
    if hasattr(engine, "submit"):
        return engine, None
    if engine == "local":  # the program is a process of its own: threads only wait for it
        pool = ThreadPoolExecutor(workers or 2)
        return pool, pool
    if engine == "submitit":
        return importlib.import_module("submitit").AutoExecutor(folder=str(folder / "submitit")), None
    if engine == "dask":
        return importlib.import_module("dask.distributed").Client(n_workers=workers or 2, threads_per_worker=1), None
    raise ValueError(f'engine: found {engine!r}; allowed: "local", "submitit", "dask", or an object with submit(function, *arguments)')

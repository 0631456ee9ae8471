"""Finds the program, runs it, follows its progress, and makes exceptions and warnings of what it says."""

from __future__ import annotations

import contextlib
import html
import importlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import threading
import warnings
from typing import IO, Any, Callable, Dict, Iterator, List, Optional, Tuple

__all__ = ["InkwaveError", "InkwaveWarning", "InputError", "MissingProgram", "call", "program"]


class InkwaveError(RuntimeError):
    """The program refused its input or failed; the text is its whole message.

    `folder` is where its results are, if it has any: what is stored stays, and the same call resumes. `printed` is what it had
    printed by then.
    """

    folder: Optional[pathlib.Path] = None
    printed: str = ""


class InputError(InkwaveError, ValueError):
    """The program refused its input before it computed anything; the text names the field, and what is allowed."""


class MissingProgram(InkwaveError, FileNotFoundError):
    """The program is not on this machine, or $INKWAVE does not name it."""


class InkwaveWarning(UserWarning):
    """What the program says of a result beside its numbers: doubtful units, missing numbers, an index that is not determined."""


def program() -> str:
    """Path of the program: $INKWAVE, next to this Python, or on the PATH.

    >>> os.path.isfile(program())
    True
    """
    named = os.environ.get("INKWAVE")
    if named:
        if os.path.isfile(named):
            return named
        raise MissingProgram(f"$INKWAVE names {named}, which is no file: name the program, or unset the variable")
    name = "inkwave.exe" if sys.platform == "win32" else "inkwave"
    places = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    own = [os.path.join(place, name) for place in places if place]
    for candidate in [*own, shutil.which("inkwave")]:
        if candidate and os.path.isfile(candidate):
            return candidate
    raise MissingProgram("the program inkwave is not found: name it by $INKWAVE, or install the wheel (python/README.md)")


# Lines of progress on standard error; every other line is said to the user as a warning.
_SOLVES = re.compile(r"^(\d+)/(\d+) solves, (.*)$")
_STAGES = (
    r"coarse table of n and κ|search over both branches of n|linearisation \d+ on all cells|predictions of other layers|verifying run \d+: |"
    r"variant \d+/\d+: |tabulating the material|packing realisation \d+|solving for the near field|evaluating the layer|calibrating with |"
    r"\d+ solves at a time instead of|estimating the error of the grid|comparing two grids on packing |"
    r"grid: |grid tried: ")
_SAID = (
    r"still working after|\d+ solves in \d+ s: |\d+ of \d+ solves were already stored$|the workers of this process waited|\d+ grids taken from |"
    r"\S+ shows the finished solves|verified: |recipes of nearly equal colour: |median prediction error of the response|to resume: |Stopped;|Stopping|"
    r"realisation \d+: \d+ grains |.*: \d+ applications")
# A stage may follow the name of a variant or a slab; the other lines stand alone.
_PROGRESS = re.compile(rf"^(?:(?:.*: )?(?:{_STAGES})|(?:{_SAID}))")
_CODES = re.compile(r"\x1b\[[0-9;?]*[ -/]*[@-~]")


def _plain(text: str) -> str:
    return _CODES.sub("", text)


def in_notebook() -> bool:
    """Whether a notebook shows what is displayed."""
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None and hasattr(shell, "get_ipython") else None
    return running is not None and "IPKernelApp" in getattr(running, "config", {})


def _shown() -> Tuple[Any, Any]:
    """What a notebook displays with."""
    module = importlib.import_module("IPython.display")
    return module.HTML, module.display


class Progress:
    """One bar: in a notebook a cell's output that is replaced, on a terminal a line, elsewhere nothing."""

    def __init__(self, title: str, show: Optional[bool] = None):
        self.title, self.done, self.all, self.said = title, 0, 0, ""
        self._notebook = in_notebook() and show is not False
        self._line = not self._notebook and (sys.stderr.isatty() if show is None else show)
        self._handle: Any = None

    def hear(self, line: str) -> bool:
        """Takes a line of the program; false if it is no progress."""
        counted = _SOLVES.match(line)
        if counted:
            self.done, self.all, self.said = int(counted[1]), int(counted[2]), counted[3]
        elif _PROGRESS.search(line):
            self.said = line
        else:
            return False
        self._draw()
        return True

    def text(self) -> str:
        counts = f" {self.done}/{self.all} solves" if self.all else ""
        return f"{self.title}{counts} {self.said}"

    def _draw(self) -> None:
        if self._line:
            print("\r\x1b[2K" + self.text()[:100], end="", file=sys.stderr, flush=True)
        if self._notebook:
            HTML, display = _shown()

            share = f' value="{self.done}" max="{self.all}"' if self.all else ""
            shown = HTML(f"<progress{share}></progress> {html.escape(self.text())}")
            if self._handle is None:
                self._handle = display(shown, display_id=True)
            else:
                self._handle.update(shown)

    def close(self) -> None:
        if self._line:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
        if self._handle is not None:
            self._handle.update(_shown()[0](""))


def _error(said: List[str], began: bool, command: str) -> InkwaveError:
    """The exception of a failure: the message from `Error:` on, and all that was said where there is none."""
    text = "\n".join(said)
    start = re.search(r"^(Error:|error:)", text, re.MULTILINE)
    message = text[start.start():] if start else text
    # A dictionary's file is temporary: its name says nothing to the user.
    message = re.sub(re.escape(os.path.join(tempfile.gettempdir(), "inkwave-")) + r"\w{8}[/\\]", "", message)
    message = re.sub(r"\AError:\s+×\s", "", message).strip() or f"inkwave {command} failed without a message"
    return InkwaveError(message) if began else InputError(message)


def _signal_of_interrupt() -> int:
    return getattr(signal, "CTRL_BREAK_EVENT") if sys.platform == "win32" else signal.SIGINT


def _own_group() -> Dict[str, Any]:
    """Keeps a terminal's Ctrl-C from the child, which gets it once, from here: a second one would end it at once."""
    if sys.platform == "win32":
        return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}
    return {"start_new_session": True}


@contextlib.contextmanager
def _started(command: List[str]) -> Iterator["subprocess.Popen[str]"]:
    environment = {"INKWAVE_PROGRESS_SECONDS": "1", **os.environ, "NO_COLOR": "1", "INKWAVE_ENDS_WITH_PARENT": "1"}
    for name in ("CLICOLOR_FORCE", "FORCE_COLOR"):
        environment.pop(name, None)
    child = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
        errors="replace", env=environment, **_own_group())
    with child:
        try:
            yield child
        except BaseException:
            if child.poll() is None:
                child.kill()
            raise


def _stop(child: "subprocess.Popen[str]") -> None:
    """Asks the program to stop after its current step, a second interrupt to stop at once; waits for it."""
    while child.poll() is None:
        try:
            child.send_signal(_signal_of_interrupt())
            child.wait()
        except KeyboardInterrupt:
            continue


def call(*arguments: object, show: Optional[bool] = None, listen: Optional[Callable[[str], None]] = None) -> str:
    """Runs the program and returns its standard output; what it remarks becomes warnings, a failure an exception.

    An interrupt is passed on: the program stops after its current step, what it stored stays, and KeyboardInterrupt goes on.
    """
    command = [program(), *map(str, arguments)]
    bar = Progress(f"inkwave {arguments[0]}", show)
    said: List[str] = []
    remarks: List[str] = []
    began = threading.Event()

    def follow(stream: "IO[str]") -> None:
        for raw in stream:
            line = _plain(raw.rstrip("\n"))
            if listen is not None:
                listen(line)
            if bar.hear(line):
                began.set()
            elif line.strip():
                remarks.append(line)
            said.append(line)

    printed: List[str] = []
    try:
        with _started(command) as child:
            assert child.stdout is not None and child.stderr is not None
            readers = [threading.Thread(target=follow, args=(child.stderr,), daemon=True),
                       threading.Thread(target=lambda out: printed.append(out.read()), args=(child.stdout,), daemon=True)]
            try:
                for reader in readers:
                    reader.start()
                child.wait()
            except KeyboardInterrupt:
                _stop(child)
                raise
            for reader in readers:
                reader.join()
    finally:
        bar.close()
    if child.returncode:
        failed = next((i for i, line in enumerate(remarks) if line.lower().startswith("error:")), len(remarks))
        remark([line.removeprefix("warning: ") for line in remarks[:failed] if not line.startswith(("usage:", "Usage:"))])
        error = _error(said, began.is_set(), str(arguments[0]))
        error.printed = _plain("".join(printed))
        raise error
    output = _plain("".join(printed))
    told = [line for line in output.splitlines() if ": no result: " in line or ": no colour: " in line]
    remark([line.removeprefix("warning: ") for line in remarks + told])
    return output


def remark(lines: List[str]) -> None:
    """Warns once of every line, at the line of the user's own code that called the module."""
    for line in dict.fromkeys(lines):
        warnings.warn(line, InkwaveWarning, stacklevel=_users_frame())


def _users_frame() -> int:
    """Stack level, as `warnings.warn` counts it, of the first caller outside this package."""
    own = str(pathlib.Path(__file__).parent)
    level, frame = 1, sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith(own) and frame.f_back is not None:
        level, frame = level + 1, frame.f_back
    return level


def version_of_program() -> Tuple[str, str]:
    """Path and version of the program."""
    return program(), call("--version").strip()

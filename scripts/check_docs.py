#!/usr/bin/env python3
"""Checks the pages in docs: links lead somewhere, pages made by docs_pages.py are as they are made, and every listing prints
what stands below it.

    scripts/check_docs.py             links, and all listings (the program by $INKWAVE, NumPy)
    scripts/check_docs.py --links     links alone
    scripts/check_docs.py --write     writes what the listings print into the pages
    scripts/check_docs.py PAGE…       these pages

A page's blocks are one session in a folder of their own, where `examples` and `reports` are those of the repository. `python` blocks are run; a block
`text` that follows is what they print. Of a `console` block, the lines that begin with `$ inkwave` are run, those below are what they print: the
error where they fail, else the result. A block whose first line is `# file: NAME` becomes that file. `…` stands for anything. Blocks `python no-run` take too long
and are compiled only; they have no printed output.
"""

import contextlib
import difflib
import io
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import traceback
import warnings

import docs_pages

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
sys.path.insert(0, str(ROOT / "python"))


def links(page, text):
    """Links of a page that lead nowhere: to files, and to headings of pages."""
    text = BLOCK.sub("", text)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        file, _, heading = target.partition("#")
        path = (page.parent / file).resolve() if file else page
        if re.match(r"[a-z]+:", target):
            continue
        if not path.exists():
            yield f"{page.name}: {target} is not there"
        elif heading and path.suffix == ".md":
            heads = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
            if heading not in [re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads]:
                yield f"{page.name}: {target} is no heading"


def same(expected, found):
    """Whether a text is the expected one, in which … stands for anything."""
    pattern = ".*?".join(re.escape(part) for part in expected.strip().split("…"))
    return re.fullmatch(pattern, found.strip(), re.DOTALL) is not None


class Session:
    """The blocks of one page: Python's names and a folder."""

    def __init__(self, page):
        self.page, self.names = page, {"__name__": "__docs__"}

    def run_python(self, source):
        import linecache

        out, name = io.StringIO(), f"<{self.page.name} {len(linecache.cache)}>"
        linecache.cache[name] = (len(source), None, source.splitlines(True), name)  # so that inspect finds it
        with contextlib.redirect_stdout(out), warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = lambda message, kind, *_: print(f"{kind.__name__}: {message}")
            exec(compile(source, name, "exec"), self.names)
        return out.getvalue()

    def run_console(self, text):
        """What a console block would show: its commands, and what they print."""
        shown = []
        for line in text.splitlines():
            if line.startswith("$ "):
                words = shlex.split(line[2:], comments=True)
                if words[0] != "inkwave":
                    raise ValueError(f"{line}: a command of inkwave is expected")
                import inkwave

                done = subprocess.run([inkwave.program(), *words[1:]], capture_output=True, encoding="utf-8",
                                      env=dict(os.environ, NO_COLOR="1"))
                shown += [line, (done.stderr if done.returncode else done.stdout).rstrip("\n")]
        return "\n".join(shown)


def checked(page, write):
    """Faults of a page's listings; with `write`, the page with what they print."""
    text, faults, session, printed = page.read_text(encoding="utf-8"), [], Session(page), None
    pieces, end, count = [], 0, 0

    def compare(kind, body, found):
        if write and not same(body, found):
            return f"```{kind}\n{found.rstrip()}\n```"
        if not same(body, found):
            lines = difflib.unified_diff(body.strip().splitlines(), found.strip().splitlines(), "page", "printed", lineterm="", n=0)
            faults.append(f"{page.name}: a listing prints something else:\n" + "\n".join(lines))
        return f"```{kind}\n{body}```"

    for block in BLOCK.finditer(text):
        kind, body = block[1].strip(), block[2]
        pieces.append(text[end:block.start()])
        end = block.end()
        whole = block[0]
        named = re.match(r"# file: (\S+)\n", body)
        try:
            if named:
                pathlib.Path(named[1]).write_text(body, encoding="utf-8")
            elif kind == "python no-run":
                compile(body, page.name, "exec")
            elif kind == "python":
                printed, count = session.run_python(body), count + 1
            elif kind == "text" and printed is not None:
                whole, printed = compare(kind, body, printed), None
            elif kind == "console":
                whole, count = compare(kind, body, session.run_console(body)), count + 1
        except Exception:
            faults.append(f"{page.name}: a listing fails:\n{body}\n{traceback.format_exc()}")
        pieces.append(whole)
    pieces.append(text[end:])
    if write:
        page.write_text("".join(pieces), encoding="utf-8")
    return faults, count


def main(arguments):
    options = {word for word in arguments if word.startswith("--")}
    names = [word for word in arguments if word not in options and word != "all"]
    pages = [pathlib.Path(name).resolve() for name in names] or sorted((ROOT / "docs").rglob("*.md"))
    faults = docs_pages.faults() + [fault for page in pages for fault in links(page, page.read_text(encoding="utf-8"))]
    listings = 0
    if "--links" not in options:
        import inkwave

        os.environ["INKWAVE"] = os.path.abspath(inkwave.program())  # sessions have folders of their own
    for page in [] if "--links" in options else pages:
        with tempfile.TemporaryDirectory() as scratch:
            os.chdir(scratch)
            for folder in ("examples", "reports"):
                os.symlink(ROOT / folder, folder)
            found, count = checked(page, "--write" in options)
            os.chdir(ROOT)
        faults, listings = faults + found, listings + count
    print("\n\n".join(faults) or f"ok      {len(pages)} pages, {listings} listings")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

#!/usr/bin/env python3
"""Packs a built program and the Python module into a wheel, with all licences. Nothing is built or fetched here.

    scripts/pack_wheel.py PROGRAM FOLDER [THIRD-PARTY.txt]

On Linux the program asks for `hypot` and `hypotf` by the versions that glibc 2.35 gave them. These replaced a wrapper that sets errno, around
the same function; the copy in the wheel asks for the wrapper's version, which every glibc has. The digits stay (checked here), and so does the
program that was given. The tag of the wheel is the newest glibc that remains. Needs Python 3.11 or newer, to pack; the wheel needs 3.9.
"""

import base64
import ctypes
import hashlib
import os
import pathlib
import platform
import random
import stat
import struct
import subprocess
import sys
import sysconfig
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SAME_SINCE = {b"hypot": b"GLIBC_2.2.5", b"hypotf": b"GLIBC_2.2.5"}


def elf_hash(name):
    value = 0
    for byte in name:
        value = (value << 4) + byte
        high = value & 0xF0000000
        value = (value ^ (high >> 24)) & ~high & 0xFFFFFFFF
    return value


class Elf:
    """The dynamic symbols of a 64-bit little-endian program, and the versions that it needs of them."""

    def __init__(self, data):
        self.data = bytearray(data)
        at, size, count, names = (struct.unpack_from("<Q", data, 40)[0], *struct.unpack_from("<HHH", data, 58))
        self.sections = {}
        heads = [struct.unpack_from("<IIQQQQII", data, at + k * size) for k in range(count)]
        for head in heads:
            self.sections[self._text(heads[names][4] + head[0])] = (head[4], head[5])

    def _text(self, offset):
        return bytes(self.data[offset:self.data.index(0, offset)])

    def needed(self):
        """(place of the entry, name of the version, its number) of every version of every library."""
        offset, _ = self.sections[b".gnu.version_r"]
        strings, _ = self.sections[b".dynstr"]
        while True:
            _, count, _, first, following = struct.unpack_from("<HHIII", self.data, offset)
            entry = offset + first
            for _ in range(count):
                _, _, number, name, further = struct.unpack_from("<IHHII", self.data, entry)
                yield entry, self._text(strings + name), number
                entry += further
            if not following:
                return
            offset += following

    def symbols_of(self, number):
        """Names of the symbols that ask for a version."""
        table, size = self.sections[b".dynsym"]
        versions, _ = self.sections[b".gnu.version"]
        strings, _ = self.sections[b".dynstr"]
        for k in range(size // 24):
            if struct.unpack_from("<H", self.data, versions + 2 * k)[0] == number:
                yield self._text(strings + struct.unpack_from("<I", self.data, table + 24 * k)[0])

    def ask_for_older(self):
        """Lets symbols that only got a new version ask for their older one; gives their names."""
        strings, _ = self.sections[b".dynstr"]
        found = []
        for entry, _, number in list(self.needed()):
            names = sorted(self.symbols_of(number))
            older = {SAME_SINCE.get(name) for name in names}
            if names and len(older) == 1 and None not in older:
                (version,) = older
                at = next(struct.unpack_from("<I", self.data, place + 8)[0] for place, name, _ in self.needed() if name == version)
                struct.pack_into("<I", self.data, entry, elf_hash(version))
                struct.pack_into("<I", self.data, entry + 8, at)
                assert self._text(strings + at) == version
                found += names
        return found

    def glibc(self):
        versions = [name[6:].decode().split(".") for _, name, _ in self.needed() if name.startswith(b"GLIBC_")]
        return max(tuple(int(part) for part in version) for version in versions)


def check_digits(names):
    """That both versions of these functions give the same bits on this machine."""
    libm = ctypes.CDLL("libm.so.6")
    libm.dlvsym.restype = ctypes.c_void_p
    draw = random.Random(1)
    for name in names:
        kind = ctypes.c_float if name.endswith(b"f") else ctypes.c_double
        function = ctypes.CFUNCTYPE(kind, kind, kind)
        new, old = (libm.dlvsym(ctypes.c_void_p(libm._handle), name, version) for version in (b"GLIBC_2.35", SAME_SINCE[name]))
        if not (new and old):
            return "not checked: this glibc has one version only"
        new, old = function(new), function(old)
        spread = 30 if kind is ctypes.c_float else 300
        for _ in range(100_000):
            x, y = (draw.uniform(-1, 1) * 10.0 ** draw.uniform(-spread, spread) for _ in range(2))
            assert new(x, y) == old(x, y), (name, x, y)
            x, y = draw.uniform(-4, 4), draw.uniform(-4, 4)
            assert new(x, y) == old(x, y), (name, x, y)
    return "the same bits on 400 000 pairs"


def for_wheel(program):
    """The program's bytes as the wheel has them, and the platform's tag."""
    data = program.read_bytes()
    machine = platform.machine().lower()
    if data[:4] != b"\x7fELF":
        return data, sysconfig.get_platform().replace("-", "_").replace(".", "_")
    elf = Elf(data)
    older = elf.ask_for_older()
    if older:
        print(f"older versions of {', '.join(name.decode() for name in older)}: {check_digits(older)}")
    major, minor = elf.glibc()
    return bytes(elf.data), f"manylinux_{major}_{minor}_{machine}"


def metadata(project, version):
    """The text of METADATA (core metadata 2.4)."""
    lines = ["Metadata-Version: 2.4", f"Name: {project['name']}", f"Version: {version}", f"Summary: {project['description']}",
             f"License-Expression: {project['license']}", *(f"License-File: {name}" for name in ("LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY.txt")),
             f"Keywords: {','.join(project['keywords'])}", *(f"Classifier: {line}" for line in project["classifiers"]),
             f"Requires-Python: {project['requires-python']}", *(f"Requires-Dist: {name}" for name in project["dependencies"])]
    for extra, names in project["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}", *(f"Requires-Dist: {name}; extra == '{extra}'" for name in names)]
    text = (ROOT / "python" / project["readme"]).read_text(encoding="utf-8")
    return "\n".join([*lines, "Description-Content-Type: text/markdown", "", text])


def main(program, folder, third_party=None):
    program, folder = pathlib.Path(program), pathlib.Path(folder)
    project = tomllib.loads((ROOT / "python/pyproject.toml").read_text(encoding="utf-8"))["project"]
    version = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
    if third_party is None:
        third_party = folder / "THIRD-PARTY.txt"
        subprocess.run([sys.executable, ROOT / "scripts/third_party.py", third_party], check=True)
    data, tag = for_wheel(program)
    name = project["name"].replace("-", "_")
    info = f"{name}-{version}.dist-info"
    files = {f"inkwave/{path.name}": path.read_bytes() for path in sorted((ROOT / "python/inkwave").iterdir())
             if path.suffix == ".py" or path.name == "py.typed"}
    files[f"{name}-{version}.data/scripts/{program.name}"] = data
    for path in (ROOT / "LICENSE-MIT", ROOT / "LICENSE-APACHE", pathlib.Path(third_party)):
        files[f"{info}/licenses/{path.name}"] = path.read_bytes()
    files[f"{info}/METADATA"] = metadata(project, version).encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: inkwave\nRoot-Is-Purelib: false\nTag: py3-none-{tag}\n".encode()
    digest = lambda text: base64.urlsafe_b64encode(hashlib.sha256(text).digest()).rstrip(b"=").decode()
    record = [f"{path},sha256={digest(text)},{len(text)}" for path, text in files.items()]
    files[f"{info}/RECORD"] = "\n".join([*record, f"{info}/RECORD,,", ""]).encode()
    folder.mkdir(parents=True, exist_ok=True)
    out = folder / f"{name}-{version}-py3-none-{tag}.whl"
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, text in files.items():
            entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (stat.S_IFREG | (0o755 if "/scripts/" in path else 0o644)) << 16
            wheel.writestr(entry, text, zipfile.ZIP_DEFLATED)
    print(out)
    return out


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])

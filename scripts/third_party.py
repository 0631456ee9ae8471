#!/usr/bin/env python3
"""Licences of what is inside the program besides its own code: crates, the font, data. For wheels and archives.

    scripts/third_party.py [FILE]     writes THIRD-PARTY.txt (default: target/release-files/THIRD-PARTY.txt)

Reads `cargo metadata` for this machine's platform and the licence files in the crates' sources. Status 1 where a crate names no licence.
A crate without a file of its own gets the text of its licence from a crate that has it, and is named there.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FILES = re.compile(r"(LICEN[SC]E|COPYING|COPYRIGHT|NOTICE|UNLICENSE)", re.IGNORECASE)
# What is inside beside crates of their own.
DATA = [
    ("Fonts DejaVu, in the program for its pictures", "Bitstream Vera licence with public-domain changes; text below"),
    ("The standard library of Rust", "MIT OR Apache-2.0, as the crates below"),
    ("SQLite, in the program for queues of processes", "public domain, by the crate libsqlite3-sys"),
    ("Refractive indices of `inkwave materials`", "database of refractiveindex.info, CC0 1.0; sources by `inkwave materials NAME`"),
    ("Tables of the CIE (observers, illuminants) and of ASTM and ISO weights", "published numbers; sources in the files under src/physics/appearance"),
]
# First words of a text by which a licence is known, where a crate has no file of its own.
KNOWN = {"MIT": "Permission is hereby granted, free of charge", "Apache-2.0": "Apache License", "BSD-3-Clause": "Redistribution and use in source",
         "BSD-2-Clause": "Redistribution and use in source", "ISC": "Permission to use, copy, modify", "Zlib": "This software is provided 'as-is'",
         "BSL-1.0": "Boost Software License", "CC0-1.0": "CC0 1.0", "Unlicense": "This is free and unencumbered", "0BSD": "Permission to use, copy"}


def metadata():
    host = next(line.split()[1] for line in subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout.splitlines()
                if line.startswith("host:"))
    said = subprocess.run(["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", host],
                          cwd=ROOT, capture_output=True, text=True)
    if said.returncode:
        sys.exit(said.stderr)
    return json.loads(said.stdout)


def linked(known):
    """Packages in the program: what it and its dependencies use, without those of builds and tests, and without macros."""
    packages = {package["id"]: package for package in known["packages"]}
    nodes = {node["id"]: node for node in known["resolve"]["nodes"]}
    todo = [id for id, package in packages.items() if package["name"] == "inkwave"]
    found = set()
    while todo:
        here = todo.pop()
        if here in found:
            continue
        found.add(here)
        todo += [dependency["pkg"] for dependency in nodes[here]["deps"] if any(kind["kind"] is None for kind in dependency["dep_kinds"])]
    macro = lambda package: any("proc-macro" in target["kind"] for target in package["targets"])
    third = [packages[id] for id in found if packages[id]["source"] and not macro(packages[id])]
    return sorted(third, key=lambda package: (package["name"], package["version"]))


def texts(package):
    """The licence texts in a crate's sources."""
    folder = pathlib.Path(package["manifest_path"]).parent
    named = [folder / package["license_file"]] if package.get("license_file") else []
    files = sorted(path for path in folder.iterdir() if path.is_file() and FILES.match(path.name))
    files += sorted(path for path in folder.glob("LICENSES/*") if path.is_file())
    return [path.read_text(encoding="utf-8", errors="replace").strip() for path in dict.fromkeys(named + files)]


def main(arguments):
    out = pathlib.Path(arguments[0]) if arguments else ROOT / "target/release-files/THIRD-PARTY.txt"
    packages = linked(metadata())
    owners, faults, without = collections.OrderedDict(), [], []
    for package in packages:
        name = f"{package['name']} {package['version']}"
        if not package["license"] and not package.get("license_file"):
            faults.append(f"{name} names no licence")
        found = texts(package)
        if not found:
            without.append((name, package["license"] or "", ", ".join(package["authors"])))
        for text in found:
            owners.setdefault(re.sub(r"\s+", " ", text), (text, []))[1].append(name)
    for name, licence, authors in without:
        words = [word for word in re.split(r"[^\w.-]+", licence) if word in KNOWN]
        known = next((entry for word in words for key, entry in owners.items() if KNOWN[word] in key), None)
        if known is None:
            faults.append(f"{name}: no text of {licence}")
        else:
            known[1].append(f"{name} (no file of its own; {licence}{', ' + authors if authors else ''})")
    if faults:
        sys.exit("\n".join(faults))
    lines = ["Software and data in inkwave by others, with their licences. inkwave itself: LICENSE-MIT or LICENSE-APACHE.", ""]
    lines += [f"{what}: {licence}." for what, licence in DATA] + [""]
    lines += [f"{package['name']} {package['version']}: {package['license'] or 'licence file'}" for package in packages]
    fonts = (ROOT / "src/draw/LICENSE-DejaVu.txt").read_text(encoding="utf-8").strip()
    for text, names in [(fonts, ["Fonts DejaVu"]), *owners.values()]:
        lines += ["", "=" * 100, ", ".join(names), "-" * 100, "", text]
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{out}: {len(packages)} crates, {len(owners)} texts, {len(without)} crates without a file of their own")


if __name__ == "__main__":
    main(sys.argv[1:])

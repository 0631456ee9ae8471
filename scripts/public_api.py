#!/usr/bin/env python3
"""What the published crates offer, one line a public item, so that a change of the surface shows in a change of
docs/public-api.txt.

    scripts/public_api.py            compares the listing with the sources; exit status 1 and the differences if they differ
    scripts/public_api.py --write    writes it

It reads rustdoc's JSON, an unstable format of the stable compiler (RUSTC_BOOTSTRAP).
"""
import difflib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LISTING = ROOT / "docs" / "public-api.txt"
CRATES = ["inkwave-numerics", "inkwave-physics", "inkwave-study", "inkwave-draw", "inkwave-bench", "inkwave"]


def documented():
    """Rustdoc's JSON of all crates, made together, as their features are those of the workspace."""
    flags = "-Zunstable-options --output-format json"
    with tempfile.TemporaryDirectory() as scratch:
        # For rustdoc alone: dependencies that see RUSTC_BOOTSTRAP are built anew.
        rustdoc = Path(scratch, "rustdoc")
        rustdoc.write_text(f'#!/bin/sh\nRUSTC_BOOTSTRAP=1 exec {os.environ.get("RUSTDOC", "rustdoc")} "$@"\n')
        rustdoc.chmod(0o755)
        subprocess.run(
            ["cargo", "doc", "--quiet", "--workspace", "--no-deps", "--lib"],
            cwd=ROOT,
            env={**os.environ, "RUSTDOC": str(rustdoc), "RUSTDOCFLAGS": flags},
            check=True,
        )
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "doc"
    return [json.loads((folder / f"{crate.replace('-', '_')}.json").read_text()) for crate in CRATES]


def members(kind, inner):
    """Identifiers of what an item of this kind holds: public fields, variants, methods of its own, methods of a trait."""
    ids = list(inner.get("items", []) if kind in ("module", "trait") else [])
    if kind == "struct":
        plain = inner["kind"].get("plain") if isinstance(inner["kind"], dict) else None
        ids += plain["fields"] if plain else []
    ids += inner.get("variants", [])
    return ids, [i for i in inner.get("impls", [])] if kind in ("struct", "enum", "union") else []


def lines_of(index):
    """`path: kind` of every public item of a crate, from its JSON."""
    items = index["index"]
    listed = set()

    def walk(number, path):
        item = items.get(str(number))
        if item is None:
            return
        (kind, inner), = item["inner"].items()
        if kind == "use":
            name = f"{path}::{inner['name']}"
            if inner.get("is_glob"):
                target = items.get(str(inner["id"]))
                for member in target["inner"].get("module", {}).get("items", []) if target else []:
                    walk(member, path)
            elif str(inner["id"]) in items and name not in listed:
                walk_named(inner["id"], name)
            else:
                listed.add(f"{name}: use {inner['source']}")
            return
        if item["visibility"] not in ("public", "default"):
            return
        walk_named(number, f"{path}::{item['name']}" if path else item["name"])

    def walk_named(number, name):
        item = items[str(number)]
        (kind, inner), = item["inner"].items()
        if kind in ("impl", "assoc_type"):
            return
        mark = " (non-exhaustive)" if "non_exhaustive" in json.dumps(item["attrs"]) else ""
        line = f"{name}: {kind.replace('_', ' ')}{mark}"
        if line in listed:
            return
        listed.add(line)
        inside, impls = members(kind, inner if isinstance(inner, dict) else {})
        for member in inside:
            walk(member, name)
        for number in impls:
            block = items.get(str(number), {}).get("inner", {}).get("impl")
            if block and block["trait"] is None:
                for member in block["items"]:
                    if items[str(member)]["visibility"] == "public":
                        walk(member, name)

    walk(index["root"], "")
    return sorted(listed)


def main():
    text = "".join(f"{line}\n" for index in documented() for line in lines_of(index))
    if "--write" in sys.argv[1:]:
        LISTING.write_text(text)
        return 0
    before = LISTING.read_text().splitlines() if LISTING.exists() else []
    changes = list(difflib.unified_diff(before, text.splitlines(), str(LISTING.relative_to(ROOT)), "sources", lineterm="", n=0))
    print("\n".join(changes) or f"{LISTING.relative_to(ROOT)} lists what the crates offer")
    return 1 if changes else 0


if __name__ == "__main__":
    sys.exit(main())

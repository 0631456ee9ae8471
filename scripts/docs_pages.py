#!/usr/bin/env python3
"""Pages of docs that are made from what the program says of itself: every key of every input file, from the schemas, and
every column of every table, from the dictionary in schema/columns.json.

    scripts/docs_pages.py             whether the pages are what the schemas say; status 1 if not
    scripts/docs_pages.py --write     makes them anew
"""

import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MADE = "<!-- made by scripts/docs_pages.py -->"

KINDS = [
    ("study", "Study", "What `inkwave run` and `inkwave pack` read, and the base of sweeps, fits and designs."),
    ("sweep", "Sweep", "What `inkwave sweep` reads: axes over fields of a study, and conclusions to test."),
    ("fit", "Fit", "What `inkwave fit` reads: measured drawdowns, and the study of the layer they are of."),
    ("design", "Design", "What `inkwave design` reads: a target colour, and the fields that may vary."),
    ("compare", "Comparison", "What `inkwave compare` reads."),
    ("case", "Case", "What `inkwave solve` reads: one explicit geometry."),
    ("composition", "Composition", "What `inkwave compose` reads: plates of a library, stacked on paper."),
]

KEYS_HEAD = f"""# Every key

{MADE}

Keys of all input files, made from the [schemas](../schema), which editors read for completion. `[a]` is a table of a TOML file, `[[a]]` may be
there several times, `a.b` is the key b in the table a. Keys without "must be given" may be left out. The same keys with an example value each:
[studies](../examples/every-key.toml), [sweeps](../examples/every-key-sweep.toml), [fits](../examples/fit/every-key.toml),
[designs](../examples/design/every-key.toml), [comparisons](../examples/every-key-compare.toml), [cases](../examples/every-key-case.toml),
[compositions](../examples/library/every-key.toml), or `inkwave schema KIND --annotated`. Libraries, which programs write:
[library.md](../schema/library.md).
"""

COLUMNS_HEAD = f"""# Every column

{MADE}

Columns of all tables, made from the program's own list (`inkwave schema columns`); `datapackage.json` in a folder describes those that its
tables have. `…_standard_error` is one standard error of the column `…`, `…_half_width_95` half the width of its 95 % interval. Sweeps add a column
for every axis. Shares, ratios and words have no unit; a name that means one thing in some tables alone names them. Folders of `pack` and
`compare` have no `datapackage.json`. The curves of `pack`, such as `pair_correlation.csv`, have headings in words with their units, which are not in
the list.
"""


def one_line(text):
    """A description as one line."""
    return " ".join(text.split())


def cell(text):
    """A description as a cell of a table."""
    return one_line(text).replace("|", "\\|")


def shown(value):
    """A value as a TOML file has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {shown(item)}" for key, item in value.items() if item is not None) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(shown, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def code(value):
    return f"`{shown(value)}`"


def span(schema):
    """The range of a number in words; empty where it has none."""
    above, least = schema.get("exclusiveMinimum"), schema.get("minimum")
    below, most = schema.get("exclusiveMaximum"), schema.get("maximum")
    start = f"above {above:g}" if above is not None else f"from {least:g}" if least is not None else ""
    end = f"below {below:g}" if below is not None else f"to {most:g}" if most is not None else ""
    return " ".join(part for part in (start, end) if part)


class Page:
    """The keys of one kind of file, in order; forms that occur again are written once."""

    def __init__(self, kind):
        self.schema = json.loads((ROOT / "schema" / f"{kind}.json").read_text(encoding="utf-8"))
        self.study = kind not in ("study", "case")
        self.seen, self.lines, self.table = {}, [], ""

    def resolved(self, schema):
        """The schema itself with what it refers to, and the name of that."""
        for part in schema.get("allOf", [schema]):
            if "$ref" in part:
                name = part["$ref"].rsplit("/", 1)[1]
                own = {key: value for key, value in schema.items() if key not in ("allOf", "$ref")}
                return {**self.schema["definitions"][name], **own}, name
        forms = schema.get("anyOf", [])
        real = [form for form in forms if form.get("type") != "null"]
        if len(real) == 1 and len(forms) > 1:
            own = {key: value for key, value in schema.items() if key != "anyOf"}
            return self.resolved({**real[0], **own}) if "$ref" in real[0] else ({**real[0], **own}, None)
        return schema, None

    def is_study(self, schema):
        """Whether a table is a whole study within another file."""
        return self.study and {"layer", "pigment", "packing"} <= set(schema.get("properties", {}))

    def word(self, schema):
        """What kind of value it is, in words; `None` for forms that need lines of their own."""
        schema, _ = self.resolved(schema)
        if "const" in schema:
            return code(schema["const"])
        if "enum" in schema:
            return " or ".join(code(value) for value in schema["enum"])
        kinds = schema.get("type")
        kinds = [kind for kind in (kinds if isinstance(kinds, list) else [kinds]) if kind != "null"]
        if kinds in (["number"], ["integer"]):
            noun = "a number" if kinds == ["number"] else "a whole number"
            return f"{noun} {span(schema)}".rstrip()
        if kinds == ["boolean"]:
            return "`true` or `false`"
        if kinds == ["string"]:
            return "text"
        if kinds == ["array"] and isinstance(schema.get("items"), dict) and (each := self.word(schema["items"])):
            least, most = schema.get("minItems"), schema.get("maxItems")
            count = f"{least} of them" if least == most and least else f"at least {least}" if (least or 0) > 1 else ""
            return f"a list, each {each}" + (f", {count}" if count else "")
        return None

    def put(self, depth, text):
        self.lines.append("  " * depth + "- " + text)

    def forms(self, depth, schema, path):
        """Lines for what a value may be, where one word does not say it."""
        schema, name = self.resolved(schema)
        if name in self.seen and (schema.get("properties") or schema.get("anyOf") or schema.get("oneOf")):
            return self.put(depth, f"as for `{self.seen[name]}`")
        if name:
            self.seen[name] = self.table + path
        if self.is_study(schema):
            return self.put(depth, "the keys of a [study](#study)")
        every = [form for form in schema.get("anyOf", schema.get("oneOf", [])) if form.get("type") != "null"]
        kinds = {form["properties"]["kind"].get("const") for form in every if "kind" in form.get("properties", {})}
        words = [form["const"] for form in every if form.get("const") in kinds]
        if words:
            self.put(depth, f"{' or '.join(map(code, words))} alone: that kind below, with the defaults")
        for form in every:
            if form.get("const") in kinds:
                continue
            full, _ = self.resolved(form)
            about = one_line(full.get("description", ""))
            if full.get("properties"):
                self.put(depth, self.heading(full) + (f": {about}" if about else ""))
                if not self.is_study(full):
                    self.keys(depth + 1, full, path)
            else:
                word = self.word(form)
                self.put(depth, (word or ("a table" if full.get("type") == "object" else "one of")) + (f": {about}" if about else ""))
                if not word:
                    self.forms(depth + 1, form, path)
        if schema.get("properties"):
            self.keys(depth, schema, path)
        if isinstance(schema.get("items"), dict):
            self.forms(depth, schema["items"], path)

    def heading(self, schema):
        """The form of a table by the keys that it must have."""
        if self.is_study(schema):
            return "the keys of a [study](#study)"
        keys = [f"kind = {shown(table['const'])}" if "const" in table else f"{key} = …"
                for key, table in schema["properties"].items() if key in schema.get("required", []) or "const" in table]
        return "`{ " + ", ".join(keys or ["…"]) + " }`"

    def keys(self, depth, schema, path):
        """A line for every key of a table, and those of the tables in it."""
        for key, entry in schema["properties"].items():
            if "const" in entry:
                continue
            full, _ = self.resolved(entry)
            word, about = self.word(entry), one_line(full.get("description", ""))
            notes = [word] if word else []
            if key in schema.get("required", []):
                notes.append("must be given")
            if "default" in entry:
                notes.append(f"default {code(entry['default'])}")
            examples = full.get("examples", [])
            if examples and "default" not in entry:
                notes.append(f"such as {code(examples[0])}")
            here = f"{path}.{key}" if path else key
            self.put(depth, f"`{here if depth == 0 else key}`: {about}" + (f" ({'; '.join(notes)})" if notes else ""))
            if not word:
                self.forms(depth + 1, entry, here)

    def tables(self, key, entry):
        """The tables that a key of the file is, each with its heading; none for plain keys."""
        full, _ = self.resolved(entry)
        items = full.get("items")
        several = self.resolved(items)[0] if isinstance(items, dict) else {}
        return [(form, table) for form, table in ((f"[{key}]", full), (f"[[{key}]]", several)) if table.get("properties")]

    def text(self):
        """Plain keys, then a chapter for every table."""
        case = self.schema["definitions"].get("Case")
        root = case or self.schema
        tables = {key: [] if case else self.tables(key, entry) for key, entry in root["properties"].items()}
        self.keys(0, {**root, "properties": {key: entry for key, entry in root["properties"].items() if not tables[key]}}, "")
        for key, forms in tables.items():
            about = one_line(self.resolved(root["properties"][key])[0].get("description", ""))
            self.table = f"{key}."
            for form, table in forms:
                self.lines += ["", f"### `{form}`", "", *([about, ""] if about else [])]
                self.keys(0, table, "")
                about = ""
        return "\n".join(self.lines)


def keys_page():
    parts = [KEYS_HEAD]
    for kind, title, about in KINDS:
        parts.append(f"## {title}\n\n{about}\n\n{Page(kind).text()}\n")
    return "\n".join(parts)


def columns_page():
    known = json.loads((ROOT / "schema" / "columns.json").read_text(encoding="utf-8"))
    rows = "\n".join(f"| `{column['name']}` | {column.get('unit', '')} | {column['type']} | {cell(column['description'])} "
                     f"| {', '.join(column.get('tables', ['any']))} |" for column in known["columns"])
    return f"{COLUMNS_HEAD}\n| column | unit | kind | meaning | tables |\n|---|---|---|---|---|\n{rows}\n"


PAGES = {"keys.md": keys_page, "columns.md": columns_page}


def faults():
    """Pages that are not as they are made."""
    paths = {name: ROOT / "docs" / name for name in PAGES}
    return [f"docs/{name} is not what the program says: scripts/docs_pages.py --write" for name, make in PAGES.items()
            if not paths[name].exists() or paths[name].read_text(encoding="utf-8") != make()]


def main(arguments):
    if arguments == ["--write"]:
        for name, make in PAGES.items():
            (ROOT / "docs" / name).write_text(make(), encoding="utf-8")
    found = faults()
    print("\n".join(found) or "ok")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

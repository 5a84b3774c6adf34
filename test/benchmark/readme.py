#!/usr/bin/env python3
"""Writes README.md of this folder from README.template.md and from the results of the benchmarks, so that no number of it
is typed.

usage: readme.py            writes README.md
       readme.py --check    exit code 1, and what differs, where README.md is not what would be written

The template has two kinds of places: {{ table RESULT.NAME }}, a line of its own, for a table of results/RESULT.json, and
{{ RESULT.NAME }} for one value of it: a key of the file, or one of facts() of the module that makes its tables. What stands
between the lines {{ begin RESULT }} and {{ end RESULT }} is left out as long as there is no results/RESULT.json; that is for the
results of OPTIONAL.
"""

import difflib
import json
import pathlib
import re
import sys

import load_table
import meshes_table
import motion_table
import node_table
import scene_table
import stress_table
import subalgorithms_table
import sweep_table
import table

FOLDER = pathlib.Path(__file__).resolve().parent
MODULES = {  # what makes the tables of a result file
    "narrowphase": table,
    "subalgorithms": subalgorithms_table,
    "scene": scene_table,
    "meshes": meshes_table,
    "load": load_table,
    "motion": motion_table,
    "node": node_table,
    "stress": stress_table,
    "sweep": sweep_table,
}
OPTIONAL = {"sweep"}
SECTION = re.compile(r"^\{\{ *begin +(\w+) *\}\}\n(.*?)^\{\{ *end +\1 *\}\}\n", re.MULTILINE | re.DOTALL)
PLACE = re.compile(r"\{\{ *(table +)?(\w+)\.(\w+) *\}\}")
HEADER = "<!-- Made by ./dev plot from README.template.md and results/*.json: change those. -->\n"


def markdown(head, lines):
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def value(name, key, result):
    """The text of one value of a result file; raises KeyError where there is none of that name."""
    facts = getattr(MODULES[name], "facts", lambda _: {})(result)
    found = {**result, **result.get("machine", {}), **facts}[key]
    return f"{found:,.0f}" if isinstance(found, (int, float)) else str(found)


def with_sections(template, results):
    """The template with the sections of the results that are there."""
    return SECTION.sub(lambda section: section[2] if section[1] in results else "", template)


def filled(template, results):
    """The template with its places filled; raises ValueError for a table that is shown nowhere, or twice."""
    template = with_sections(template, results)
    tables = {f"{name}.{key}": lines for name, result in results.items()
              for key, lines in MODULES[name].tables(result).items()}
    shown = [f"{name}.{key}" for is_table, name, key in PLACE.findall(template) if is_table]
    if sorted(shown) != sorted(tables):
        raise ValueError(f"README.template.md shows the tables {sorted(shown)}, but there are {sorted(tables)}")

    def fill(place):
        is_table, name, key = place.groups()
        return markdown(*tables[f"{name}.{key}"]) if is_table else value(name, key, results[name])

    return HEADER + PLACE.sub(fill, template)


def read_results():
    files = {name: FOLDER / "results" / f"{name}.json" for name in MODULES}
    return {name: json.loads(file.read_text()) for name, file in files.items() if name not in OPTIONAL or file.exists()}


def main(arguments):
    if arguments not in ([], ["--check"]):
        sys.exit(__doc__)
    text = filled((FOLDER / "README.template.md").read_text(), read_results())
    target = FOLDER / "README.md"
    if not arguments:
        target.write_text(text)
        print(target)
        return
    differences = list(difflib.unified_diff(target.read_text().splitlines(), text.splitlines(), "README.md", "the results",
                                            lineterm="", n=0))
    if differences:
        sys.exit("test/benchmark/README.md is not what ./dev plot makes of the results:\n" + "\n".join(differences[:40]))


if __name__ == "__main__":
    main(sys.argv[1:])

#!/usr/bin/env python3
"""Writes README.md and TABLES.md of this folder from their templates and from the results of the benchmarks, so that
no number of them is typed.

usage: tables.py                         writes both
       tables.py --check                 exit code 1, and what differs, if a page is not what would be written
       tables.py --show SUITE RESULT     prints the tables of a result file

A template has two kinds of places: {{ table SUITE.NAME }}, a line of its own, for a table of results/SUITE.json, and
{{ SUITE.NAME }} for one value of it: a key of the file, or one of facts() of SUITE_table.py, which makes its tables.
The suite `headlines` has the results of all others.
"""

import difflib
import importlib
import json
import pathlib
import re
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
SUITES = ("narrowphase", "subalgorithms", "scene", "meshes", "load", "motion", "node", "points", "sets", "stress", "sweep")
PAGES = ("README", "TABLES")
PLACE = re.compile(r"\{\{ *(table +)?(\w+)\.(\w+) *\}\}")


def module_of(suite):
    """Returns the module that makes the tables of a suite."""
    return importlib.import_module("headlines" if suite == "headlines" else f"{suite}_table")


def header(page):
    return f"<!-- Made by ./dev plot from {page}.template.md and results/*.json: change those. -->\n"


def markdown(head, lines):
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def value(suite, key, result):
    """Returns the text of one value of a result file; raises KeyError if there is none of that name."""
    facts = getattr(module_of(suite), "facts", lambda _: {})(result)
    found = {**result, **result.get("machine", {}), **facts}[key]
    return f"{found:,.0f}" if isinstance(found, (int, float)) else str(found)


def filled(templates, results):
    """Returns the templates with their places filled; raises ValueError for a table that is shown nowhere, or twice."""
    tables = {f"{suite}.{key}": lines for suite, result in results.items()
              for key, lines in module_of(suite).tables(result).items()}
    shown = [f"{suite}.{key}" for text in templates.values() for is_table, suite, key in PLACE.findall(text) if is_table]
    if sorted(shown) != sorted(tables):
        raise ValueError(f"the templates show the tables {sorted(shown)}, but there are {sorted(tables)}")

    def fill(place):
        is_table, suite, key = place.groups()
        return markdown(*tables[f"{suite}.{key}"]) if is_table else value(suite, key, results[suite])

    return {page: header(page) + PLACE.sub(fill, text) for page, text in templates.items()}


def pages():
    """Returns the text of each page by its name."""
    results = {suite: json.loads((FOLDER / f"results/{suite}.json").read_text()) for suite in SUITES}
    templates = {page: (FOLDER / f"{page}.template.md").read_text() for page in PAGES}
    return filled(templates, {**results, "headlines": results})


def write():
    for page, text in pages().items():
        target = FOLDER / f"{page}.md"
        target.write_text(text)
        print(target)


def check():
    for page, text in pages().items():
        differences = list(difflib.unified_diff((FOLDER / f"{page}.md").read_text().splitlines(), text.splitlines(), f"{page}.md",
                                                "the results", lineterm="", n=0))
        if differences:
            sys.exit(f"test/benchmark/{page}.md is not what ./dev plot makes of the results:\n" + "\n".join(differences[:40]))


def show(suite, file):
    module, result = module_of(suite), json.loads(pathlib.Path(file).read_text())
    for head, lines in [*module.tables(result).values(), *getattr(module, "details", lambda _: [])(result)]:
        lines = [head, *lines]
        widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
        print("\n".join("  ".join(text.ljust(width) for text, width in zip(line, widths)).rstrip() for line in lines) + "\n")
    if hasattr(module, "note"):
        print(module.note(result))


def main(arguments):
    if not arguments:
        write()
    elif arguments == ["--check"]:
        check()
    elif len(arguments) == 3 and arguments[0] == "--show":
        show(*arguments[1:])
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])

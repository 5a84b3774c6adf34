#!/usr/bin/env python3
"""Prints a header or a document as doxygen is to read it; the INPUT_FILTER of config/Doxyfile.

usage: doxygen_filter.py FILE     in the top folder of the repository

* Headings of a document get the anchors that browsers of the repository give them, and its links lead to pages of the site.
* The top README.md becomes the main page. It declares the sections, and a page for each other file that a document links to.
* In a header the lines of a contract ("Frame: ...") become a list.

No line moves, so that a warning names the right one.
"""

import os
import pathlib
import re
import sys

# The sections in their order, each with its documents.
SECTIONS = {
    "Tutorials": ["config/tutorials/ur5.md", "config/tutorials/*.md"],
    "The node": ["srv/README.md", "msg/README.md", "config/README.md", "config/PARAMETERS.md",
                 "config/UNCERTAINTY.md", "config/SEPARATION.md", "config/SENSED.md", "src/demo/README.md",
                 "src/node/*/README.md"],
    "Tools": ["src/tools/README.md", "src/tools/*/README.md", "test/node/clearancetest/README.md"],
    "Libraries": ["include/README.md", "src/python/README.md"],
    "Inside": ["src/README.md", "src/GLOSSARY.md", "src/narrowphase/README.md", "src/narrowphase/BOUNDS.md"],
    "Tests and benchmarks": ["test/README.md", "test/*/README.md", "test/*/TABLES.md"],
}
TOP = pathlib.Path("README.md")
SPAN = r"`[^`]+`"
BLOCK = r"^```.*?^```$|(?<=\n\n)(?: {4}[^\n]*\n|\n(?= {4}))+"  # fenced, or indented
LINK = r"(!?)\[([^][]*)\]\((?!\w+:)([^)\s#]*)(?:#([^)\s]+))?\)"


def documents(section):
    return list(dict.fromkeys(path for pattern in SECTIONS[section] for path in sorted(pathlib.Path().glob(pattern))))


def page_of(path):
    """The name of a file's page: src_tools for src/tools/README.md."""
    if path == TOP:
        return "index"
    return re.sub(r"\W", "_", str(path.parent if path.name == TOP.name else path))


def target_of(document, file):
    """The file that a link of a document leads to; None for a folder without README.md."""
    path = pathlib.Path(os.path.relpath(document.parent / file)) if file else document
    if path.is_dir():
        return path / TOP.name if (path / TOP.name).exists() else None
    return path


def other_files():
    """All that documents link to, and that are none."""
    for document in [TOP, *(path for section in SECTIONS for path in documents(section))]:
        for image, _, file, _ in re.findall(LINK, document.read_text()):
            path = target_of(document, file)
            if path and path.suffix != ".md" and path.is_file() and not image:
                yield path


def sections():
    """The pages of the sections, and of other files."""
    pages = {section: [page_of(path) for path in documents(section)] for section in SECTIONS}
    files = sorted(set(other_files()))
    pages["Other files"] = [page_of(path) for path in files]
    names = {section: "section_" + re.sub(r"\W", "_", section) for section in pages if pages[section]}
    for name in names.values():
        yield f"* \\subpage {name}\n"
    for section, name in names.items():
        yield f"\\page {name} {section}\n" + "".join(f"* \\subpage {page}\n" for page in pages[section])
    for path in files:
        yield f"\\page {page_of(path)} {path}\n\\verbatim\n{path.read_text()}\\endverbatim\n"


def outside(pattern, change, text):
    """The text, changed where the pattern does not match."""
    kept = re.findall(pattern, text, re.MULTILINE | re.DOTALL)
    changed = map(change, re.split(pattern, text, flags=re.MULTILINE | re.DOTALL))
    return "".join(part for pair in zip(changed, [*kept, ""]) for part in pair)


def escaped(text):
    """Doxygen would take <collision> for a tag of HTML, and end a span of code at an apostrophe."""
    text = outside(SPAN, lambda prose: re.sub(r"<(?=/?\w)", r"\\<", prose), text)
    return re.sub(SPAN, lambda span: f"`{span[0]}`" if "'" in span[0] else span[0], text)


def document_of(path):
    page, seen = page_of(path), []

    def link(match):
        image, text, file, anchor = match.groups()
        target = target_of(path, file)
        if image:
            return f"![{text}]({target})"
        if target is None:
            return text
        return f"[{text}]({page_of(target)}.html" + (f"#{page_of(target)}-{anchor})" if anchor else ")")

    def heading(match):
        if match[1] == "#":
            return f"{match[0]} {{#{'mainpage' if path == TOP else page}}}"
        seen.append(re.sub(r"[^\w\- ]", "", match[2].lower()).replace(" ", "-"))
        number = seen.count(seen[-1]) - 1
        return f"{match[0]} {{#{page}-{seen[-1]}" + (f"-{number}}}" if number else "}")

    def prose(text):
        text = re.sub(r"<!--.*?-->", "", text)
        return re.sub(r"(?m)^(#+) (.*)$", heading, re.sub(LINK, link, escaped(text)))

    return outside(BLOCK, prose, path.read_text()) + ("\n" + "".join(sections()) if path == TOP else "")


def header_of(path):
    text = re.sub(r"(?m)^( */// )(?=[A-Z]\w+: )", r"\1- ", path.read_text())
    return re.sub(r"(?m)///.*$", lambda comment: escaped(comment[0]), text)


if __name__ == "__main__":
    file = pathlib.Path(os.path.relpath(sys.argv[1]))
    sys.stdout.write(document_of(file) if file.suffix == ".md" else header_of(file))

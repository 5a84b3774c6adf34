#!/usr/bin/env python3
"""Builds the site of config/Doxyfile, and checks it.

usage: make_docs.py FOLDER     in the top folder of the repository; FOLDER gets the site

Prints the warnings of doxygen, and every link of the site that leads to no page, to no anchor of a page, or loads something from
elsewhere. Exit code 0 if there is none.
"""

import html.parser
import pathlib
import re
import subprocess
import sys
import urllib.parse
import xml.etree.ElementTree as ElementTree


class Page(html.parser.HTMLParser):
    """The anchors and the links of a page, and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors.update(filter(None, (attributes.get("id"), attributes.get("name"))))
        (self.links if tag == "a" else self.loaded).extend(filter(None, (attributes.get("href"), attributes.get("src"))))


def broken_links(site):
    """(page, link) of each link that is broken."""
    pages = {path.name: Page(path) for path in site.glob("*.html")}
    for name, page in sorted(pages.items()):
        yield from ((name, link) for link in page.loaded if re.match(r"https?:|//", link))
        for link in [*page.links, *page.loaded]:
            if re.match(r"\w+:", link):
                continue
            file, _, anchor = urllib.parse.unquote(link).partition("#")
            file = file or name
            if anchor == "nested-classes":  # doxygen itself writes it, for private ones too, which it leaves out
                continue
            if not (site / file).exists() or (anchor and file in pages and anchor not in pages[file].anchors):
                yield name, link


def build(site):
    """Returns the exit code of doxygen."""
    site.mkdir(parents=True, exist_ok=True)
    for path in site.glob("*.html"):
        path.unlink()  # a page of before must not serve a link
    settings = {"PROJECT_NUMBER": ElementTree.parse("package.xml").findtext("version"), "OUTPUT_DIRECTORY": site, "HTML_OUTPUT": ".",
                "WARN_AS_ERROR": "FAIL_ON_WARNINGS"}
    own = "".join(f"{name} = {value}\n" for name, value in settings.items())
    return subprocess.run(["doxygen", "-"], input="@INCLUDE = config/Doxyfile\n" + own, text=True, check=False).returncode


if __name__ == "__main__":
    site = pathlib.Path(sys.argv[1]).resolve()
    code = build(site)
    broken = list(broken_links(site))
    for page, link in broken:
        print(f"{page}: the link {link} is broken", file=sys.stderr)
    sys.exit(1 if code or broken else 0)

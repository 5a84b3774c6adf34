#!/usr/bin/env python3
"""Builds the site of ./dev docs: it has no warning and no broken link, and both are found where there is one.

usage: docs_test.py SOURCE_DIR --gtest_output=xml:FILE
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import rosunit
import yaml

SOURCE = pathlib.Path(sys.argv[1]).resolve()
HEADER = """namespace small {
/// The result of add().
struct Sum {
  int value;
};
/// Adds.
/// @param a  the first one
/// @param b  the second one
Sum add(int a, int b);
}
"""


class Docs(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()

    def built(self, source):
        """The exit code, and what was printed."""
        result = subprocess.run([sys.executable, source / "src/docs/make_docs.py", self.folder / "site"], cwd=source,
                                capture_output=True, text=True, check=False)
        return result.returncode, result.stdout + result.stderr

    def small(self, readme="# Small\n\n## One of two\n", header=HEADER):
        """What is built of a repository that has a README.md, a page about its messages and a header."""
        source = self.folder / "small"
        shutil.copytree(SOURCE / "src/docs", source / "src/docs")
        for name in ("config", "include", "msg", "srv", "test"):
            (source / name).mkdir()
        for name in ("config/Doxyfile", "package.xml"):
            shutil.copy(SOURCE / name, source / name)
        (source / "README.md").write_text(readme)
        (source / "msg/README.md").write_text("# Messages\n\n## Of the node\n\nSee [the top](../README.md#one-of-two).\n\n## One of two\n")
        (source / "msg/Small.msg").write_text("int32 small\n")
        (source / "include/sum.h").write_text(header)
        return self.built(source)

    def text_of(self, page):
        return (self.folder / "site" / page).read_text()

    def test_the_site_has_no_warning_and_no_broken_link(self):
        self.assertEqual((0, ""), self.built(SOURCE))
        self.assertIn("<td><code>minimum_distance</code>", self.text_of("index.html").replace(' class="markdownTableBodyNone"', ""))
        tree = "".join(path.read_text() for path in (self.folder / "site").glob("*.js"))
        self.assertIn('"Services of the node", "srv.html"', tree)

    def test_links_lead_to_headings_of_other_pages_and_to_files(self):
        readme = "# Small\n\nSee [its\nnode](msg/README.md#of-the-node), [`Small`](msg/Small.msg), [all](msg).\n\n## One of two\n"
        self.assertEqual((0, ""), self.small(readme))
        for target in ("msg.html#msg-of-the-node", "msg_Small_msg.html", "msg.html"):
            self.assertIn(f'href="{target}"', self.text_of("index.html"))
        self.assertIn("int32 small", self.text_of("msg_Small_msg.html"))
        self.assertIn('href="index.html#index-one-of-two"', self.text_of("msg.html"))

    def test_tags_of_others_and_quotes_in_code_are_text(self):
        self.assertEqual((0, ""), self.small("# Small\n\nA <collision>, `a <link>` and `it's`.\n\n## One of two\n"))
        for text in ("A &lt;collision&gt;", "<code>a &lt;link&gt;</code>", "<code>it's</code>"):
            self.assertIn(text, self.text_of("index.html"))

    def test_a_link_to_no_file_and_one_to_no_heading_are_found(self):
        code, printed = self.small("# Small\n\nSee [this](msg/gone.md) and [that](msg/README.md#gone).\n\n## One of two\n")
        self.assertEqual(1, code)
        self.assertIn("index.html: the link msg_gone_md.html is broken", printed)
        self.assertIn("index.html: the link msg.html#msg-gone is broken", printed)

    def test_a_picture_from_elsewhere_is_found(self):
        code, printed = self.small("# Small\n\n![picture](https://example.org/picture.png)\n\n## One of two\n")
        self.assertEqual(1, code)
        self.assertIn("the link https://example.org/picture.png is broken", printed)

    def test_a_parameter_that_is_not_documented_is_a_warning(self):
        code, printed = self.small(header=HEADER.replace("@param b  the second one", "It is fast."))
        self.assertEqual(1, code)
        self.assertIn("include/sum.h:", printed)
        self.assertIn("parameter 'b'", printed)

    def test_every_document_has_its_place_in_a_section(self):
        script = "import doxygen_filter as site; print(*(path for section in site.SECTIONS for path in site.documents(section)))"
        listed = subprocess.check_output([sys.executable, "-B", "-c", script], cwd=SOURCE, text=True, env={"PYTHONPATH": "src/docs"})
        found = [str(path.relative_to(SOURCE)) for folder in ("config", "include", "msg", "srv", "src", "test")
                 for path in (SOURCE / folder).rglob("*.md") if ".template" not in path.name]
        self.assertEqual(sorted(found), sorted(listed.split()))

    def test_rosdoc_lite_has_the_same_settings(self):
        builder, = yaml.safe_load((SOURCE / "config/rosdoc.yaml").read_text())
        self.assertIn('<rosdoc config="config/rosdoc.yaml"/>', (SOURCE / "package.xml").read_text())
        settings = self.folder / "Doxyfile"
        settings.write_text(f"INPUT = elsewhere\nPREDEFINED = {builder['predefined']}\nTAGFILES =\n")
        ours, theirs = (subprocess.check_output(["doxygen", "-x", path], cwd=SOURCE, text=True) for path in ("config/Doxyfile", settings))
        self.assertEqual(ours, theirs)
        self.assertIn("doxygen_filter.py", theirs)


def write_skipped(path):
    """Writes the result of one case that is skipped; rosunit would count it as passed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text('<testsuite name="Docs"><testcase classname="Docs" name="build"><skipped>there is no doxygen: ./dev packages docs'
                    '</skipped></testcase></testsuite>')


if __name__ == "__main__":
    if shutil.which("doxygen"):
        rosunit.unitrun("proximity_server", "docs_test", Docs)
    else:
        write_skipped(pathlib.Path(sys.argv[2].replace("--gtest_output=xml:", "")))

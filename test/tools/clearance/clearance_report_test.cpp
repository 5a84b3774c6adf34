// --report of the executable. A script reads the page as XML, and compares it with rows and with numbers on paper.
#include "sanitized.h"
#include "tools/program/clearance_command.h"
#include "tools/text/content_hash.h"

#include <filesystem>

namespace proximity_server::tools::clearance_report_test {

using namespace scene;

// table(head): the rows of the table below a heading, by their first column. Requires a page that an XML parser and an
// HTML parser accept, with unique ids and without links to other files.
const char* const kReadPage = R"py(
import csv, html.parser, re, sys, xml.etree.ElementTree as tree
written = open(sys.argv[1], encoding="utf-8").read()
root = tree.fromstring(written)
class Tags(html.parser.HTMLParser):
    open_tags = []
    def handle_starttag(self, tag, attributes):
        self.open_tags.append(tag)
    def handle_startendtag(self, tag, attributes):
        pass
    def handle_endtag(self, tag):
        assert self.open_tags.pop() == tag
parser = Tags()
parser.feed(written)
assert not parser.open_tags
ids = re.findall(r'\sid="([^"]*)"', written)
assert len(ids) == len(set(ids)) > 10
links = set(re.findall(r'(?:url\(|href=")([^")]*)', written))
inside = {link for link in links if link.startswith("data:image/png;base64,")} | {"#" + name for name in ids}
assert links <= inside, "all links lead into the page"
assert "src=" not in written and "@import" not in written and "<script" not in written
assert "viewport" in written and "@media print" in written
body = list(root.find("{*}body"))
def text(element):
    return "".join(element.itertext()).strip()
def part(head):
    at = [text(element) for element in body].index(head)
    after = next((i for i, element in enumerate(body) if i > at and element.tag.endswith("h2")), len(body))
    return body[at + 1:after]
def words(head):
    return " ".join(text(element) for element in part(head))
def table(head):
    rows = [row for element in part(head) for row in element.iter("{http://www.w3.org/1999/xhtml}tr")]
    cells = [[text(cell).replace("\u2212", "-") for cell in row] for row in rows]
    return {row[0]: row[1:] for row in cells}
def moments():
    heads = [text(head).replace("\u2212", "-") for head in root.iter("{http://www.w3.org/1999/xhtml}h3")]
    return [head.split(". ", 1)[1] for head in heads]
)py";

class ClearanceReportTest : public Clearance {
 protected:
  void SetUp() override {
    if (runCommand("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null").exit_code != 0)
      GTEST_SKIP() << "python3-matplotlib is not installed";
  }

  CommandResult report(const std::string& states, const std::string& arguments) {
    return run(states, arguments + " --report " + page_);
  }

  /// Runs Python with what kReadPage defines; sys.argv[2] are the rows.
  void expectPage(const std::string& assertions, const std::string& rows = "") {
    const std::string script = files_.write("check.py", kReadPage + assertions);
    const CommandResult result = runCommand("/usr/bin/python3 " + script + " " + page_ + " " + rows + " 2>&1");
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }

  std::string page_ = files_.path("report.html");
};

// The smallest distance of each pair, its first state and the worst moments are those of the rows of --pairs all.
TEST_F(ClearanceReportTest, HasThePairsOfAllRows) {
  const std::string states = wander(300) + "-1.5\n-1.5\n";
  const std::string rows = files_.write("rows.csv", run(states, "--no-filter --pairs all").output);
  ASSERT_EQ(report(states, "--no-filter").exit_code, 0);
  expectPage(R"py(
smallest = {}
for row in csv.DictReader(open(sys.argv[2])):
    pair, distance = row["link_a"] + " \u2013 " + row["link_b"], float(row["distance"])
    if pair not in smallest or distance < smallest[pair][0]:
        smallest[pair] = distance, row["state"], float(row["lower"])
found = table("All pairs")
assert len(smallest) == 5 and set(found) == {"pair", *smallest}, found
for pair, (distance, state, lower) in smallest.items():
    assert abs(float(found[pair][0]) - 1e3 * distance) < 6e-4 and abs(float(found[pair][1]) - 1e3 * lower) < 6e-4
    assert found[pair][2] == "state " + state, (pair, found[pair], state)
order = sorted(smallest, key=lambda pair: smallest[pair][0])
assert moments() == [f"{pair}: {found[pair][0]} mm" for pair in order[:5]], moments()
)py",
             rows);
}

TEST_F(ClearanceReportTest, SharesAreThoseOfTheRows) {
  const std::string states = wander(200) + "1.7e308\n", thresholds = files_.write("t.yaml",
                                                                                  "stop_distance: 0.5\n"
                                                                                  "warn_distance: 1.25\n");
  const std::string arguments = "--no-filter --thresholds " + thresholds;
  const std::string rows = files_.write("rows.csv", run(states, arguments).output);
  ASSERT_EQ(report(states, arguments).exit_code, 0);
  expectPage(R"py(
rows = list(csv.DictReader(open(sys.argv[2])))
found = table("Share of the states")
for level in ("CLEAR", "WARN", "STOP", "COLLISION"):
    count = sum(row["level"] == level for row in rows)
    assert count > 9 and found["level " + level] == [f"{100 * count / 201:.2f} %", f"{count} of 201"], (level, found)
assert found["without an answer (INVALID)"][1] == "1 of 201"
near = sum(float(row["lower"]) <= 0.1 for row in rows if row["level"] != "INVALID")
assert found["at 100 mm or below"][1] == f"{near} of 201"
assert text(body[1]).startswith("Closest: ") and ", COLLISION, state " in text(body[1])
)py",
             rows);
}

// On paper: sled to base 1 + slide, ball to sled 2.25 + slide, ball to base 4.25 + 2 slide.
TEST_F(ClearanceReportTest, KnowsTheMinimumOfEachPairAlongATrajectory) {
  ASSERT_EQ(report("time,slide\n0,0\n4,-0.5\n6,1\n", "--trajectory --no-filter").exit_code, 0);
  expectPage(R"py(
found = table("All pairs")
for pair, distance in (("base \u2013 sled, left", 500.0), ("ball \u2013 sled, left", 1750.0), ("base \u2013 ball", 3250.0)):
    assert abs(float(found[pair][0]) - distance) < 2e-3 and float(found[pair][1]) <= distance, found
    assert found[pair][2].startswith(("4 s (segment", "3.9999")), found
assert found["sled, left \u2013 mast"][2].endswith("(segment 0)")
assert table("Share of the time")["at 100 mm or below"] == ["0.00 %", "0 of 6 s"]
assert moments()[0] == "base \u2013 sled, left: " + found["base \u2013 sled, left"][0] + " mm"
)py");
}

// Base and sled are nearer than 0.8 m from 1.6 s to 4.4 s, and nearer than 0.6 m from 3.2 s to 4.133 s. A whole part of a
// segment counts: 1/16 s of the first one, 1/32 s of the second one.
TEST_F(ClearanceReportTest, SharesAlongATrajectoryAreThoseOfItsParts) {
  const std::string thresholds = files_.write("t.yaml", "{stop_distance: 0.6, warn_distance: 0.8}");
  ASSERT_EQ(report("time,slide\n0,0\n4,-0.5\n6,1\n", "--trajectory --no-filter --thresholds " + thresholds).exit_code,
            0);
  expectPage(R"py(
shares = table("Share of the time")
assert shares["level STOP"][1] == "0.96875 of 6 s", shares
assert shares["level WARN"][1] == "1.875 of 6 s", shares
assert shares["level CLEAR"][1] == "3.15625 of 6 s", shares
assert ", STOP, " in text(body[1]) and "stop distance" in written and "of their own" not in written
)py");
}

TEST_F(ClearanceReportTest, TellsWhoseThresholdsTheLinesAreAndGoesWithAPlot) {
  const std::string own = "pair_stop_distance: [{links: [base, ball], distance: 0.01}]";
  const std::string picture = files_.path("plot.png");
  const std::string arguments =
      "--trajectory --no-filter --thresholds " + files_.write("t.yaml", own) + " --plot " + picture;
  ASSERT_EQ(report("slide\n0\n-0.5\n", arguments).exit_code, 0);
  expectPage(R"py(
assert "The lines are the thresholds of two links without thresholds of their own." in written
)py");
  EXPECT_TRUE(std::filesystem::exists(picture));
}

TEST_F(ClearanceReportTest, CountsWhatIsBeyondLimitsAndNeverChecked) {
  ASSERT_EQ(report("slide\n0\n2.5\n3\n-0.5\n", "").exit_code, 0);
  expectPage(R"py(
assert words("States beyond limits").endswith('s.csv: 2 of 4 states are beyond the limits of a joint. The first is state 1, '
                                              'line 3: "slide" is at 2.5 m, its limits are -1 and 2 m.')
assert "adjacent: 2base \u2013 ball; base \u2013 sled, left" in words("Pairs never checked")
assert "same body: 1" in words("Pairs never checked")
)py");
}

// The column of lower bounds then holds for all states within the uncertainty: it is 0.25 below the distance.
TEST_F(ClearanceReportTest, LowerBoundsHoldWithinTheUncertainty) {
  ASSERT_EQ(report("slide\n0\n1\n", "--joint-uncertainty 0.25 --pairs all").exit_code, 0);
  expectPage(R"py(
smallest, proven, first = table("All pairs")["ball \u2013 sled, left"][:3]
assert smallest == "2250.000" and 1999.9 < float(proven) <= 2000.0 and first == "state 0", (smallest, proven)
assert table("What was checked")["joint uncertainty"] == ["0.25"]
)py");
}

TEST_F(ClearanceReportTest, ShowsObjectsAndTheLinksThatTheyMayTouch) {
  const std::string objects = files_.write("cell.yaml", R"py(
objects:
- {id: ground, primitives: [{type: BOX, dimensions: [20, 20, 0.1]}], pose: {position: [0, 0, -2.05]}}
- {id: tool, primitives: [{type: SPHERE, dimensions: [0.1]}], link: ball, pose: {position: [0, 0, 1]}, touch_links: ["sled, left"]}
)py");
  const CommandResult result = report("slide\n0\n", "--objects " + objects);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  expectPage(R"py(
assert abs(float(table("All pairs")["ball \u2013 ground"][0]) - 1750.0) < 1e-3
assert "sled, left \u2013 tool" in words("Pairs never checked") and "ball \u2013 tool" in words("Pairs never checked")
assert "ground" not in words("Pairs never checked").replace("base \u2013 ground", "").replace("mast \u2013 ground", "")
)py");
}

TEST_F(ClearanceReportTest, ThePairOfTheWorstLevelNeedNotBeTheClosest) {
  const std::string pair = ": [{links: [ball, \"sled, left\"], distance: ";
  const std::string thresholds = files_.write("t.yaml", "stop_distance: 0.1\nwarn_distance: 0.2\npair_stop_distance" +
                                                            pair + "3}]\npair_warn_distance" + pair + "4}]\n");
  const CommandResult result = report("slide\n0\n", "--no-filter --thresholds " + thresholds);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  expectPage(R"py(
assert text(body[1]) == "Worst level: ball \u2013 sled, left, 2250.000 mm, STOP, state 0."
assert text(body[2]) == "Closest: base \u2013 sled, left, 1000.000 mm, CLEAR, state 0."
assert moments()[:2] == ["ball \u2013 sled, left: 2250.000 mm", "base \u2013 sled, left: 1000.000 mm"]
)py");
}

// The time is that of the bag or the table, with enough digits for a stamp.
TEST_F(ClearanceReportTest, TellsTheTimeOfAState) {
  ASSERT_EQ(report("time,slide\n1764255600.25,0\n1764255600.75,-0.5\n", "--pairs all").exit_code, 0);
  expectPage(R"py(
assert table("All pairs")["ball \u2013 sled, left"][2] == "state 1 (1764255600.75 s)"
)py");
}

TEST_F(ClearanceReportTest, HashesTheFilesOfTheQuestion) {
  const std::string thresholds = files_.write("t.yaml", "stop_distance: 0.5\nwarn_distance: 1\n");
  ASSERT_EQ(report("slide\n0\n", "--thresholds " + thresholds).exit_code, 0);
  expectPage(
      "asked = table('What was checked')\n"
      "assert asked['URDF'] == ['" +
      urdf_ + ", hash " + contentHash(urdf_) +
      "'], asked\n"
      "assert asked['thresholds'][0].endswith('" +
      contentHash(thresholds) + "')\n");
}

TEST_F(ClearanceReportTest, TheSameInputGivesTheSameBytes) {
  if (kIsSanitized) GTEST_SKIP() << "the other tests make the same pages";
  for (const std::string arguments : {"--no-filter --threads 2", "--no-filter --trajectory --threads 2"}) {
    ASSERT_EQ(report(wander(600), arguments).exit_code, 0);
    const std::string first = readFile(page_);
    ASSERT_EQ(report(wander(600), arguments).exit_code, 0);
    EXPECT_EQ(readFile(page_), first);
    expectPage("");
  }
}

TEST_F(ClearanceReportTest, RowsKeepTheirBytes) {
  if (kIsSanitized) GTEST_SKIP() << "the other tests make the same pages";
  for (const std::string arguments :
       {"", "--no-filter --pairs all", "--pairs any:1", "--accuracy 1e-4", "--no-skip --format json",
        "--joint-uncertainty 0.01", "--trajectory --tracking-error 0.01"}) {
    const CommandResult plain = run(wander(300), arguments), with_report = report(wander(300), arguments);
    EXPECT_EQ(with_report.exit_code, 0) << arguments << with_report.errors;
    EXPECT_EQ(with_report.output, plain.output) << arguments;
    EXPECT_EQ(with_report.errors, plain.errors) << arguments;
  }
}

// Names may contain whatever a URDF may: markup, quotes, and the dollars of matplotlib's formulas.
TEST_F(ClearanceReportTest, NamesAreTextOnly) {
  std::string urdf = kTwoSliders;
  for (std::size_t at = 0; (at = urdf.find("\"ball\"", at)) != std::string::npos;)
    urdf.replace(at, 6, "\"&lt;b&gt;&amp;$\\frac&quot;'--&gt; \xe6\xbc\xa2\"");
  urdf_ = files_.write("names.urdf", urdf);
  for (const std::string arguments : {"--no-filter", "--trajectory --no-filter"}) {
    const CommandResult result = report("slide\n0\n1\n", arguments);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    expectPage(
        "assert 'base \\u2013 <b>&$\\\\frac\"\\'--> \\u6f22' in table('All pairs'), table('All pairs')\n"
        "assert any(text(element) == '<b>&$\\\\frac\"\\'--> \\u6f22' for element in\n"
        "           root.iter('{http://www.w3.org/2000/svg}text')), 'the matrix has it too'\n");
  }
}

TEST_F(ClearanceReportTest, AStateWithoutAnAnswerIsNamed) {
  ASSERT_EQ(report("slide\n1.7e308\n", "").exit_code, 0);
  const std::string script = files_.write("check.py",
                                          "import sys, xml.etree.ElementTree as tree\n"
                                          "tree.parse(sys.argv[1])\n");
  EXPECT_EQ(runCommand("/usr/bin/python3 " + script + " " + page_).exit_code, 0);
  EXPECT_TRUE(says(readFile(page_), "No pair has an answer in any state."));
}

TEST_F(ClearanceReportTest, TellsWhatWasAskedAndHow) {
  const CommandResult result = report("slide\n0\n", "--no-filter --assert-above 1.5");
  EXPECT_EQ(result.exit_code, 2);
  expectPage(R"py(
assert "--no-filter --assert-above 1.5 --report " + sys.argv[1] in words("The command"), words("The command")
assert "not proven to be above 1.5 m" in " ".join(text(element) for element in body)
assert table("What was checked")["robot"] == ["two sliders"]
assert table("What was checked")["tolerances"] == ["pieces 5.000 mm from their meshes; distances 1e-06 mm"]
assert table("Geometry")["ball"] == ["sphere, radius 0.25", "exact", "1", "0.000", "0.000"]
)py");
}

TEST_F(ClearanceReportTest, FindsOutBeforeTheFirstStateThatThereWillBeNoPage) {
  const auto expect = [&](const std::string& prefix, const std::string& page, const std::string& part) {
    const CommandResult result =
        runCommandApart("printf 'slide\\n0\\n' | " + prefix + CLEARANCE " " + urdf_ + " --report " + page);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.output, "");
    EXPECT_TRUE(says(result.errors, part)) << result.errors;
  };
  expect("", "/nodir/x.html", "clearance: --report: /nodir/x.html: cannot be written (No such file or directory)");
  expect("", files_.path("x.pdf"), "x.pdf: the name does not end in .html");
  files_.write("broken/matplotlib.py", "raise ImportError('matplotlib is broken')");
  expect("PYTHONPATH=" + files_.path("broken") + " ", page_,
         "--report: /usr/bin/python3 cannot use matplotlib (Debian package python3-matplotlib)");
  EXPECT_FALSE(std::filesystem::exists(page_));
}

}  // namespace proximity_server::tools::clearance_report_test

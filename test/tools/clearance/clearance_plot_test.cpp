// --plot of the executable. What a picture shows is asked of the script that draws it.
#include "tools/program/clearance_command.h"

namespace proximity_server::tools::clearance_plot_test {

using namespace scene;

class ClearancePlotTest : public Clearance {
 protected:
  void SetUp() override {
    if (runCommand("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null").exit_code != 0) {
      GTEST_SKIP() << "python3-matplotlib is not installed";
    }
  }

  /// How a file begins.
  static std::string beginOf(const std::string& file) { return readFile(file).substr(0, 5); }
};

TEST_F(ClearancePlotTest, DrawsStatesAndSegments) {
  const std::string png = files_.path("it's a plot.png");
  for (const std::string arguments : {"--pairs all", "--trajectory"}) {
    std::filesystem::remove(png);
    const CommandResult result = run(wander(100), "--no-filter " + arguments + " --plot \"" + png + "\"");
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_GT(std::filesystem::file_size(png), 1000U);
  }
}

// The ball of the two sliders is at 5 + 2 slide.
TEST_F(ClearancePlotTest, AStateWithoutAnAnswerIsAGapInThePicture) {
  const std::string png = files_.path("plot.png");
  const CommandResult some = run("slide\n0\n1.7e308\n", "--pairs k:2 --plot " + png);
  EXPECT_EQ(some.exit_code, 0) << some.errors;
  EXPECT_GT(std::filesystem::file_size(png), 1000U);
  EXPECT_FALSE(says(some.errors, "Warning")) << some.errors;
  const CommandResult none = run("slide\n1.7e308\n", "--pairs k:2 --plot " + png);
  EXPECT_TRUE(says(none.errors, "no pair was listed in any state: nothing to draw")) << none.errors;
  EXPECT_FALSE(says(none.errors, "Traceback")) << none.errors;
}

TEST_F(ClearancePlotTest, TheSuffixSaysTheFormat) {
  for (const auto& [suffix, begin] :
       std::vector<std::pair<std::string, std::string>>{{"png", "\x89PNG\r"}, {"PDF", "%PDF-"}, {"svg", "<?xml"}}) {
    const std::string picture = files_.path("plot." + suffix);
    EXPECT_EQ(run(wander(10), "--plot " + picture).exit_code, 0);
    EXPECT_EQ(beginOf(picture), begin);
  }
}

TEST_F(ClearancePlotTest, FindsOutBeforeTheFirstStateThatThereWillBeNoPicture) {
  const auto expect = [&](const std::string& prefix, const std::string& picture, const std::string& part) {
    const CommandResult result =
        runCommandApart("printf 'slide\\n0\\n' | " + prefix + CLEARANCE " " + urdf_ + " --plot " + picture);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.output, "");
    EXPECT_TRUE(says(result.errors, part)) << result.errors;
    EXPECT_FALSE(says(result.errors, "Traceback")) << result.errors;
  };
  const std::string picture = files_.path("plot.png");
  expect("", "/nodir/x.png", "clearance: --plot: /nodir/x.png: cannot be written (No such file or directory)");
  expect("", files_.path("x.gif"), "x.gif: the name ends in none of .png, .pdf and .svg");
  files_.write("broken/matplotlib.py", "raise ImportError('matplotlib is broken')");
  expect("PYTHONPATH=" + files_.path("broken") + " ", picture,
         "/usr/bin/python3 cannot use matplotlib (Debian package python3-matplotlib)");
  EXPECT_FALSE(std::filesystem::exists(picture));
}

TEST_F(ClearancePlotTest, APictureThatThereIsStaysWhereTheInputIsBad) {
  const std::string picture = files_.write("plot.png", "an old picture");
  EXPECT_EQ(run("elbow\n0\n", "--plot " + picture).exit_code, 1);
  EXPECT_EQ(readFile(picture), "an old picture");
}

// In the coordinates of the picture: the marks of contacts end below whatever belongs to the curve.
TEST_F(ClearancePlotTest, MarksOfContactsDoNotLieOverTheCurve) {
  const std::string rows =
      files_.write("rows.csv", run("time,slide\n10,0\n14,-2\n15,2\n16,1\n", "--trajectory --no-filter").output);
  const std::string script = files_.write("check.py", R"(
import sys
import matplotlib.collections
import numpy
sys.path.insert(0, sys.argv[1])
import clearance_plot
rows = clearance_plot.read_rows(sys.argv[2])
assert "true" in [row["contact"] for row in rows]
panel = clearance_plot.draw(rows, 0.0).axes[0]
panel.figure.canvas.draw()
height = panel.get_ylim()
lowest = min(float(row["lower"]) for row in rows)
share = (lowest - height[0]) / (height[1] - height[0])
bars = "BrokenBarHCollection" if hasattr(matplotlib.collections, "BrokenBarHCollection") else "PolyCollection"
marks = [box for box in panel.collections if type(box).__name__ == bars]
assert len(marks) == 1
tops = [path.vertices[:, 1].max() for path in marks[0].get_paths()]
assert max(tops) < share, (tops, share)
assert all(len(line.get_paths()) and numpy.ptp(line.get_paths()[0].vertices[:, 1]) == 0.0
           for line in panel.collections if type(line).__name__ == "LineCollection"), "no upright lines"
)");
  const CommandResult result = runCommand("/usr/bin/python3 " + script + " $(dirname " CLEARANCE ") " + rows + " 2>&1");
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

}  // namespace proximity_server::tools::clearance_plot_test

// --plot of the executable. What a picture shows is asked of the script that draws it.
#include "tools/explain/explain_command.h"

#include <filesystem>

namespace proximity_server::tools::explain_plot_test {

class ExplainPlot : public ::testing::Test {
 protected:
  void SetUp() override {
    if (runCommand("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null").exit_code != 0) {
      GTEST_SKIP() << "python3-matplotlib is not installed";
    }
  }

  /// Draws without a word on standard error.
  void expectPicture(const std::string& arguments) {
    std::filesystem::remove(picture_);
    const CommandResult result = explainCommand(arguments + " --plot '" + picture_ + "'");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.errors, "") << arguments;
    ASSERT_TRUE(std::filesystem::exists(picture_)) << arguments;
    EXPECT_GT(std::filesystem::file_size(picture_), 3000U);
    EXPECT_LT(std::filesystem::file_size(picture_), 100000U);
  }

  /// The file with the data that the tool gives to the script.
  std::string dataOf(const std::string& arguments) {
    std::string data = files_.path("data.json");
    files_.write("explain_plot.py",
                 "import sys, shutil\nif len(sys.argv) > 1: shutil.copy(sys.argv[1], '" + data + "')\n");
    std::filesystem::copy_file(EXPLAIN, files_.path("explain"), std::filesystem::copy_options::overwrite_existing);
    const CommandResult copied =
        runCommandApart("LD_LIBRARY_PATH=$(dirname " EXPLAIN ")/..:$LD_LIBRARY_PATH " + files_.path("explain") + " " +
                        arguments + " --plot " + files_.path("x.png"));
    EXPECT_EQ(copied.exit_code, 0) << copied.errors;
    return data;
  }

  /// Runs a script of Python with the folder of the tool and the data of a query.
  void expectScript(const std::string& script, const std::string& arguments) {
    const std::string data = dataOf(arguments);
    const CommandResult result = runCommand("/usr/bin/python3 -B " + files_.write("check.py", script) + " $(dirname " +
                                            EXPLAIN + ") " + data + " 2>&1");
    EXPECT_EQ(result.exit_code, 0) << arguments << "\n" << result.output;
  }

  scene::TemporaryFiles files_;
  std::string picture_ = files_.path("it's a plot.png");
};

TEST_F(ExplainPlot, DrawsFlatAndSolidPairs) {
  picture_ = files_.path("plot.png");
  expectPicture(kFourSteps);
  expectPicture(kPolygons);
  expectPicture(kOctahedron);
}

TEST_F(ExplainPlot, DrawsCurvedPairsClosedFormsAndPoints) {
  picture_ = files_.path("plot.png");
  expectPicture("'ellipsoid 0.1 0.2 0.3' 'cone 0.2 0.4' --xyz '0.1 0.2 0.1' --rpy '0.5 0.3 0.1'");
  expectPicture("'box 1 1 1' 'box 1 2 3' --xyz '0.1 0.2 0.3'");
  expectPicture("'sphere 1' 'sphere 1' --xyz '3 0 0'");
  expectPicture("'hull 2 0 0 0 1 0 0' 'hull 1 0 0 0' --xyz '0 1 0'");
  expectPicture("'hull 1 0 0 0' 'hull 1 0 0 0'");
}

TEST_F(ExplainPlot, TheSuffixSaysTheFormat) {
  picture_ = files_.path("plot.svg");
  EXPECT_EQ(explainCommand(std::string(kPolygons) + " --plot " + picture_).exit_code, 0);
  EXPECT_EQ(readFile(picture_).substr(0, 5), "<?xml");
}

TEST_F(ExplainPlot, FindsOutBeforeTheQueryThatThereWillBeNoPicture) {
  const CommandResult result = explainCommand(std::string(kPolygons) + " --plot /nodir/x.png");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.output, "");
  EXPECT_EQ(result.errors, "explain: --plot: /nodir/x.png: cannot be written (No such file or directory)\n");
}

// Looks at the data of the script: every panel has its step, names lie apart, and the sampled CSO of the polygons is
// the one on paper (narrowphase_gjk_epa_test, WorkedExample).
TEST_F(ExplainPlot, ShowsEveryStepAndNamesThatLieApart) {
  const std::string script = R"(
import json, sys
import numpy
sys.path.insert(0, sys.argv[1])
import explain_plot
data = json.load(open(sys.argv[2]))
figure = explain_plot.draw(data)
titles = [axes.get_title() for axes in figure.axes]
steps = [f"GJK {i}" for i in range(1, 1 + len(data["gjk"]))] + [f"EPA {i}" for i in range(1, 1 + len(data["epa"]))]
assert [title.split(":")[0] for title in titles] == ["a and b"] + steps + ["bounds of the distance [m]"], titles
figure.canvas.draw()
renderer = figure.canvas.get_renderer()
for axes, step in zip(figure.axes[1:], data["gjk"] + data["epa"]):
    boxes = [text.get_window_extent(renderer) for text in axes.texts if text.get_text()]
    named = {step["vertex"], *(step["simplex"] if "simplex" in step else step["closest"])}
    missing = {data["vertices"][vertex]["name"] for vertex in named} - {text.get_text() for text in axes.texts}
    assert not missing, (axes.get_title(), missing)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i]), axes.get_title()
    inside = figure.bbox
    assert all(inside.x0 <= box.x0 and box.x1 <= inside.x1 for box in boxes), axes.get_title()
)";
  for (const char* example : {kFourSteps, kPolygons, kOctahedron}) expectScript(script, example);
}

// Rounding may make the sample of a thin CSO flat, although EPA has a polytope of it.
TEST_F(ExplainPlot, DrawsStepsOfEpaInSpaceEvenIfTheCsoIsFlat) {
  expectScript(R"(
import json, sys
sys.path.insert(0, sys.argv[1])
import explain_plot
data = json.load(open(sys.argv[2]))
assert data["epa"]
data["cso"]["dimension"] = data["cso"]["dimension_with_origin"] = 2
assert "EPA 1" in explain_plot.draw(data).axes[1 + len(data["gjk"])].get_title()
)",
               kOctahedron);
}

TEST_F(ExplainPlot, ShowsBothShapesWithTheirMarginsInTheFrameOfA) {
  const auto shapes = nlohmann::json::parse(readFile(dataOf("'box 1 2 3' 'sphere 0.5' --xyz '2 0.25 0'")))["shapes"];
  ASSERT_EQ(shapes.size(), 2U);
  ASSERT_EQ(shapes[0]["points"].size(), 8U);
  for (const auto& corner : shapes[0]["points"])
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(std::abs(corner[i].get<double>()), 0.5 * static_cast<double>(i + 1));
  ASSERT_GT(shapes[1]["points"].size(), 1000U);
  for (const auto& point : shapes[1]["points"])
    EXPECT_NEAR(std::hypot(point[0].get<double>() - 2.0, point[1].get<double>() - 0.25, point[2].get<double>()), 0.5,
                1e-12);
}

// The points of a swept hull lie in two places each.
TEST_F(ExplainPlot, NamesOnlyPointsThatLieWhereTheHullHasThem) {
  const std::string hull = "'hull 4 0 0 0 1 0 0 0 1 0 0 0 1", point = "' 'hull 1 3 0 0'";
  const auto named = [&](const std::string& arguments) {
    return nlohmann::json::parse(readFile(dataOf(arguments)))["cso"]["named"].size();
  };
  EXPECT_EQ(named(hull + point), 4U);
  EXPECT_EQ(named(hull + " sweep 1 0 0 0 1 0 0 0 1 1 0 0" + point), 0U);
}

}  // namespace proximity_server::tools::explain_plot_test

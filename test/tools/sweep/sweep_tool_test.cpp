// Sweeps in parts, by the executable.
#include "robots/urdf.h"
#include "sanitized.h"
#include "tools/program/clearance_command.h"
#include "tools/robot/robot_files.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>

namespace proximity_server::tools::sweep_tool_test {

using namespace scene;

namespace fs = std::filesystem;

class SweepTool : public Clearance {
 protected:
  /// The slider at random places, some of them in contact; in more than one block of every kind.
  void SetUp() override { writeStates("s.csv", kStates, 7); }

  void writeStates(const std::string& name, int count, unsigned seed) { files_.write(name, wander(count, -1.2, seed)); }

  CommandResult sweep(const std::string& arguments, const std::string& states = "s.csv") const {
    return runCommandApart(CLEARANCE " " + urdf_ + " --states " + files_.path(states) + " " + arguments);
  }
  std::string in(const std::string& name) const { return files_.path(name); }
  std::string text(const std::string& name) const { return readTextFile(in(name)); }

  /// Computes all of `of` shards, the last one first.
  void computeShards(int of, const std::string& arguments) const {
    for (int i = of; i >= 1; --i) {
      const CommandResult result = sweep("--shard " + std::to_string(i) + "/" + std::to_string(of) + " " + arguments);
      ASSERT_EQ(result.exit_code, 0) << result.errors;
    }
  }

  void expectError(const CommandResult& result, const std::string& message) const {
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(says(result.errors, message)) << result.errors << "does not say: " << message;
  }

  static constexpr int kStates = 5000;
};

/// The path of the file of a range.
std::string part(const std::string& folder, const std::string& range, const std::string& suffix) {
  return folder + "/states-" + range + "." + suffix;
}

TEST_F(SweepTool, MergedShardsHaveTheBytesOfOneRun) {
  for (const std::string pairs : {"minimum", "any:3", "below:2.5", "k:2", "all", "minimum --no-filter"}) {
    for (const std::string format : {"csv", "json", "npy"}) {
      const std::string question = "--pairs " + pairs + " --format " + format;
      for (const char* name : {"parts", "merged.manifest"}) fs::remove_all(in(name));
      computeShards(3, question + " --out " + in("parts"));
      const CommandResult whole =
          sweep(question + " --threads 1 --out " + in("whole") + " --summary " + in("whole.json"));
      ASSERT_EQ(whole.exit_code, 0) << whole.errors;
      const CommandResult merged = runCommandApart(CLEARANCE " --merge " + in("parts") + " --out " + in("merged") +
                                                   " --summary " + in("merged.json"));
      ASSERT_EQ(merged.exit_code, 0) << merged.errors;
      EXPECT_TRUE(text("merged") == text("whole")) << question;
      EXPECT_EQ(text("merged.json"), text("whole.json")) << question;
      if (format == "npy") {
        EXPECT_EQ(text("merged.manifest"), text("whole.manifest")) << question;
      } else {
        EXPECT_FALSE(fs::exists(in("merged.manifest")));
      }
    }
  }
}

// The objects change on the way, so a part has to make the changes of all parts before it.
TEST_F(SweepTool, MergedShardsWithObjectsHaveTheBytesOfOneRun) {
  files_.write("cell.yaml", R"(objects:
- {id: wall, pose: {position: [0, 2, 0]}, primitives: [{type: BOX, dimensions: [4, 0.2, 1]}]}
changes:
- {at: {row: 700}, operation: REMOVE, id: wall}
- {at: {row: 3100}, operation: ADD, id: drop, pose: {position: [1, 2, 0]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}
)");
  const std::string question = "--objects " + in("cell.yaml") + " --pairs k:2 --out ";
  computeShards(4, question + in("parts"));
  ASSERT_EQ(sweep(question + in("whole")).exit_code, 0);
  ASSERT_EQ(runCommandApart(CLEARANCE " --merge " + in("parts") + " --out " + in("merged")).exit_code, 0);
  EXPECT_TRUE(text("merged") == text("whole"));
  EXPECT_TRUE(says(text("whole"), "\n3100,") && says(text("whole"), ",drop,"));
}

// Of "two sliders" only sled and ball are checked, 2.25 + slide apart.
TEST_F(SweepTool, AnySaysOfEachStateWhetherAPairIsAsClose) {
  files_.write("few.csv", "slide\n0\n0.5\n1.5\n");
  EXPECT_EQ(sweep("--pairs any:2.5", "few.csv").output,
            "state,verdict,link_a,link_b\n0,below,ball,\"sled, left\"\n1,above,,\n2,above,,\n");
  const auto json = nlohmann::json::parse(sweep("--pairs any:2.5 --format json", "few.csv").output);
  EXPECT_EQ(json[0].dump(), R"({"link_a":"ball","link_b":"sled, left","state":0,"verdict":"below"})");
  EXPECT_EQ(json[2]["verdict"], "above");
  // By Scene: without its filter, where base and sled are 1 + slide apart.
  EXPECT_TRUE(says(sweep("--pairs any:1.2 --no-filter", "few.csv").output, "0,below,base,\"sled, left\"\n1,above,,\n"));
}

TEST_F(SweepTool, AnyAgreesWithTheMinimum) {
  const auto verdicts = rowsOf(sweep("--pairs any:2.9").output), minima = rowsOf(sweep("--pairs minimum").output);
  ASSERT_EQ(verdicts.size(), minima.size());
  int below = 0;
  for (std::size_t i = 1; i < minima.size(); ++i) {
    const bool is_below = std::stod(minima[i][4]) <= 2.9;
    below += is_below ? 1 : 0;
    EXPECT_EQ(verdicts[i][1], is_below ? "below" : "above") << "state " << i - 1;
  }
  EXPECT_GT(below, 1000);
  EXPECT_LT(below, 4000);
}

TEST_F(SweepTool, APartThatIsThereIsNotComputedAgain) {
  const std::string arguments = "--range 100:300 --out " + in("parts");
  ASSERT_EQ(sweep(arguments).exit_code, 0);
  const std::string file = part(in("parts"), "000000000100-000000000300", "csv");
  const auto time = fs::last_write_time(file);
  const CommandResult again = sweep(arguments);
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_TRUE(says(again.errors, file + " is there already")) << again.errors;
  EXPECT_EQ(fs::last_write_time(file), time);
  // A file that was cut is computed again.
  fs::resize_file(file, 50);
  EXPECT_EQ(sweep(arguments).exit_code, 0);
  EXPECT_GT(fs::file_size(file), 50U);
}

TEST_F(SweepTool, AKilledRunLeavesNothingThatTheNextOneKeeps) {
  fs::create_directory(in("parts"));
  files_.write("parts/.states-000000000000-000000005000.csv.host-1.tmp", "half a ro");
  files_.write("parts/states-000000000000-000000005000.csv", "renamed, but without a manifest");
  computeShards(1, "--out " + in("parts"));
  EXPECT_EQ(std::distance(fs::directory_iterator(in("parts")), fs::directory_iterator()), 2);
  files_.write(".merged.host-1.tmp", "half a ro");
  ASSERT_EQ(runCommandApart(CLEARANCE " --merge " + in("parts") + " --out " + in("merged")).exit_code, 0);
  EXPECT_TRUE(text("merged") == sweep("").output);
  EXPECT_FALSE(fs::exists(in(".merged.host-1.tmp")));
}

TEST_F(SweepTool, RefusesPartsOfAnotherSweepAndNamesWhatDiffers) {
  ASSERT_EQ(sweep("--shard 1/2 --out " + in("parts")).exit_code, 0);
  const std::string file = part(in("parts"), "000000000000-000000002500", "csv");
  const std::string before = readTextFile(file), manifest = readTextFile(file + ".manifest");
  const std::string arguments = "--shard 2/2 --out " + in("parts");
  expectError(sweep(arguments + " --pairs k:3"),
              file + ".manifest: is of another sweep: question.pairs is \"minimum\" there and \"k:3\" here");
  expectError(sweep(arguments + " --format npy"), "output.format is \"csv\" there and \"npy\" here");
  expectError(sweep(arguments + " --no-skip"), "question.skipping is true there and false here");
  writeStates("other.csv", kStates, 8);
  expectError(sweep(arguments, "other.csv"), "states.identity is ");
  // A robot that differs in one padding, in one length, in one limit: by what is loaded, not by the name of the file.
  std::string other = kTwoSliders;
  other.replace(other.find("radius=\"0.25\""), 13, "radius=\"0.26\"");
  urdf_ = files_.write("other.urdf", other);
  expectError(sweep(arguments), "model.shapes is ");
  urdf_ = files_.write("same.urdf", kTwoSliders);
  EXPECT_EQ(sweep(arguments).exit_code, 0);
  EXPECT_EQ(readTextFile(file), before);
  EXPECT_EQ(readTextFile(file + ".manifest"), manifest);
}

// Regression: the C library has other sines where the processor has no fused products.
TEST_F(SweepTool, HostsWithAndWithoutFusedProductsAnswerTheSame) {
  using namespace robots;
  files_.write("turn.urdf", urdfOf(link("a", ball("0.1", "1 0 0")) + link("b", ball("0.1", "2 0 0")) +
                                   hinge("j", "a", "b", "0.6 0 0.8")));
  const std::string older = "GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA_Usable,-AVX2,-AVX2_Usable,-FMA4 ";
  const std::string command = CLEARANCE " " + in("turn.urdf") + " --no-filter --sample 20000 ";
  const std::string whole = runCommandApart(command).output;
  ASSERT_FALSE(whole.empty());
  EXPECT_TRUE(runCommandApart(older + command).output == whole);
  EXPECT_EQ(runCommandApart(command + "--shard 1/2 --out " + in("parts")).exit_code, 0);
  EXPECT_EQ(runCommandApart(older + command + "--shard 2/2 --out " + in("parts")).exit_code, 0);
}

// Regression: only the file of the objects was compared, and the meshes that it names lie beside it.
TEST_F(SweepTool, RefusesPartsWithOtherMeshesOfObjects) {
  const auto writePyramid = [&](const std::string& height) {
    const std::string a = "vertex 0 0 0 ", b = "vertex 1 0 0 ", c = "vertex 0 1 0 ", top = "vertex 0 0 " + height + " ";
    std::string facets;
    for (const std::string& corners : {a + c + b, a + b + top, b + c + top, c + a + top})
      facets += "facet normal 0 0 0 outer loop " + corners + "endloop endfacet\n";
    return files_.write("part.stl", "solid s\n" + facets + "endsolid s\n");
  };
  const std::string mesh = "mesh_files: [{uri: \"file://" + writePyramid("1") + "\"}]}\n";
  for (const std::string& cell :
       {"objects:\n- {id: part, pose: {position: [0, 0, 2]}, " + mesh,
        "changes:\n- {at: {row: 10}, operation: ADD, id: part, pose: {position: [0, 0, 2]}, " + mesh}) {
    SCOPED_TRACE(cell);
    fs::remove_all(in("parts"));
    writePyramid("1");
    const std::string arguments = "--objects " + files_.write("cell.yaml", cell) + " --out " + in("parts");
    const CommandResult first = sweep("--shard 1/2 " + arguments);
    ASSERT_EQ(first.exit_code, 0) << first.errors;
    writePyramid("1.5");
    expectError(sweep("--shard 2/2 " + arguments), "question.object_shapes is ");
    writePyramid("1");
    EXPECT_EQ(sweep("--shard 2/2 " + arguments).exit_code, 0);
  }
}

TEST_F(SweepTool, RefusesRangesThatOverlap) {
  ASSERT_EQ(sweep("--range 0:1000 --out " + in("parts")).exit_code, 0);
  expectError(sweep("--range 500:1500 --out " + in("parts")), "has the states 0:1000, which overlap 500:1500");
  EXPECT_EQ(sweep("--range 1000:1500 --out " + in("parts")).exit_code, 0);
}

TEST_F(SweepTool, MergingNamesTheRangesThatAreMissing) {
  const std::string merge = CLEARANCE " --merge " + in("parts") + " --out " + in("merged");
  expectError(runCommandApart(merge), in("parts") + ": cannot be read (No such file or directory)");
  fs::create_directory(in("parts"));
  expectError(runCommandApart(merge), in("parts") + ": has no complete part of a sweep");
  for (const std::string range : {"1000:2000", "3000:3500"})
    ASSERT_EQ(sweep("--range " + range + " --out " + in("parts")).exit_code, 0);
  expectError(runCommandApart(merge), in("parts") + ": the states 0:1000, 2000:3000, 3500:5000 of 0:5000 are missing");
  EXPECT_FALSE(fs::exists(in("merged")));
}

TEST_F(SweepTool, MergingNamesAPartThatIsNotWhatItsManifestSays) {
  computeShards(2, "--out " + in("parts"));
  const std::string merge = CLEARANCE " --merge " + in("parts") + " --out " + in("merged");
  const std::string file = part(in("parts"), "000000000000-000000002500", "csv"), content = readTextFile(file);
  files_.write("merged", "old");
  std::string changed = content;
  changed[changed.size() / 2] ^= 1;
  for (const auto& [bad, why] :
       {std::pair{changed, "its rows have another hash"}, std::pair{content.substr(1), "it should have "},
        std::pair{"x" + content.substr(1), "it begins otherwise"}}) {
    files_.write("parts/states-000000000000-000000002500.csv", bad);
    expectError(runCommandApart(merge), file + ": is not what its manifest says: " + why);
  }
  fs::remove(file);
  expectError(runCommandApart(merge), file + ": cannot be read (No such file or directory)");
  files_.write("parts/states-000000000000-000000002500.csv", content);
  files_.write("parts/states-000000000000-000000002500.csv.manifest", "{}");
  expectError(runCommandApart(merge), file + ".manifest: no manifest of a sweep: ");
  EXPECT_EQ(text("merged"), "old");
}

TEST_F(SweepTool, MergingNamesPartsOfDifferentSweepsAndOnesThatOverlap) {
  ASSERT_EQ(sweep("--range 0:2000 --out " + in("parts")).exit_code, 0);
  ASSERT_EQ(sweep("--range 1000:5000 --out " + in("others")).exit_code, 0);
  ASSERT_EQ(sweep("--range 2000:5000 --pairs k:2 --out " + in("different")).exit_code, 0);
  const auto copyParts = [&](const std::string& from, const std::string& to) {
    fs::copy(in(from), in(to), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  };
  const auto merge = [&](const std::string& folder) {
    return runCommandApart(CLEARANCE " --merge " + in(folder) + " --out " + in("merged"));
  };
  copyParts("parts", "others");
  expectError(merge("others"), part(in("others"), "000000001000-000000005000", "csv") + ": has states that " +
                                   part(in("others"), "000000000000-000000002000", "csv") + " has too");
  copyParts("parts", "different");
  expectError(merge("different"), "is of another sweep than ");
  EXPECT_FALSE(fs::exists(in("merged")));
}

TEST_F(SweepTool, NamesAFileWhereAFolderIsWantedAndTheOtherWayRound) {
  fs::create_directory(in("folder"));
  files_.write("file", "old");
  expectError(sweep("--shard 1/4 --out " + in("file")), in("file") + ": is a file, and parts of a sweep need a folder");
  expectError(sweep("--shard 1/4 --out " + in("file/below")), in("file/below") + ": cannot be made (Not a directory)");
  expectError(sweep("--format npy --out " + in("folder")), in("folder") + ": is a folder, not a file");
  expectError(sweep("--format npy --out /nowhere/x.npy"),
              "/nowhere/x.npy: cannot be written (No such file or directory)");
  expectError(sweep("--summary " + in("folder")), in("folder") + ": is a folder, not a file");
  expectError(sweep("--summary /nowhere/x.json"), "/nowhere/x.json: cannot be written");
  computeShards(1, "--out " + in("parts"));
  expectError(runCommandApart(CLEARANCE " --merge " + in("parts") + " --out " + in("folder")),
              in("folder") + ": is a folder, not a file");
  EXPECT_EQ(text("file"), "old");
}

TEST_F(SweepTool, ABadStateLeavesNoPart) {
  files_.write("bad.csv", "slide\n0\n1\nx\n");
  expectError(sweep("--shard 1/1 --out " + in("parts"), "bad.csv"), "line 4: column \"slide\"");
  expectError(sweep("--format npy --out " + in("x.npy"), "bad.csv"), "line 4: column \"slide\"");
  EXPECT_TRUE(fs::is_empty(in("parts")));
  EXPECT_FALSE(fs::exists(in("x.npy")));
}

/// Three spheres of radius 0.1 on the x axis: a at cart + a, b at b and c at c. The sum of the first two overflows
/// where each is finite.
const std::string kOnACart = [] {
  using namespace robots;
  std::string links = link("base") + link("cart");
  for (const std::string name : {"a", "b", "c"}) links += link(name, ball("0.1"));
  return urdfOf(links + slider("cart", "base", "cart", "1 0 0") + slider("a", "cart", "a", "1 0 0") +
                slider("b", "base", "b", "1 0 0") + slider("c", "base", "c", "1 0 0"));
}();

/// In the middle one of three states a has no pose; b and c have one, 0.8 apart.
class UnknownStates : public SweepTool {
 protected:
  void SetUp() override {
    urdf_ = files_.write("cart.urdf", kOnACart);
    files_.write("s.csv", "cart,a,b,c\n0,3,0,1\n1.7e308,1.7e308,0,1\n0,0.4,0,1\n");
  }

  /// The rows about a state.
  static std::vector<std::vector<std::string>> rowsAbout(const std::string& state, const std::string& csv) {
    std::vector<std::vector<std::string>> found;
    for (const auto& row : rowsOf(csv))
      if (row[0] == state) found.push_back(row);
    return found;
  }

  const std::vector<std::string> ways_ = {"", " --no-filter", " --no-skip",
                                          " --objects " + files_.write("cell.yaml", "objects: []")};
};

// Regression: lists had no row for such a state, which reads as "nothing is near"; those by Scene had the pairs that
// are known, as if they were all.
TEST_F(UnknownStates, HaveOneRowWithoutAPairInEveryList) {
  for (const std::string pairs : {"minimum", "k:2", "below:0.9", "below:0.01"}) {
    for (const std::string& way : ways_) {
      SCOPED_TRACE(pairs + way);
      const std::string question = "--pairs " + pairs + way;
      const std::string csv = sweep(question).output;
      const auto rows = rowsAbout("1", csv);
      ASSERT_EQ(rows.size(), 1U);
      EXPECT_EQ((std::vector<std::string>(rows[0].begin(), rows[0].begin() + 6)),
                (std::vector<std::string>{"1", "", "", "nan", "-inf", "inf"}));
      EXPECT_EQ(rows[0][15], "unknown");
      EXPECT_EQ(rowsAbout("2", csv).empty(), pairs == "below:0.01");

      int in_json = 0;
      for (const auto& row : nlohmann::json::parse(sweep(question + " --format json").output)) {
        if (row["state"] != 1) continue;
        ++in_json;
        EXPECT_TRUE(row["status"] == "unknown" && row["link_a"] == "" && row["distance"].is_null()) << row;
      }
      EXPECT_EQ(in_json, 1);
    }
  }
}

TEST_F(UnknownStates, HaveTheNumbersOfNoAnswerInNpy) {
  for (const std::string way : {"", " --no-skip"}) {
    ASSERT_EQ(sweep("--pairs below:0.01 --format npy --out " + in("x.npy") + way).exit_code, 0);
    const std::string bytes = text("x.npy");
    constexpr std::size_t kHeader = 256, kRow = 24;
    ASSERT_EQ(bytes.size(), kHeader + kRow) << way;
    const auto read = [&](auto number, std::size_t offset) {
      std::memcpy(&number, bytes.data() + kHeader + offset, sizeof number);
      return number;
    };
    EXPECT_EQ(read(std::uint64_t{}, 0), 1U);
    EXPECT_EQ(read(std::int32_t{}, 8), -1);
    EXPECT_TRUE(std::isnan(read(float{}, 12)));
    EXPECT_EQ(read(float{}, 16), -std::numeric_limits<float>::infinity());
    EXPECT_EQ(read(float{}, 20), std::numeric_limits<float>::infinity());
  }
}

// Regression: a state with some pairs unknown was counted by the closest of the others.
TEST_F(UnknownStates, AreCountedAsUnknown) {
  for (const std::string pairs : {"minimum", "k:2", "below:0.9", "below:0.01", "all"}) {
    for (const std::string& way : ways_) {
      SCOPED_TRACE(pairs + way);
      ASSERT_EQ(sweep("--pairs " + pairs + way + " --summary " + in("summary.json")).exit_code, 0);
      const auto summary = nlohmann::json::parse(text("summary.json"));
      EXPECT_EQ(summary["states"], 3);
      EXPECT_EQ(summary["unknown"], 1);
      EXPECT_EQ(summary["unlisted"], pairs == "below:0.01" ? 2 : 0);
      for (const auto& worst : summary["worst"]) EXPECT_NE(worst["state"], 1);
    }
  }
}

TEST_F(UnknownStates, WithAllPairsKeepTheRowOfEachPair) {
  const auto rows = rowsAbout("1", sweep("--pairs all").output);
  ASSERT_EQ(rows.size(), 3U);
  int unknown = 0;
  for (const auto& row : rows) {
    EXPECT_FALSE(row[1].empty());
    unknown += row[15] == "unknown" ? 1 : 0;
  }
  EXPECT_EQ(unknown, 2);
}

TEST_F(UnknownStates, OfMergedShardsHaveTheBytesOfOneRun) {
  for (const std::string pairs : {"k:2", "below:0.01", "minimum --no-skip"}) {
    for (const std::string format : {"csv", "json", "npy"}) {
      SCOPED_TRACE(pairs + " " + format);
      const std::string question = "--pairs " + pairs + " --format " + format + " --out ";
      fs::remove_all(in("parts"));
      computeShards(3, question + in("parts"));
      ASSERT_EQ(sweep(question + in("whole") + " --summary " + in("whole.json")).exit_code, 0);
      ASSERT_EQ(runCommandApart(CLEARANCE " --merge " + in("parts") + " --out " + in("merged") + " --summary " +
                                in("merged.json"))
                    .exit_code,
                0);
      EXPECT_TRUE(text("merged") == text("whole"));
      EXPECT_EQ(text("merged.json"), text("whole.json"));
    }
  }
}

TEST_F(SweepTool, TwoWorkersAtTheSameShardDoNoHarm) {
  const std::string shard =
      CLEARANCE " " + urdf_ + " --states " + in("s.csv") + " --pairs all --shard 1/1 --out " + in("parts");
  const CommandResult both = runCommandApart(shard + " & " + shard + " ; first=$? ; wait $! && exit $first");
  EXPECT_EQ(both.exit_code, 0) << both.errors;
  ASSERT_EQ(runCommandApart(CLEARANCE " --merge " + in("parts") + " --out " + in("merged")).exit_code, 0);
  EXPECT_TRUE(text("merged") == sweep("--pairs all").output);
}

TEST_F(SweepTool, TheSummarySaysWhatTheRowsSay) {
  const CommandResult result = sweep("--summary " + in("summary.json"));
  const auto rows = rowsOf(result.output);
  const auto json = nlohmann::json::parse(text("summary.json"));
  double smallest = 1e9;
  std::string worst;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (std::stod(rows[i][3]) >= smallest) continue;
    smallest = std::stod(rows[i][3]);
    worst = rows[i][0];
  }
  EXPECT_EQ(json["states"], kStates);
  EXPECT_EQ(json["worst"][0]["distance"], smallest);
  EXPECT_EQ(std::to_string(json["worst"][0]["state"].get<int>()), worst);
  EXPECT_NEAR(json["worst"][0]["positions"]["slide"], smallest - 2.25, 1e-9);
  int in_bins = 0;
  for (const auto& bin : json["histogram"]) in_bins += bin["states"].get<int>();
  EXPECT_EQ(in_bins, kStates);
  EXPECT_TRUE(says(result.errors, "clearance: 5000 states, 0 at or below 0, 0 unknown; the closest is state " + worst))
      << result.errors;
  EXPECT_TRUE(says(result.errors, " states per core-hour, ")) << result.errors;
}

}  // namespace proximity_server::tools::sweep_tool_test

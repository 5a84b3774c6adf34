#include "tools/states/numpy_states.h"

#include "sanitized.h"
#include "scene/files.h"
#include "tools/program/run_command.h"
#include "tools/states/arm.h"
#include "tools/states/numpy_bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::tools::numpy_states_test {

using namespace scene;

const double kNaN = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();
const std::vector<std::string> kElbowLift{"elbow", "lift"};

class NumpyFile : public ::testing::Test {
 protected:
  NumpyStates open(const std::string& name, const std::vector<std::string>& joints = {}) {
    return NumpyStates(files_.path(name), joints, arm());
  }

  std::string errorIn(const std::string& name, const std::vector<std::string>& joints = kElbowLift) {
    const std::string error = errorOf([&] {
      NumpyStates states(files_.path(name), joints, arm());
      restOf(states);
    });
    const std::string folder = files_.path("");
    std::string text = error;
    for (std::size_t at = 0; (at = text.find(folder)) != std::string::npos;) text.erase(at, folder.size());
    return text;
  }
  std::string errorInBytes(const std::string& bytes) {
    files_.write("s.npy", bytes);
    return errorIn("s.npy");
  }

  TemporaryFiles files_;
};

/// By numpy itself, where it is installed.
class WrittenNumpyFile : public NumpyFile {
 protected:
  void SetUp() override {
    if (runCommand("/usr/bin/python3 -c 'import numpy' 2>&1").exit_code != 0) GTEST_SKIP() << "needs python3-numpy";
  }

  /// Runs a script of Python, with numpy as np and the folder of the test as working directory.
  void python(const std::string& script) {
    files_.write("script.py", "import numpy as np\n" + script);
    const CommandResult result = runCommand("cd " + files_.path("") + " && /usr/bin/python3 script.py 2>&1");
    ASSERT_EQ(result.exit_code, 0) << result.output;
  }
};

TEST_F(WrittenNumpyFile, IsReadInEveryOrderTypeAndVersionThatNumPyWrites) {
  // So many rows that there are several blocks. Eighths are exact in float32.
  const int rows = 40001;
  python(R"(
i = np.arange(40001.0)
q = np.stack([i % 7 / 8, i / 8, -i], axis=1)
for order in 'CF':
  for dtype in ['<f8', '>f8', '<f4', '>f4']:
    for version in [(1, 0), (2, 0), (3, 0)]:
      with open(order + dtype[1:] + ('l' if dtype[0] == '<' else 'b') + str(version[0]) + '.npy', 'wb') as file:
        np.lib.format.write_array(file, np.asarray(q, dtype, order=order), version)
)");
  for (const std::string order : {"C", "F"}) {
    for (const std::string dtype : {"f8l", "f8b", "f4l", "f4b"}) {
      for (const std::string version : {"1", "2", "3"}) {
        const std::string name = order + dtype + version + ".npy";
        SCOPED_TRACE(name);
        NumpyStates states = open(name, {"elbow", "lift", "wheel"});
        EXPECT_EQ(states.count(), rows);
        scene::TrajectoryPoint state;
        int wrong = 0;
        for (int i = 0; i < rows; ++i) {
          ASSERT_TRUE(states.next(state));
          wrong += state.positions == at(i % 7 / 8.0, i / 8.0, -i) ? 0 : 1;
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_FALSE(states.next(state));
      }
    }
  }
}

TEST_F(WrittenNumpyFile, IsReadFromAnyStateOn) {
  python(
      "i = np.arange(30000.0)\nq = np.stack([i, -i], axis=1)\n"
      "np.save('c.npy', q)\nnp.save('f.npy', np.asfortranarray(q))\nnp.savez('s.npz', q)\n"
      "np.savez_compressed('d.npz', q)\nnp.savez('t.npz', np.asfortranarray(q))\n");
  for (const std::string name : {"c.npy", "f.npy", "s.npz", "d.npz", "t.npz"}) {
    SCOPED_TRACE(name);
    NumpyStates states = open(name, kElbowLift);
    scene::TrajectoryPoint state;
    for (const int number : {0, 5, 6, 16384, 16385, 29999}) {
      states.skipTo(static_cast<std::uint64_t>(number));
      ASSERT_TRUE(states.next(state));
      EXPECT_EQ(state.positions, at(number, -number, 0.0));
    }
    states.skipTo(40000);
    EXPECT_FALSE(states.next(state));
  }
}

TEST_F(NumpyFile, IsWhatItsBytesSay) {
  const std::string data = bytesOf<double>({1.0, 2.0, 3.0, 4.0});
  for (const std::string dictionary : {"{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }",
                                       "{'shape':(2,2,),'descr':\"<f8\",'fortran_order':False}",
                                       "{'descr': '<f8', 'fortran_order': False, 'shape': (2L, 2L)}   \n"}) {
    SCOPED_TRACE(dictionary);
    files_.write("s.npy", npyHeader(dictionary) + data);
    EXPECT_EQ(restOf(open("s.npy", kElbowLift)), (std::vector<Positions>{at(1.0, 2.0, 0.0), at(3.0, 4.0, 0.0)}));
    EXPECT_EQ(restOf(open("s.npy", {"wheel", "elbow"})),
              (std::vector<Positions>{at(2.0, 0.0, 1.0), at(4.0, 0.0, 3.0)}));
  }
  files_.write("f.npy", npyHeader("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 2), }") + data);
  EXPECT_EQ(restOf(open("f.npy", kElbowLift)), (std::vector<Positions>{at(1.0, 3.0, 0.0), at(2.0, 4.0, 0.0)}));
  files_.write("none.npy", npyHeader(npyDictionary("<f8", "(0, 2)")));
  EXPECT_EQ(open("none.npy", kElbowLift).count(), 0U);
  EXPECT_EQ(restOf(open("none.npy", kElbowLift)).size(), 0U);
}

TEST_F(NumpyFile, IsRefusedWithWhatIsWrong) {
  const std::string data = bytesOf<double>({1.0, 2.0, 3.0, 4.0});
  const auto withDtype = [&](const std::string& dtype) { return npyHeader(npyDictionary(dtype, "(2, 2)")) + data; };
  const auto withShape = [&](const std::string& shape) { return npyHeader(npyDictionary("<f8", shape)) + data; };
  const std::string no_numbers = "; expected float64 or float32";
  for (const std::string dtype : {"<i8", "|O", "<f2", "<c16", "<U5", "|b1", "", "<M8[ns]", "=f8", "<f8 "})
    EXPECT_EQ(errorInBytes(withDtype(dtype)), "s.npy: dtype " + dtype + no_numbers);
  EXPECT_EQ(errorInBytes(npyHeader("{'descr': [('q', '<f8', (2,))], 'fortran_order': False, 'shape': (2,), }") + data),
            "s.npy: a structured array; expected a table of float64 or float32");
  EXPECT_EQ(errorInBytes(withShape("(4,)")), "s.npy: an array of one dimension; expected a row for each state");
  EXPECT_EQ(errorInBytes(withShape("(1, 2, 2)")), "s.npy: shape (1, 2, 2); expected a row for each state");
  EXPECT_EQ(errorInBytes(withShape("()")), "s.npy: shape (); expected a row for each state");
  EXPECT_EQ(errorInBytes(withShape("(1, 4)")), "s.npy: 4 columns for 2 names of joints");
  EXPECT_EQ(errorInBytes(withShape("(3, 2)")), "s.npy: truncated: shape (3, 2) of <f8 has 48 bytes, there are 32");
  EXPECT_EQ(errorInBytes(withShape("(1, 2)")),
            "s.npy: there is more behind the array: shape (1, 2) of <f8 has 16 bytes, there are 32");
  EXPECT_EQ(
      errorInBytes(withShape("(9223372036854775807, 2)")),
      "s.npy: truncated: shape (9223372036854775807, 2) of <f8 has more bytes than a file can have, there are 32");
  EXPECT_EQ(errorInBytes(withShape("(4611686018427387906, 2)")),
            "s.npy: truncated: shape (4611686018427387906, 2) of <f8 has more bytes than a file can have, there are 32")
      << "2^62 + 2 rows, whose size in 64 bits is that of the data";
  EXPECT_EQ(errorInBytes(""), "s.npy: no NumPy array: it does not begin as a .npy");
  EXPECT_EQ(errorInBytes("elbow,lift\n1,2\n"), "s.npy: no NumPy array: it does not begin as a .npy");
  EXPECT_EQ(errorInBytes(npyHeader(npyDictionary("<f8", "(2, 2)"), 4) + data),
            "s.npy: version 4 of .npy; known are 1 to 3");
  EXPECT_EQ(errorIn("nowhere.npy"), "nowhere.npy: cannot be read (No such file or directory)");
}

TEST_F(NumpyFile, IsRefusedIfItsHeaderIsDamaged) {
  for (const std::string dictionary :
       {"", "{}", "{'descr': '<f8', 'fortran_order': False}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), 'shape': (2, 2)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), 'more': 1}",
        "{'descr': '<f8', 'fortran_order': 0, 'shape': (2, 2)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-2, 2)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 99999999999999999999)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2 2)}",
        "{'descr': '<f8, 'fortran_order': False, 'shape': (2, 2)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)} x", "{,}", "('descr', '<f8')"}) {
    EXPECT_EQ(errorInBytes(npyHeader(dictionary) + bytesOf<double>({1.0, 2.0, 3.0, 4.0})),
              "s.npy: the header of the array is damaged")
        << dictionary;
  }
}

TEST_F(WrittenNumpyFile, IsRefusedWhereverItIsCutOff) {
  python(
      "q = np.ones((5, 2))\nnp.save('a.npy', q)\nnp.savez('b.npz', states=q, joints=np.array(['elbow', 'lift']))\n"
      "np.savez_compressed('c.npz', states=q, joints=np.array(['elbow', 'lift']))\n");
  for (const std::string name : {"a.npy", "b.npz", "c.npz"}) {
    EXPECT_EQ(errorIn(name), "");
    const std::string whole = readFile(files_.path(name)), cut = "cut" + name.substr(1);
    const std::size_t step = name == "a.npy" ? 1 : 3;
    for (std::size_t size = 0; size < whole.size(); size += kIsSanitized ? 17 : step) {
      files_.write(cut, whole.substr(0, size));
      EXPECT_NE(errorIn(cut), "") << name << " " << size;
    }
  }
}

TEST_F(NumpyFile, ThatIsCutOffWhileItIsReadIsAnError) {
  files_.write("s.npy", npyHeader(npyDictionary("<f8", "(50000, 2)")) + std::string(800000, '\0'));
  NumpyStates states = open("s.npy", kElbowLift);
  scene::TrajectoryPoint state;
  ASSERT_TRUE(states.next(state));
  std::filesystem::resize_file(files_.path("s.npy"), 300000);
  const std::string error = errorOf([&] { restOf(states); });
  EXPECT_NE(error.find("s.npy: truncated: ends at byte 300000"), std::string::npos) << error;
}

// 160 GB, of which the file system keeps the last numbers only.
TEST_F(NumpyFile, LargerThanTheMemoryIsReadFromAnyStateOn) {
  const std::uint64_t rows = 10'000'000'000;
  for (const std::string order : {"False", "True"}) {
    const std::string file = files_.write(
        "large.npy", npyHeader("{'descr': '<f8', 'fortran_order': " + order + ", 'shape': (10000000000, 2)}"));
    std::error_code refused;
    std::filesystem::resize_file(file, std::filesystem::file_size(file) + rows * 16 - 8, refused);
    if (refused) GTEST_SKIP() << "needs a file system for sparse files of 160 GB";
    std::ofstream(file, std::ios::binary | std::ios::app) << bytesOf<double>({0.25});
    NumpyStates states = open("large.npy", kElbowLift);
    EXPECT_EQ(states.count(), rows);
    states.skipTo(rows - 2);
    EXPECT_EQ(restOf(states), (std::vector<Positions>{at(0.0, 0.0, 0.0), at(0.0, 0.25, 0.0)}));
  }
}

TEST_F(NumpyFile, NamesTheFirstNumberThatIsNotFinite) {
  for (const auto& [number, text] : {std::pair(kNaN, "nan"), {kInfinity, "inf"}, {-kInfinity, "-inf"}}) {
    const std::string expected = std::string("s.npy, state 2: column \"lift\": \"") + text + "\" is no finite number";
    const std::vector<double> numbers{0.0, 0.0, 0.0, 0.0, 0.0, number, kNaN, kNaN};
    EXPECT_EQ(errorInBytes(npyHeader(npyDictionary("<f8", "(4, 2)")) + bytesOf(numbers)), expected);
    const std::vector<float> floats(numbers.begin(), numbers.end());
    EXPECT_EQ(errorInBytes(npyHeader(npyDictionary("<f4", "(4, 2)")) + bytesOf(floats)), expected);
  }
}

TEST_F(WrittenNumpyFile, HasItsJointsNamedByTheCallerTheArchiveOrAFileBesideIt) {
  python(
      "q = np.array([[1.0, 2.0]])\nnp.save('a.npy', q)\nnp.savez('b.npz', q, joints=np.array(['elbow', 'lift']))\n"
      "np.savez('c.npz', q, names=np.array([b'elbow', b'lift']))\nnp.savez('d.npz', q)\n"
      "np.savez('e.npz', q, joints=np.array(['elbow', 'lift'], '>U20'))\n");
  const std::vector<Positions> expected{at(1.0, 2.0, 0.0)};
  for (const std::string name : {"b.npz", "c.npz", "e.npz"}) EXPECT_EQ(restOf(open(name)), expected) << name;
  const std::string unnamed = ": the joints of its 2 columns are not named: give --joints NAME,NAME, ..., or the file ",
                    joints = "elbow,lift,wheel";
  EXPECT_EQ(errorIn("a.npy", {}), "a.npy" + unnamed + "a.joints; the joints of the robot are " + joints);
  EXPECT_EQ(errorIn("d.npz", {}), "d.npz, arr_0.npy" + unnamed + "d.joints; the joints of the robot are " + joints);
  files_.write("a.joints", "elbow\r\n\n lift \n");
  files_.write("d.joints", "elbow, \"lift\"");
  for (const std::string name : {"a.npy", "d.npz"}) EXPECT_EQ(restOf(open(name)), expected) << name;
  EXPECT_EQ(restOf(open("b.npz", {"lift", "wheel"})), std::vector<Positions>{at(0.0, 1.0, 2.0)})
      << "the caller is right";
}

TEST_F(NumpyFile, IsRefusedForNamesThatACsvMayNotHave) {
  files_.write("s.npy", npyHeader(npyDictionary("<f8", "(1, 2)")) + bytesOf<double>({1.0, 2.0}));
  EXPECT_EQ(errorIn("s.npy", {"elbow", "lft"}), "s.npy: column \"lft\": no such joint (did you mean \"lift\"?)");
  EXPECT_EQ(errorIn("s.npy", {"elbow", "elbow"}), "s.npy: two columns are named \"elbow\"");
  EXPECT_EQ(errorIn("s.npy", {"elbow", "weld"}), "s.npy: column \"weld\": a fixed joint has no position");
  EXPECT_EQ(errorIn("s.npy", {"base", "lift"}),
            "s.npy: column \"base\": a floating or planar joint has more than one position");
  NumpyStates states = open("s.npy", {"elbow", "finger"});
  EXPECT_EQ(
      states.header().warnings,
      std::vector<std::string>{files_.path("s.npy") + ": column \"finger\" is not used: the joint follows \"lift\"."});
  EXPECT_EQ(states.header().source, files_.path("s.npy"));
}

TEST_F(WrittenNumpyFile, HasTimesInAColumnOrInAnArrayOfTheArchive) {
  python(
      "q = np.array([[1.0, 2.0], [3.0, 4.0]])\nnp.savez('t.npz', q=q, time=np.array([0.5, 1.5]))\n"
      "np.savez('few.npz', q=q, time=np.array([0.5]))\nnp.savez('nan.npz', q=q, time=np.array([0.5, np.nan]))\n"
      "np.save('s.npy', q)\n");
  NumpyStates beside = open("t.npz", kElbowLift);
  EXPECT_TRUE(beside.header().has(JointColumn::Quantity::Time));
  scene::TrajectoryPoint state;
  ASSERT_TRUE(beside.next(state) && beside.next(state));
  EXPECT_EQ(state.time, 1.5);
  EXPECT_EQ(state.positions, at(3.0, 4.0, 0.0));
  NumpyStates states = open("s.npy", {"time", "lift"});
  EXPECT_TRUE(states.header().has(JointColumn::Quantity::Time));
  ASSERT_TRUE(states.next(state));
  EXPECT_EQ(state.time, 1.0);
  EXPECT_EQ(state.positions, at(0.0, 2.0, 0.0));
  EXPECT_FALSE(open("s.npy", kElbowLift).header().has(JointColumn::Quantity::Time));
  EXPECT_EQ(errorIn("few.npz"), "few.npz, time.npy: not one time for each of 2 states");
  EXPECT_EQ(errorIn("nan.npz"), "nan.npz, q.npy, state 1: column \"time\": \"nan\" is no finite number");
  EXPECT_EQ(errorIn("t.npz", {"time", "lift"}), "t.npz, q.npy: a column \"time\", and an array \"time\" beside it");
}

TEST_F(WrittenNumpyFile, IsAnArchiveWhoseTableIsKnownByItsNameOrAlone) {
  python(
      "q = np.array([[1.0, 2.0]])\nnp.savez('a.npz', other=q + 1, states=q)\nnp.savez('b.npz', x=q, y=q)\n"
      "np.savez('none.npz', joints=np.array(['elbow', 'lift']))\nnp.savez('c.npz', q, joints=np.array([1, 2]))\n"
      "np.savez('d.npz', q, joints=np.array(['elbow', None], dtype=object))\n");
  EXPECT_EQ(restOf(open("a.npz", kElbowLift)), std::vector<Positions>{at(1.0, 2.0, 0.0)});
  EXPECT_EQ(errorIn("b.npz"), "b.npz: which array are the states? Name it \"states\"; there are x.npy, y.npy");
  EXPECT_EQ(errorIn("none.npz"), "none.npz: which array are the states? Name it \"states\"; there is none");
  EXPECT_EQ(errorIn("c.npz", {}), "c.npz, joints.npy: dtype <i8, shape (2); expected a list of texts");
  EXPECT_EQ(errorIn("d.npz", {}), "d.npz, joints.npy: dtype |O, shape (2); expected a list of texts");
}

// The bit of encryption in the local header of a member, and in the directory.
TEST_F(WrittenNumpyFile, IsRefusedIfAMemberIsEncrypted) {
  python("np.savez('a.npz', states=np.ones((1, 2)))\n");
  std::string bytes = readFile(files_.path("a.npz"));
  bytes.at(bytes.find("PK\3\4") + 6) |= 1;
  bytes.at(bytes.find("PK\1\2") + 8) |= 1;
  files_.write("e.npz", bytes);
  const std::string error = errorIn("e.npz");
  if (error.rfind("e.npz: no .npz, or a damaged one", 0) == 0) return;  // libzip of Debian 13 expects other sizes
  EXPECT_EQ(error, "e.npz, states.npy: encrypted");
}

TEST_F(WrittenNumpyFile, IsRefusedIfACompressedMemberIsDamaged) {
  python("np.savez_compressed('a.npz', states=np.random.default_rng(1).random((100, 2)))\n");
  std::string bytes = readFile(files_.path("a.npz"));
  bytes.at(bytes.size() / 2) ^= 1;
  files_.write("d.npz", bytes);
  EXPECT_NE(errorIn("d.npz").find("d.npz, states.npy: damaged ("), std::string::npos) << errorIn("d.npz");
}

// A number in the middle becomes another one, which is finite.
TEST_F(WrittenNumpyFile, WhoseStoredMemberIsDamagedIsAnErrorAtItsEnd) {
  python("np.savez('a.npz', states=np.ones((50000, 2)))\n");
  std::string bytes = readFile(files_.path("a.npz"));
  EXPECT_EQ(errorIn("a.npz"), "");
  bytes.at(bytes.size() / 2) ^= 1;
  files_.write("d.npz", bytes);
  EXPECT_EQ(errorIn("d.npz"), "d.npz, states.npy: reading failed (CRC error)");
}

TEST_F(NumpyFile, HasTheIdentityOfItsContentAndItsJoints) {
  const std::string header = npyHeader(npyDictionary("<f8", "(1, 2)"));
  files_.write("a.npy", header + bytesOf<double>({1.0, 2.0}));
  files_.write("same.npy", header + bytesOf<double>({1.0, 2.0}));
  files_.write("b.npy", header + bytesOf<double>({1.0, std::nextafter(2.0, 3.0)}));
  const std::string identity = open("a.npy", kElbowLift).identity();
  EXPECT_EQ(open("same.npy", kElbowLift).identity(), identity);
  EXPECT_NE(open("b.npy", kElbowLift).identity(), identity);
  EXPECT_NE(open("a.npy", {"lift", "elbow"}).identity(), identity);
}

TEST_F(NumpyFile, TellsWhichStateIsBeyondALimit) {
  files_.write("s.npy", npyHeader(npyDictionary("<f8", "(3, 2)")) + bytesOf<double>({0.0, 0.0, 4.0, 0.0, 5.0, 0.0}));
  NumpyStates states = open("s.npy", kElbowLift);
  states.skipTo(1);
  EXPECT_EQ(restOf(states).size(), 2U);
  EXPECT_EQ(states.limitWarning(),
            files_.path("s.npy") +
                ": 2 of 2 states are beyond the limits of a joint. The first is state 1: \"elbow\" is "
                "at 4 rad, its limits are -2 and 3 rad.");
}

TEST_F(NumpyFile, IsReadOnBehindAStateThatIsWrong) {
  files_.write("s.npy", npyHeader(npyDictionary("<f8", "(3, 2)")) + bytesOf<double>({1.0, 2.0, kNaN, 0.0, 3.0, 4.0}));
  NumpyStates states = open("s.npy", kElbowLift);
  scene::TrajectoryPoint state;
  ASSERT_TRUE(states.next(state));
  EXPECT_NE(errorOf([&] { states.next(state); }).find("s.npy, state 1: column \"elbow\""), std::string::npos);
  EXPECT_EQ(restOf(states), std::vector<Positions>{at(3.0, 4.0, 0.0)});
}

}  // namespace proximity_server::tools::numpy_states_test

// The seeds of the fuzzers, and whatever they have found, in the builds that are not fuzzed.
#include "fuzz/corpus.h"

#include "fuzz/targets.h"

namespace proximity_server::fuzz::corpus_test {

TEST(Corpus, MeshesAreTakenOrRefused) { EXPECT_GT(tryAll("mesh", tryMesh), 5); }

TEST(Corpus, RobotsAreTakenOrRefused) { EXPECT_GT(tryAll("robot", tryRobot), 3); }

TEST(Corpus, StatesAreTakenOrRefused) { EXPECT_GT(tryAll("states", tryStates), 2); }

TEST(Corpus, ObjectFilesAreTakenOrRefused) { EXPECT_GT(tryAll("object_files", tryObjectFile), 4); }

TEST(Corpus, CloudFilesAreReadOrRefused) { EXPECT_GT(tryAll("cloud_files", tryCloudFile), 5); }

}  // namespace proximity_server::fuzz::corpus_test

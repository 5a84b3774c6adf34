// As corpus_test.cpp, for what a node reads.
#include "fuzz/corpus.h"
#include "fuzz/targets.h"

namespace proximity_server::fuzz::node_corpus_test {

TEST(NodeCorpus, RequestsAreAnsweredOrRefused) { EXPECT_GT(tryAll("requests", tryRequest), 4); }

TEST(NodeCorpus, ParametersAreTakenOrRefused) { EXPECT_GT(tryAll("parameters", tryParameters), 2); }

TEST(NodeCorpus, ObjectsAreTakenOrRefused) { EXPECT_GT(tryAll("objects", tryObjects), 4); }

TEST(NodeCorpus, CloudsAreReadOrRefused) { EXPECT_GT(tryAll("clouds", tryCloud), 4); }

}  // namespace proximity_server::fuzz::node_corpus_test

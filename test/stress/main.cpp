// A program of ./dev stress for each campaign, which CMake names.
#include "stress/campaign.h"

int main(int argc, char** argv) {
  using namespace proximity_server::stress;
  return runProgram(PROXIMITY_CAMPAIGN(), argc, argv);
}

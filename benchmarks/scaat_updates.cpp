// Just so many SCAAT updates, for scripts/count-instructions in the tests:   scaat_updates --updates scaat N
#include <cstdlib>

#include "scaat_setting.hpp"

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  return holdfast::benchmarks::only_update<holdfast::benchmarks::Scaat>(std::atoi(argv[3]));
}

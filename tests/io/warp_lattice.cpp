// The CPU warp's prepared lens for every descriptor that is shipped: how far it is from the exact lens.
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/hmd.hpp>
#include <holdfast/io/osvr.hpp>

#include "deflection/lattice_error.hpp"

using namespace holdfast;

TEST_CASE("the prepared lens of every shipped headset is within 0.01 px of the exact one") {
  int descriptors = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HOLDFAST_SOURCE_DIR "/assets/hmds")) {
    if (entry.path().extension() != ".json") continue;
    const HmdModel hmd = io::read_hmd(entry.path());
    for (const LensMode mode : {LensMode::exact, LensMode::cubic}) {
      const WarpLattice lattice(hmd.left, mode);
      const test::LatticeError error = test::lattice_error(lattice, hmd.left, 11);
      MESSAGE(entry.path().stem().string(), ", ", (mode == LensMode::exact ? "exact" : "cubic"), ": worst ",
              error.worst_px, " px, ", lattice.bytes() / 1024, " KiB");
      CHECK(error.worst_px < 0.003);  // the bound of 0.002, and float positions: 3e-4 at 2000 px
      CHECK(error.wrongly_defined == 0);
    }
    ++descriptors;
  }
  CHECK(descriptors >= 5);
}

TEST_CASE("a point mesh's kinks are kept exactly") {
  const std::filesystem::path path = std::filesystem::path(HOLDFAST_RECORDINGS) / "hmd/OSVR_HDK_1_3_with_mesh.json";
  if (!std::filesystem::exists(path)) {
    MESSAGE("skipped: no ", path.string());
    return;
  }
  const HmdModel hmd = io::read_osvr(path).hmd;
  const WarpLattice lattice(hmd.left, LensMode::exact);
  const test::LatticeError error = test::lattice_error(lattice, hmd.left, 5);
  MESSAGE("worst ", error.worst_px, " px, ", lattice.bytes() / 1024, " KiB");
  // Kinks lie between the 81 pixels at which a cell is checked, too.
  CHECK(error.worst_px < 0.01);
  CHECK(error.wrongly_defined == 0);
}

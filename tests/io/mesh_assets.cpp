// Predistortion meshes of real headsets: those of assets/hmds, and OSVR's descriptors where they are at hand.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/io/hmd.hpp>

#include "../optics/mesh_checks.hpp"

using namespace holdfast;

namespace {

void check_meshes(const HmdModel& hmd) {
  const AdaptiveMeshOptions options{.max_error_px = 0.3};
  for (const EyeModel* eye : {&hmd.left, &hmd.right}) {
    const PredistortionMesh mesh = adaptive_mesh(*eye, LensMode::exact, options);
    REQUIRE(mesh.ok());
    CHECK(mesh.max_error_px <= 0.3);
    CHECK(test::dense_error_px(*eye, LensMode::exact, mesh, 8) <= mesh.max_error_px);
    CHECK(test::folds(*eye, mesh) == 0);
    const std::vector<test::Edge> inner = test::inner_outline(mesh);
    // Nothing is left dark but where a lens ends; then there is a border.
    const bool whole = test::covered(mesh) == 1.0;
    CHECK(whole == inner.empty());
  }
}

std::vector<std::filesystem::path> descriptors_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

TEST_CASE("every headset of assets: the bound holds, left and right mirror") {
  for (const auto& file : descriptors_in(HOLDFAST_SOURCE_DIR "/assets/hmds")) {
    const std::string name = file.string();
    CAPTURE(name);
    const HmdModel hmd = io::read_hmd(file);
    check_meshes(hmd);
    const PredistortionMesh left = adaptive_mesh(hmd.left, LensMode::exact, {.max_error_px = 0.3});
    const PredistortionMesh right = adaptive_mesh(hmd.right, LensMode::exact, {.max_error_px = 0.3});
    REQUIRE(left.vertices.size() == right.vertices.size());
    bool mirror = true;
    for (std::size_t i = 0; i < left.vertices.size(); ++i) {
      PredistortionVertex expected = left.vertices[i];
      expected.panel_x = 1.0f - expected.panel_x;
      for (auto& t : expected.tangent) t[0] = -t[0];
      mirror = mirror && right.vertices[i] == expected;
    }
    CHECK(mirror);
  }
}

TEST_CASE("OSVR's headsets, lenses of samples among them") {
  const std::filesystem::path folder = std::filesystem::path(HOLDFAST_RECORDINGS) / "hmd";
  if (!std::filesystem::exists(folder)) {
    MESSAGE("skipped: no descriptors at " << folder.string());
    return;
  }
  int read = 0;
  for (const auto& file : descriptors_in(folder)) {
    const std::string name = file.string();
    CAPTURE(name);
    if (file.filename() == "Oculus_Rift_DK1.json") continue;  // refused: it describes no lens (tests/io/osvr.cpp)
    check_meshes(io::read_hmd(file));
    ++read;
  }
  CHECK(read >= 5);
}

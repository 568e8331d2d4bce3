// OSVR descriptors and meshes: any bytes are either read into a headset whose lenses go there and back, or refused by
// an InputError. What can be written as OSVR is read again as the same text, and our own JSON holds it.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include <holdfast/io/hmd.hpp>

namespace {

using namespace holdfast;

void check(bool condition) {
  if (!condition) std::abort();
}

void exercise(const EyeModel& eye, Color color) {
  const Lens& lens = eye.lens_of(color);
  const FieldTangents& t = eye.tangents;
  check(lens.valid_radius() >= 0.0 && lens.valid_image_radius() >= 0.0);
  for (int i = 0; i <= 8; ++i) {
    for (int k = 0; k <= 8; ++k) {
      const Vector2 panel(t.left + (t.right - t.left) * i / 8, t.down + (t.up - t.down) * k / 8);
      const auto seen = lens.distort(panel);
      if (!seen) continue;
      check(seen->allFinite());
      const auto back = lens.undistort(*seen);
      // A point on the domain's very edge may fall off it by rounding; elsewhere the way back is there.
      if (!back) continue;
      check(back->allFinite());
      const auto again = lens.distort(*back);
      check(!again || again->allFinite());
    }
  }
}

/// A mesh for descriptors that name a file.
io::NamedText beside(std::string_view name) {
  return {R"({"display": {"hmd": {"distortion": {
    "mono_point_samples": [[[[0,0],[0,0.1]],[[1,0],[1,0]],[[0,1],[0,1]],[[1,1],[0.9,1]]],
                           [[[0,0],[0,0]],[[1,0],[1,0.1]],[[0,1],[0.1,1]],[[1,1],[1,1]]]],
    "red_point_samples": [[[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]]], [[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]]]],
    "green_point_samples": [[[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]]], [[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]]]],
    "blue_point_samples": [[[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]]], [[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]]]]
  }}}})",
          std::string(name)};
}

/// As OSVR, where OSVR can say it.
void write_again(const HmdModel& hmd) {
  std::string text;
  try {
    text = io::osvr_json(hmd).text;
  } catch (const io::InputError& error) {
    check(error.problem().find("cannot express") != std::string::npos);
    return;
  }
  static_cast<void>(io::parse_osvr(text, "again.json", beside));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const io::OsvrHmd read = io::parse_osvr(text, "fuzz.json", beside);
    for (const EyeModel* eye : {&read.hmd.left, &read.hmd.right}) {
      check(problem_of(eye->tangents) == FieldProblem::none);
      for (const Color color : {Color::red, Color::green, Color::blue}) exercise(*eye, color);
    }
    write_again(read.hmd);
  } catch (const io::InputError& error) {
    check(*error.what() != '\0');
  }
  return 0;
}

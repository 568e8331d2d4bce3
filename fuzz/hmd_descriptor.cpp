// Headset descriptors: any bytes are either read into a model that projects, and that is written and read again to the
// same text, or refused by an InputError.
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

void exercise(const EyeModel& eye) {
  check(problem_of(eye.tangents) == FieldProblem::none);
  const Vector2 centre(eye.resolution.width / 2.0, eye.resolution.height / 2.0);
  check(ray_E(eye, centre).allFinite());
  check(projection_matrix(eye, ClipPlanes{}).allFinite());
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
      for (const Vector2& pixel : {Vector2(0.5, 0.5), centre}) {
        const auto seen = seen_pixel(eye, mode, pixel, color);
        check(!seen || seen->allFinite());
        const auto ideal = ideal_pixel(eye, mode, pixel, color);
        check(!ideal || ideal->allFinite());
      }
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const HmdModel hmd = io::parse_hmd(text, "fuzz.json");
    exercise(hmd.left);
    exercise(hmd.right);
    const std::string written = io::hmd_json(hmd);
    const HmdModel again = io::parse_hmd(written, "again.json");
    check(io::hmd_json(again) == written);
  } catch (const io::InputError& error) {
    check(*error.what() != '\0');
    check(error.file() != "again.json");  // what we write we must be able to read
  }
  return 0;
}

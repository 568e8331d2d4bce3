// Cardboard viewers as address, buffer or JSON: any bytes are either read into a viewer that all three forms hold and
// that makes a headset with a phone, or refused by an InputError.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include <holdfast/io/cardboard.hpp>

namespace {

using namespace holdfast;

void check(bool condition) {
  if (!condition) std::abort();
}

void exercise(const io::CardboardViewer& viewer) {
  check(!io::problem_of(viewer));
  check(io::parse_cardboard_buffer(io::cardboard_buffer(viewer), "again") == viewer);
  check(io::parse_cardboard(io::cardboard_uri(viewer), "again") == viewer);
  io::CardboardViewer plain = viewer;  // JSON holds names in UTF-8 alone
  plain.vendor = plain.model = "name";
  check(io::parse_cardboard(io::cardboard_json(plain), "again") == plain);
  static_cast<void>(io::cardboard_json(viewer));
  const io::PhoneScreen phone{0.11, 0.062, {1920, 1080}, 60.0};
  if (io::problem_of(viewer, phone)) return;
  const HmdModel hmd = io::cardboard_hmd(viewer, phone);
  check(problem_of(hmd.left.tangents) == FieldProblem::none);
  check(projection_matrix(hmd.left, ClipPlanes{}).allFinite());
  const auto seen = hmd.left.lens.distort(Vector2(0.3, 0.2));
  check(!seen || seen->allFinite());
  for (const EyeModel* eye : {&hmd.left, &hmd.right}) {
    const FieldTangents drawn = io::drawn_field(viewer, *eye);
    check(drawn.left <= 0.0 && drawn.right >= 0.0 && drawn.down <= 0.0 && drawn.up >= 0.0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    exercise(io::parse_cardboard(text, "fuzz"));
  } catch (const io::InputError& error) {
    check(error.file() == "fuzz");
  }
  try {
    exercise(io::parse_cardboard_buffer(text, "fuzz"));
  } catch (const io::InputError& error) {
    check(error.file() == "fuzz");
  }
  return 0;
}

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/hmd.hpp>

using namespace holdfast;

namespace {

const std::string good = R"({
  "meta": {"schemaVersion": 1},
  "hmd": {
    "device": {"vendor": "Maker", "model": "One", "Version": "2", "Note": "any"},
    "field_of_view": {
      "monocular_horizontal": 90,
      "monocular_vertical": 80,
      "overlap_percent": 100,
      "pitch_tilt": 0
    },
    "resolutions": [
      {"width": 1920, "height": 1080, "video_inputs": 1, "display_mode": "horz_side_by_side", "swap_eyes": 0}
    ],
    "distortion": {
      /* comments are allowed */
      "distance_scale_x": 1,
      "distance_scale_y": 1.5,
      "polynomial_coeffs_red": [0, 1, 0.1, 0.2],
      "polynomial_coeffs_green": [0, 1, 0.1, 0.3],
      "polynomial_coeffs_blue": [0, 1, 0.1, 0.4]
    },
    "rendering": {"right_roll": 0, "left_roll": 0},
    "eyes": [
      {"center_proj_x": 0.45, "center_proj_y": 0.6, "rotate_180": 0},
      {"center_proj_x": 0.55, "center_proj_y": 0.6, "rotate_180": 0}
    ]
  }
}
)";

std::string with(const std::string& old_text, const std::string& new_text, std::string text = good) {
  const std::size_t at = text.find(old_text);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old_text.size(), new_text);
}

/// `good` with another distortion.
std::string distorted(const std::string& distortion) {
  const std::size_t begin = good.find("{\n      /* comments");
  const std::size_t end = good.find("},\n    \"rendering\"") + 1;
  return good.substr(0, begin) + distortion + good.substr(end);
}

const io::BesideReader nothing_beside = [](std::string_view name) -> io::NamedText {
  throw io::InputError({.file = std::string(name), .problem = "is not there", .expected = "the file"});
};

HmdModel read(const std::string& text, const io::BesideReader& beside = nothing_beside) {
  return io::parse_osvr(text, "test.json", beside).hmd;
}

io::InputError error_of(const std::string& text, const io::BesideReader& beside = nothing_beside) {
  try {
    static_cast<void>(read(text, beside));
  } catch (const io::InputError& error) {
    return error;
  }
  FAIL("accepted:\n" << text);
  return io::InputError({});
}

void check_error(const std::string& text, std::size_t line, const std::string& key, const std::string& problem) {
  const io::InputError error = error_of(text);
  CAPTURE(std::string(error.what()));
  CHECK(error.file() == "test.json");
  CHECK(error.line() == line);
  CHECK(error.key() == key);
  CHECK(error.problem().find(problem) != std::string::npos);
  CHECK_FALSE(error.expected().empty());
}

/// A mesh of one eye that moves x by `shift`: 3 x 3 samples.
std::string mesh(double shift, int rows = 3) {
  std::string text = "[";
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < rows; ++k) {
      const auto number = [](double x) { return std::to_string(x); };
      text += (text.size() > 1 ? "," : "") + std::string("[[") + number(i / 2.0) + "," + number(k / double(rows - 1)) +
              "],[" + number(i / 2.0 + shift) + "," + number(k / double(rows - 1)) + "]]";
    }
  }
  return text + "]";
}

std::filesystem::path recorded(const char* name) {
  return std::filesystem::path(HOLDFAST_RECORDINGS) / "hmd" / name;
}

bool is_absent(const std::filesystem::path& file) {
  if (std::filesystem::exists(file)) return false;
  MESSAGE("skipped: " << file.string() << " is absent");
  return true;
}

/// OSVR's own formula, in fractions of the screen (DistortionCorrectRGBSymmetricPolynomials, with COP in the same space).
Vector2 osvr_formula(const Vector2& p, const Vector2& cop, const Vector2& D, const std::vector<double>& a) {
  const Vector2 o = (p - cop).cwiseProduct(D);
  const double r = o.norm();
  double sum = 0.0;
  for (std::size_t i = a.size(); i-- > 0;) sum = sum * r + a[i];
  return cop + (sum / r * o).cwiseQuotient(D);
}

Vector2 fraction_of(const EyeModel& eye, const Vector2& tangent) {
  const FieldTangents& t = eye.tangents;
  return {(tangent.x() - t.left) / (t.right - t.left), (tangent.y() - t.down) / (t.up - t.down)};
}
Vector2 tangent_of(const EyeModel& eye, const Vector2& fraction) {
  const FieldTangents& t = eye.tangents;
  return {t.left + fraction.x() * (t.right - t.left), t.down + fraction.y() * (t.up - t.down)};
}

}  // namespace

TEST_CASE("field, centre of projection, resolution, name") {
  const HmdModel hmd = read(good);
  CHECK(hmd.name == "Maker One 2");
  const double w = 2.0, h = 2.0 * std::tan(40 * std::numbers::pi / 180);
  CHECK(hmd.left.tangents.left == doctest::Approx(-0.45 * w).epsilon(1e-14));
  CHECK(hmd.left.tangents.right == doctest::Approx(0.55 * w).epsilon(1e-14));
  CHECK(hmd.left.tangents.down == doctest::Approx(-0.6 * h).epsilon(1e-14));
  CHECK(hmd.left.tangents.up == doctest::Approx(0.4 * h).epsilon(1e-14));
  CHECK(hmd.right.tangents.left == doctest::Approx(-0.55 * w).epsilon(1e-14));
  CHECK(hmd.left.resolution == PixelSize{960, 1080});
  CHECK(hmd.ipd_m == 0.063);
  CHECK(hmd.left.X_HE.p() == Vector3(-0.0315, 0, 0));
  CHECK(hmd.left.X_HE.q().w() == 1.0);
  CHECK(hmd.source.find("assumed") != std::string::npos);
  CHECK(read(with("\"horz_side_by_side\"", "\"vert_side_by_side\"")).left.resolution == PixelSize{1920, 540});
  CHECK(read(with("\"horz_side_by_side\"", "\"full_screen\"")).left.resolution == PixelSize{1920, 1080});
  CHECK(read(with(", \"display_mode\": \"horz_side_by_side\"", "")).left.resolution == PixelSize{960, 1080});
}

TEST_CASE("polynomials are OSVR's formula, per colour") {
  const HmdModel hmd = read(good);
  const std::map<Color, std::vector<double>> a{
      {Color::red, {0, 1, 0.1, 0.2}}, {Color::green, {0, 1, 0.1, 0.3}}, {Color::blue, {0, 1, 0.1, 0.4}}};
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> u(0, 1);
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    const EyeModel& eye = hmd.eye(side);
    const Vector2 cop(side == EyeSide::left ? 0.45 : 0.55, 0.6);
    for (const auto& [color, k] : a) {
      for (int i = 0; i < 200; ++i) {
        const Vector2 p(u(random), u(random));
        const auto seen = eye.lens_of(color).distort(tangent_of(eye, p));
        REQUIRE(seen);
        // Tangents and fractions are of size 1: some roundings.
        CHECK((fraction_of(eye, *seen) - osvr_formula(p, cop, Vector2(1, 1.5), k)).norm() < 1e-14);
        const auto back = eye.lens_of(color).undistort(*seen);
        REQUIRE(back);
        CHECK((*back - tangent_of(eye, p)).norm() < 1e-13);
      }
    }
  }
}

TEST_CASE("equal colours are one lens, and the identity is none") {
  const std::string same = R"({"polynomial_coeffs_red": [0, 1, 0.1], "polynomial_coeffs_green": [0, 1, 0.1],
    "polynomial_coeffs_blue": [0, 1, 0.1]})";
  CHECK_FALSE(read(distorted(same)).left.lens_red.has_value());
  CHECK(read(distorted(same)).left.lens.model_if<PowerSeriesLens>() != nullptr);
  const std::string identity = R"({"type": "rgb_symmetric_polynomials", "polynomial_coeffs_red": [0, 1],
    "polynomial_coeffs_green": [0, 1, 0, 0], "polynomial_coeffs_blue": [0, 1]})";
  CHECK(read(distorted(identity)).left.lens.model_if<NoLens>() != nullptr);
}

TEST_CASE("an overlap below 100 % turns each eye outward by half of what is missing") {
  const HmdModel hmd = read(with("\"overlap_percent\": 100", "\"overlap_percent\": 80"));
  // 90 degrees, 20 % of them not shared: 9 degrees for each eye.
  const Vector3 axis = hmd.left.X_HE.q() * Vector3(0, 0, -1);
  CHECK(std::atan2(-axis.x(), -axis.z()) * 180 / std::numbers::pi == doctest::Approx(9).epsilon(1e-12));
  CHECK(hmd.right.X_HE.q().y() == doctest::Approx(-hmd.left.X_HE.q().y()).epsilon(1e-15));
  check_error(with("\"overlap_percent\": 100", "\"overlap_percent\": 120"), 8, "hmd.field_of_view.overlap_percent",
              "out of range");
}

TEST_CASE("pitch_tilt lowers the picture, and with it the lens") {
  const HmdModel level = read(good);
  const HmdModel tilted = read(with("\"pitch_tilt\": 0", "\"pitch_tilt\": 10"));
  const double drop = std::tan(10 * std::numbers::pi / 180);
  CHECK(tilted.left.tangents.up == doctest::Approx(level.left.tangents.up - drop).epsilon(1e-14));
  CHECK(tilted.left.tangents.down == doctest::Approx(level.left.tangents.down - drop).epsilon(1e-14));
  CHECK((tilted.left.lens.centre() - Vector2(0, -drop)).norm() < 1e-15);
  const Vector2 p(0.3, 0.8);
  CHECK((fraction_of(tilted.left, *tilted.left.lens.distort(tangent_of(tilted.left, p))) -
         fraction_of(level.left, *level.left.lens.distort(tangent_of(level.left, p))))
            .norm() < 1e-14);
}

TEST_CASE("upside-down panels, swapped eyes, legacy device properties") {
  const HmdModel turned = read(with("\"rotate_180\": 0", "\"rotate_180\": 1"));
  CHECK(turned.left.upside_down);
  CHECK_FALSE(turned.right.upside_down);
  CHECK(turned.left.tangents == read(good).left.tangents);
  const io::OsvrHmd swapped = io::parse_osvr(with("\"swap_eyes\": 0", "\"swap_eyes\": true"), "t", nothing_beside);
  CHECK(swapped.swap_eyes);
  CHECK(swapped.hmd.source.find("change places") != std::string::npos);
  CHECK(read(with("{\"vendor\": \"Maker\", \"model\": \"One\", \"Version\": \"2\", \"Note\": \"any\"}",
                  "{\"properties\": {\"vendor\": \"Old\", \"model\": \"Way\"}}"))
            .name == "Old Way");
}

TEST_CASE("k1 alone is refused, zero k1 means no distortion, k1 beside polynomials is of no effect") {
  const std::string k1 = "{\n\"type\": \"rgb_k1_coefficients\",\n\"k1_red\": 0,\n\"k1_green\": 0.5, \"k1_blue\": 0}";
  check_error(distorted(k1), 17, "hmd.distortion.k1_green", "RenderManager ignores it");
  CHECK(error_of(distorted(R"({"k1_red": 0.1, "k1_green": 0, "k1_blue": 0})")).key() == "hmd.distortion.k1_red");
  const io::OsvrHmd none =
      io::parse_osvr(distorted(R"({"k1_red": 0, "k1_green": 0, "k1_blue": 0})"), "t", nothing_beside);
  CHECK(none.hmd.left.lens.model_if<NoLens>() != nullptr);
  CHECK(none.hmd.source.find("free of it") != std::string::npos);
  CHECK(read(with("\"distance_scale_x\": 1,", "\"distance_scale_x\": 1, \"k1_red\": 0.3,")).left.lens_red.has_value());
}

TEST_CASE("meshes: screen fractions to canonical fractions, for each eye and colour") {
  const std::string mono = "{\"mono_point_samples\": [" + mesh(0.1) + "," + mesh(-0.1) + "]}";
  const HmdModel hmd = read(distorted(mono));
  for (const auto& [side, shift] : {std::pair(EyeSide::left, 0.1), std::pair(EyeSide::right, -0.1)}) {
    const EyeModel& eye = hmd.eye(side);
    for (const Vector2& p : {Vector2(0.3, 0.4), Vector2(0.99, 0.01), Vector2(0.5, 0.5)}) {
      const auto seen = eye.lens.distort(tangent_of(eye, p));
      REQUIRE(seen);
      CHECK((fraction_of(eye, *seen) - (p + Vector2(shift, 0))).norm() < 1e-14);
    }
    CHECK_FALSE(eye.lens.distort(tangent_of(eye, Vector2(1.01, 0.5))).has_value());
  }
  CHECK_FALSE(hmd.left.lens_red.has_value());
  const auto colour = [](const char* name, double shift) {
    return "\"" + std::string(name) + "_point_samples\": [" + mesh(shift) + "," + mesh(shift) + "]";
  };
  const HmdModel rgb = read(distorted("{\"type\": \"rgb_point_samples\"," + colour("red", 0.1) + "," +
                                      colour("green", 0.05) + "," + colour("blue", 0.05) + "}"));
  CHECK(rgb.left.lens_red.has_value());
  CHECK_FALSE(rgb.left.lens_blue.has_value());
  const Vector2 p(0.3, 0.4);
  CHECK((fraction_of(rgb.left, *rgb.left.lens_of(Color::red).distort(tangent_of(rgb.left, p))) - Vector2(0.4, 0.4))
            .norm() < 1e-14);
}

TEST_CASE("meshes from files beside the descriptor; built-in ones too; a missing one is named") {
  const std::string file =
      "{\"display\": {\"hmd\": {\"distortion\": {\"mono_point_samples\": [" + mesh(0.2) + "," + mesh(0.2) + "]}}}}";
  std::string asked;
  const io::BesideReader beside = [&](std::string_view name) {
    asked = name;
    return io::NamedText{file, "folder/" + std::string(name)};
  };
  const auto shift_of = [&](const std::string& distortion) {
    const HmdModel hmd = read(distorted(distortion), beside);
    return fraction_of(hmd.left, *hmd.left.lens.distort(tangent_of(hmd.left, Vector2(0.5, 0.5)))).x() - 0.5;
  };
  CHECK(shift_of(R"({"type": "mono_point_samples", "mono_point_samples_built_in": "OSVR_HDK_13_V2"})") ==
        doctest::Approx(0.2));
  CHECK(asked == "builtin_osvr_hdk13_v2.json");
  CHECK(shift_of(R"({"mono_point_samples_external_file": "mine.json"})") == doctest::Approx(0.2));
  CHECK(asked == "mine.json");
  const io::InputError missing = error_of(distorted(R"({"mono_point_samples_external_file": "mine.json"})"));
  CHECK(missing.file() == "mine.json");
  check_error(distorted(R"({"mono_point_samples_built_in": "OSVR_HDK_99"})"), 14,
              "hmd.distortion.mono_point_samples_built_in", "unknown word");
  for (const char* name : {"../up.json", "/etc/passwd", "a\\\\b", "c:x", "", ".."}) {
    const std::string text = distorted("{\"mono_point_samples_external_file\": \"" + std::string(name) + "\"}");
    CHECK(error_of(text, beside).problem().find("plain name") != std::string::npos);
  }
  // A fault in the other file is named by that file and its line.
  const io::BesideReader broken = [](std::string_view) { return io::NamedText{"{\n\"hmd\": {}}", "other.json"}; };
  const io::InputError error = error_of(distorted(R"({"mono_point_samples_external_file": "mine.json"})"), broken);
  CHECK(error.file() == "other.json");
  CHECK(error.line() == 2);
  CHECK(error.key() == "hmd.distortion");
}

TEST_CASE("an eye may have a distortion of its own") {
  const std::string own = R"("rotate_180": 0, "distortion": {"polynomial_coeffs_red": [0, 1, 0.7],
    "polynomial_coeffs_green": [0, 1, 0.7], "polynomial_coeffs_blue": [0, 1, 0.7]}})";
  const HmdModel hmd = read(with("\"rotate_180\": 0}", own));
  CHECK_FALSE(hmd.left.lens_red.has_value());
  CHECK(hmd.right.lens_red.has_value());
}

TEST_CASE("bad input is refused with line, key and reason") {
  check_error(with("\"monocular_horizontal\": 90", "\"monocular_horizontal\": 0"), 6,
              "hmd.field_of_view.monocular_horizontal", "out of range");
  check_error(with("\"monocular_vertical\": 80", "\"monocular_vertical\": 180"), 7,
              "hmd.field_of_view.monocular_vertical", "out of range");
  check_error(with("[0, 1, 0.1, 0.3]", "[0.01, 1, 0.1, 0.3]"), 19, "hmd.distortion.polynomial_coeffs_green[0]",
              "tears");
  check_error(with("[0, 1, 0.1, 0.3]", "[0, -1, 0.1, 0.3]"), 19, "hmd.distortion.polynomial_coeffs_green",
              "folds over");
  check_error(with("[0, 1, 0.1, 0.3]", "[0]"), 19, "hmd.distortion.polynomial_coeffs_green", "wrong number");
  check_error(with("[0, 1, 0.1, 0.3]", "[0, 1, 1e10]"), 19, "hmd.distortion.polynomial_coeffs_green[2]",
              "out of range");
  check_error(with("\"polynomial_coeffs_blue\"", "\"polynomial_coefs_blue\""), 20,
              "hmd.distortion.polynomial_coefs_blue", "unknown key");
  check_error(with("\"distance_scale_x\": 1", "\"distance_scale_x\": 0"), 16, "hmd.distortion.distance_scale_x",
              "out of range");
  check_error(with("\"left_roll\": 0", "\"left_roll\": 3"), 22, "hmd.rendering.left_roll", "rolled");
  check_error(with("\"width\": 1920", "\"width\": 1921"), 12, "hmd.resolutions[0].width", "equally");
  check_error(with("horz_side_by_side", "diagonal"), 12, "hmd.resolutions[0].display_mode", "unknown word");
  check_error(with("\"rotate_180\": 0", "\"rotate_180\": 90"), 24, "hmd.eyes[0].rotate_180", "out of range");
  check_error(with(",\n      {\"center_proj_x\": 0.55, \"center_proj_y\": 0.6, \"rotate_180\": 0}", ""), 23, "hmd.eyes",
              "wrong number");
  check_error(with("\"center_proj_x\": 0.45", "\"center_proj_x\": 45"), 24, "hmd.eyes[0].center_proj_x",
              "out of range");
  check_error(with("\"type\"", "\"type\"", distorted(R"({"type": "fisheye"})")), 14, "hmd.distortion.type",
              "unknown word");
}

TEST_CASE("bad meshes are refused with the sample and the reason") {
  const auto mono = [](const std::string& left) {
    return distorted("{\n\"mono_point_samples\": [\n" + left + ",\n" + mesh(0) + "]}");
  };
  check_error(mono("[]"), 16, "hmd.distortion.mono_point_samples[0]", "wrong number");
  check_error(mono("[[[0,0],[0,0]],[[1,0],[1,0]],[[0,1]]]"), 16, "hmd.distortion.mono_point_samples[0][2]",
              "wrong number");
  check_error(mono("[[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,\"1\"]]]"), 16,
              "hmd.distortion.mono_point_samples[0][2][1][1]", "not a number");
  check_error(mono("[[[0,0],[0,0]],[[1,0],[1,0]],[[0,1],[0,1]],\n[[1,0],[1,0.1]]]"), 17,
              "hmd.distortion.mono_point_samples[0][3]", "same panel point");
  check_error(mono("[[[0,0],[0,0]],[[0,1],[1,0]],[[0,2],[0,1]]]"), 16, "hmd.distortion.mono_point_samples[0]",
              "one line");
  check_error(mono("[[[0,0],[0,0]],[[1,0],[-1,0]],[[0,1],[0,1]]]"), 16, "hmd.distortion.mono_point_samples[0]", "fold");
  check_error(distorted("{\n\"mono_point_samples\": [" + mesh(0) + "]}"), 15, "hmd.distortion.mono_point_samples",
              "wrong number");
  const auto rgb = [](const std::string& green) {
    return distorted("{\n\"red_point_samples\": [" + mesh(0) + "," + mesh(0) + "],\n\"green_point_samples\": [" +
                     green + "," + mesh(0) + "],\n\"blue_point_samples\": [" + mesh(0) + "," + mesh(0) + "]}");
  };
  CHECK_NOTHROW(static_cast<void>(read(rgb(mesh(0)))));
  check_error(rgb(mesh(0, 4)), 16, "hmd.distortion.green_point_samples[0]",
              "differ in length: red has 9 samples, green 12");
}

TEST_CASE("what OSVR can say is written, and means the same when it is read again") {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> u(0, 1);
  const std::string mono = distorted("{\"mono_point_samples\": [" + mesh(0.1) + "," + mesh(-0.1) + "]}");
  const std::string tilted =
      with("\"pitch_tilt\": 0", "\"pitch_tilt\": 7", with("\"overlap_percent\": 100", "\"overlap_percent\": 85"));
  for (const std::string& text : {good, mono, tilted, with("\"rotate_180\": 0", "\"rotate_180\": 1")}) {
    const HmdModel a = read(text);
    const io::OsvrText written = io::osvr_json(a);
    CHECK_FALSE(written.left_out.empty());
    const HmdModel b = read(written.text);
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      const EyeModel& x = a.eye(side);
      const EyeModel& y = b.eye(side);
      CHECK(y.resolution == x.resolution);
      CHECK(y.upside_down == x.upside_down);
      CHECK((y.X_HE.p() - x.X_HE.p()).norm() < 1e-15);
      CHECK(y.X_HE.q().angularDistance(x.X_HE.q()) < 1e-13);
      CHECK(std::abs(y.tangents.left - x.tangents.left) < 1e-13);  // 15 digits in the file
      CHECK(std::abs(y.tangents.up - x.tangents.up) < 1e-13);
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        for (int i = 0; i < 50; ++i) {
          const Vector2 t = tangent_of(x, Vector2(0.01 + 0.98 * u(random), 0.01 + 0.98 * u(random)));
          const auto seen_a = x.lens_of(color).distort(t);
          const auto seen_b = y.lens_of(color).distort(t);
          REQUIRE(seen_a);
          REQUIRE(seen_b);
          CHECK((*seen_a - *seen_b).norm() < 1e-12);
        }
      }
    }
  }
}

TEST_CASE("meshes for each colour, and every display mode, are written too") {
  const auto colour = [](const char* name, double shift) {
    return "\"" + std::string(name) + "_point_samples\": [" + mesh(shift) + "," + mesh(-shift) + "]";
  };
  const HmdModel a =
      read(distorted("{" + colour("red", 0.1) + "," + colour("green", 0.05) + "," + colour("blue", 0.05) + "}"));
  for (const auto mode : {io::OsvrDisplayMode::side_by_side, io::OsvrDisplayMode::one_above_the_other,
                          io::OsvrDisplayMode::full_screen}) {
    const io::OsvrHmd back = io::parse_osvr(io::osvr_json(a, mode).text, "back", nothing_beside);
    CHECK(back.display_mode == mode);
    CHECK(back.hmd.left.resolution == a.left.resolution);
    CHECK(back.hmd.right.lens_red.has_value());
    CHECK_FALSE(back.hmd.right.lens_blue.has_value());
    for (const Color color : {Color::red, Color::green, Color::blue}) {
      const Vector2 t(0.2, -0.3);
      CHECK((*back.hmd.right.lens_of(color).distort(t) - *a.right.lens_of(color).distort(t)).norm() < 1e-13);
    }
  }
}

TEST_CASE("our other radial lenses become OSVR polynomials too") {
  HmdModel hmd = default_hmd();
  hmd.left.lens = Lens(PolynomialLens(std::vector<double>{0.2, 0.1}), placed_at(0.7));
  hmd.left.lens_red = Lens(RadialLens{0.15}, placed_at(0.6));  // another unit
  hmd.right = mirrored(hmd.left);
  const HmdModel back = read(io::osvr_json(hmd).text);
  for (const Color color : {Color::red, Color::green}) {
    for (const Vector2& t : {Vector2(0.2, 0.1), Vector2(-0.5, 0.3)}) {
      CHECK((*back.left.lens_of(color).distort(t) - *hmd.left.lens_of(color).distort(t)).norm() < 1e-13);
      CHECK((*back.right.lens_of(color).distort(t) - *hmd.right.lens_of(color).distort(t)).norm() < 1e-13);
    }
  }
}

TEST_CASE("what OSVR cannot say is refused by its name") {
  const auto refusal = [](const std::function<void(HmdModel&)>& change) {
    HmdModel hmd = default_hmd();
    change(hmd);
    try {
      static_cast<void>(io::osvr_json(hmd));
    } catch (const io::InputError& error) {
      return error.problem();
    }
    return std::string();
  };
  CHECK(refusal([](HmdModel&) {}).empty());
  CHECK(refusal([](HmdModel& h) { h.left.lens = ViveLens(); }).find("no polynomial") != std::string::npos);
  CHECK(refusal([](HmdModel& h) { h.left.tangents.left *= 2; }).find("different size") != std::string::npos);
  CHECK(refusal([](HmdModel& h) { h.left.resolution.width = 8; }).find("resolutions") != std::string::npos);
  CHECK(refusal([](HmdModel& h) {
          h.left.X_HE = eye_pose(EyeSide::left, h.ipd_m, degrees(0), degrees(5));
        }).find("tilted") != std::string::npos);
  CHECK(refusal([](HmdModel& h) {
          h.left.X_HE = eye_pose(EyeSide::left, h.ipd_m, degrees(10));
        }).find("different angles") != std::string::npos);
  CHECK(refusal([](HmdModel& h) {
          for (EyeModel* e : {&h.left, &h.right}) e->X_HE = eye_pose(e->side, h.ipd_m, degrees(-10));
        }).find("converging") != std::string::npos);
  CHECK(refusal([](HmdModel& h) { h.left.X_HE = eye_pose(EyeSide::left, 0.1); }).find("beside its place") !=
        std::string::npos);
  CHECK(refusal([](HmdModel& h) {
          h.left.lens = moved(h.left.lens, 1.0, Vector2(0.1, 0));
        }).find("centre of projection") != std::string::npos);
  CHECK(refusal([](HmdModel& h) { h.right.lens = RadialLens{0.9}; }) != "");
}

TEST_CASE("OSVR's own descriptors") {
  if (is_absent(recorded("OSVR_HDK_2_0.json"))) return;
  struct Expected {
    const char* file;
    const char* name;
    PixelSize eye;
  };
  for (const Expected& e : {Expected{"OSVR_HDK_1_1.json", "OSVR HDK 1.2", {960, 1080}},
                            Expected{"OSVR_HDK_1_3.json", "OSVR HDK 1.3", {960, 1080}},
                            Expected{"OSVR_HDK_1_3_with_mesh.json", "OSVR HDK 1.3", {960, 1080}},
                            Expected{"OSVR_HDK_2_0.json", "OSVR HDK 2.0", {1080, 1200}},
                            Expected{"Oculus_Rift_DK2.json", "Oculus Rift DK2", {960, 1080}},
                            Expected{"Vrvana_Totem.json", "Vrvana Totem 1", {1280, 1440}}}) {
    const HmdModel hmd = io::read_hmd(recorded(e.file));
    CHECK(hmd.name == e.name);
    CHECK(hmd.left.resolution == e.eye);
    for (const EyeModel* eye : {&hmd.left, &hmd.right}) {
      // Exact there and back: to 1e-6 px wherever the lens answers.
      const double px = eye->resolution.width / (eye->tangents.right - eye->tangents.left);
      int answered = 0;
      for (double x = 0.01; x < 1; x += 0.0271) {
        for (double y = 0.01; y < 1; y += 0.0271) {
          const Vector2 panel = tangent_of(*eye, Vector2(x, y));
          const auto seen = eye->lens.distort(panel);
          if (!seen) continue;
          const auto back = eye->lens.undistort(*seen);
          REQUIRE(back);
          CHECK((*back - panel).norm() * px < 1e-6);
          ++answered;
        }
      }
      CHECK(answered > 1000);  // of 1369
    }
  }
  // Refused: a lens given by k1 alone.
  try {
    static_cast<void>(io::read_hmd(recorded("Oculus_Rift_DK1.json")));
    FAIL("accepted");
  } catch (const io::InputError& error) {
    CHECK(error.line() == 29);
    CHECK(error.key() == "hmd.distortion.k1_red");
    CHECK(error.value() == "0.696995");
  }
}

TEST_CASE("OSVR's mesh files stand alone, too, and the left eye's mirrors the right one's") {
  for (const char* name : {"builtin_osvr_hdk13_v1.json", "builtin_osvr_hdk13_v2.json", "builtin_osvr_hdk20_v1.json",
                           "HDK13_mesh_client.json"}) {
    if (is_absent(recorded(name))) continue;
    const HmdModel hmd = io::read_hmd(recorded(name));
    const PointMesh& left = hmd.left.lens.model_if<PointMeshLens>()->mesh();
    const PointMesh& right = hmd.right.lens.model_if<PointMeshLens>()->mesh();
    CHECK(left.samples.size() == right.samples.size());
    CHECK(left.samples.size() > 1400);
    // HDK 2.0's file has samples some degrees off their neighbours; the others have none.
    const bool has_wild_samples = std::string(name) == "builtin_osvr_hdk20_v1.json";
    CHECK(left.folds.empty() != has_wild_samples);
    CHECK(left.folds.size() < 80);
    CHECK(hmd.left.lens.valid_radius() > 0.75);  // of a panel whose half height is 0.95 to 1.04
    double worst = 0.0;
    for (double x = -0.6; x <= 0.6; x += 0.1) {
      for (double y = -0.4; y <= 0.4; y += 0.1) {
        const auto a = hmd.left.lens.distort(Vector2(x, y));
        const auto b = hmd.right.lens.distort(Vector2(-x, y));
        REQUIRE(a);
        REQUIRE(b);
        worst = std::max(worst, (Vector2(-b->x(), b->y()) - *a).norm());
      }
    }
    CHECK(worst < 0.005);  // samples have 4 digits, and the two triangulations differ
  }
}

TEST_CASE("a mesh file that is not there is said to be missing where it was looked for") {
  const auto folder = std::filesystem::temp_directory_path() / "holdfast_osvr_test";
  std::filesystem::create_directories(folder);
  io::write_whole_file(folder / "hmd.json", distorted(R"({"mono_point_samples_built_in": "OSVR_HDK_20_V1"})"));
  try {
    static_cast<void>(io::read_hmd(folder / "hmd.json"));
    FAIL("accepted");
  } catch (const io::InputError& error) {
    CHECK(error.file() == (folder / "builtin_osvr_hdk20_v1.json").string());
  }
  const std::vector<std::string> left_out = io::write_osvr(folder / "written.json", default_hmd());
  CHECK(left_out.size() >= 2);
  CHECK(io::read_hmd(folder / "written.json").left.resolution == PixelSize{1280, 720});
  std::filesystem::remove_all(folder);
}

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/io/hmd.hpp>

using namespace holdfast;

namespace {

const std::string good = R"({
  "schema": "holdfast/hmd/1",
  "name": "test",
  "source": "invented",  // comments are welcome
  "ipd_m": 0.062,
  "timing": {"refresh_hz": 90, "scan_out": "rolling", "scan_duration_ms": 10.5},
  "eyes": {
    "left": {
      "resolution_px": [640, 512],
      "tangents": {
        "left": -0.8, "right": 0.6,
        "down": -0.5, "up": 0.45
      },
      "lens": {"model": "radial", "k": 0.1933, "r_norm": 0.5}
    },
    "right": "mirrored"
  }
}
)";

/// `good` with one text replaced by another; both must be found, or the test is wrong.
std::string with(const std::string& old_text, const std::string& new_text, std::string text = good) {
  const std::size_t at = text.find(old_text);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old_text.size(), new_text);
}

io::InputError error_of(const std::string& text) {
  try {
    static_cast<void>(io::parse_hmd(text, "test.json"));
  } catch (const io::InputError& error) {
    return error;
  }
  FAIL("accepted:\n" << text);
  return io::InputError({});
}

void check_error(const std::string& text, std::size_t line, const std::string& key, const std::string& problem,
                 const std::string& value) {
  const io::InputError error = error_of(text);
  CAPTURE(std::string(error.what()));
  CHECK(error.file() == "test.json");
  CHECK(error.line() == line);
  CHECK(error.key() == key);
  CHECK(error.problem().find(problem) != std::string::npos);
  CHECK(error.value() == value);
  CHECK_FALSE(error.expected().empty());
}

std::uint64_t bits(double value) {
  return std::bit_cast<std::uint64_t>(value);
}

HmdModel reread(const HmdModel& hmd) {
  return io::parse_hmd(io::hmd_json(hmd), "reread");
}

}  // namespace

TEST_CASE("a good descriptor is read") {
  const HmdModel hmd = io::parse_hmd(good, "test.json");
  CHECK(hmd.name == "test");
  CHECK(hmd.ipd_m == 0.062);
  CHECK(hmd.timing.refresh_hz == 90.0);
  CHECK(hmd.timing.scan_out == ScanOut::rolling);
  CHECK(hmd.timing.scan_duration == from_milliseconds(10.5));
  CHECK(hmd.left.resolution == PixelSize{640, 512});
  CHECK(hmd.left.tangents == FieldTangents{-0.8, 0.6, -0.5, 0.45});
  CHECK(hmd.right.tangents == FieldTangents{-0.6, 0.8, -0.5, 0.45});
  CHECK(hmd.left.X_HE.p() == Vector3(-0.031, 0, 0));
  const Lens& lens = hmd.left.lens;
  REQUIRE(lens.model_if<RadialLens>());
  CHECK(lens.model_if<RadialLens>()->k == 0.1933);
  CHECK(lens.k_pd() == doctest::Approx(-0.1335).epsilon(0.005));  // the best cubic, as none was given
  CHECK(std::isinf(hmd.left.image_distance_m));
}

TEST_CASE("the four ways to give a field agree") {
  const std::string tangents = R"("tangents": {
        "left": -0.8, "right": 0.6,
        "down": -0.5, "up": 0.45
      })";
  const auto field = [&](const std::string& text) { return io::parse_hmd(with(tangents, text), "t").left; };
  const EyeModel angles = field(R"("angles_deg": {"left": -45, "right": 30, "down": -20, "up": 25})");
  CHECK(angles.tangents.left == doctest::Approx(-1).epsilon(1e-14));
  CHECK(angles.tangents.up == doctest::Approx(std::tan(degrees(25).radians())).epsilon(1e-14));
  const EyeModel fov = field(R"("fov_deg": {"horizontal": 90, "vertical": 60})");
  CHECK(fov.tangents.right == doctest::Approx(1).epsilon(1e-14));
  const EyeModel image =
      field(R"("virtual_image_m": {"w_x": 1.57, "w_y": 1.19, "z_p": -1.18, "x_cw": -0.187, "y_cw": 0})");
  CHECK(image.tangents == tangents_of(VirtualImage{1.57, 1.19, -1.18, -0.187, 0.0}).value());
  CHECK(image.image_distance_m == 1.18);
}

TEST_CASE("either eye may mirror the other") {
  const HmdModel hmd = io::parse_hmd(with("\"right\": \"mirrored\"", "\"left\": \"mirrored\"",
                                          with("\"left\": {\n      \"res", "\"right\": {\n      \"res")),
                                     "t");
  CHECK(hmd.right.tangents == FieldTangents{-0.8, 0.6, -0.5, 0.45});
  CHECK(hmd.left.side == EyeSide::left);
  CHECK(hmd.left.X_HE.p() == Vector3(-0.031, 0, 0));
  check_error(with("\"mirrored\"", "\"mirror\""), 16, "eyes.right", "unknown word", "\"mirror\"");
  check_error(with("\"test\"", "\"\""), 3, "name", "empty", "\"\"");
}

TEST_CASE("writing and reading gives back every bit") {
  HmdModel hmd = io::parse_hmd(good, "t");
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    hmd.ipd_m = 0.1 + 0.05 * u(random);
    hmd.left.tangents = {-1 + 0.3 * u(random), 1 + 0.3 * u(random), -1 + 0.3 * u(random), 1 + 0.3 * u(random)};
    hmd.left.image_distance_m = trial % 2 == 0 ? std::numeric_limits<double>::infinity() : 2 + u(random);
    hmd.left.eye_relief_m = 0.1 + 0.01 * u(random);
    hmd.left.X_HE = Rigid(hmd.left.X_HE.q(), 0.5 * Vector3(u(random), u(random), u(random)));
    hmd.left.upside_down = trial % 3 == 0;
    hmd.left.lens =
        Lens(RadialLens{u(random)}, placed_at(1 + 0.5 * u(random), Vector2(u(random), u(random))), u(random));
    hmd.left.lens_blue =
        Lens(PolynomialLens(std::array<double, 3>{u(random), u(random), 1e-17 * u(random)}, 1 + 0.1 * u(random)),
             {Vector2(u(random), u(random)), Vector2(-1 + 0.5 * u(random), 1 + 0.5 * u(random))}, u(random));
    const HmdModel back = reread(hmd);
    CHECK(bits(back.ipd_m) == bits(hmd.ipd_m));
    CHECK(back.left.tangents == hmd.left.tangents);
    CHECK(bits(back.left.image_distance_m) == bits(hmd.left.image_distance_m));
    CHECK(bits(back.left.eye_relief_m) == bits(hmd.left.eye_relief_m));
    CHECK(back.left.X_HE.p() == hmd.left.X_HE.p());
    CHECK(back.left.X_HE.q().coeffs() == hmd.left.X_HE.q().coeffs());
    CHECK(back.left.upside_down == hmd.left.upside_down);
    const Lens& a = hmd.left.lens;
    const Lens& b = back.left.lens;
    CHECK(bits(a.model_if<RadialLens>()->k) == bits(b.model_if<RadialLens>()->k));
    CHECK(bits(a.k_pd()) == bits(b.k_pd()));
    CHECK(a.placement() == b.placement());
    CHECK(hmd.left.lens_blue->placement() == back.left.lens_blue->placement());
    // The text tells of everything that is written.
    CHECK(io::hmd_json(back) == io::hmd_json(hmd));
  }
}

TEST_CASE("a canted headset survives any number of writings") {
  for (int i = 0; i < 50; ++i) {
    HmdModel hmd = default_hmd();
    hmd.left.X_HE = eye_pose(EyeSide::left, 0.062, degrees(0.7 * i), degrees(0.3 * i));
    hmd.right = mirrored(hmd.left);
    const HmdModel once = reread(hmd);
    // Normalising a unit quaternion again may move its last bit, once.
    CHECK((once.left.X_HE.q().coeffs() - hmd.left.X_HE.q().coeffs()).norm() < 3e-16);
    const HmdModel twice = reread(once);
    CHECK(twice.left.X_HE.q().coeffs() == once.left.X_HE.q().coeffs());
    CHECK(io::hmd_json(twice) == io::hmd_json(once));
  }
}

TEST_CASE("the display's timing survives, and its phase is not the headset's") {
  HmdModel hmd = default_hmd();
  hmd.timing.scan_out = ScanOut::rolling;
  hmd.timing.scan_duration = Duration(11'111'111);
  hmd.timing.persistence = Duration(1'999'999);
  hmd.timing.internal_delay = Duration(3'141'593);
  hmd.timing.scan_direction = ScanDirection::right_to_left;
  hmd.timing.refresh_hz = 59.94;
  const HmdModel back = reread(hmd);
  CHECK(back.timing.scan_out == ScanOut::rolling);
  CHECK(back.timing.scan_duration == hmd.timing.scan_duration);
  CHECK(back.timing.persistence == hmd.timing.persistence);
  CHECK(back.timing.internal_delay == hmd.timing.internal_delay);
  CHECK(back.timing.scan_direction == ScanDirection::right_to_left);
  CHECK(back.timing.refresh_hz == 59.94);
}

TEST_CASE("errors name file, line, key, value and what was expected") {
  check_error(with("\"right\": 0.6", "\"right\": \"wide\""), 11, "eyes.left.tangents.right", "not a number",
              "\"wide\"");
  check_error(with("\"right\": 0.6", "\"rihgt\": 0.6"), 11, "eyes.left.tangents.rihgt", "unknown key", "0.6");
  check_error(with("\"down\": -0.5, ", ""), 10, "eyes.left.tangents.down", "missing", "");
  check_error(with("\"down\": -0.5", "\"down\": 1e4"), 12, "eyes.left.tangents.down", "out of range", "10000.0");
  check_error(with("\"right\": 0.6", "\"right\": -0.8"), 10, "eyes.left.tangents", "no width", "");
  check_error(with("[640, 512]", "[640, 512.5]"), 9, "eyes.left.resolution_px[1]", "not a whole number", "512.5");
  check_error(with("[640, 512]", "[640]"), 9, "eyes.left.resolution_px", "wrong number of elements", "[640]");
  check_error(with("[640, 512]", "[640, 0]"), 9, "eyes.left.resolution_px[1]", "out of range", "0");
  check_error(with("[640, 512]", "[18446744073709551615, 512]"), 9, "eyes.left.resolution_px[0]", "out of range",
              "18446744073709551615");
  check_error(with("0.062", "62"), 5, "ipd_m", "out of range", "62");
  check_error(with("0.062", "null"), 5, "ipd_m", "not a number", "null");
  check_error(with("\"ipd_m\": 0.062,", ""), 1, "ipd_m", "missing", "");
  check_error(with("\"radial\"", "\"fisheye\""), 14, "eyes.left.lens.model", "unknown word", "\"fisheye\"");
  check_error(with("\"k\": 0.1933", "\"coefficients\": [0.1]"), 14, "eyes.left.lens.coefficients", "unknown key",
              "[0.1]");
  check_error(with("\"r_norm\": 0.5", "\"r_norm\": 0"), 14, "eyes.left.lens.r_norm", "out of range", "0");
  check_error(with("\"rolling\"", "\"interlaced\""), 6, "timing.scan_out", "unknown word", "\"interlaced\"");
  check_error(with(", \"scan_duration_ms\": 10.5", ""), 6, "timing", "scan_duration", "");
  check_error(with("10.5", "12"), 6, "timing", "scan_duration", "");  // longer than a frame of 90 Hz
  check_error(with("\"refresh_hz\": 90, ", ""), 6, "timing.refresh_hz", "missing", "");
  check_error(with("\"name\": \"test\"", "\"name\": 7"), 3, "name", "not a string", "7");
}

TEST_CASE("fields that no headset has are refused") {
  check_error(with("\"right\": 0.6", "\"right\": -0.79999999"), 10, "eyes.left.tangents", "impossibly narrow", "");
  const std::string no_field = with("\"tangents\"", "\"virtual_image_m\"");
  const std::string edges = "\"left\": -0.8, \"right\": 0.6,\n        \"down\": -0.5, \"up\": 0.45";
  check_error(with(edges, "\"w_x\": 500, \"w_y\": 1, \"z_p\": -1, \"x_cw\": 0, \"y_cw\": 0", no_field), 10,
              "eyes.left.virtual_image_m", "impossibly wide", "");
  check_error(with(edges, "\"w_x\": 1, \"w_y\": 1, \"z_p\": 1, \"x_cw\": 0, \"y_cw\": 0", no_field), 11,
              "eyes.left.virtual_image_m.z_p", "out of range", "1");
}

TEST_CASE("a name that is not UTF-8 does not keep a headset from being written") {
  HmdModel hmd = default_hmd();
  hmd.name = "caf\xe9";
  CHECK(reread(hmd).name == "caf\xef\xbf\xbd");
}

TEST_CASE("the descriptor in docs/optics.md is read, and its mistake is answered as the page says") {
  std::ifstream file(std::filesystem::path(HOLDFAST_SOURCE_DIR) / "docs" / "optics.md");
  REQUIRE(file);
  const std::string page((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t begin = page.find("```json\n") + 8;
  const std::string text = page.substr(begin, page.find("```", begin) - begin);
  CHECK(io::parse_hmd(text, "my.json").left.resolution == PixelSize{1440, 1600});
  try {
    static_cast<void>(io::parse_hmd(with("\"right\": 45", "\"rihgt\": 45", text), "my.json"));
    FAIL("accepted");
  } catch (const io::InputError& error) {
    CHECK(page.find(error.what()) != std::string::npos);
    CHECK(std::string(error.what()).find("my.json:10: eyes.left.angles_deg.rihgt: unknown key") == 0);
  }
}

TEST_CASE("fields given twice, or not at all, are refused") {
  check_error(with("\"lens\":", "\"fov_deg\": {\"horizontal\": 90, \"vertical\": 60}, \"lens\":"), 8, "eyes.left",
              "more than once", "");
  check_error(with("\"tangents\":", "\"lens_red\":"), 8, "eyes.left", "no field of view", "");
  check_error(with("\"lens\":",
                   "\"pose\": {\"position\": [0,0,0], \"rotation\": "
                   "{\"x\":0,\"y\":0,\"z\":0,\"w\":1}},\n\"tilt_up_deg\": 3,\n\"lens\":"),
              15, "eyes.left.tilt_up_deg", "beside pose", "3");
  check_error(with("\"lens\":",
                   "\"pose\": {\"position\": [0,0,0],\n \"rotation\": {\"x\":0,\"y\":0,\"z\":0,\"w\":0.9}}, \"lens\":"),
              15, "eyes.left.pose.rotation", "not a unit quaternion", "");
  check_error(with("\"left\": {\n      \"res", "\"left\": \"mirrored\", \"rest\": {\n      \"res"), 8, "eyes.rest",
              "unknown key", "");
}

TEST_CASE("text that is no JSON names its line") {
  check_error(with("\"down\": -0.5,", "\"down\": -0.5"), 12, "", "not valid JSON", "");
  check_error(with("0.062", "NaN"), 5, "", "not valid JSON", "");
  check_error(with("0.062", "1e999"), 5, "", "too large", "1e999");
  check_error(good.substr(0, good.find("640")), 9, "", "not valid JSON", "");
  check_error("", 1, "", "not valid JSON", "");
  check_error("\n\n\xff", 3, "", "not valid JSON", "");
  check_error(good + std::string("\n\0{\"", 4), 20, "", "zero byte", "");
  check_error(with("\"name\": \"test\",", "\"name\": \"test\",\n\"ipd_m\": 0.07,"), 6, "ipd_m", "twice", "");
  check_error(std::string(100, '[') + std::string(100, ']'), 0, "", "too deeply", "");
  check_error(std::string(5'000'000, ' '), 0, "", "too long", "");
}

TEST_CASE("files of another kind are called by their own name") {
  check_error(with("holdfast/hmd/1", "holdfast/hmd/2"), 2, "schema", "this version", "\"holdfast/hmd/2\"");
  check_error(with("holdfast/hmd/1", "holdfast/run/1"), 2, "schema", "another kind", "\"holdfast/run/1\"");
  check_error("[1, 2]", 1, "", "no object", "[1,2]");
  check_error("{}", 1, "", "not a headset descriptor", "");
  check_error("{\"hmd\": {\"device\": {}}}", 1, "", "OSVR descriptor", "");
  check_error("{\"display\": {\"hmd\": {}}}", 1, "", "OSVR descriptor", "");
}

TEST_CASE("read_hmd calls a file by what it is") {
  const auto problem = [](const std::string& text) {
    try {
      static_cast<void>(io::parse_any_hmd(text, "any", nullptr));
    } catch (const io::InputError& error) {
      CHECK(error.file() == "any");
      return error.problem();
    }
    return std::string("read");
  };
  CHECK(problem(good) == "read");
  CHECK(problem("// a comment first\n" + good) == "read");
  CHECK(problem("\xef\xbb\xbf" + good) == "read");
  CHECK(problem("") == "this is no headset descriptor");
  CHECK(problem("t,x,y,z\n1,2,3,4\n") == "this is no headset descriptor");
  CHECK(problem("{\"a\": 1}") == "this is not a headset descriptor");
  CHECK(problem("{\"schema\": \"holdfast/run/1\"}") == "this is a file of another kind");
  CHECK(problem("{\"hmd\": {}}") == "the key is missing");  // OSVR's field_of_view
  CHECK(problem("{\"hmd\": {}").find("not valid JSON") != std::string::npos);
  CHECK(problem(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16)).find("neither text nor the buffer") == 0);
}

TEST_CASE("files: missing, folders, and whole or not at all") {
  const auto folder = std::filesystem::temp_directory_path() / "holdfast_hmd_test";
  std::filesystem::create_directories(folder);
  CHECK_THROWS_AS(static_cast<void>(io::read_hmd(folder / "absent.json")), io::InputError);
  CHECK_THROWS_AS(static_cast<void>(io::read_hmd(folder)), io::InputError);
  const auto file = folder / "written.json";
  io::write_hmd(file, default_hmd());
  CHECK(io::hmd_json(io::read_hmd(file)) == io::hmd_json(default_hmd()));
  // A model that cannot be read back is not written, and the old file stays.
  HmdModel bad = default_hmd();
  bad.left.tangents.right = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(io::write_hmd(file, bad), io::InputError);
  CHECK(io::hmd_json(io::read_hmd(file)) == io::hmd_json(default_hmd()));
  CHECK_THROWS_AS(io::write_hmd(folder / "no" / "such" / "folder.json", default_hmd()), io::InputError);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++files;
  CHECK(files == 1);  // no half-written rest
  std::filesystem::remove_all(folder);
}

TEST_CASE("lines are found through comments, strings with braces, escapes and arrays") {
  const std::string text = R"(// first
/* a comment
   with { and " in it */ {
  "a\"b": [1,
    {"x": "}]", "y": 2}],
  "z": [[], [3,
    4]]
})";
  const io::JsonLines lines = io::JsonLineScanner(text).scan();
  const auto line = [&](const std::string& path) { return lines.line_of_path.at(path); };
  CHECK(line("") == 3);
  CHECK(line("a\"b") == 4);
  CHECK(line("a\"b[0]") == 4);
  CHECK(line("a\"b[1]") == 5);
  CHECK(line("a\"b[1].y") == 5);
  CHECK(line("z") == 6);
  CHECK(line("z[1][0]") == 6);
  CHECK(line("z[1][1]") == 7);
  CHECK(lines.duplicate.empty());
}

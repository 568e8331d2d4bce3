#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/cardboard.hpp>
#include <holdfast/io/hmd.hpp>

using namespace holdfast;

namespace {

// Published viewers: Google's own two, and Zeiss's.
const std::string cardboard_v1 =
    "https://google.com/cardboard/"
    "cfg?p=CgxHb29nbGUsIEluYy4SDENhcmRib2FyZCB2MR0xCCw9JY_CdT0qEAAAIEIAACBCAAAgQgAAIEJYADUp"
    "XA89OgiuR-E-mpkZPlABYAE";
const std::string cardboard_2015 =
    "http://google.com/cardboard/"
    "cfg?p=CgZHb29nbGUSEkNhcmRib2FyZCBJL08gMjAxNR2ZuxY9JbbzfT0qEAAASEIAAEhCAABIQgAASEJYADUpXA89"
    "OgiCc4Y-MCqJPlAAYAM";
const std::string zeiss_vr_one =
    "http://google.com/cardboard/"
    "cfg?p=Cg1DYXJsIFplaXNzIEFHEgZWUiBPTkUdUI0XPSW28309KhAAAEhCAABIQgAASEIAAEhCWAE1KVwPPToIzczMPQAAgD9QAGAA";

const io::PhoneScreen phone{0.110, 0.062, {1920, 1080}, 60.0};

io::CardboardViewer random_viewer(std::mt19937_64& random) {
  std::uniform_real_distribution<float> u(0.0f, 1.0f);
  io::CardboardViewer v;
  v.vendor = "v" + std::to_string(random() % 1000);
  v.model = std::string(random() % 200, 'm');
  v.screen_to_lens_m = 0.03f + 0.03f * u(random);
  v.inter_lens_m = 0.05f + 0.02f * u(random);
  v.tray_to_lens_m = 0.02f + 0.03f * u(random);
  v.alignment = static_cast<io::CardboardAlignment>(random() % 3);
  v.button = static_cast<io::CardboardButton>(random() % 4);
  for (float& angle : v.fov_deg) angle = 20.0f + 40.0f * u(random);
  for (std::size_t i = random() % 6; i > 0; --i) v.distortion.push_back(u(random) - 0.3f);
  if (random() % 2 == 0) v.has_magnet = random() % 2 == 0;
  return v;
}

io::InputError error_of(const std::string& text) {
  try {
    static_cast<void>(io::parse_cardboard(text, "viewer"));
  } catch (const io::InputError& error) {
    return error;
  }
  FAIL("accepted: " << text);
  return io::InputError({});
}

}  // namespace

TEST_CASE("published viewers are read") {
  const io::CardboardViewer v1 = io::parse_cardboard(cardboard_v1, "v1");
  CHECK(v1.vendor == "Google, Inc.");
  CHECK(v1.model == "Cardboard v1");
  CHECK(v1.screen_to_lens_m == 0.042f);
  CHECK(v1.inter_lens_m == 0.06f);
  CHECK(v1.tray_to_lens_m == 0.035f);
  CHECK(v1.distortion == std::vector<float>{0.44f, 0.15f});
  CHECK(v1.fov_deg == std::array{40.0f, 40.0f, 40.0f, 40.0f});
  CHECK(v1.button == io::CardboardButton::magnet);
  CHECK(v1.has_magnet == true);
  const io::CardboardViewer v2 = io::parse_cardboard(cardboard_2015, "v2");
  CHECK(v2.model == "Cardboard I/O 2015");
  CHECK(v2.inter_lens_m == doctest::Approx(0.062).epsilon(1e-6));
  CHECK(v2.fov_deg[0] == 50.0f);
  CHECK(v2.button == io::CardboardButton::indirect_touch);
  CHECK(v2.has_magnet == false);
  const io::CardboardViewer zeiss = io::parse_cardboard(zeiss_vr_one, "zeiss");
  CHECK(zeiss.vendor == "Carl Zeiss AG");
  CHECK(zeiss.alignment == io::CardboardAlignment::center);
}

TEST_CASE("a published viewer is written as it was published") {
  CHECK(io::cardboard_uri(io::parse_cardboard(cardboard_v1, "v1")) == cardboard_v1);
  const std::string code = cardboard_2015.substr(cardboard_2015.find("?p="));
  CHECK(io::cardboard_uri(io::parse_cardboard(cardboard_2015, "v2")) == "https://google.com/cardboard/cfg" + code);
}

TEST_CASE("all three forms hold the same viewer bit by bit") {
  std::mt19937_64 random(31);
  for (int i = 0; i < 500; ++i) {
    const io::CardboardViewer v = random_viewer(random);
    CHECK(io::parse_cardboard(io::cardboard_uri(v), "uri") == v);
    CHECK(io::parse_cardboard(io::cardboard_json(v), "json") == v);
    CHECK(io::parse_cardboard_buffer(io::cardboard_buffer(v), "buffer") == v);
  }
}

TEST_CASE("the headset is the SDK's: lengths on the screen over the lens's distance") {
  const HmdModel hmd = io::cardboard_hmd(io::parse_cardboard(cardboard_v1, "v1"), phone);
  const double to_screen = double(0.042f), half = double(0.06f) / 2;
  const FieldTangents& t = hmd.left.tangents;
  CHECK(t.left == doctest::Approx(-(0.055 - half) / to_screen).epsilon(1e-12));
  CHECK(t.right == doctest::Approx(half / to_screen).epsilon(1e-12));
  CHECK(t.down == doctest::Approx(-(double(0.035f) - 0.003) / to_screen).epsilon(1e-12));
  CHECK(t.up == doctest::Approx((0.062 - double(0.035f) + 0.003) / to_screen).epsilon(1e-12));
  CHECK(hmd.left.resolution == PixelSize{960, 1080});
  CHECK(hmd.right.tangents == mirrored(t));
  // p' = p (1 + K1 r^2 + K2 r^4) with r in tangents.
  const auto seen = hmd.left.lens.distort(Vector2(0.5, 0.0));
  REQUIRE(seen);
  CHECK(seen->x() == doctest::Approx(0.5 * (1 + double(0.44f) * 0.25 + double(0.15f) * 0.0625)).epsilon(1e-12));
  // Square pixels on the phone are square in tangents.
  const Vector2 s = pixels_per_tangent(hmd.left);
  CHECK(s.x() == doctest::Approx(1920 / 0.110 * to_screen).epsilon(1e-12));
}

TEST_CASE("the drawn field is what the screen's edges are seen at, within the viewer's limits") {
  io::CardboardViewer v = io::parse_cardboard(cardboard_v1, "v1");
  const HmdModel hmd = io::cardboard_hmd(v, phone);
  const double limit = std::tan(40 * 3.14159265358979 / 180);
  const FieldTangents drawn = io::drawn_field(v, hmd.left);
  CHECK(drawn.left ==
        doctest::Approx(std::max(-limit, hmd.left.lens.distort(Vector2(hmd.left.tangents.left, 0))->x())));
  CHECK(drawn.right == doctest::Approx(limit));  // the lens would show more
  v.fov_deg = {80.0f, 10.0f, 80.0f, 20.0f};
  const FieldTangents other = io::drawn_field(v, hmd.left);
  CHECK(other.right == doctest::Approx(std::tan(10 * 3.14159265358979 / 180)));
  CHECK(other.up == doctest::Approx(std::tan(20 * 3.14159265358979 / 180)));
  CHECK(other.left < drawn.left + 1e-12);
  const FieldTangents right = io::drawn_field(v, hmd.right);
  CHECK(right == mirrored(other));
}

TEST_CASE("how the phone lies decides the lens's height") {
  io::CardboardViewer v = io::parse_cardboard(cardboard_v1, "v1");
  v.tray_to_lens_m = 0.03f;
  CHECK(io::lens_height_m(v, 0.07) == doctest::Approx(0.027).epsilon(1e-6));
  v.alignment = io::CardboardAlignment::center;
  CHECK(io::lens_height_m(v, 0.07) == doctest::Approx(0.035).epsilon(1e-6));
  v.alignment = io::CardboardAlignment::top;
  CHECK(io::lens_height_m(v, 0.07) == doctest::Approx(0.037).epsilon(1e-6));
}

TEST_CASE("a buffer with unknown fields, or numbers one by one, is read") {
  const io::CardboardViewer v = io::parse_cardboard(cardboard_v1, "v1");
  io::WireWriter more;
  more.integer(99, 1234567890123ULL);
  more.bytes(98, "anything");
  more.float32(97, 1.5f);
  CHECK(io::parse_cardboard_buffer(io::cardboard_buffer(v) + more.written(), "b") == v);
  io::WireWriter unpacked;
  unpacked.bytes(1, v.vendor);
  unpacked.bytes(2, v.model);
  unpacked.float32(3, v.screen_to_lens_m);
  unpacked.float32(4, v.inter_lens_m);
  for (const float angle : v.fov_deg) unpacked.float32(5, angle);
  unpacked.float32(6, v.tray_to_lens_m);
  for (const float k : v.distortion) unpacked.float32(7, k);
  unpacked.integer(10, 1);
  CHECK(io::parse_cardboard_buffer(unpacked.written(), "b") == v);  // alignment and button have their defaults
}

TEST_CASE("what is no viewer is refused with the reason") {
  CHECK(error_of("http://goo.gl/R2gCV1").problem().find("holds no viewer") != std::string::npos);
  CHECK(error_of("https://google.com/cardboard/cfg?p=abc*").problem() == "not base64url");
  CHECK(error_of("https://google.com/cardboard/cfg?p=").key() == "left_eye_field_of_view_angles");
  CHECK(error_of("").key() == "left_eye_field_of_view_angles");
  const std::string good = io::cardboard_buffer(io::parse_cardboard(cardboard_v1, "v1"));
  // Cut anywhere, it is never read as a whole viewer but when only fields with defaults are lost.
  int refused = 0;
  for (std::size_t n = 0; n < good.size(); ++n) {
    try {
      static_cast<void>(io::parse_cardboard_buffer(good.substr(0, n), "cut"));
    } catch (const io::InputError& error) {
      CHECK(error.file() == "cut");
      CHECK_FALSE(error.expected().empty());
      ++refused;
    }
  }
  CHECK(refused > static_cast<int>(good.size()) - 20);
  std::mt19937_64 random(1);
  for (const auto& [change, key] : std::initializer_list<std::pair<void (*)(io::CardboardViewer&), const char*>>{
           {[](io::CardboardViewer& v) { v.screen_to_lens_m = 0.0f; }, "screen_to_lens_distance"},
           {[](io::CardboardViewer& v) { v.inter_lens_m = std::numeric_limits<float>::quiet_NaN(); },
            "inter_lens_distance"},
           {[](io::CardboardViewer& v) { v.tray_to_lens_m = -1.0f; }, "tray_to_lens_distance"},
           {[](io::CardboardViewer& v) { v.fov_deg[2] = 0.0f; }, "left_eye_field_of_view_angles"},
           {[](io::CardboardViewer& v) { v.fov_deg[1] = 90.0f; }, "left_eye_field_of_view_angles"},
           {[](io::CardboardViewer& v) { v.distortion = {INFINITY}; }, "distortion_coefficients"},
           {[](io::CardboardViewer& v) { v.distortion.assign(40, 0.0f); }, "distortion_coefficients"}}) {
    io::CardboardViewer v = io::parse_cardboard(cardboard_v1, "v1");
    change(v);
    try {
      static_cast<void>(io::parse_cardboard_buffer(io::cardboard_buffer(v), "changed"));
      FAIL("accepted " << key);
    } catch (const io::InputError& error) {
      CHECK(error.key() == key);
    }
  }
}

TEST_CASE("JSON: errors name line and key") {
  std::string json = io::cardboard_json(io::parse_cardboard(cardboard_v1, "v1"));
  json.replace(json.find("0.042"), 5, "\"far\"");
  const io::InputError error = error_of(json);
  CHECK(error.line() == 5);
  CHECK(error.key() == "screen_to_lens_distance");
  CHECK(error_of("{\"schema\": \"holdfast/cardboard/1\"}").key() == "screen_to_lens_distance");
}

TEST_CASE("read_hmd knows a viewer, and wants a phone for it") {
  const auto read = [](const std::string& text, const io::HmdOptions& options) {
    return io::parse_any_hmd(text, "viewer", nullptr, options);
  };
  const io::CardboardViewer v = io::parse_cardboard(cardboard_v1, "v1");
  for (const std::string& text : {cardboard_v1, io::cardboard_json(v), io::cardboard_buffer(v)}) {
    try {
      static_cast<void>(read(text, {}));
      FAIL("accepted without a phone");
    } catch (const io::InputError& error) {
      CHECK(error.problem().find("Cardboard viewer") != std::string::npos);
      CHECK(error.expected().find("phone") != std::string::npos);
    }
    io::HmdOptions options;
    options.phone = phone;
    CHECK(read(text, options).left.tangents == io::cardboard_hmd(v, phone).left.tangents);
    CHECK(io::parse_hmd_file(text, "viewer", nullptr, options).format == io::HmdFormat::cardboard);
  }
}

TEST_CASE("phones that do not fit are refused") {
  const io::CardboardViewer v = io::parse_cardboard(cardboard_v1, "v1");
  const auto key = [&](const io::PhoneScreen& p) {
    try {
      static_cast<void>(io::checked_cardboard_hmd(v, p, "viewer"));
    } catch (const io::InputError& error) {
      return error.key();
    }
    return std::string("accepted");
  };
  CHECK(key(phone) == "accepted");
  CHECK(key({0.0, 0.062, {1920, 1080}, 60}) == "width_m");
  CHECK(key({0.11, 1.5, {1920, 1080}, 60}) == "height_m");
  CHECK(key({0.11, 0.062, {1921, 1080}, 60}) == "resolution.width");
  CHECK(key({0.11, 0.062, {1920, 0}, 60}) == "resolution.height");
  CHECK(key({0.11, 0.062, {1920, 1080}, 0}) == "refresh_hz");
  CHECK(key({0.05, 0.062, {1920, 1080}, 60}) == "inter_lens_distance");
  CHECK(key({0.11, 0.031, {1920, 1080}, 60}) == "tray_to_lens_distance");
}

TEST_CASE("base64url") {
  CHECK(io::to_base64url("") == "");
  CHECK(io::to_base64url("f") == "Zg");
  CHECK(io::to_base64url("foobar") == "Zm9vYmFy");  // RFC 4648 section 10
  CHECK(io::to_base64url("\xfb\xff") == "-_8");
  std::mt19937_64 random(2);
  for (std::size_t n = 0; n < 100; ++n) {
    std::string bytes;
    for (std::size_t i = 0; i < n; ++i) bytes += static_cast<char>(random());
    CHECK(io::from_base64url(io::to_base64url(bytes)) == bytes);
    CHECK(io::from_base64url(io::to_base64url(bytes) + "==") == bytes);
  }
  CHECK_FALSE(io::from_base64url("Z").has_value());
  CHECK_FALSE(io::from_base64url("Zh").has_value());  // bits beyond the last byte
  CHECK_FALSE(io::from_base64url("Zg+/").has_value());
  CHECK_FALSE(io::from_base64url("Z g").has_value());
}

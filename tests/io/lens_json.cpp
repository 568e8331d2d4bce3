// Every lens model through our JSON: bit by bit there and back, refused with the reason when it cannot be used.
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <sys/wait.h>

#include <holdfast/io/hmd.hpp>

using namespace holdfast;

namespace {

class Random {
 public:
  double operator()(double size = 1.0) { return size * uniform_(engine_); }
  template <std::size_t N>
  std::array<double, N> array(double size) {
    std::array<double, N> numbers{};
    for (double& x : numbers) x = (*this)(size);
    return numbers;
  }
  std::vector<double> list(std::size_t n, double size) {
    std::vector<double> numbers(n);
    for (double& x : numbers) x = (*this)(size);
    return numbers;
  }

 private:
  std::mt19937_64 engine_{17};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

/// One lens of every model, with numbers of all digits.
std::vector<Lens::Model> all_models(Random& u) {
  std::vector<double> series = u.list(6, 0.1);
  series[0] += 1.0;
  CatmullRomCoefficients spline;
  for (std::size_t i = 0; i < 11; ++i) spline.knots[i] = 1.0 + 0.02 * double(i) + u(0.001);
  spline.r_max = 1.2 + u(0.1);
  spline.chroma = u.array<2>(0.01);
  const BrownConradyCoefficients brown{u(0.05), u(0.01), u(0.001), u(0.001), u(0.001), u(0.01), u(0.01), u(0.001)};
  BivariateCoefficients bivariate;
  bivariate.x = u.array<16>(0.01);
  bivariate.y = u.array<16>(0.01);
  bivariate.x[4] += 1.0;
  bivariate.y[1] += 1.0;
  bivariate.limit = 0.8 + u(0.1);
  std::vector<PointMeshSample> samples;
  for (int i = 0; i < 5; ++i) {
    for (int k = 0; k < 4; ++k) {
      const Vector2 p(i - 2.0, k - 1.5);
      samples.push_back({p, Vector2(p.x() + u(0.1), p.y() + u(0.1))});
    }
  }
  return {RadialLens{u()},
          PolynomialLens(u.list(3, 0.1), 1.0 + u(0.1)),
          PowerSeriesLens(series),
          ViveLens({u(0.1), u(0.1), u(0.1), u(0.1)}),
          CatmullRomLens(spline),
          KannalaBrandtLens(u.array<4>(0.01)),
          BrownConradyLens(brown),
          BivariateLens(bivariate),
          PointMeshLens(make_point_mesh(samples).mesh),
          ReversedLens<PolynomialLens>(PolynomialLens(u.list(3, 0.1), 1.0 + u(0.1))),
          ReversedLens<PowerSeriesLens>(PowerSeriesLens(series)),
          ReversedLens<BrownConradyLens>(BrownConradyLens(brown))};
}

Lens random_lens(const Lens::Model& model, Random& u) {
  const LensPlacement place{Vector2(u(), u()), Vector2(1.0 + u(0.5), -1.0 + u(0.5))};
  return Lens(model, place, u(0.3));
}

bool same_bits(const std::optional<Vector2>& a, const std::optional<Vector2>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::bit_cast<std::uint64_t>(a->x()) == std::bit_cast<std::uint64_t>(b->x()) &&
         std::bit_cast<std::uint64_t>(a->y()) == std::bit_cast<std::uint64_t>(b->y());
}

void check_same(const Lens& a, const Lens& b) {
  CHECK(a.model().index() == b.model().index());
  CHECK(a.placement() == b.placement());
  CHECK(a.k_pd() == b.k_pd());
  Random u;
  int answered = 0;
  for (int i = 0; i < 50; ++i) {
    const Vector2 t = a.centre() + Vector2(u(0.4), u(0.4));
    CHECK(same_bits(a.distort(t), b.distort(t)));
    CHECK(same_bits(a.undistort(t), b.undistort(t)));
    answered += a.distort(t).has_value() ? 1 : 0;
  }
  CHECK(answered > 25);  // or nothing was compared
}

HmdModel reread(const HmdModel& hmd) {
  return io::parse_hmd(io::hmd_json(hmd), "reread");
}

io::InputError lens_error(const std::string& lens) {
  HmdModel hmd = default_hmd();
  hmd.left.lens = NoLens{};
  hmd.right.lens = NoLens{};
  std::string text = io::hmd_json(hmd);
  const std::string none = "{\n        \"model\": \"none\"\n      }";
  const std::size_t at = text.find(none);
  REQUIRE(at != std::string::npos);
  text.replace(at, none.size(), lens);
  try {
    static_cast<void>(io::parse_hmd(text, "test.json"));
  } catch (const io::InputError& error) {
    return error;
  }
  FAIL("accepted " << lens);
  return io::InputError({});
}

}  // namespace

TEST_CASE("every model is read as it was written, bit by bit") {
  Random u;
  for (int trial = 0; trial < 20; ++trial) {
    for (const Lens::Model& model : all_models(u)) {
      HmdModel hmd = default_hmd();
      hmd.left.lens = random_lens(model, u);
      hmd.left.lens_blue = random_lens(model, u);
      hmd.right = mirrored(hmd.left);
      const HmdModel back = reread(hmd);
      check_same(hmd.left.lens, back.left.lens);
      check_same(*hmd.left.lens_blue, *back.left.lens_blue);
      check_same(hmd.right.lens, back.right.lens);
      CHECK_FALSE(back.left.lens_red.has_value());
      CHECK(io::hmd_json(back) == io::hmd_json(hmd));
    }
  }
}

TEST_CASE("lenses at several eye reliefs, bit by bit, and in order") {
  Random u;
  HmdModel hmd = default_hmd();
  hmd.left.eye_relief_m = 0.012;
  for (const double relief : {0.008, 0.0123456789, 0.02}) {
    LensesAtRelief row{relief, random_lens(PowerSeriesLens(std::vector<double>{1.0, u(0.1)}), u), std::nullopt,
                       std::nullopt};
    if (relief > 0.01) row.lens_blue = random_lens(RadialLens{u()}, u);
    hmd.left.lenses_at_relief.push_back(row);
  }
  hmd.right = mirrored(hmd.left);
  const HmdModel back = reread(hmd);
  REQUIRE(back.left.lenses_at_relief.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const LensesAtRelief& a = hmd.left.lenses_at_relief[i];
    const LensesAtRelief& b = back.left.lenses_at_relief[i];
    CHECK(a.eye_relief_m == b.eye_relief_m);
    check_same(a.lens, b.lens);
    CHECK(a.lens_blue.has_value() == b.lens_blue.has_value());
    CHECK_FALSE(b.lens_red.has_value());
  }
  CHECK(io::hmd_json(back) == io::hmd_json(hmd));
  std::swap(hmd.left.lenses_at_relief[0], hmd.left.lenses_at_relief[2]);
  try {
    static_cast<void>(reread(hmd));
    FAIL("accepted rows out of order");
  } catch (const io::InputError& error) {
    CHECK(error.key() == "eyes.left.lenses_at_relief[1].eye_relief_m");
  }
}

TEST_CASE("lenses that cannot be used are refused by key and reason") {
  const auto refused = [](const std::string& lens, const std::string& key, const std::string& problem) {
    const io::InputError error = lens_error(lens);
    CAPTURE(std::string(error.what()));
    CHECK(error.file() == "test.json");
    CHECK(error.line() > 1);
    CHECK(error.key() == "eyes.left.lens" + key);
    CHECK(error.problem().find(problem) != std::string::npos);
    CHECK_FALSE(error.expected().empty());
  };
  refused(R"({"model": "power_series", "coefficients": [-1, 2], "r_norm": 1})", ".coefficients",
          "folds over at its very centre");
  refused(R"({"model": "power_series", "coefficients": [], "r_norm": 1})", ".coefficients", "wrong number");
  refused(R"({"model": "power_series", "coefficients": [1], "k0": 1, "r_norm": 1})", ".k0", "unknown key");
  refused(R"({"model": "polynomial", "coefficients": [1e5], "r_norm": 1})", ".coefficients[0]", "out of range");
  refused(R"({"model": "vive", "coefficients": [0, 0, 0, -1.5], "r_norm": 1})", ".coefficients", "folds over");
  refused(R"({"model": "vive", "coefficients": [0, 0], "r_norm": 1})", ".coefficients", "wrong number");
  refused(R"({"model": "catmull_rom", "knots": [1, 1], "r_max": 1, "r_norm": 1})", ".knots", "wrong number");
  refused(R"({"model": "catmull_rom", "knots": [1,1,1,1,1,1,1,1,1,1,1], "r_max": 0, "r_norm": 1})", ".r_max",
          "out of range");
  refused(R"({"model": "catmull_rom", "knots": [1,1,1,1,1,1,1,1,1,1,1], "r_max": 1, "chroma": [-2, 0], "r_norm": 1})",
          "", "folds over");
  refused(R"({"model": "kannala_brandt", "coefficients": [1, 2, 3], "r_norm": 1})", ".coefficients", "wrong number");
  refused(R"({"model": "kannala_brandt", "coefficients": [1, 2, 3, 4], "direction": "seen_to_panel", "r_norm": 1})",
          ".direction", "unknown key");
  refused(R"({"model": "brown_conrady", "coefficients": [1, 2, 3, 4], "direction": "up", "r_norm": 1})", ".direction",
          "unknown word");
  refused(
      R"({"model": "bivariate", "x": [0,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0], "y": [0,-1,0,0,0,0,0,0,0,0,0,0,0,0,0,0], "r_norm": 1})",
      "", "folds over");
  refused(R"({"model": "point_mesh", "samples": [[0,0,0,0],[1,0,1,0]], "r_norm": 1})", ".samples", "wrong number");
  refused(R"({"model": "point_mesh", "samples": [[0,0,0,0],[1,0,1,0],[0,1,0]], "r_norm": 1})", ".samples[2]",
          "wrong number");
  refused(R"({"model": "point_mesh", "samples": [[0,0,0,0],[1,0,1,0],[0,1,0,1],[1,0,2,2]], "r_norm": 1})",
          ".samples[3]", "same panel point");
  refused(R"({"model": "point_mesh", "samples": [[0,0,0,0],[1,0,1,0],[2,0,2,0]], "r_norm": 1})", ".samples",
          "one line");
  refused(R"({"model": "point_mesh", "samples": [[0,0,0,0],[1,0,-1,0],[0,1,0,1]], "r_norm": 1})", ".samples",
          "fold over");
  refused(R"({"model": "radial", "k": 1})", ".r_norm", "missing");
  refused(R"({"model": "radial", "k": 1, "r_norm": 1, "scale": [1, 1]})", ".scale", "beside r_norm");
  refused(R"({"model": "radial", "k": 1, "scale": [1, 0]})", ".scale", "too small");
}

TEST_CASE("every model's JSON obeys the schema, and what we refuse by form the schema refuses too") {
  const auto folder = std::filesystem::temp_directory_path() / "holdfast_lens_schema_test";
  std::filesystem::create_directories(folder);
  Random u;
  std::string files;
  std::size_t number = 0;
  for (const Lens::Model& model : all_models(u)) {
    HmdModel hmd = default_hmd();
    hmd.left.lens = random_lens(model, u);
    hmd.left.lenses_at_relief = {{0.01, hmd.left.lens, std::nullopt, Lens()},
                                 {0.02, hmd.left.lens, Lens(), std::nullopt}};
    const auto file = folder / (std::to_string(number++) + ".json");
    io::write_hmd(file, hmd);
    files += " '" + file.string() + "'";
  }
  const auto verdict = [](const std::string& names) {
    const std::string command = std::string("'" HOLDFAST_PYTHON "' '") + HOLDFAST_SOURCE_DIR +
                                "/tests/io/hmd_schema.py'" + names + " > /dev/null";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const int code = verdict(files);
  if (code == 77 || code == 127) {
    MESSAGE("skipped: python3-jsonschema is not installed");
    return;
  }
  CHECK(code == 0);
  const auto bad = folder / "bad.json";
  std::string text = io::hmd_json(default_hmd());
  text.replace(text.find("\"radial\""), 8, "\"vive\"");
  io::write_whole_file(bad, text);
  CHECK(verdict(" '" + bad.string() + "'") == 1);
  std::filesystem::remove_all(folder);
}

#include <functional>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/picture_centroid.hpp>
#include <holdfast/registration/projected_ellipse.hpp>

using namespace holdfast;

namespace {

/// RGBA picture in which `is_inside` decides the colour, with samples x samples points a pixel on a regular grid.
struct Picture {
  int width, height;
  std::vector<std::uint8_t> bytes;

  Picture(int w, int h, int samples, const Vector3& inside, const Vector3& outside,
          const std::function<bool(double, double)>& is_inside)
      : width(w), height(h) {
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        int hits = 0;
        for (int i = 0; i < samples * samples; ++i) {
          hits += is_inside(x + (i % samples + 0.5) / samples, y + (i / samples + 0.5) / samples) ? 1 : 0;
        }
        const double share = static_cast<double>(hits) / (samples * samples);
        const Vector3 color = share * inside + (1.0 - share) * outside;
        for (int c = 0; c < 3; ++c) bytes.push_back(static_cast<std::uint8_t>(std::lround(color[c])));
        bytes.push_back(255);
      }
    }
  }
  [[nodiscard]] PictureView view() const { return {bytes, width, height, 4}; }
};

/// RMS error (px, both axes) of the centroid of discs of `radius` at random places.
double centroid_rms(double radius, int samples) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(20.0, 24.0);
  double squares = 0.0;
  constexpr int discs = 60;
  for (int i = 0; i < discs; ++i) {
    const Vector2 centre(place(random), place(random));
    const Picture picture(44, 44, samples, Vector3(250, 120, 40), Vector3(10, 10, 30),
                          [&](double x, double y) { return (Vector2(x, y) - centre).squaredNorm() < radius * radius; });
    const auto found = picture_centroid(picture.view(), window_around(centre, Vector2::Constant(radius)));
    REQUIRE(found);
    CHECK(found->area_px == doctest::Approx(std::numbers::pi * radius * radius).epsilon(0.05));
    squares += (found->centroid - centre).squaredNorm() / 2.0;
  }
  return std::sqrt(squares / discs);
}

}  // namespace

TEST_CASE("the centroid of a disc is measured to the floor that its samples leave") {
  // evaluation.md, per axis: 0.010 px with 4x4 samples, 0.031 with 2x2, 0.072 with one; 60 discs know an RMS to 7 %, 3
  // sigma.
  CHECK(centroid_rms(8.0, 4) < 0.0125);
  CHECK(centroid_rms(8.0, 2) < 0.038);
  CHECK(centroid_rms(8.0, 1) < 0.088);
  CHECK(centroid_rms(8.0, 1) > centroid_rms(8.0, 4));
}

TEST_CASE("the picture of a slanted disc has its centroid where the projected ellipse says") {
  const EyeModel eye = default_hmd({160, 90}).left;
  Disc disc;
  disc.centre_W = Vector3(0.25, 0.05, -1.0);
  disc.normal_W = Vector3(-0.8, 0.2, 0.6).normalized();
  disc.radius_m = 0.2;
  const auto e = project_disc(eye, Rigid(), disc);
  REQUIRE(e);
  const Picture picture(160, 90, 4, Vector3::Constant(255), Vector3::Zero(), [&](double x, double y) {
    const Vector3 ray = ray_E(eye, Vector2(x, y));
    const Vector3 hit = ray * (disc.normal_W.dot(disc.centre_W) / disc.normal_W.dot(ray));
    return (hit - disc.centre_W).norm() < disc.radius_m;
  });
  const auto found = picture_centroid(picture.view(), window_around(e->centroid, e->half_extent_px));
  REQUIRE(found);
  CHECK((found->centroid - e->centroid).norm() < 0.03);  // three times the floor
  // The projected centre would be wrong by far more.
  CHECK((found->centroid - *project(eye, disc.centre_W)).norm() > 0.3);
}

TEST_CASE("windows outside the picture and pictures without a disc give nothing") {
  const Picture flat(40, 40, 1, Vector3::Zero(), Vector3::Constant(90), [](double, double) { return false; });
  CHECK_FALSE(picture_centroid(flat.view(), {5, 5, 35, 35}));
  CHECK_FALSE(picture_centroid(flat.view(), {-1, 5, 35, 35}));
  CHECK_FALSE(picture_centroid(flat.view(), {5, 5, 35, 41}));
  CHECK_FALSE(picture_edge(flat.view(), {5, 5, 35, 35}));
}

TEST_CASE("a slanted edge is found to a hundredth of a pixel") {
  const double slope = 0.031, x0 = 30.37;
  const Picture picture(64, 80, 4, Vector3(230, 230, 220), Vector3(20, 20, 20),
                        [&](double x, double y) { return x > x0 + slope * (y - 40.0); });
  const auto line = picture_edge(picture.view(), {20, 2, 44, 78});
  REQUIRE(line);
  CHECK(line->rows >= 60);
  // A row's edge is quantised to 1/16 px at worst with 4x4 samples: 0.02 px RMS a row, over 70 rows 0.0025 px, slope
  // 1e-4.
  CHECK(line->x_at(40.0) == doctest::Approx(x0).epsilon(3e-4));
  CHECK(std::abs(line->slope - slope) < 4e-4);
}

TEST_CASE("rows that something else covers do not tilt the line") {
  std::vector<Vector2> points;
  for (int y = 0; y < 60; ++y) points.emplace_back(10.0 + 0.1 * y + 0.01 * (y % 3 - 1), y);
  for (int y = 20; y < 32; ++y) points[static_cast<std::size_t>(y)].x() += 4.0 + 0.3 * y;
  const auto line = fit_vertical_line(points);
  REQUIRE(line);
  CHECK(line->slope == doctest::Approx(0.1).epsilon(1e-3));
  CHECK(line->rows == 48);
  CHECK_FALSE(fit_vertical_line(std::span(points).first(2)));
}

#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/projected_ellipse.hpp>

using namespace holdfast;

namespace {

Disc some_disc(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Disc disc;
  const double depth = 1.3 + u(random);
  disc.centre_W = Vector3(0.4 * depth * u(random), 0.2 * depth * u(random), -depth);
  disc.normal_W = Vector3(u(random), u(random), 1.2).normalized();
  disc.radius_m = 0.05 + 0.03 * u(random);
  return disc;
}

/// Centroid of the picture of the disc by brute force: area and moments of its projected outline, a polygon of many
/// points.
Vector2 centroid_by_outline(const EyeModel& eye, const Rigid& X_WE, const Disc& disc, int points) {
  const auto across = detail::basis_across(disc.normal_W);
  std::vector<Vector2> outline;
  for (int i = 0; i < points; ++i) {
    const double a = 2.0 * std::numbers::pi * i / points;
    const Vector3 p_W = disc.centre_W + disc.radius_m * (std::cos(a) * across[0] + std::sin(a) * across[1]);
    outline.push_back(*project(eye, X_WE.inverse() * p_W));
  }
  double area = 0.0;
  Vector2 moment = Vector2::Zero();
  const Vector2 origin = outline.front();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2 p = outline[i] - origin, q = outline[(i + 1) % outline.size()] - origin;
    const double cross = p.x() * q.y() - p.y() * q.x();
    area += cross;
    moment += cross * (p + q);
  }
  return origin + moment / (3.0 * area);
}

}  // namespace

TEST_CASE("the ellipse holds the projected outline") {
  std::mt19937 random(1);
  const EyeModel eye = default_hmd().right;
  const Rigid X_WE(so3::exp<double>(Vector3(0.1, -0.2, 0.3)), Vector3(0.03, -0.02, 0.1));
  for (int i = 0; i < 50; ++i) {
    const Disc disc = some_disc(random);
    const auto e = project_disc(eye, X_WE, disc);
    REQUIRE(e);
    const auto across = detail::basis_across(disc.normal_W);
    for (double a = 0.0; a < 6.28; a += 0.7) {
      const Vector3 p_W = disc.centre_W + disc.radius_m * (std::cos(a) * across[0] + std::sin(a) * across[1]);
      const Vector2 d = *project(eye, X_WE.inverse() * p_W) - e->centroid;
      // Relative; the conic's entries are of size 1e6 px^2, so nine digits remain.
      CHECK(d.dot(e->shape.inverse() * d) == doctest::Approx(1.0).epsilon(1e-8));
      CHECK(std::abs(d.x()) <= e->half_extent_px.x() * (1.0 + 1e-9));
      CHECK(std::abs(d.y()) <= e->half_extent_px.y() * (1.0 + 1e-9));
    }
  }
}

TEST_CASE("the ellipse's centre is the centroid of the picture, not the picture of the centre") {
  std::mt19937 random(2);
  const EyeModel eye = default_hmd().left;
  double largest = 0.0;
  for (int i = 0; i < 20; ++i) {
    const Disc disc = some_disc(random);
    const auto e = project_disc(eye, Rigid(), disc);
    REQUIRE(e);
    // A polygon of n points inside an ellipse has its centroid to (2 pi / n)^2 of the perspective skew (below 20 px):
    // 1e-5.
    CHECK((e->centroid - centroid_by_outline(eye, Rigid(), disc, 4000)).norm() < 1e-4);
    largest = std::max(largest, (e->centroid - *project(eye, disc.centre_W)).norm());
  }
  CHECK(largest > 0.3);  // px: far above the 0.01 px that pictures are measured to
}

TEST_CASE("a disc facing the eye on its axis is a circle of radius f r / d") {
  const EyeModel eye = default_hmd().left;
  Disc disc;
  disc.centre_W = Vector3(0, 0, -2);
  disc.radius_m = 0.05;
  const auto e = project_disc(eye, Rigid(), disc);
  REQUIRE(e);
  const double radius = pixels_per_tangent(eye).x() * 0.05 / 2.0;
  CHECK(e->semi_major_px == doctest::Approx(radius).epsilon(1e-10));
  CHECK(e->semi_minor_px == doctest::Approx(radius).epsilon(1e-10));
  CHECK((e->centroid - Vector2(640, 360)).norm() < 1e-9);
  CHECK(e->depth_m == 2.0);
  CHECK(e->front);
}

TEST_CASE("discs without an ellipse, and backs") {
  const EyeModel eye = default_hmd().left;
  Disc disc;
  disc.radius_m = 0.1;
  disc.centre_W = Vector3(0, 0, 1);
  CHECK_FALSE(project_disc(eye, Rigid(), disc));  // behind
  disc.centre_W = Vector3(0, 0, -0.05);
  disc.normal_W = Vector3::UnitX();
  CHECK_FALSE(project_disc(eye, Rigid(), disc));  // reaches through the eye's plane
  disc.centre_W = Vector3(0, 0, -1);
  CHECK_FALSE(project_disc(eye, Rigid(), disc));  // seen from its edge
  disc.normal_W = -Vector3::UnitZ();
  REQUIRE(project_disc(eye, Rigid(), disc));
  CHECK_FALSE(project_disc(eye, Rigid(), disc)->front);
  disc.centre_W.x() = NAN;
  CHECK_FALSE(project_disc(eye, Rigid(), disc));
}

TEST_CASE("the lens moves the seen centroid as the lens says, exact correction does not") {
  const EyeModel eye = default_hmd().left;
  Disc disc;
  disc.centre_W = Vector3(0.25, 0.1, -1);
  disc.radius_m = 0.005;
  const auto e = project_disc(eye, Rigid(), disc);
  REQUIRE(e);
  CHECK(*seen_centroid(eye, LensMode::none, *e) == e->centroid);
  CHECK((*seen_centroid(eye, LensMode::exact, *e) - e->centroid).norm() == 0.0);
  // Drawn and seen through the same lens point by point: exact up to the inverse's rounding.
  CHECK((*seen_centroid(eye, eye, LensMode::exact, *e) - e->centroid).norm() < 1e-9);
  for (const LensMode mode : {LensMode::cubic, LensMode::uncorrected}) {
    const Vector2 seen = *seen_centroid(eye, mode, *e);
    // A small disc: its bent outline's centroid is near the bent centre, nearer by the square of the radius.
    CHECK((seen - *seen_pixel(eye, mode, e->centroid)).norm() < 0.15);
    CHECK((seen - e->centroid).norm() > 1.0);
  }
}

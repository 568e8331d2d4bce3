#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/outline_centroid.hpp>
#include <holdfast/registration/projected_ellipse.hpp>

using namespace holdfast;

namespace {

/// Centroid of the polygon through many points of the curve.
template <typename Curve>
Vector2 polygon_centroid(const Curve& curve, int n = 20000) {
  double area = 0.0;
  Vector2 moment = Vector2::Zero();
  const auto at = [&](int i) -> Vector2 {
    const double a = 2.0 * std::numbers::pi * i / n;
    return *curve(std::cos(a), std::sin(a));
  };
  const Vector2 origin = at(0);
  for (int i = 0; i < n; ++i) {
    const Vector2 p = at(i) - origin, q = at(i + 1) - origin;
    const double cross = p.x() * q.y() - p.y() * q.x();
    area += cross;
    moment += cross * (p + q);
  }
  return origin + moment / (3.0 * area);
}

}  // namespace

TEST_CASE("an ellipse's centroid is its centre, whichever way round") {
  const Vector2 centre(1234.5, -67.8);
  for (const double sign : {1.0, -1.0}) {
    const auto found = outline_centroid([&](double c, double s) -> std::optional<Vector2> {
      return Vector2(centre + Vector2(17.0 * c + 3.0 * sign * s, -2.0 * c + 9.0 * sign * s));
    });
    REQUIRE(found);
    CHECK((*found - centre).norm() < 1e-11);  // rounding at 1e3
  }
}

TEST_CASE("under a homography it is the centroid of the conic's image") {
  const EyeModel eye = default_hmd().left;
  Disc disc;
  disc.centre_W = Vector3(0.2, -0.15, -1.0);
  disc.normal_W = Vector3(0.3, 0.1, 1.0).normalized();
  disc.radius_m = 0.05;
  const Matrix3 H_ES = so3::exp<double>(Vector3(0.05, -0.12, 0.2)).toRotationMatrix();
  const auto whole = project_disc(eye, Rigid(), disc, H_ES), drawn = project_disc(eye, Rigid(), disc);
  REQUIRE(whole);
  const auto found = centroid_through(*drawn, [&](const Vector2& pixel) -> std::optional<Vector2> {
    const Vector2 t = tangent_of_pixel(eye, pixel);
    const Vector3 h = H_ES * Vector3(t.x(), t.y(), 1.0);
    return pixel_of_tangent(eye, Vector2(h.x() / h.z(), h.y() / h.z()));
  });
  REQUIRE(found);
  CHECK((*found - whole->centroid).norm() < 1e-9);
  CHECK((whole->centroid - drawn->centroid).norm() > 100.0);  // the map did something
}

TEST_CASE("under a lens it is what a fine polygon has") {
  const EyeModel eye = default_hmd().left;
  const Vector2 centre(1000.0, 560.0);
  const auto curve = [&](double c, double s) {
    return seen_pixel(eye, LensMode::uncorrected, Vector2(centre + 18.0 * Vector2(c, s)));
  };
  const auto found = outline_centroid(curve);
  REQUIRE(found);
  // A polygon of n points inside has its centroid to (2 pi / n)^2 = 1e-7 of the bend, which is below 1 px.
  CHECK((*found - polygon_centroid(curve)).norm() < 1e-6);
  CHECK((*found - *seen_pixel(eye, LensMode::uncorrected, centre)).norm() > 0.05);  // the bend shows
}

TEST_CASE("a curve with a hole, or without area, has no centroid") {
  CHECK_FALSE(outline_centroid(
      [](double c, double s) { return c > 0.9 ? std::nullopt : std::optional<Vector2>(Vector2(c, s)); }));
  CHECK_FALSE(outline_centroid([](double, double) { return std::optional<Vector2>(Vector2(3.0, 4.0)); }));
}

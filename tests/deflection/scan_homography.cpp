#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/scan_homography.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

namespace {

/// Largest distance, in px at `pixels_per_tangent`, between the parabola and the map of each line's own pose, over a
/// field whose edges have the tangents +-half_x and +-half_y.
double worst_error_px(const DeflectionSettings& settings, const ScanPose& X_SE, const ScanHomography& H_SE,
                      double pixels_per_tangent, double half_x, double half_y) {
  double worst = 0.0;
  for (int line = 0; line <= 40; ++line) {
    const double s = line / 40.0;
    const auto exact = deflection_detail::homography(settings, Vector2::Zero(), X_SE.at(s));
    REQUIRE(exact);
    for (int i = -4; i <= 4; ++i) {
      for (int k = -2; k <= 2; ++k) {
        const Vector2 t_E(half_x * i / 4, half_y * k / 2);
        const auto drawn = H_SE.source_tangent(t_E, s);
        REQUIRE(drawn);
        worst = std::max(worst, pixels_per_tangent * (*drawn - *exact->apply(t_E)).norm());
      }
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the parabola passes through begin, middle and end; the identity is exact at every line") {
  test::Random random(301);
  for (int i = 0; i < 20; ++i) {
    const auto H = [&] { return Homography::rotation(random.turn(0.3)); };
    const Homography begin = H(), middle = H(), end = H();
    const ScanHomography H_SE(begin, middle, end);
    CHECK((H_SE.at(0.0) - begin.matrix()).cwiseAbs().maxCoeff() == 0.0);
    CHECK((H_SE.at(0.5) - middle.matrix()).cwiseAbs().maxCoeff() < 2e-15);
    CHECK((H_SE.at(1.0) - end.matrix()).cwiseAbs().maxCoeff() < 2e-15);
    CHECK_FALSE(H_SE.is_constant());
    // One map for all lines stays itself, to the last bit.
    for (const double s : {0.0, 0.123, 0.5, 1.0, 1.7}) CHECK(ScanHomography(middle).at(s) == middle.matrix());
    CHECK(ScanHomography(middle).is_constant());
    // There and back on one line.
    const Vector2 t(0.3, -0.4);
    CHECK((*H_SE.displayed_tangent(*H_SE.source_tangent(t, 0.3), 0.3) - t).norm() < 1e-14);
    // A shader may sum the same parabola.
    const ScanMatrices& M = H_SE.matrices();
    const Matrix3 summed = M.begin + 0.3 * M.linear() + 0.09 * M.quadratic();
    CHECK((summed - H_SE.at(0.3)).cwiseAbs().maxCoeff() < 1e-15);
  }
  CHECK(ScanHomography().matrices().is_identity());
}

TEST_CASE("at 200 deg/s and 11.1 ms the parabola errs by less than 0.001 px from each line's own pose") {
  // 1108 px per tangent: 1280 px over 60 degrees, the default headset. The bound 0.0080 a^3 (scan_homography.hpp) gives
  // 4.7e-7 of tangent = 0.0005 px on the axis; off the axis tangents grow by up to 1 + t^2: 1.4 at this headset's
  // corners. A field of 90 by 70 degrees with as many pixels per tangent (2216 across) has 2.5 there.
  const double pixels_per_tangent = 1280 / (2 * tan(degrees(30)));
  const Vector2 half = tan(degrees(30)) * Vector2(1.0, 720.0 / 1280.0), wide_half(1.0, 0.7);
  double worst_rotation = 0.0, worst_plane = 0.0, worst_wide = 0.0;
  test::Random random(302);
  for (int i = 0; i < 40; ++i) {
    const Vector3 axis = i < 3 ? Vector3(Vector3::Unit(i)) : Vector3(random.vector(1.0).normalized());
    const RenderedView view{random.pose(3.0, 1.0), {-1, 1, -1, 1}, {1280, 720}, {}};
    const LatePoses late = test::moved_on(view, axis * degrees(200).radians(), random.vector(0.6), 0.01, 0.0111);
    const auto worst_of = [&](const DeflectionSettings& settings, const Vector2& field, double worst) {
      const DeflectionResult result = deflect(settings, view, late);
      REQUIRE(result.ok());
      const double error = worst_error_px(settings, result.X_SE, result.H_SE, pixels_per_tangent, field.x(), field.y());
      return std::max(worst, error);
    };
    worst_rotation = worst_of({DeflectionKind::rotation}, half, worst_rotation);
    worst_plane = worst_of({DeflectionKind::plane, 1.0}, half, worst_plane);
    worst_wide = worst_of({DeflectionKind::rotation}, wide_half, worst_wide);
  }
  MESSAGE("worst error of the parabola, 200 deg/s, 11.1 ms: rotation ", worst_rotation, " px, plane at 1 m ",
          worst_plane, " px; over 90 by 70 degrees ", worst_wide, " px");
  CHECK(worst_rotation < 1e-3);
  CHECK(worst_plane < 1.5e-3);  // and the eye moves at 1 m/s besides
  CHECK(worst_wide < 2e-3);
  CHECK(worst_rotation > 1e-5);  // the measure does measure
}

TEST_CASE("a head that accelerates during the scan: the middle pose takes what two poses leave") {
  // Yaw of 3 degrees at 2 Hz, 11.1 ms: at the turning points it accelerates by 8.3 rad/s^2, so that the middle of the
  // scan lies a T^2 / 8 = 1.3e-4 rad beside the way between its ends: 0.14 px at 1108 px per tangent, and 1 + tan^2 more
  // at the edge. Through three poses 0.008 (0.14 rad)^3 3 deg = 1.1e-6 rad are left.
  const double scan_s = 0.0111;
  const RenderedView view{{}, {-1, 1, -1, 1}, {1280, 720}, {}};
  const auto X_WE = [](double t) {
    return Rigid::rotation(
        so3::exp<double>(Vector3(0, degrees(3).radians() * std::sin(4.0 * std::numbers::pi * t), 0)));
  };
  double worst_two = 0.0, worst_three = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double begin = 0.01 * i;
    LatePoses late{X_WE(begin), X_WE(begin + scan_s)};
    const DeflectionResult two = deflect({}, view, late);
    late.X_WE_middle = X_WE(begin + 0.5 * scan_s);
    const DeflectionResult three = deflect({}, view, late);
    for (int line = 0; line <= 20; ++line) {
      const double s = line / 20.0;
      const Homography exact = Homography::rotation(X_WE(begin + s * scan_s).q());
      for (const double x : {-0.577, 0.0, 0.577}) {
        const Vector2 t_E(x, 0.325 * (1.0 - 2.0 * s)), truth = *exact.apply(t_E);
        worst_two = std::max(worst_two, 1108.0 * (*two.H_SE.source_tangent(t_E, s) - truth).norm());
        worst_three = std::max(worst_three, 1108.0 * (*three.H_SE.source_tangent(t_E, s) - truth).norm());
      }
    }
  }
  MESSAGE("yaw 2 Hz 3 deg, 11.1 ms: worst ", worst_two, " px with two late poses, ", worst_three, " px with three");
  CHECK(worst_two > 0.13);
  CHECK(worst_three < 0.003);
}

TEST_CASE("the parabola's error grows with the cube of the turn during the scan") {
  const RenderedView view{{}, {-1, 1, -1, 1}, {1280, 720}, {}};
  const auto error = [&](double deg_s) {
    const LatePoses late = test::moved_on(view, Vector3(0, degrees(deg_s).radians(), 0), Vector3::Zero(), 0.0, 0.0111);
    const DeflectionResult result = deflect({}, view, late);
    return worst_error_px({}, result.X_SE, result.H_SE, 1108.0, 0.577, 0.325);
  };
  // The next order is smaller by about the turn itself, 0.04 and 0.08 rad.
  CHECK(error(400.0) / error(200.0) == doctest::Approx(8.0).epsilon(0.08));
}

#include <cmath>
#include <limits>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/optics/planar_model.hpp>

#include "optics/lens_checks.hpp"

using namespace holdfast;

namespace {

/// exp(z) - 1 in the complex plane: conformal, everywhere without a vanishing derivative, but not one-to-one beyond a
/// strip of height 2 pi.
struct Exponential {
  [[nodiscard]] PlanarValue at(const Vector2& u) const {
    const double e = std::exp(u.x());
    const double c = e * std::cos(u.y());
    const double s = e * std::sin(u.y());
    PlanarValue f;
    f.seen = {c - 1.0, s};
    f.J << c, -s, s, c;
    return f;
  }
  [[nodiscard]] double limit() const { return 50.0; }
};

/// A map with a steep wall, where Newton's full steps leap far beyond the disc.
struct Wall {
  [[nodiscard]] PlanarValue at(const Vector2& u) const {
    PlanarValue f;
    f.seen = {u.x() + 20.0 * std::tanh(8.0 * (u.x() - 0.6)) + 20.0 * std::tanh(4.8), u.y() + 0.2 * u.x() * u.x()};
    const double t = std::tanh(8.0 * (u.x() - 0.6));
    f.J << 1.0 + 160.0 * (1.0 - t * t), 0.0, 0.4 * u.x(), 1.0;
    return f;
  }
  [[nodiscard]] double limit() const { return 1.0; }
};

}  // namespace

TEST_CASE("exp(z) - 1: the domain ends where the real part of its derivative vanishes, at a radius of pi / 2") {
  const PlanarModel<Exponential> lens;
  // Re exp(z) = e^x cos y > 0.01 on the disc fails first near x = 0, y = pi / 2.
  CHECK(lens.valid_radius() < std::numbers::pi / 2);
  CHECK(lens.valid_radius() > 0.9 * std::numbers::pi / 2);
  test::for_disc(Vector2::Zero(), lens.valid_radius() * (1 - 1e-12), [&](const Vector2& u) {
    const Vector2 v = lens.distort(u).value();
    CHECK((lens.undistort(v).value() - u).norm() < 1e-14);
    // The inverse is the complex logarithm.
    const Vector2 w(0.5 * std::log((1.0 + v.x()) * (1.0 + v.x()) + v.y() * v.y()), std::atan2(v.y(), 1.0 + v.x()));
    CHECK((w - u).norm() < 1e-14);
  });
  // Points whose logarithm lies outside the disc have no answer, however near: no other branch is taken.
  int refused = 0;
  test::for_disc(Vector2::Zero(), 3.0, [&](const Vector2& u) {
    if (u.norm() < lens.valid_radius() * (1 + 1e-9)) return;
    if (std::abs(u.y()) > std::numbers::pi) return;
    CHECK_FALSE(lens.undistort(Exponential().at(u).seen).has_value());
    ++refused;
  });
  CHECK(refused > 100);
  CHECK_FALSE(lens.undistort(Vector2(-1.0, 0.0)).has_value());  // exp never vanishes
}

TEST_CASE("the covered disc is covered") {
  const PlanarModel<Exponential> lens;
  CHECK(lens.valid_image_radius() > 0.5);
  CHECK(test::worst_residual(lens, Vector2::Zero(), lens.valid_image_radius()) < 1e-15);
}

TEST_CASE("steps that leap are cut short: a wall of slope 160") {
  const PlanarModel<Wall> lens;
  CHECK(lens.valid_radius() > 0.3);
  test::for_disc(Vector2::Zero(), lens.valid_radius() * (1 - 1e-12), [&](const Vector2& u) {
    const Vector2 v = lens.distort(u).value();
    const auto back = lens.undistort(v);
    REQUIRE(back.has_value());
    CHECK((*back - u).norm() < 1e-13);
  });
}

// Checks that every lens model must pass.
#pragma once

#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/optics/lens.hpp>

namespace holdfast::test {

/// Points in rings and spokes round the lens's centre, up to `radius` (in the unit of r_norm).
template <typename Visit>
void for_disc(const Vector2& centre, double radius, const Visit& visit) {
  visit(centre);
  for (int ring = 1; ring <= 40; ++ring) {
    for (int spoke = 0; spoke < 7; ++spoke) {
      const double a = 2.0 * std::numbers::pi * spoke / 7 + 0.1;
      visit(Vector2(centre + radius * ring / 40 * Vector2(std::cos(a), std::sin(a))));
    }
  }
}

/// distort(undistort(v)) - v over the seen disc; the worst distance.
template <LensModel L>
double worst_residual(const L& lens, const Vector2& centre, double seen_radius) {
  double worst = 0.0;
  for_disc(centre, seen_radius, [&](const Vector2& v) {
    const auto p = lens.undistort(v);
    REQUIRE(p.has_value());
    const auto back = lens.distort(*p);
    REQUIRE(back.has_value());
    worst = std::max(worst, (*back - v).norm());
  });
  return worst;
}

/// Both Jacobians against central differences over the panel disc. With step h the differences err by h^2 times a third
/// derivative plus rounding / h; h = 1e-5 leaves about 1e-9.
template <LensModel L>
void check_jacobians(const L& lens, const Vector2& centre, double panel_radius) {
  const double h = 1e-5 * panel_radius;
  for_disc(centre, panel_radius, [&](const Vector2& p) {
    const Matrix2 J = lens.distort_jacobian(p);
    Matrix2 numeric;
    for (int i = 0; i < 2; ++i) {
      const Vector2 step = h * Vector2::Unit(i);
      numeric.col(i) = (*lens.distort(Vector2(p + step)) - *lens.distort(Vector2(p - step))) / (2 * h);
    }
    CHECK((J - numeric).norm() < 1e-7 * (1 + J.norm()));
    const Vector2 v = *lens.distort(p);
    const auto J_inverse = lens.undistort_jacobian(v);
    REQUIRE(J_inverse.has_value());
    CHECK((*J_inverse * J - Matrix2::Identity()).norm() < 1e-8);
  });
}

}  // namespace holdfast::test

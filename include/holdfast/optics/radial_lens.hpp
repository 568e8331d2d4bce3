/// The third-order radial lens of Robinett & Holloway, r_v = r + k r^3, with its exact inverse.
///
/// A point of the panel at `p` is seen at distort(p), both from the optical axis and in the unit r_norm in which k is
/// given (a Lens places it: LensPlacement). With r = |p|:
///
///     distort(p) = p (1 + k r^2)                       000 eq. 7.9.2; k > 0 is pincushion, k < 0 barrel
///
///     undistort(v) = v m,                              m + c m^3 = 1,  c = k |v|^2
///
/// The inverse is exact (to rounding): for c < 0 by the trigonometric closed form (Rolland & Hopkins 1993 solve the
/// same cubic), for c >= 0 by Halley's iteration with a start so near that a fixed number of steps reaches rounding.
/// Drawing a picture at undistort makes it look right through the lens. The paper instead predistorts with r + k_pd r^3
/// (Lens::cubic_inverse, itself such a lens), which is only near. For k < 0 the lens folds over at valid_radius: farther out, points of the panel
/// are seen nearer again. Beyond that radius, or beyond its image when inverting, the answer is nothing. Source:
/// Robinett & Holloway 1994 (course 11), 7.9 and table 8.1.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/radial_model.hpp>

namespace holdfast {

namespace detail {

/// The root m of m + c m^3 = 1 that is 1 at c = 0. Precondition: c >= -4/27, where the cubic folds over (m = 1.5).
inline double cubic_scale(double c) {
  if (c < 0.0) {
    if (c > -1e-6) return 1.0 - c * (1.0 - 3.0 * c);  // next term 12 c^3: below rounding
    const double a = -c;
    const double m = 2.0 / std::sqrt(3.0 * a) * std::sin(std::asin(std::min(1.0, std::sqrt(6.75 * a))) / 3.0);
    const double slope = 1.0 + 3.0 * c * m * m;
    // One Newton step removes the closed form's rounding, except at the fold, where the slope vanishes.
    return slope > 0.05 ? m - (m + c * m * m * m - 1.0) / slope : m;
  }
  const auto halley = [c](double x) {
    const double f = x + c * x * x * x - 1.0;
    const double slope = 1.0 + 3.0 * c * x * x;
    return x - f * slope / (slope * slope - 3.0 * c * x * f);
  };
  // The start is within 2e-4 of the root for c <= 1, and Halley's error is cubic: two steps reach rounding.
  if (c <= 1.0) return halley(halley((1.0 + c * (3.237 + 0.869 * c)) / (1.0 + c * (4.231 + 2.252 * c))));
  double m = std::cbrt(1.0 / c);  // above the root by at most 32 %, whatever c
  for (int i = 0; i < 5; ++i) m = halley(m);
  return m;
}

}  // namespace detail

struct RadialLens {
  double k = 0.0;  ///< distortion at r = 1, i.e. at r_norm from the centre (k_n in the paper)

  [[nodiscard]] static LensProblem problem_of(double k) {
    return std::isfinite(k) ? LensProblem::none : LensProblem::not_finite;
  }

  /// Panel radius up to which distort is one-to-one: 1/sqrt(-3k); infinite for k >= 0.
  [[nodiscard]] double valid_radius() const {
    return k < 0.0 ? 1.0 / std::sqrt(-3.0 * k) : std::numeric_limits<double>::infinity();
  }
  /// The seen radius that valid_radius maps to: undistort's domain.
  [[nodiscard]] double valid_image_radius() const { return valid_radius() * (k < 0.0 ? 2.0 / 3.0 : 1.0); }

  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const {
    const double r2 = p.squaredNorm();
    if (!(-3.0 * k * r2 <= 1.0) || !std::isfinite(r2)) return std::nullopt;
    return Vector2(p * (1.0 + k * r2));
  }

  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const {
    const double v2 = v.squaredNorm();
    const double c = k * v2;
    if (!(c >= -4.0 / 27.0) || !std::isfinite(v2)) return std::nullopt;
    return Vector2(v * detail::cubic_scale(c));
  }

  /// d distort / d p = (1 + k r^2) I + 2 k p p^T.
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& p) const {
    return (1.0 + k * p.squaredNorm()) * Matrix2::Identity() + 2.0 * k * p * p.transpose();
  }

  /// d undistort / d v; nothing outside the domain and at the fold itself, where it is infinite.
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    const std::optional<Vector2> p = undistort(v);
    if (!p) return std::nullopt;
    const Matrix2 J = distort_jacobian(*p);
    if (!(J.determinant() > 0.0)) return std::nullopt;
    return Matrix2(J.inverse());
  }

  /// The lens as a RadialProfile: it is its own.
  [[nodiscard]] const RadialLens& profile() const { return *this; }
  [[nodiscard]] double scale(double r2) const { return 1.0 + k * r2; }
  [[nodiscard]] RadialValue at(double r) const { return {r * (1.0 + k * r * r), 1.0 + 3.0 * k * r * r}; }
  [[nodiscard]] double fold() const { return valid_radius(); }

  friend bool operator==(const RadialLens&, const RadialLens&) = default;
};

}  // namespace holdfast

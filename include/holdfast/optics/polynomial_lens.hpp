/// Radial polynomial lens, as the Rifts, Cardboard and OSVR's headsets are described by.
///
/// A point of the panel at `p` is seen at distort(p), both from the optical axis and in the unit in which the
/// coefficients are given (a Lens places it: LensPlacement). With r = |p|:
///
///     distort(p) = p (k0 + k1 r^2 + k2 r^4 + ... + kn r^2n)          n <= 6
///
/// k0 is 1 but where a colour is magnified differently from the one that the panel's tangents are given for.
/// distort is one-to-one up to valid_radius, the smallest r where the derivative of r (k0 + k1 r^2 + ...) vanishes
/// (infinite when it never does); undistort inverts it there by Newton's method kept inside a bracket, to rounding.
/// Elsewhere: nothing. Sources: Google Cardboard's viewer profile (K1, K2 in tangents); Oculus SDK 0.2 (distortionK, r
/// in quarters of the screen's width).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>

namespace holdfast {

namespace detail {

/// Value of c[0] + c[1] x + ... + c[degree] x^degree.
template <std::size_t N>
[[nodiscard]] double polynomial_value(const std::array<double, N>& c, std::size_t degree, double x) {
  double value = c[degree];
  for (std::size_t i = degree; i-- > 0;) value = value * x + c[i];
  return value;
}

/// The root of a monotone stretch [a, b] of the polynomial, whose ends differ in sign, by bisection to the last bit.
template <std::size_t N>
[[nodiscard]] double bisect(const std::array<double, N>& c, std::size_t degree, double a, double b) {
  const bool rising = polynomial_value(c, degree, b) > 0.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = a + (b - a) / 2.0;
    if (middle <= a || middle >= b) break;
    ((polynomial_value(c, degree, middle) > 0.0) == rising ? b : a) = middle;
  }
  return a;
}

/// Where the polynomial changes sign in (0, limit), in rising order: its derivative's sign changes cut the stretch into
/// monotone pieces, each of which holds at most one.
template <std::size_t N>
[[nodiscard]] std::array<double, N> sign_changes(const std::array<double, N>& c, std::size_t degree, double limit,
                                                 std::size_t& count) {
  std::array<double, N> roots{};
  count = 0;
  if (degree == 0) return roots;
  std::array<double, N> derivative{};
  for (std::size_t i = 1; i <= degree; ++i) derivative[i - 1] = static_cast<double>(i) * c[i];
  std::size_t cuts = 0;
  const std::array<double, N> cut = sign_changes(derivative, degree - 1, limit, cuts);
  double a = 0.0;
  for (std::size_t i = 0; i <= cuts; ++i) {
    const double b = i < cuts ? cut[i] : limit;
    if ((polynomial_value(c, degree, a) > 0.0) != (polynomial_value(c, degree, b) > 0.0) && count < N) {
      roots[count++] = bisect(c, degree, a, b);
    }
    a = b;
  }
  return roots;
}

}  // namespace detail

class PolynomialLens {
 public:
  static constexpr std::size_t max_coefficients = 6;

  PolynomialLens() = default;

  /// Coefficients k1, k2, ...: at most 6, finite; k0 > 0.
  explicit PolynomialLens(std::span<const double> k, double k0 = 1.0) : count_(k.size()), k0_(k0) {
    HOLDFAST_ASSERT(k0 > 0.0, "k0 must be positive");
    HOLDFAST_ASSERT(k.size() <= max_coefficients, "too many lens coefficients");
    std::copy_n(k.begin(), std::min(k.size(), max_coefficients), k_.begin());
    fold_ = first_fold();
    image_fold_ = std::isfinite(fold_) ? seen_radius(fold_) : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] std::span<const double> coefficients() const { return {k_.data(), count_}; }
  [[nodiscard]] double k0() const { return k0_; }
  [[nodiscard]] double valid_radius() const { return fold_; }
  [[nodiscard]] double valid_image_radius() const { return image_fold_; }

  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const {
    const double r2 = p.squaredNorm();
    if (!(r2 <= fold_ * fold_) || !std::isfinite(r2)) return std::nullopt;
    return Vector2(p * scale(r2));
  }

  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const {
    const double seen = v.norm();
    if (!(seen <= image_fold_) || !std::isfinite(seen)) return std::nullopt;
    if (!(seen > 0.0)) return v;
    return Vector2(v * (panel_radius(seen) / seen));
  }

  /// d distort / d p = s I + 2 s' p p^T, s = k0 + k1 r^2 + ..., s' = ds/d(r^2).
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& p) const {
    const double r2 = p.squaredNorm();
    return scale(r2) * Matrix2::Identity() + 2.0 * scale_slope(r2) * p * p.transpose();
  }

  /// d undistort / d v; nothing outside the domain and at the fold itself, where it is infinite.
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    const std::optional<Vector2> p = undistort(v);
    if (!p) return std::nullopt;
    const Matrix2 J = distort_jacobian(*p);
    if (!(J.determinant() > 0.0)) return std::nullopt;
    return Matrix2(J.inverse());
  }

 private:
  [[nodiscard]] double scale(double r2) const {
    double sum = 0.0;
    for (std::size_t i = count_; i-- > 0;) sum = (sum + k_[i]) * r2;
    return k0_ + sum;
  }
  [[nodiscard]] double scale_slope(double r2) const {
    double sum = 0.0;
    for (std::size_t i = count_; i-- > 0;) sum = sum * r2 + static_cast<double>(i + 1) * k_[i];
    return sum;
  }
  [[nodiscard]] double seen_radius(double r) const { return r * scale(r * r); }
  [[nodiscard]] double seen_slope(double r) const { return scale(r * r) + 2.0 * r * r * scale_slope(r * r); }

  /// Smallest r > 0 where d(r (k0 + k1 r^2 + ...))/dr = k0 + 3 k1 r^2 + 5 k2 r^4 + ... changes sign.
  [[nodiscard]] double first_fold() const {
    std::array<double, max_coefficients + 1> slope{k0_};
    double largest = 0.0;
    std::size_t degree = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      slope[i + 1] = static_cast<double>(2 * i + 3) * k_[i];
      if (k_[i] != 0.0) degree = i + 1;
    }
    if (degree == 0) return std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < degree; ++i) largest = std::max(largest, std::abs(slope[i] / slope[degree]));
    const double beyond_all_roots = 1.0 + largest;  // Cauchy's bound, on r^2
    std::size_t count = 0;
    const auto roots = detail::sign_changes(slope, degree, beyond_all_roots, count);
    return count > 0 ? std::sqrt(roots[0]) : std::numeric_limits<double>::infinity();
  }

  /// The r of [0, fold] that is seen at radius `seen` in (0, image_fold].
  [[nodiscard]] double panel_radius(double seen) const {
    double low = 0.0;
    double high = std::isfinite(fold_) ? fold_ : std::max(1.0, seen);
    while (!std::isfinite(fold_) && seen_radius(high) < seen) high *= 2.0;
    double r = std::clamp(seen, low, high);
    for (int i = 0; i < 100; ++i) {
      const double error = seen_radius(r) - seen;
      if (error == 0.0) return r;
      (error > 0.0 ? high : low) = r;
      double next = r - error / seen_slope(r);
      if (!(next > low && next < high)) next = low + (high - low) / 2.0;
      if (std::abs(next - r) <= 2e-16 * r || !(next > low && next < high)) return next;
      r = next;
    }
    return r;
  }

  std::array<double, max_coefficients> k_{};
  std::size_t count_ = 0;
  double k0_ = 1.0;
  double fold_ = std::numeric_limits<double>::infinity();        ///< panel radius
  double image_fold_ = std::numeric_limits<double>::infinity();  ///< what it is seen at
};

}  // namespace holdfast

/// Which way three points turn, exactly, and whether a fourth lies in their circle.
///
/// orientation is right for any doubles of magnitude 0 or 1e-120 to 1e100: a plain evaluation with an error bound
/// decides nearly always, and an exact sum of exact products the rest. surely_in_circle answers true only when rounding
/// cannot have made it so. Source: Shewchuk 1997, Adaptive Precision Floating-Point Arithmetic and Fast Robust
/// Geometric Predicates (error bounds A, grow-expansion). Unit: any, the same for all points. Wants IEEE arithmetic (no
/// -ffast-math).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

namespace detail {

inline constexpr double half_ulp_of_one = 0x1p-53;

/// The sign of the exact sum of exact products +-a b.
class ExactSum {
 public:
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }

  /// -1, 0 or 1: the largest part that is not zero decides, as the parts do not overlap.
  [[nodiscard]] int sign() const {
    for (std::size_t i = count_; i-- > 0;) {
      if (parts_[i] != 0.0) return parts_[i] > 0.0 ? 1 : -1;
    }
    return 0;
  }

 private:
  void add(double x) {
    for (std::size_t i = 0; i < count_; ++i) {
      const double sum = x + parts_[i];
      const double x_part = sum - parts_[i];
      const double other_part = sum - x_part;
      parts_[i] = (parts_[i] - other_part) + (x - x_part);  // what rounding lost
      x = sum;
    }
    parts_[count_++] = x;
  }

  std::array<double, 12> parts_{};
  std::size_t count_ = 0;
};

}  // namespace detail

/// 1 when a, b, c turn counter-clockwise, -1 clockwise, 0 when they lie on one line.
[[nodiscard]] inline int orientation(const Vector2& a, const Vector2& b, const Vector2& c) {
  const double left = (a.x() - c.x()) * (b.y() - c.y());
  const double right = (a.y() - c.y()) * (b.x() - c.x());
  const double det = left - right;
  constexpr double eps = detail::half_ulp_of_one;
  const double bound = (3.0 + 16.0 * eps) * eps * (std::abs(left) + std::abs(right));
  if (std::abs(det) > bound) return det > 0.0 ? 1 : -1;
  detail::ExactSum sum;
  sum.add_product(a.x(), b.y());
  sum.add_product(-a.x(), c.y());
  sum.add_product(-c.x(), b.y());
  sum.add_product(-a.y(), b.x());
  sum.add_product(a.y(), c.x());
  sum.add_product(c.y(), b.x());
  return sum.sign();
}

/// Whether d lies inside the circle through a, b, c (counter-clockwise) beyond all doubt of rounding.
[[nodiscard]] inline bool surely_in_circle(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& d) {
  const double ax = a.x() - d.x(), ay = a.y() - d.y();
  const double bx = b.x() - d.x(), by = b.y() - d.y();
  const double cx = c.x() - d.x(), cy = c.y() - d.y();
  const double a2 = ax * ax + ay * ay;
  const double b2 = bx * bx + by * by;
  const double c2 = cx * cx + cy * cy;
  const double det = a2 * (bx * cy - cx * by) + b2 * (cx * ay - ax * cy) + c2 * (ax * by - bx * ay);
  const double permanent = a2 * (std::abs(bx * cy) + std::abs(cx * by)) + b2 * (std::abs(cx * ay) + std::abs(ax * cy)) +
                           c2 * (std::abs(ax * by) + std::abs(bx * ay));
  constexpr double eps = detail::half_ulp_of_one;
  return det > (10.0 + 96.0 * eps) * eps * permanent && permanent > 1e-280;  // below, products may have underflowed
}

}  // namespace holdfast

/// Polynomials c[0] + c[1] x + ... of fixed size, and where they change sign: the folds of lenses.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace holdfast::detail {

/// Value of c[0] + c[1] x + ... + c[degree] x^degree.
template <std::size_t N>
[[nodiscard]] double polynomial_value(const std::array<double, N>& c, std::size_t degree, double x) {
  double value = c[degree];
  for (std::size_t i = degree; i-- > 0;) value = value * x + c[i];
  return value;
}

template <std::size_t N>
[[nodiscard]] std::array<double, N> polynomial_derivative(const std::array<double, N>& c) {
  std::array<double, N> derivative{};
  for (std::size_t i = 1; i < N; ++i) derivative[i - 1] = static_cast<double>(i) * c[i];
  return derivative;
}

/// The product; terms of x^N and above must vanish.
template <std::size_t N>
[[nodiscard]] std::array<double, N> polynomial_product(const std::array<double, N>& a, const std::array<double, N>& b) {
  std::array<double, N> product{};
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; i + j < N; ++j) product[i + j] += a[i] * b[j];
  }
  return product;
}

/// The highest power with a coefficient that is not zero.
template <std::size_t N>
[[nodiscard]] std::size_t polynomial_degree(const std::array<double, N>& c) {
  std::size_t degree = N - 1;
  while (degree > 0 && c[degree] == 0.0) --degree;
  return degree;
}

/// The root of a monotone stretch [a, b] of the polynomial, whose ends differ in sign, by bisection to the last bit.
/// The answer lies on a's side of the root.
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
  std::size_t cuts = 0;
  const std::array<double, N> cut = sign_changes(polynomial_derivative(c), degree - 1, limit, cuts);
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

/// The smallest x in (0, limit) where the polynomial changes sign. Where there is none: infinity when that is so for all
/// x > 0 (Cauchy's bound on the roots lies below the limit), else the limit.
template <std::size_t N>
[[nodiscard]] double first_sign_change(const std::array<double, N>& c, double limit) {
  const std::size_t degree = polynomial_degree(c);
  double largest = 0.0;
  for (std::size_t i = 0; i < degree; ++i) largest = std::max(largest, std::abs(c[i] / c[degree]));
  const bool all = degree == 0 || 1.0 + largest < limit;
  std::size_t count = 0;
  const auto roots = sign_changes(c, degree, all ? 1.0 + largest : limit, count);
  if (count > 0) return roots[0];
  return all ? std::numeric_limits<double>::infinity() : limit;
}

}  // namespace holdfast::detail

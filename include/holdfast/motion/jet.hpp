/// A scalar function of time at one moment: its value and its first two derivatives.
///
/// Arithmetic follows the product and chain rules, so that a motion written once as a formula yields exact velocity and
/// acceleration (truncated Taylor series, forward differentiation). Time itself is Jet::time(t) = {t, 1, 0}; a plain
/// number is constant. Units: value u, rate u/s, acceleration u/s^2.
#pragma once

#include <cmath>

namespace holdfast {

struct Jet {
  double value = 0.0;
  double rate = 0.0;
  double acceleration = 0.0;

  constexpr Jet() = default;
  constexpr Jet(double constant) : value(constant) {}  // NOLINT: a number is a constant function, by intent
  constexpr Jet(double x, double dx, double ddx) : value(x), rate(dx), acceleration(ddx) {}

  [[nodiscard]] static constexpr Jet time(double seconds) { return {seconds, 1.0, 0.0}; }
};

[[nodiscard]] constexpr Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.rate + b.rate, a.acceleration + b.acceleration};
}
[[nodiscard]] constexpr Jet operator-(const Jet& a, const Jet& b) {
  return {a.value - b.value, a.rate - b.rate, a.acceleration - b.acceleration};
}
[[nodiscard]] constexpr Jet operator-(const Jet& a) {
  return Jet(0.0) - a;
}
[[nodiscard]] constexpr Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate,
          a.acceleration * b.value + 2.0 * a.rate * b.rate + a.value * b.acceleration};
}

namespace detail {

/// f(a), given f, f' and f'' at a.value.
[[nodiscard]] constexpr Jet chain(const Jet& a, double f, double df, double ddf) {
  return {f, df * a.rate, ddf * a.rate * a.rate + df * a.acceleration};
}

}  // namespace detail

/// Precondition: b.value is not zero.
[[nodiscard]] constexpr Jet operator/(const Jet& a, const Jet& b) {
  const double i = 1.0 / b.value;
  return a * detail::chain(b, i, -i * i, 2.0 * i * i * i);
}

[[nodiscard]] inline Jet sin(const Jet& a) {
  const double s = std::sin(a.value);
  return detail::chain(a, s, std::cos(a.value), -s);
}
[[nodiscard]] inline Jet cos(const Jet& a) {
  const double c = std::cos(a.value);
  return detail::chain(a, c, -std::sin(a.value), -c);
}
/// Precondition: a.value > 0.
[[nodiscard]] inline Jet sqrt(const Jet& a) {
  const double r = std::sqrt(a.value);
  return detail::chain(a, r, 0.5 / r, -0.25 / (r * a.value));
}
/// Precondition: a.value > 0.
[[nodiscard]] inline Jet log(const Jet& a) {
  const double i = 1.0 / a.value;
  return detail::chain(a, std::log(a.value), i, -i * i);
}
[[nodiscard]] inline Jet exp(const Jet& a) {
  const double e = std::exp(a.value);
  return detail::chain(a, e, e, e);
}
[[nodiscard]] inline Jet atan(const Jet& a) {
  const double d = 1.0 / (1.0 + a.value * a.value);
  return detail::chain(a, std::atan(a.value), d, -2.0 * a.value * d * d);
}
/// Angle of the point (x, y), as std::atan2. Precondition: not both zero.
[[nodiscard]] inline Jet atan2(const Jet& y, const Jet& x) {
  const bool steep = std::abs(y.value) > std::abs(x.value);
  Jet angle = steep ? -atan(x / y) : atan(y / x);  // equal up to a constant
  angle.value = std::atan2(y.value, x.value);
  return angle;
}

/// Goes from 0 to 1 while s goes from 0 to 1, with rate and acceleration zero at both ends and constant outside: 6s^5 -
/// 15s^4 + 10s^3.
[[nodiscard]] inline Jet smooth_step(const Jet& s) {
  if (s.value <= 0.0) return 0.0;
  if (s.value >= 1.0) return 1.0;
  return s * s * s * (s * (s * 6.0 - 15.0) + 10.0);
}

}  // namespace holdfast

/// Typed angle: built from radians, degrees or arc minutes by name, never from a bare number.
///
///     Angle yaw = degrees(30.0);    double y = yaw.radians();    Angle half = yaw / 2;
///
/// Public functions that take an angle from people take this type; inner code works in radians.
#pragma once

#include <cmath>
#include <compare>
#include <numbers>

namespace holdfast {

class Angle {
 public:
  constexpr Angle() = default;

  [[nodiscard]] static constexpr Angle from_radians(double value) { return Angle(value); }
  [[nodiscard]] constexpr double radians() const { return radians_; }
  [[nodiscard]] constexpr double degrees() const { return radians_ * (180.0 / std::numbers::pi); }
  [[nodiscard]] constexpr double arcmin() const { return radians_ * (180.0 * 60.0 / std::numbers::pi); }

  /// The same direction in (-pi, pi].
  [[nodiscard]] Angle wrapped() const {
    const double wrapped = std::remainder(radians_, 2.0 * std::numbers::pi);
    return Angle(wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped);
  }

  friend constexpr Angle operator+(Angle a, Angle b) { return Angle(a.radians_ + b.radians_); }
  friend constexpr Angle operator-(Angle a, Angle b) { return Angle(a.radians_ - b.radians_); }
  friend constexpr Angle operator-(Angle a) { return Angle(-a.radians_); }
  friend constexpr Angle operator*(Angle a, double s) { return Angle(a.radians_ * s); }
  friend constexpr Angle operator*(double s, Angle a) { return a * s; }
  friend constexpr Angle operator/(Angle a, double s) { return Angle(a.radians_ / s); }
  friend constexpr double operator/(Angle a, Angle b) { return a.radians_ / b.radians_; }
  friend constexpr auto operator<=>(Angle a, Angle b) = default;

 private:
  explicit constexpr Angle(double radians) : radians_(radians) {}
  double radians_ = 0.0;
};

[[nodiscard]] constexpr Angle radians(double value) {
  return Angle::from_radians(value);
}
[[nodiscard]] constexpr Angle degrees(double value) {
  return Angle::from_radians(value * (std::numbers::pi / 180.0));
}
[[nodiscard]] constexpr Angle arcmin(double value) {
  return degrees(value / 60.0);
}

[[nodiscard]] inline double sin(Angle a) {
  return std::sin(a.radians());
}
[[nodiscard]] inline double cos(Angle a) {
  return std::cos(a.radians());
}
[[nodiscard]] inline double tan(Angle a) {
  return std::tan(a.radians());
}

namespace literals {
constexpr Angle operator""_deg(long double value) {
  return degrees(static_cast<double>(value));
}
constexpr Angle operator""_deg(unsigned long long value) {
  return degrees(static_cast<double>(value));
}
constexpr Angle operator""_rad(long double value) {
  return radians(static_cast<double>(value));
}
constexpr Angle operator""_arcmin(long double value) {
  return arcmin(static_cast<double>(value));
}
constexpr Angle operator""_arcmin(unsigned long long value) {
  return arcmin(static_cast<double>(value));
}
}  // namespace literals

}  // namespace holdfast

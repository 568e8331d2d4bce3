/// How far predictions were off of late, and the covariance to expect of the next.
///
/// The second moment of the errors of about one second, evened out among the axes by a part, since so few do not tell a
/// direction; times a factor that is moved by every error until 95 % of them lie inside the ellipsoid that should hold
/// 95 %: up by a step when one is outside, down by 5/95 of it when inside. That holds whatever the errors' distribution
/// (adaptive conformal inference, Gibbs & Candes 2021). Each error is judged by the covariance of when it was
/// predicted. Orientation and place have their own moments, and one factor: the ellipsoid of both holds 95 %.
/// Bad input: precondition finite errors.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

class ErrorSpread {
 public:
  /// Deviations of each number before anything is known: rad, m.
  ErrorSpread(double turn_deviation, double move_deviation)
      : turn_(turn_deviation * turn_deviation * Matrix3::Identity()),
        move_(move_deviation * move_deviation * Matrix3::Identity()) {}

  /// An orientation was off by `turn`, a place by `move`, where these covariances were expected. `fade`: what remains
  /// of the earlier errors.
  void add(const Vector3& turn, const Vector3& move, const Matrix3& turn_expected, const Matrix3& move_expected,
           double fade) {
    constexpr double limit = 12.592, step = 0.03;  // 95 % of chi-squared with 6 degrees of freedom
    const double turn_squared = squared(turn, turn_expected), move_squared = squared(move, move_expected);
    count(turn_, turn, turn_squared, fade);
    count(move_, move, move_squared, fade);
    factor_ *= turn_squared + move_squared > limit ? std::exp(step) : std::exp(-step * 5.0 / 95.0);
    factor_ = std::clamp(factor_, 0.05, 20.0);
  }

  [[nodiscard]] Matrix3 turn_covariance() const { return covariance(turn_); }
  [[nodiscard]] Matrix3 move_covariance() const { return covariance(move_); }

 private:
  static constexpr double largest = 50.0;  ///< squared standard deviations that a single error can count for

  [[nodiscard]] static double squared(const Vector3& error, const Matrix3& expected) {
    const Vector3 weighted = expected.inverse() * error;
    return error.dot(weighted);
  }
  static void count(Matrix3& moment, const Vector3& error, double squared, double fade) {
    moment = fade * moment + (1.0 - fade) * std::min(1.0, largest / squared) * error * error.transpose();
  }
  [[nodiscard]] Matrix3 covariance(const Matrix3& moment) const {
    constexpr double even = 0.3;
    Matrix3 covariance = (1.0 - even) * factor_ * moment;
    covariance.diagonal().array() += even * factor_ * moment.trace() / 3.0 + 1e-16;
    return covariance;
  }

  Matrix3 turn_, move_;  ///< second moments
  double factor_ = 1.25;
};

}  // namespace holdfast

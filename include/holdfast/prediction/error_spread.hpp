/// How far predictions were off of late, and the covariance to expect of the next.
///
/// Errors are seen against measured poses, so the poses' noise is in them. The second moment of about one second's
/// errors, less almost all of that noise (a filter that errs takes some of its own for the poses'), but no less than what
/// the filter says of its own state: evened out among the axes by a part,
/// since so few do not tell a direction; times a factor that is moved by every error until 95 % of them lie inside the
/// ellipsoid, noise added, that should hold 95 %: up by a step when one is outside, down by 5/95 of it when inside.
/// That holds whatever the errors' distribution (adaptive conformal inference, Gibbs & Candes 2021). Where noise is
/// most of what is seen, the factor has little to learn from: the steps are that much smaller, and it returns to 1.
/// Each error is judged by the covariance of when it was predicted. Orientation and place have their own moments, and
/// one factor: the ellipsoid of both holds 95 %.
/// Units: rad, m, their squares.
/// Bad input: precondition finite errors.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <holdfast/geometry/types.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

namespace holdfast {

class ErrorSpread {
 public:
  /// Deviations of each number before anything is known: rad, m.
  ErrorSpread(double turn_deviation, double move_deviation)
      : turn_(turn_deviation * turn_deviation * Matrix3::Identity()),
        move_(move_deviation * move_deviation * Matrix3::Identity()) {}

  /// An orientation was off by `turn` against one measured with this noise, a place by `move`, where these covariances
  /// were expected. `fade`: what remains of the earlier errors.
  void add(const Vector3& turn, const Vector3& move, const Matrix3& turn_expected, const Matrix3& move_expected,
           const PoseNoise& noise, double fade) {
    constexpr double limit = 12.592, step = 0.03, forgotten = 0.005;  // 95 % of chi-squared with 6 degrees of freedom
    const double turn_noise = noise.orientation_rad * noise.orientation_rad;
    const double move_noise = noise.position_m * noise.position_m;
    const double turn_squared = squared(turn, turn_expected, turn_noise);
    const double move_squared = squared(move, move_expected, move_noise);
    count(turn_, turn, turn_squared, fade);
    count(move_, move, move_squared, fade);
    const double seen = 0.5 * (share(turn_expected, turn_noise) + share(move_expected, move_noise));
    const double by = turn_squared + move_squared > limit ? step : -step * 5.0 / 95.0;
    factor_ *= std::exp(seen * by) * std::pow(factor_, (seen - 1.0) * forgotten);
    factor_ = std::clamp(factor_, 0.05, 20.0);
  }

  /// Without the noise, a variance; its size no less than `least`, as far as that was seen.
  [[nodiscard]] Matrix3 turn_covariance(double noise, double least) const { return covariance(turn_, noise, least); }
  [[nodiscard]] Matrix3 move_covariance(double noise, double least) const { return covariance(move_, noise, least); }

 private:
  static constexpr double largest = 50.0;  ///< squared standard deviations that a single error can count for

  [[nodiscard]] static double squared(const Vector3& error, const Matrix3& expected, double noise) {
    Matrix3 with_noise = expected;
    with_noise.diagonal().array() += noise;
    const Vector3 weighted = with_noise.inverse() * error;
    return error.dot(weighted);
  }
  [[nodiscard]] static double share(const Matrix3& expected, double noise) {
    return expected.trace() / (expected.trace() + 3.0 * noise);
  }
  static void count(Matrix3& moment, const Vector3& error, double squared, double fade) {
    moment = fade * moment + (1.0 - fade) * std::min(1.0, largest / squared) * error * error.transpose();
  }
  [[nodiscard]] Matrix3 covariance(const Matrix3& moment, double noise, double least) const {
    constexpr double even = 0.3, believed = 0.985;
    const double size = moment.trace() / 3.0 + 1e-16;  // errors that are exactly zero leave nothing to divide by
    const double wanted = factor_ * std::min(size, std::max(size - believed * noise, least));
    Matrix3 covariance = (1.0 - even) * wanted / size * moment;
    covariance.diagonal().array() += even * wanted + 1e-16;
    return covariance;
  }

  Matrix3 turn_, move_;  ///< second moments
  double factor_ = 1.25;
};

}  // namespace holdfast

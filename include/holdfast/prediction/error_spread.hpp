/// How far predictions were off of late, and the covariance to expect of the next.
///
/// The second moment of the errors of about one second, evened out among the axes by a part, since so few do not tell a
/// direction; times a factor that is moved by every error until 95 % of them lie inside the ellipsoid that should hold 95 %:
/// up by a step when one is outside, down by 5/95 of it when inside. That holds whatever the errors' distribution (adaptive
/// conformal inference, Gibbs & Candes 2021). Each error is judged by the covariance of when it was predicted.
/// Bad input: precondition finite errors.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

class ErrorSpread {
 public:
  /// `deviation`: of each number, before anything is known.
  explicit ErrorSpread(double deviation) : moment_(deviation * deviation * Matrix3::Identity()) {}

  /// `predicted`: the covariance that was expected. `fade`: what remains of the earlier errors.
  void add(const Vector3& error, const Matrix3& predicted, double fade) {
    constexpr double limit = 7.815, step = 0.03;  // 95 % of chi-squared with 3 degrees of freedom
    const Vector3 weighted = predicted.inverse() * error;
    const double squared = error.dot(weighted);
    const double counted = std::min(1.0, largest / squared);
    moment_ = fade * moment_ + (1.0 - fade) * counted * error * error.transpose();
    factor_ *= squared > limit ? std::exp(step) : std::exp(-step * 5.0 / 95.0);
    factor_ = std::clamp(factor_, 0.05, 20.0);
  }

  [[nodiscard]] Matrix3 covariance() const {
    constexpr double even = 0.3;
    Matrix3 covariance = (1.0 - even) * factor_ * moment_;
    covariance.diagonal().array() += even * factor_ * moment_.trace() / 3.0 + 1e-16;
    return covariance;
  }

 private:
  static constexpr double largest = 50.0;  ///< squared standard deviations that a single error can count for

  Matrix3 moment_;
  double factor_ = 1.25;
};

}  // namespace holdfast

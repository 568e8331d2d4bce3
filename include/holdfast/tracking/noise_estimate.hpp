/// How noisy a measurement of three numbers is, from what a filter left over of it (innovations).
///
/// What the state's covariance does not explain of a residual is noise; the last hundred count. The filter itself takes it for no
/// less than a smallest deviation: its model is never as good as the best measurements.
/// Source: innovation-based adaptive estimation (Mehra 1970). Units: those of the measurement.
/// Bad input: precondition finite numbers, deviations > 0.
#pragma once

#include <algorithm>
#include <cmath>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

class NoiseEstimate {
 public:
  NoiseEstimate() = default;
  NoiseEstimate(double deviation, double smallest) : smallest_(smallest * smallest), variance_(deviation * deviation) {}

  /// `explained`: the variance of each number that the state's covariance says. One that is far off counts as 5 deviations.
  void add(const Vector3& residual, double explained) {
    const double square = std::min(residual.squaredNorm() / 3.0, 25.0 * (explained + assumed_variance()));
    variance_ += 0.01 * (square - explained - variance_);
    variance_ = std::max(variance_, 0.01 * smallest_);
  }

  [[nodiscard]] double found() const { return std::sqrt(variance_); }
  [[nodiscard]] double assumed_variance() const { return std::max(variance_, smallest_); }
  [[nodiscard]] double assumed() const { return std::sqrt(assumed_variance()); }

 private:
  double smallest_ = 0.0, variance_ = 0.0;
};

}  // namespace holdfast

/// What a filter's innovations, three numbers each, tell of its noises.
///
/// NoiseEstimate: how noisy the measurement is.
/// What the state's covariance does not explain of a residual is noise; the last hundred count. The filter itself takes
/// it for no less than a smallest deviation: its model is never as good as the best measurements.
/// InnovationBalance: whether the state's own noise is more or less than believed. Innovations of a filter that trusts
/// its model too much go on the same way from one to the next; of one that trusts it too little, back again; else they
/// are white.
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

  /// `explained`: the variance of each number that the state's covariance says. One that is far off counts as 5
  /// deviations.
  void add(const Vector3& residual, double explained) {
    const double square = std::min(residual.squaredNorm() / 3.0, 25.0 * (explained + assumed_variance()));
    // What is believed to begin with is a guess, and worth two; but while the state settles, residuals are not all noise,
    // and say little of it.
    const double told = assumed_variance() / (explained + assumed_variance());
    weight_ /= 1.0 + told * told * weight_;
    const double more = square - explained - variance_;
    variance_ += (more < 0.0 ? std::max(0.01, told * told * weight_) : 0.01) * more;
    variance_ = std::max(variance_, 0.01 * smallest_);
  }

  [[nodiscard]] double found() const { return std::sqrt(variance_); }
  [[nodiscard]] double assumed_variance() const { return std::max(variance_, smallest_); }
  [[nodiscard]] double assumed() const { return std::sqrt(assumed_variance()); }

 private:
  double smallest_ = 0.0, variance_ = 0.0;
  double weight_ = 0.5;  ///< of the newest
};

class InnovationBalance {
 public:
  /// `most`: the largest scale.
  explicit InnovationBalance(double most = 4.0) : most_(most) {}

  void add(const Vector3& residual, double variance) {
    const Vector3 now = residual / std::sqrt(variance);
    const double alike = std::clamp(now.dot(before_) / 3.0, -1.0, 3.0);
    scale_ = std::clamp(scale_ * std::exp(0.04 * alike), 0.3, most_);
    before_ = now;
  }
  /// The next innovation does not follow the last one.
  void restart() { before_.setZero(); }

  /// By which the deviation of the state's noise is to be multiplied.
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double most() const { return most_; }

 private:
  double scale_ = 1.0, most_;
  Vector3 before_ = Vector3::Zero();
};

}  // namespace holdfast

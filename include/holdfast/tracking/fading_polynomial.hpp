/// A vector signal's value, rate of change and second derivative, by the parabola that fits its past best, the past
/// fading.
///
/// The fading-memory polynomial filter of degree two (Morrison 1969, Introduction to Sequential Smoothing and
/// Prediction, section 13; g-h-k filter): least squares with weights exp(-age / memory), in a recursion of three gains.
/// Critically damped: one number sets it. Samples may come unevenly. Units: those of the signal, per s, per s^2.
/// Bad input: preconditions memory > 0, finite numbers, and times that increase.
#pragma once

#include <cmath>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

class FadingPolynomial {
 public:
  explicit FadingPolynomial(double memory_s) : memory_s_(memory_s) {}

  /// The signal was `z`, `dt` seconds after the sample before; the first one starts it.
  void update(double dt, const Vector3& z) {
    if (!started_) {
      *this = FadingPolynomial(memory_s_);
      value_ = z;
      started_ = true;
      return;
    }
    const double fade = std::exp(-dt / memory_s_), kept = 1.0 - fade;
    value_ += dt * rate_ + 0.5 * dt * dt * second_;
    rate_ += dt * second_;
    const Vector3 e = z - value_;
    value_ += (1.0 - fade * fade * fade) * e;
    rate_ += 1.5 * kept * kept * (1.0 + fade) / dt * e;
    second_ += kept * kept * kept / (dt * dt) * e;
  }
  void restart() { started_ = false; }

  [[nodiscard]] const Vector3& value() const { return value_; }
  [[nodiscard]] const Vector3& rate() const { return rate_; }
  [[nodiscard]] const Vector3& second() const { return second_; }

 private:
  double memory_s_;
  bool started_ = false;
  Vector3 value_ = Vector3::Zero(), rate_ = Vector3::Zero(), second_ = Vector3::Zero();
};

}  // namespace holdfast

/// Azuma & Bishop's position estimator as published (001 section 5.2.2): a linear Kalman filter for one of x, y, z.
///
///   X = (y, y', y''),   X' = A X,  P' = A P + P A^T + E
///   Z = (y_m, y''_m):  the tracker's position and the accelerometers' world acceleration (linear_acceleration.hpp)
/// What 001 integrates by Runge and Kutta's method has a closed form, which is taken here (chain_step.hpp): each diagonal
/// number of E drives the chain below it. R is diagonal, so the two numbers are taken one after the other. Without inertial
/// sensors only the first is there.
/// 001's noise has no believable unit (a tracker of 0.1 m): only ratios matter to the gain. They say that acceleration is
/// taken as measured, and that the position corrects the double integral of it slowly.
/// Units: m, m/s, m/s^2. Nothing here allocates, locks or throws. Preconditions: seconds >= 0, numbers finite.
#pragma once

#include <cmath>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/chain_step.hpp>

namespace holdfast {

/// 001's values.
struct AzumaBishopPositionNoise {
  Vector3 drift = Vector3(0.007, 0.007, 2e6);    ///< E's diagonal, per second
  double position = 0.01;                        ///< R
  double acceleration = 0.05;                    ///< R
  Vector3 initial = Vector3(2.0, 500.0, 500.0);  ///< P's diagonal at the start
};

class AzumaBishopPosition {
 public:
  explicit AzumaBishopPosition(double start = 0.0, const AzumaBishopPositionNoise& noise = {}) : noise_(noise) {
    HOLDFAST_ASSERT(noise.position > 0.0 && noise.acceleration > 0.0, "a measurement without noise");
    X_ = Vector3(start, 0.0, 0.0);
    P_ = noise.initial.asDiagonal();
  }

  /// Time update.
  void advance(double seconds) {
    const ChainStep<3> whole = chain_step<3>(noise_.drift[2], 0.0, seconds);
    const ChainStep<2> lower = chain_step<2>(noise_.drift[1], 0.0, seconds);
    X_ = (whole.A * X_).eval();
    P_ = (whole.A * P_ * whole.A.transpose() + whole.Q).eval();
    P_.topLeftCorner<2, 2>() += lower.Q;
    P_(0, 0) += noise_.drift[0] * seconds;
  }

  /// Measurement update.
  void correct(double position, const std::optional<double>& acceleration = std::nullopt) {
    const Vector3 variance = P_.diagonal();
    take(0, position, noise_.position);
    if (acceleration) take(2, *acceleration, noise_.acceleration);
    P_.diagonal() += rounding_floor * variance;
  }

  /// Position, velocity, acceleration.
  [[nodiscard]] const Vector3& X() const { return X_; }
  [[nodiscard]] const Matrix3& P() const { return P_; }

 private:
  void take(int row, double measured, double variance) {
    const Vector3 c = P_.col(row);
    const double s = c[row] + variance;
    X_ += c * ((measured - X_[row]) / s);
    P_ -= c * c.transpose() / s;
  }

  AzumaBishopPositionNoise noise_;
  Vector3 X_;
  Matrix3 P_;
};

}  // namespace holdfast

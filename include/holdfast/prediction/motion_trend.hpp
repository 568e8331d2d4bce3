/// What the newest inertial readings tell of the next tenth of a second: a few candidate movements, to be weighed.
///
/// Orientation: the angular velocity as just read, and its rate of change at growing ages, between the newest reading
/// and means over (0, 5], (5, 10], (10, 20] and (20, 40] ms. Each is carried over the horizon: w h, then alpha h^2 / 2.
/// Place: velocity, acceleration as just read, acceleration and its rate of change smoothed over 20 ms, and over 50 ms
/// (fading_polynomial.hpp): v h, a h^2 / 2, j h^3 / 6. Which of these help depends on the horizon, on the noise and on
/// how the body moves: weights for them are found on line (inertial_predictor.hpp).
/// Readings end `gap` seconds before the pose that is carried on: so much longer they are carried.
/// Frames: turns in B, movements in W. Bad input: precondition finite numbers.
#pragma once

#include <algorithm>
#include <array>

#include <holdfast/prediction/fading_least_squares.hpp>
#include <holdfast/tracking/fading_polynomial.hpp>
#include <holdfast/tracking/inertial_filter.hpp>

namespace holdfast {

/// World acceleration, smoothed over a shorter and a longer time.
struct AccelerationTrend {
  FadingPolynomial fast{0.02}, slow{0.05};

  void update(double dt, const Vector3& a_W) {
    fast.update(dt, a_W);
    slow.update(dt, a_W);
  }
  void restart() {
    fast.restart();
    slow.restart();
  }
};

struct MotionTrend {
  static constexpr int turns = 5, moves = 5;
  using TurnWeights = VectorOf<double, turns>;
  using MoveWeights = VectorOf<double, moves>;

  HostTime t;  ///< of the pose
  Rigid X_WS;  ///< sensors' place, body's axes
  Vector3 lever_B = Vector3::Zero();
  double gap = 0.0;
  MatrixOf<double, 3, turns> turn_rates = MatrixOf<double, 3, turns>::Zero();  ///< w; alpha of growing age
  MatrixOf<double, 3, moves> move_rates = MatrixOf<double, 3, moves>::Zero();  ///< v; a; a, j smoothed; a smoothed more

  /// Movements over the horizon, for each weight one.
  [[nodiscard]] MatrixOf<double, 3, turns> turn_over(double h) const {
    return turn_rates * turn_powers(h).asDiagonal();
  }
  [[nodiscard]] MatrixOf<double, 3, moves> move_over(double h) const {
    return move_rates * move_powers(h).asDiagonal();
  }
  [[nodiscard]] TurnWeights turn_powers(double h) const {
    TurnWeights powers = TurnWeights::Constant(h * (0.5 * h + gap));
    powers[0] = h;
    return powers;
  }
  [[nodiscard]] MoveWeights move_powers(double h) const {
    const double square = 0.5 * h * h;
    return MoveWeights(h, square, square, square * (h / 3.0 + gap), square);
  }
  /// B at horizon h, if it turns and its sensors move so.
  [[nodiscard]] Rigid carried(const Vector3& turn_B, const Vector3& move_W) const {
    const Quaternion q = X_WS.q() * so3::exp<double>(turn_B);
    return Rigid(q, X_WS.p() + move_W - q * lever_B);
  }
};

/// Weights before any were learnt: velocities count in full, and half of the newest angular acceleration.
[[nodiscard]] inline MotionTrend::TurnWeights usual_turn_weights() {
  return MotionTrend::TurnWeights(1.0, 0.5, 0.0, 0.0, 0.0);
}
[[nodiscard]] inline MotionTrend::MoveWeights usual_move_weights() {
  return MotionTrend::MoveWeights(1.0, 0.0, 1.0, 0.0, 0.0);
}

/// Of the filter's newest state. `acceleration_W`: smoothed accelerations up to the newest reading.
[[nodiscard]] inline MotionTrend motion_trend(const InertialFilter& filter, const AccelerationTrend& acceleration_W) {
  constexpr std::array ages{0.0, 0.005, 0.010, 0.020, 0.040};
  const InertialState& now = filter.now();
  const InertialHistory& history = filter.history();
  MotionTrend trend;
  trend.t = now.t;
  trend.X_WS = now.X_WS;
  trend.lever_B = now.lever_B;
  trend.move_rates << now.v_WS, filter.acceleration_now_W(), acceleration_W.fast.value(), acceleration_W.fast.rate(),
      acceleration_W.slow.value();
  if (history.empty()) return trend;
  const HostTime newest = history.newest().t;
  trend.gap = std::clamp(to_seconds(now.t - (newest - filter.time_offset())), 0.0, 0.02);
  Vector3 later = history.newest().rate_B;
  trend.turn_rates.col(0) = later - now.bias.rate_B;
  double later_age = 0.0;
  std::size_t k = history.size() - 1;
  for (std::size_t i = 1; i < ages.size() && k > 0; ++i) {
    Vector3 sum = Vector3::Zero();
    double sum_of_ages = 0.0, count = 0.0;
    for (; k > 0; --k, ++count) {
      const double age = to_seconds(newest - history[k - 1].t);
      if (count > 0.0 && age > ages[i] + 1e-6) break;
      sum += history[k - 1].rate_B;
      sum_of_ages += age;
    }
    const Vector3 mean = sum / count;
    const double age = sum_of_ages / count;
    trend.turn_rates.col(static_cast<int>(i)) = (later - mean) / std::max(1e-3, age - later_age);
    later = mean;
    later_age = age;
  }
  return trend;
}

}  // namespace holdfast

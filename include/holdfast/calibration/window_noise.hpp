/// How noisy the poses and the sensor are, from what a fit leaves over.
///
/// A residual holds sum_j c_j n_j of the poses' noise n (c the window's weights), and of the sensor's noise the integral of the same
/// weights, summed once (rates) or twice (accelerations). Neighbouring windows overlap, and do so differently for the two noises:
/// pose variance and sensor density are those that explain the residuals' autocovariance best, by least squares, neither below
/// zero. Residuals with a weight below one are left out.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <holdfast/calibration/fit_model.hpp>

namespace holdfast {

struct WindowNoise {
  double pose_variance = 0.0;   ///< of each number of a pose
  double sensor_density = 0.0;  ///< of each of the sensor's numbers, squared unit / Hz
};

namespace detail {

/// A window's weights for the sensor's noise, times sqrt(dt): sums of those for poses.
[[nodiscard]] inline std::vector<double> sensor_weights(const PoseWindow& window, std::span<const double> times,
                                                        int sums) {
  std::vector<double> acts;
  double once = 0.0, twice = 0.0;
  for (std::size_t k = 0; k + 1 < window.weights.size(); ++k) {
    const double dt = times[window.first + k + 1] - times[window.first + k];
    once += window.weights[k];
    twice += dt * once;
    acts.push_back(std::sqrt(dt) * (sums == 1 ? once : twice));
  }
  return acts;
}

[[nodiscard]] inline double overlap(std::size_t first_a, const std::vector<double>& a, std::size_t first_b,
                                    const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = first_b; k < std::min(first_a + a.size(), first_b + b.size()); ++k) {
    sum += a[k - first_a] * b[k - first_b];
  }
  return sum;
}

}  // namespace detail

[[nodiscard]] inline WindowNoise estimate_window_noise(const FitModel& model, std::span<const double> times,
                                                       std::span<const Vector3> residuals,
                                                       std::span<const double> residual_weights) {
  const std::vector<PoseWindow>& windows = model.windows();
  std::vector<std::vector<double>> sensor;
  for (const PoseWindow& window : windows) {
    sensor.push_back(detail::sensor_weights(window, times, model.sensor_sums()));
  }
  constexpr std::size_t most_lags = 40;
  Matrix2 normal = Matrix2::Zero();
  Vector2 right = Vector2::Zero();
  for (std::size_t lag = 0; lag < most_lags; ++lag) {
    double covariance = 0.0, pairs = 0.0;
    Vector2 explained = Vector2::Zero();
    for (std::size_t i = 0; i + lag < windows.size(); ++i) {
      const PoseWindow &a = windows[i], &b = windows[i + lag];
      if (residual_weights[i] < 1.0 || residual_weights[i + lag] < 1.0 || b.first > a.last()) continue;
      covariance += residuals[i].dot(residuals[i + lag]) / model.used_axes();
      explained[0] += detail::overlap(a.first, a.weights, b.first, b.weights);
      explained[1] += detail::overlap(a.first, sensor[i], b.first, sensor[i + lag]);
      pairs += 1.0;
    }
    if (pairs < 1.0) break;
    const Vector2 row = explained / pairs;
    normal += row * row.transpose();
    right += covariance / pairs * row;
  }
  const double determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(1, 0);
  const double pose = (normal(1, 1) * right[0] - normal(0, 1) * right[1]) / determinant;
  const double density = (normal(0, 0) * right[1] - normal(0, 1) * right[0]) / determinant;
  if (determinant > 0.0 && pose >= 0.0 && density >= 0.0) return {pose, density};
  if (!(density >= 0.0)) return {std::max(0.0, right[0] / normal(0, 0)), 0.0};
  return {0.0, std::max(0.0, right[1] / normal(1, 1))};
}

}  // namespace holdfast

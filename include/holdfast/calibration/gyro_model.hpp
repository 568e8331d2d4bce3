/// What both ways of calibrating gyros share: ten numbers, what is thought possible of them, and a start that needs no guess.
///
/// x = (rotation vector from the nominal q_BS, bias, scale, time offset). The start: the shift in time and the rotation by which
/// the gyros' turning, averaged over the same windows as the poses', covaries best with theirs. Means are taken off both, so that
/// biases do not matter; the rotation is that of the singular value decomposition (Wahba's problem).
/// A motion that repeats itself fits at several shifts: the smallest of those within 1 % is taken.
#pragma once

#include <optional>
#include <string>

#include <holdfast/calibration/inertial_parameters.hpp>
#include <holdfast/calibration/parameter_fit.hpp>
#include <holdfast/geometry/align.hpp>

namespace holdfast {

/// How far from nominal each may be thought to lie (a standard deviation).
struct GyroPrior {
  GyroParameters nominal;
  double orientation_rad = 1.0, bias = 0.1, scale = 0.1, time_offset_s = 0.1;
};

namespace detail {

[[nodiscard]] inline std::vector<FitParameter> gyro_fit_parameters(const GyroPrior& prior) {
  std::vector<FitParameter> parameters;
  for (const char* axis : {"x", "y", "z"}) {
    parameters.push_back({std::string("gyro orientation ") + axis, "rad", 0.0, prior.orientation_rad});
  }
  for (int i = 0; i < 3; ++i) {
    parameters.push_back({std::string("gyro bias ") + "xyz"[i], "rad/s", prior.nominal.bias[i], prior.bias});
  }
  for (int i = 0; i < 3; ++i) {
    parameters.push_back({std::string("gyro scale ") + "xyz"[i], "1", prior.nominal.scale[i], prior.scale});
  }
  parameters.push_back({"time offset", "s", prior.nominal.time_offset_s, prior.time_offset_s});
  return parameters;
}

[[nodiscard]] inline Eigen::VectorXd to_vector(const GyroParameters& gyro, const Quaternion& nominal) {
  Eigen::VectorXd x(10);
  x << so3::log<double>(nominal.conjugate() * gyro.q_BS), gyro.bias, gyro.scale, gyro.time_offset_s;
  return x;
}

[[nodiscard]] inline GyroParameters gyro_of(const Eigen::VectorXd& x, const Quaternion& nominal) {
  GyroParameters gyro;
  gyro.q_BS = (nominal * so3::exp<double>(x.head<3>())).normalized();
  gyro.bias = x.segment<3>(3);
  gyro.scale = x.segment<3>(6);
  gyro.time_offset_s = x[9];
  return gyro;
}

}  // namespace detail

/// Turning of the body, as the poses have it, averaged over a window of them: sum of c_j turned_j.
struct TurnRate {
  PoseWindow window;
  Vector3 rate_B = Vector3::Zero();
};

/// The gyros' signal at each pose, `offset` later: its integral and itself.
struct SignalAtPoses {
  std::vector<Vector3> integral, value;

  SignalAtPoses() = default;
  SignalAtPoses(const SensorSignal& signal, const PoseArrays& poses, double offset) {
    for (const double t : poses.t) {
      integral.push_back(signal.integral(t + offset));
      value.push_back(signal.at(t + offset));
    }
  }
};

/// The same average of the gyros' signal (its integral), or of its slope (itself).
[[nodiscard]] inline Vector3 averaged(const std::vector<Vector3>& at_poses, const PoseWindow& window) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < window.weights.size(); ++k) sum += window.weights[k] * at_poses[window.first + k];
  return sum;
}

/// Windows of about `width` round every pose, no nearer than an eighth of it: the slope of the straight line through the turns
/// in each. Left out where poses or readings (within `margin` of the offset) are missing.
[[nodiscard]] inline std::vector<TurnRate> turn_rates(const PoseArrays& poses, const SensorSignal& gyro, double width,
                                                      double offset, double margin) {
  std::vector<TurnRate> rates;
  std::size_t a = 0, b = 0;
  for (const std::size_t i : poses.spaced(0.125 * width)) {
    if (i == 0 || i + 1 == poses.size()) continue;
    while (a + 1 < i && poses.t[i] - poses.t[a + 1] >= 0.499 * width) ++a;
    b = std::max(b, i + 1);
    while (b + 1 < poses.size() && poses.t[b] - poses.t[i] < 0.499 * width) ++b;
    const double from = poses.t[a], to = poses.t[b];
    if (to - from > 2.0 * width || to - poses.t[i] > 1.5 * (poses.t[i] - from) ||
        poses.t[i] - from > 1.5 * (to - poses.t[i])) {
      continue;
    }
    if (!gyro.covers(from + offset - margin, to + offset + margin)) continue;
    TurnRate rate;
    rate.window.first = a;
    double mean = 0.0, spread = 0.0;
    for (std::size_t k = a; k <= b; ++k) mean += poses.t[k] / static_cast<double>(b - a + 1);
    for (std::size_t k = a; k <= b; ++k) spread += (poses.t[k] - mean) * (poses.t[k] - mean);
    for (std::size_t k = a; k <= b; ++k) {
      rate.window.weights.push_back((poses.t[k] - mean) / spread);
      rate.rate_B += rate.window.weights.back() * (poses.turned_B[k] - poses.turned_B[i]);
    }
    rates.push_back(std::move(rate));
  }
  return rates;
}

/// Slower turning than this about an axis, RMS about the mean, tells nothing of it, rad/s.
inline constexpr double least_turning = 0.02;

struct GyroStart {
  GyroParameters gyro;
  Matrix3 turning_axes_S = Matrix3::Zero();  ///< projects on the directions about which there surely is turning
  double agreement = 0.0;                    ///< 1: the gyros' turning is the poses', but for a rotation
  double turning = 0.0;                      ///< by the gyros, RMS about the mean, rad/s
  double by_poses = 0.0;                     ///< the same by the poses
};

namespace detail {

/// Rotation and agreement at one time offset.
[[nodiscard]] inline std::optional<GyroStart> start_at(const std::vector<TurnRate>& rates, const PoseArrays& poses,
                                                       const SensorSignal& signal, const GyroPrior& prior,
                                                       double offset) {
  const double n = static_cast<double>(rates.size());
  Vector3 mean_B = Vector3::Zero(), mean_S = Vector3::Zero();
  std::vector<Vector3> said;
  const SignalAtPoses at_poses(signal, poses, offset);
  for (const TurnRate& rate : rates) {
    said.push_back(averaged(at_poses.integral, rate.window));
    mean_B += rate.rate_B / n;
    mean_S += said.back() / n;
  }
  Matrix3 covariance = Matrix3::Zero();
  double squares_B = 0.0, squares_S = 0.0;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const Vector3 b = rates[i].rate_B - mean_B, s = said[i] - mean_S;
    covariance += b * s.transpose() / n;
    squares_B += b.squaredNorm() / n;
    squares_S += s.squaredNorm() / n;
  }
  GyroStart start;
  start.gyro = prior.nominal;
  start.gyro.time_offset_s = offset;
  start.gyro.bias = mean_S - start.gyro.q_BS.conjugate() * mean_B;
  start.turning = std::sqrt(squares_S);
  start.by_poses = std::sqrt(squares_B);
  // A little of the nominal orientation, for what the motion leaves open.
  const Matrix3 with_nominal = covariance + 1e-3 * covariance.norm() * prior.nominal.q_BS.toRotationMatrix();
  const auto nearest = align_detail::nearest_rotation(with_nominal);
  if (!nearest || !(squares_B > 0.0 && squares_S > 0.0)) return start;
  start.gyro.q_BS = Quaternion(nearest->R);
  start.gyro.bias = mean_S - nearest->R.transpose() * mean_B;
  const Matrix3 in_S = nearest->R.transpose() * covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> about(Eigen::Matrix3d(0.5 * (in_S + in_S.transpose())));
  for (int i = 0; i < 3; ++i) {
    const Vector3 axis = about.eigenvectors().col(i);
    if (about.eigenvalues()[i] > least_turning * least_turning) start.turning_axes_S += axis * axis.transpose();
  }
  start.agreement = in_S.trace() / std::sqrt(squares_B * squares_S);
  return start;
}

}  // namespace detail

/// Looks for the time offset within +- `longest` of the nominal one. Nothing when there is no rate.
[[nodiscard]] inline std::optional<GyroStart> start_of_gyro(const PoseArrays& poses, const SensorSignal& signal,
                                                            const GyroPrior& prior, double width, double longest) {
  const double nominal = prior.nominal.time_offset_s, step = std::min(0.01, 0.2 * width);
  std::vector<TurnRate> rates = turn_rates(poses, signal, width, nominal, longest);
  if (rates.empty()) return std::nullopt;
  constexpr std::size_t enough = 4000;
  if (rates.size() > enough) {
    const std::size_t every = rates.size() / enough + 1;
    for (std::size_t i = 0; i * every < rates.size(); ++i) rates[i] = rates[i * every];
    rates.resize((rates.size() + every - 1) / every);
  }
  std::optional<GyroStart> best;
  const int steps = static_cast<int>(std::ceil(longest / step));
  for (int k = 0; k <= 2 * steps; ++k) {  // 0, 1, -1, 2, -2, ...: the nearest first
    const double shift = step * (k % 2 == 1 ? (k + 1) / 2 : -k / 2);
    const auto tried = detail::start_at(rates, poses, signal, prior, nominal + shift);
    const bool is_far = best && std::abs(nominal + shift - best->gyro.time_offset_s) > 4.0 * step;
    if (!best || tried->agreement > best->agreement + (is_far ? 0.01 * std::abs(best->agreement) : 0.0)) best = tried;
  }
  return best;
}

}  // namespace holdfast

/// What is thought of accelerometers beforehand, and a start for their calibration that needs no guess of how they are mounted.
#pragma once

#include <limits>
#include <numbers>

#include <holdfast/calibration/inertial_parameters.hpp>
#include <holdfast/calibration/inertial_signal.hpp>
#include <holdfast/geometry/align.hpp>

namespace holdfast {

struct AccelerometerPrior {
  AccelerometerParameters nominal;
  double orientation_rad = 1.0, bias = 0.5, scale = 0.1, place_m = 0.2, gravity = 0.03, gravity_tilt_rad = 1.0;
  bool separate = false;  ///< three accelerometers, each with a place of its own
};

/// Where to start: Wahba's rotation in turn with gravity, as all the readings have it in W, from the nominal orientation. If gravity
/// then wanders by more than biases and scales may explain, of the 24 ways to turn it by right angles the one under which it holds
/// stillest.
[[nodiscard]] inline AccelerometerParameters start_of_accelerometer(const PoseArrays& poses,
                                                                    const SensorSignal& accelerometer, double offset,
                                                                    const AccelerometerPrior& prior) {
  std::vector<Vector3> said;
  std::vector<Quaternion> q_WB;
  const std::size_t every = std::max<std::size_t>(1, poses.size() / 2000);
  for (std::size_t i = 0; i < poses.size(); i += every) {
    const double t = poses.t[i] + offset;
    if (!accelerometer.covers(t - 0.05, t + 0.05)) continue;
    said.push_back((accelerometer.integral(t + 0.05) - accelerometer.integral(t - 0.05)) / 0.1);
    q_WB.push_back(poses.q_WB[i]);
  }
  AccelerometerParameters best = prior.nominal;
  if (said.empty()) return best;
  const double n = static_cast<double>(said.size());
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 24; ++k) {
    const double quarter = 0.5 * std::numbers::pi;
    const Vector3 first =
        k / 4 < 4 ? Vector3(quarter * (k / 4), 0.0, 0.0) : Vector3(0.0, 0.0, k / 4 == 4 ? quarter : -quarter);
    Quaternion q_BA =
        prior.nominal.q_BA * so3::exp<double>(first) * so3::exp<double>(Vector3(0.0, quarter * (k % 4), 0.0));
    Vector3 up_W = Vector3::Zero();
    double spread = 0.0;
    for (int round = 0; round < 6; ++round) {
      up_W.setZero();
      for (std::size_t i = 0; i < said.size(); ++i) up_W += q_WB[i] * (q_BA * said[i]) / n;
      Matrix3 covariance = Matrix3::Zero();
      spread = 0.0;
      for (std::size_t i = 0; i < said.size(); ++i) {
        const Vector3 up_B = q_WB[i].conjugate() * up_W;
        spread += (q_BA * said[i] - up_B).squaredNorm() / n;
        covariance += up_B * said[i].transpose() / n;
      }
      covariance += 1e-3 * covariance.norm() * q_BA.toRotationMatrix();  // what is left open stays
      const auto nearest = align_detail::nearest_rotation(covariance);
      if (round == 5 || !nearest) break;
      q_BA = Quaternion(nearest->R);
    }
    if (spread < 0.7 * least) {
      least = spread;
      best.q_BA = q_BA;
      best.gravity_W = -standard_gravity * up_W.normalized();
    }
    const double by_scale = prior.scale * standard_gravity;
    if (k == 0 && spread < prior.bias * prior.bias + by_scale * by_scale) break;
  }
  return best;
}

}  // namespace holdfast

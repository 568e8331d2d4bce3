/// Calibrates gyros by integrating (001 appendix C, the second method): predicts each pose's orientation from one about 100 ms
/// before by the gyros' readings of the time between ("ideal noncausal predictor").
///
///   r = log(Q^-1 R_SB (R_WBa^T R_WBb) R_BS),   Q the integral of (z - b) / k from t_a + offset to t_b + offset, in S
/// All windows share one integral over the recording: Q = Q(t_a)^-1 Q(t_b). What Q changes by, when bias and scale change, is such an
/// integral too. J is exact to first order in the turn between two readings.
#pragma once

#include <holdfast/calibration/gyro_model.hpp>

namespace holdfast {

/// From each pose, but no nearer than a sixteenth of `length`, to the first of them that is `length` later. Left out where
/// readings are missing.
[[nodiscard]] inline std::vector<PoseWindow> prediction_windows(const PoseArrays& poses, const SensorSignal& signal,
                                                                double length, double offset, double margin) {
  std::vector<PoseWindow> windows;
  const std::vector<std::size_t> taken = poses.spaced(length / 16.0);
  std::size_t later = 0;
  for (const std::size_t a : taken) {
    while (later < taken.size() && poses.t[taken[later]] - poses.t[a] < 0.999 * length) ++later;
    if (later == taken.size()) break;
    const std::size_t b = taken[later];
    if (poses.t[b] - poses.t[a] > 2.0 * length) continue;
    if (!signal.covers(poses.t[a] + offset - margin, poses.t[b] + offset + margin)) continue;
    PoseWindow window{a, std::vector<double>(b - a + 1, 0.0)};
    window.weights.front() = -1.0;
    window.weights.back() = 1.0;
    windows.push_back(std::move(window));
  }
  return windows;
}

class IntegratingModel : public FitModel {
 public:
  /// None of the arguments may go before the model.
  IntegratingModel(const PoseArrays& poses, const SensorSignal& gyro, const GyroPrior& prior, double length,
                   const GyroStart& start)
      : poses_(&poses), signal_(&gyro), nominal_(prior.nominal.q_BS), sure_(start.turning_axes_S) {
    parameters_ = detail::gyro_fit_parameters(prior);
    windows_ = prediction_windows(poses, gyro, length, start.gyro.time_offset_s, offset_margin);
  }
  static constexpr double offset_margin = 0.03;  ///< how far the offset may move from where it started, s

  [[nodiscard]] const std::vector<FitParameter>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<PoseWindow>& windows() const override { return windows_; }

  void count_sure_motion_alone(bool yes) override { counted_ = yes ? sure_ : Matrix3(Matrix3::Identity()); }

  void prepare(const Eigen::VectorXd& x) override {
    gyro_ = detail::gyro_of(x, nominal_);
    turn_jacobian_ = so3::right_jacobian<double>(x.head<3>());
    sums_.resize(poses_->size());
    Sum sum;
    for (std::size_t i = 0; i < poses_->size(); ++i) {
      if (i > 0) integrate(poses_->t[i - 1] + gyro_.time_offset_s, poses_->t[i] + gyro_.time_offset_s, sum);
      const Vector3 said = signal_->at(poses_->t[i] + gyro_.time_offset_s);
      sum.rate = counted_ * (said - gyro_.bias).cwiseQuotient(gyro_.scale);
      sums_[i] = sum;
    }
  }

  void compare(std::size_t i, Vector3& r, Jacobian& J) const override {
    const std::size_t a = windows_[i].first, b = windows_[i].last();
    const Quaternion turned = sums_[a].q.conjugate() * sums_[b].q;
    const Quaternion by_poses = gyro_.q_BS.conjugate() * poses_->q_WB[a].conjugate() * poses_->q_WB[b] * gyro_.q_BS;
    r = so3::log<double>(turned.conjugate() * by_poses);
    const Matrix3 at_left = so3::left_jacobian_inverse<double>(r), at_right = so3::right_jacobian_inverse<double>(r);
    const Matrix3 to_end = sums_[b].q.conjugate().toRotationMatrix();
    const Vector3 turn = counted_ * so3::log<double>(turned);  // less noisy than the poses' turn
    const Matrix3 seen = Matrix3::Identity() - so3::exp<double>(Vector3(-turn)).toRotationMatrix();
    const Vector3 inverse = gyro_.scale.cwiseInverse();
    const Vector3 later = sums_[b].rate - turned.conjugate() * sums_[a].rate;
    J.leftCols<3>() = at_right * seen * turn_jacobian_;
    J.middleCols<3>(3) = at_left * to_end * (sums_[b].by_bias - sums_[a].by_bias) * inverse.asDiagonal();
    J.middleCols<3>(6) = at_left * to_end * (sums_[b].by_scale - sums_[a].by_scale) * inverse.asDiagonal();
    J.col(9) = -at_left * later;
  }

 private:
  struct Sum {
    Quaternion q = Quaternion::Identity();  ///< S now, seen from S at the begin
    Matrix3 by_bias = Matrix3::Zero();      ///< integral of R
    Matrix3 by_scale = Matrix3::Zero();     ///< integral of R diag(rate)
    Vector3 rate = Vector3::Zero();
  };

  void integrate(double from, double to, Sum& sum) const {
    Vector3 integral = signal_->integral(from);
    signal_->for_pieces(from, to, [&](double begin, double end) {
      const Vector3 next = signal_->integral(end);
      const double dt = end - begin;
      const Vector3 turn = (next - integral - dt * gyro_.bias).cwiseQuotient(gyro_.scale);
      const Matrix3 R = (sum.q * so3::exp<double>(0.5 * turn)).toRotationMatrix();
      sum.by_bias += dt * R;
      const Vector3 counted = counted_ * turn;
      sum.by_scale += R * counted.asDiagonal();
      sum.q = (sum.q * so3::exp<double>(turn)).normalized();
      integral = next;
    });
  }

  const PoseArrays* poses_;
  const SensorSignal* signal_;
  Quaternion nominal_;
  std::vector<FitParameter> parameters_;
  std::vector<PoseWindow> windows_;
  std::vector<Sum> sums_;
  GyroParameters gyro_;
  Matrix3 turn_jacobian_ = Matrix3::Identity(), sure_, counted_ = Matrix3::Identity();
};

}  // namespace holdfast

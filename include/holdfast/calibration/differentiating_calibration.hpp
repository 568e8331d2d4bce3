/// Calibrates gyros by differentiating (001 appendix C, the first method): the poses' turning against the gyros'.
///
///   r_i = R_SB w_i - (z_i - b) / k,   w_i the slope of the poses' turns within a window round a pose,
///                                     z_i the gyros' signal averaged with the same weights, time_offset later
/// 001 let a Kalman filter differentiate: its lag came out as a time shift of about 60 ms. A window that reaches as far forward as
/// back has no lag, and the same average of both leaves no difference in bandwidth, which would be taken for a scale. Row i needs
/// axis i alone: a gyro that is missing leaves the others calibrated.
/// Accelerometers are not calibrated so: two differentiations leave nothing but noise (001).
#pragma once

#include <holdfast/calibration/gyro_model.hpp>

namespace holdfast {

class DifferentiatingModel : public FitModel {
 public:
  /// `has_axis`: gyros that speak. None of the arguments may go before the model.
  DifferentiatingModel(const PoseArrays& poses, const SensorSignal& gyro, const GyroPrior& prior,
                       const std::array<bool, 3>& has_axis, double width, const GyroStart& start)
      : poses_(&poses), signal_(&gyro), has_axis_(has_axis), nominal_(prior.nominal.q_BS), sure_(start.turning_axes_S) {
    parameters_ = detail::gyro_fit_parameters(prior);
    for (TurnRate& rate : turn_rates(poses, gyro, width, start.gyro.time_offset_s, offset_margin)) {
      windows_.push_back(std::move(rate.window));
      rates_B_.push_back(rate.rate_B);
    }
  }
  static constexpr double offset_margin = 0.03;  ///< how far the offset may move from where it started, s

  [[nodiscard]] const std::vector<FitParameter>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<PoseWindow>& windows() const override { return windows_; }
  void count_sure_motion_alone(bool yes) override { counted_ = yes ? sure_ : Matrix3(Matrix3::Identity()); }
  [[nodiscard]] int used_axes() const override { return int(has_axis_[0]) + int(has_axis_[1]) + int(has_axis_[2]); }

  void prepare(const Eigen::VectorXd& x) override {
    gyro_ = detail::gyro_of(x, nominal_);
    turn_jacobian_ = so3::right_jacobian<double>(x.head<3>());
    at_poses_ = SignalAtPoses(*signal_, *poses_, gyro_.time_offset_s);
  }

  void compare(std::size_t i, Vector3& r, Jacobian& J) const override {
    const Vector3 said = averaged(at_poses_.integral, windows_[i]);
    const Vector3 slope = averaged(at_poses_.value, windows_[i]);
    const Vector3 rate_S = gyro_.q_BS.conjugate() * rates_B_[i];
    const Vector3 inverse = gyro_.scale.cwiseInverse();
    const Vector3 unbiased = (said - gyro_.bias).cwiseProduct(inverse);
    r = rate_S - unbiased;
    Vector3 about = unbiased;  // the gyros' rate, less noisy than the poses', where there are gyros
    for (int axis = 0; axis < 3; ++axis) {
      if (!has_axis_[static_cast<std::size_t>(axis)]) about[axis] = rate_S[axis];
    }
    about = counted_ * about;
    J.setZero();
    J.leftCols<3>() = so3::hat<double>(about) * turn_jacobian_;
    J.middleCols<3>(3) = inverse.asDiagonal();
    J.middleCols<3>(6) = about.cwiseProduct(inverse).asDiagonal();
    J.col(9) = -(counted_ * slope.cwiseProduct(inverse));
    for (int axis = 0; axis < 3; ++axis) {
      if (has_axis_[static_cast<std::size_t>(axis)]) continue;
      r[axis] = 0.0;
      J.row(axis).setZero();
    }
  }

 private:
  const PoseArrays* poses_;
  const SensorSignal* signal_;
  std::array<bool, 3> has_axis_;
  Quaternion nominal_;
  std::vector<FitParameter> parameters_;
  std::vector<PoseWindow> windows_;
  std::vector<Vector3> rates_B_;
  GyroParameters gyro_;
  SignalAtPoses at_poses_;
  Matrix3 turn_jacobian_ = Matrix3::Identity(), sure_, counted_ = Matrix3::Identity();
};

}  // namespace holdfast

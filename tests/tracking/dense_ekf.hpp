// The tracker's equations as a textbook writes them: one dense extended Kalman filter of 15 states (pose, velocities, one
// beacon), with fixed-size matrices of Eigen's own alignment. To compare with: tests of equality, and the benchmark.
#pragma once

#include <Eigen/Dense>

#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/device_estimate.hpp>

namespace holdfast::test {

class DenseEkf {
 public:
  using Matrix15 = Eigen::Matrix<double, 15, 15>;
  using Vector15 = Eigen::Matrix<double, 15, 1>;
  using Matrix2x15 = Eigen::Matrix<double, 2, 15>;

  TargetState<2> state;  // its P is unused
  Matrix15 P = Matrix15::Identity();

  // Swaps the beacon in, carries both to t, corrects both, and swaps the beacon out (002 sections 4.3.7 and 4.4.3).
  bool update(HostTime t, const ProcessModel<2>& model, const CameraSighting& sighting, DeviceEstimate<3>& beacon) {
    P.topRightCorner<12, 3>().setZero();
    P.bottomLeftCorner<3, 12>().setZero();
    P.bottomRightCorner<3, 3>() = beacon.P;

    const double dt = to_seconds(t - state.t);
    Matrix15 F = Matrix15::Identity();
    F.topLeftCorner<12, 12>() = state_transition(state, model, t);
    Matrix15 Q = Matrix15::Zero();
    for (int axis = 0; axis < 6; ++axis) {
      const double mu = model.intensity[axis];
      Q(axis, axis) = mu * dt * dt * dt / 3.0;
      Q(axis, axis + 6) = Q(axis + 6, axis) = mu * dt * dt / 2.0;
      Q(axis + 6, axis + 6) = mu * dt;
    }
    P = F * P * F.transpose() + Q;
    state.X_WB =
        Rigid(state.X_WB.q() * so3::exp<double>(dt * state.velocity.w_WB_B), state.X_WB.p() + dt * state.velocity.v_WB);
    state.t = t;

    Linearization<CameraSighting> linear;
    if (!sighting.linearize(state, beacon.x, {}, linear)) return false;
    Matrix2x15 H = Matrix2x15::Zero();
    H.leftCols<6>() = linear.H;
    H.rightCols<3>() = linear.H_source;
    const Eigen::Matrix2d S = H * P * H.transpose() + linear.R;
    const Eigen::Matrix<double, 15, 2> K = P * H.transpose() * S.inverse();
    const Vector15 d = K * linear.residual;
    P = (Matrix15::Identity() - K * H) * P;
    state.add(d.head<12>());
    beacon.x += d.tail<3>();
    beacon.P = P.bottomRightCorner<3, 3>();
    return true;
  }
};

}  // namespace holdfast::test

/// The joint angles of a mechanical arm that holds the body: a boom, a haptic arm, an exoskeleton (000 section 3.1.4).
///
/// The arm is a product of exponentials: with every joint at zero the body is at X_WB_at_zero, and joint i turns all that
/// follows it about an axis through point_W along axis_W, both given for the arm at zero:
///   X_WB(q) = T_1(q_1) ... T_n(q_n) X_WB_at_zero
/// (Brockett 1984; Lynch & Park, Modern Robotics, 4.1). The measured angles thus give a pose, whose residual is that of
/// pose_measurement.hpp. Its covariance is that of the angles, carried through the arm, and `flex`, what the links give
/// way: without it an arm of fewer than six joints would claim to know some directions exactly.
/// The sensor's parameters are the angles' zero offsets (rad): a joint reads q + offset.
/// Bad input: axes have unit length; `flex` is positive definite for an arm of fewer than six joints.
#pragma once

#include <array>

#include <holdfast/tracking/pose_measurement.hpp>

namespace holdfast {

struct RevoluteJoint {
  Vector3 axis_W = Vector3::UnitZ();  ///< unit length
  Vector3 point_W = Vector3::Zero();
};

template <int Joints>
struct JointArm {
  std::array<RevoluteJoint, Joints> joints;
  Rigid X_WB_at_zero;

  struct End {
    Rigid X_WB;
    MatrixOf<double, 6, Joints> by_angle;  ///< of the end's (dp, dphi): position in W, turn about B's axes
  };

  [[nodiscard]] End end(const VectorOf<double, Joints>& angles) const {
    std::array<RevoluteJoint, Joints> placed;
    Rigid moved;
    for (int i = 0; i < Joints; ++i) {
      const RevoluteJoint& joint = joints[i];
      placed[i] = {moved.q() * joint.axis_W, moved * joint.point_W};
      const Quaternion turn = so3::exp<double>(angles[i] * joint.axis_W);
      moved = moved * Rigid(turn, joint.point_W - turn * joint.point_W);
    }
    End end;
    end.X_WB = moved * X_WB_at_zero;
    for (int i = 0; i < Joints; ++i) {
      end.by_angle.template block<3, 1>(0, i) = placed[i].axis_W.cross(end.X_WB.p() - placed[i].point_W);
      end.by_angle.template block<3, 1>(3, i) = end.X_WB.q().conjugate() * placed[i].axis_W;
    }
    return end;
  }
};

template <int Joints>
struct JointAngles {
  static constexpr int size = 6;
  static constexpr int state_size = 6;
  static constexpr int source_size = 0;
  static constexpr int sensor_size = Joints;

  VectorOf<double, Joints> angles = VectorOf<double, Joints>::Zero();  ///< as read, rad
  const JointArm<Joints>* arm = nullptr;                               ///< not owned, not null
  double variance = 0.0;                                               ///< of each angle, rad^2
  Matrix6 flex = Matrix6::Zero();                                      ///< of (dp, dphi): m^2, rad^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const DeviceParameters<0>&,
                               const DeviceParameters<Joints>& offsets, Linearization<JointAngles>& linear) const {
    const VectorOf<double, Joints> q = angles - offsets;
    if (!q.allFinite()) return false;
    const auto end = arm->end(q);
    Linearization<PoseMeasurement> pose;
    if (!PoseMeasurement{end.X_WB, flex}.linearize(state, {}, {}, pose)) return false;
    linear.residual = pose.residual;
    linear.H = pose.H;
    linear.H_sensor = end.by_angle;
    linear.H_sensor.template bottomRows<3>() =
        so3::right_jacobian_inverse<double>(pose.residual.template tail<3>()) * end.by_angle.template bottomRows<3>();
    linear.R = flex + variance * linear.H_sensor * linear.H_sensor.transpose();
    return true;
  }
};

}  // namespace holdfast

/// How the error of a strapdown inertial navigator goes on over a stretch of time (Sola 2017, section 5; 003's reference 10).
///
/// The error's numbers are the first 15 of inertial_state.hpp: place (W), turn (B), velocity (W), rate bias, force bias (B).
///   place    <- place + dt velocity - R [p]x (turn - dt/3 b_w) - dt^2/2 R b_f
///   turn     <- C^T turn - dt/2 (1 + C^T) b_w
///   velocity <- velocity - R [v]x (turn - dt/2 b_w) - dt R b_f
/// with R the orientation at the stretch's begin, C the turn within it, v and p the integrals of the force (StrapdownIncrement).
/// Exact to first order in the error for a force and a rate that hardly change within the stretch: of the coupling to b_w a part
/// of the order dt |w| is left out.
/// P <- F P F^T needs a sixth of the products of the dense form, because the blocks that are zero or one are not multiplied.
/// An axis that is not believed has no bias: what stands in for it owes nothing to the sensor.
/// Nothing here allocates. Bad input: nothing is checked; what is not finite stays so.
#pragma once

#include <holdfast/tracking/inertial_state.hpp>

namespace holdfast {

inline constexpr int strapdown_error_size = 15;
using StrapdownCovariance = MatrixOf<double, strapdown_error_size>;

/// Which axes are believed: 1, or 0.
struct BelievedAxes {
  Vector3 rate = Vector3::Ones();
  Vector3 force = Vector3::Ones();

  [[nodiscard]] bool operator==(const BelievedAxes& other) const { return rate == other.rate && force == other.force; }
};

/// White noise and random walks, per axis of B.
struct StrapdownNoise {
  Vector3 rate = Vector3::Zero();       ///< rad/s / sqrt(Hz)
  Vector3 force = Vector3::Zero();      ///< m/s^2 / sqrt(Hz)
  Vector3 rate_walk = Vector3::Zero();  ///< rad/s / sqrt(s)
  Vector3 force_walk = Vector3::Zero();
};

/// F of P <- F P F^T, whole.
[[nodiscard]] inline StrapdownCovariance strapdown_transition(const StrapdownIncrement& step, const Matrix3& R,
                                                              const BelievedAxes& believed = {}) {
  using S = InertialState;
  const double dt = step.seconds;
  const Matrix3 Ct = step.q.conjugate().toRotationMatrix();
  const Matrix3 A = -R * so3::hat<double>(step.position_B), E = -R * so3::hat<double>(step.velocity_B);
  StrapdownCovariance F = StrapdownCovariance::Identity();
  F.block<3, 3>(S::place, S::velocity).diagonal().setConstant(dt);
  F.block<3, 3>(S::place, S::turn) = A;
  F.block<3, 3>(S::place, S::rate_bias) = -dt / 3.0 * A * believed.rate.asDiagonal();
  F.block<3, 3>(S::place, S::force_bias) = -0.5 * dt * dt * R * believed.force.asDiagonal();
  F.block<3, 3>(S::turn, S::turn) = Ct;
  F.block<3, 3>(S::turn, S::rate_bias) = -0.5 * dt * (Matrix3::Identity() + Ct) * believed.rate.asDiagonal();
  F.block<3, 3>(S::velocity, S::turn) = E;
  F.block<3, 3>(S::velocity, S::rate_bias) = -0.5 * dt * E * believed.rate.asDiagonal();
  F.block<3, 3>(S::velocity, S::force_bias) = -dt * R * believed.force.asDiagonal();
  return F;
}

/// P <- F P F^T, block by block. P stays symmetric.
inline void carry_covariance(StrapdownCovariance& P, const StrapdownIncrement& step, const Matrix3& R,
                             const BelievedAxes& believed = {}) {
  using S = InertialState;
  using Rows = MatrixOf<double, 3, strapdown_error_size>;
  const double dt = step.seconds;
  const Matrix3 Ct = step.q.conjugate().toRotationMatrix();
  const Matrix3 A = -R * so3::hat<double>(step.position_B), E = -R * so3::hat<double>(step.velocity_B);
  const Matrix3 D = -0.5 * dt * (Matrix3::Identity() + Ct) * believed.rate.asDiagonal();
  const Matrix3 G = -dt * R * believed.force.asDiagonal();

  const Rows turn = P.middleRows<3>(S::turn), velocity = P.middleRows<3>(S::velocity);
  const Rows rate_bias = believed.rate.asDiagonal() * P.middleRows<3>(S::rate_bias);
  Rows by_force;  // G P_f
  by_force.noalias() = G.lazyProduct(P.middleRows<3>(S::force_bias));
  const Rows half = turn - 0.5 * dt * rate_bias, third = turn - dt / 3.0 * rate_bias;
  MatrixOf<double, 9, strapdown_error_size> FP;
  FP.topRows<3>() = P.topRows<3>() + dt * velocity + 0.5 * dt * by_force;
  FP.topRows<3>().noalias() += A.lazyProduct(third);
  FP.middleRows<3>(S::turn).noalias() = Ct.lazyProduct(turn);
  FP.middleRows<3>(S::turn).noalias() += D.lazyProduct(P.middleRows<3>(S::rate_bias));
  FP.middleRows<3>(S::velocity) = velocity + by_force;
  FP.middleRows<3>(S::velocity).noalias() += E.lazyProduct(half);

  // The same from the right, on the nine rows that change.
  using Columns = MatrixOf<double, 9, 3>;
  const Columns turned = FP.middleCols<3>(S::turn), moved = FP.middleCols<3>(S::velocity);
  const Columns rate_side = FP.middleCols<3>(S::rate_bias) * believed.rate.asDiagonal();
  Columns force_side;
  force_side.noalias() = FP.middleCols<3>(S::force_bias).lazyProduct(G.transpose());
  const Columns half_side = turned - 0.5 * dt * rate_side, third_side = turned - dt / 3.0 * rate_side;
  MatrixOf<double, 9> carried;
  carried.leftCols<3>() = FP.leftCols<3>() + dt * moved + 0.5 * dt * force_side;
  carried.leftCols<3>().noalias() += third_side.lazyProduct(A.transpose());
  carried.middleCols<3>(S::turn).noalias() = turned.lazyProduct(Ct.transpose());
  carried.middleCols<3>(S::turn).noalias() += FP.middleCols<3>(S::rate_bias).lazyProduct(D.transpose());
  carried.rightCols<3>() = moved + force_side;
  carried.rightCols<3>().noalias() += half_side.lazyProduct(E.transpose());
  P.topLeftCorner<9, 9>() = 0.5 * (carried + carried.transpose());
  P.topRightCorner<9, 6>() = FP.rightCols<6>();
  P.bottomLeftCorner<6, 9>() = FP.rightCols<6>().transpose();
}

/// What a stretch of dt seconds adds to P.
inline void add_noise(StrapdownCovariance& P, double dt, const Matrix3& R, const StrapdownNoise& noise) {
  using S = InertialState;
  const Vector3 force_variances = noise.force.cwiseAbs2();
  const Matrix3 force_W = R * force_variances.asDiagonal() * R.transpose();
  P.block<3, 3>(S::place, S::place) += dt * dt * dt / 3.0 * force_W;
  P.block<3, 3>(S::place, S::velocity) += 0.5 * dt * dt * force_W;
  P.block<3, 3>(S::velocity, S::place) += 0.5 * dt * dt * force_W;
  P.block<3, 3>(S::velocity, S::velocity) += dt * force_W;
  P.diagonal().segment<3>(S::turn) += dt * noise.rate.cwiseAbs2();
  P.diagonal().segment<3>(S::rate_bias) += dt * noise.rate_walk.cwiseAbs2();
  P.diagonal().segment<3>(S::force_bias) += dt * noise.force_walk.cwiseAbs2();
}

}  // namespace holdfast

/// How uncertain the pose becomes that an inertial filter carries on when no pose comes any more.
///
/// What the covariance P says of the pose s seconds later, with the sensors going on: the place errs by
/// dp + s dv + s^2 / 2 da, where da comes from the tilt, the force's bias and gravity, and the orientation by dphi - s
/// db. So the variances are polynomials in s; here they are made once, to be evaluated at any s. Of B's origin, not the
/// sensors' place. Means over the axes; m^2, rad^2. Bad input: precondition finite numbers.
#pragma once

#include <algorithm>

#include <holdfast/tracking/inertial_process.hpp>

namespace holdfast {

struct PoseSpread {
  VectorOf<double, 5> place = VectorOf<double, 5>::Zero();  ///< coefficients of s^0, s^1, ...
  Vector3 turn = Vector3::Zero();

  [[nodiscard]] double place_m2(double s) const {
    return place[0] + s * (place[1] + s * (place[2] + s * (place[3] + s * place[4])));
  }
  [[nodiscard]] double turn_rad2(double s) const { return turn[0] + s * (turn[1] + s * turn[2]); }
};

/// `noise`: what comes to it. `has_force` false: the
/// velocity is carried on as it is.
[[nodiscard]] inline PoseSpread pose_spread(const InertialState& state, const InertialState::Covariance& P,
                                            bool has_force, const ProcessNoise& noise) {
  using S = InertialState;
  using Rows = MatrixOf<double, 3, S::size>;
  const Matrix3 R = state.X_WS.R();
  Rows place = Rows::Zero(), velocity = Rows::Zero(), force = Rows::Zero();
  place.middleCols<3>(S::place).setIdentity();
  place.middleCols<3>(S::lever) = -R;
  place.middleCols<3>(S::turn) = R * so3::hat<double>(state.lever_B);
  velocity.middleCols<3>(S::velocity).setIdentity();
  if (has_force) {
    force.middleCols<3>(S::turn) = R * so3::hat<double>(state.X_WS.q().conjugate() * state.gravity_W);
    force.middleCols<3>(S::force_bias) = -R;
    force.middleCols<3>(S::gravity).setIdentity();
  }
  Rows place_P, velocity_P, force_P;
  place_P.noalias() = place.lazyProduct(P);
  velocity_P.noalias() = velocity.lazyProduct(P);
  force_P.noalias() = force.lazyProduct(P);
  const auto mean = [](const Rows& a_P, const Rows& b) { return a_P.cwiseProduct(b).sum() / 3.0; };
  PoseSpread spread;
  spread.place << mean(place_P, place), 2.0 * mean(velocity_P, place),
      mean(velocity_P, velocity) + mean(force_P, place), mean(force_P, velocity) + noise.force / 3.0,
      0.25 * mean(force_P, force);
  spread.turn << P.diagonal().segment<3>(S::turn).mean(),
      noise.turn - 2.0 * P.block<3, 3>(S::turn, S::rate_bias).trace() / 3.0,
      P.diagonal().segment<3>(S::rate_bias).mean();
  return spread;
}

}  // namespace holdfast

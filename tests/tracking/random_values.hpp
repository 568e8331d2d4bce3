// Normal values for the tests of tracking, from a generator of a known seed, and motions made of them.
#pragma once

#include <cmath>
#include <random>

#include <holdfast/tracking/advance.hpp>

namespace holdfast::test {

/// Components in order.
template <int Size>
VectorOf<double, Size> random_vector(std::mt19937& random, double sigma = 1.0) {
  std::normal_distribution<double> normal(0.0, sigma);
  VectorOf<double, Size> v;
  for (int i = 0; i < Size; ++i) v[i] = normal(random);
  return v;
}

/// Components in the order in which the compiler takes arguments.
inline Vector3 random_vector(std::mt19937& random, double sigma = 1.0) {
  std::normal_distribution<double> normal(0.0, sigma);
  return Vector3(normal(random), normal(random), normal(random));
}

inline Rigid random_pose(std::mt19937& random) {
  return Rigid(so3::exp<double>(random_vector(random)), random_vector(random));
}

/// The truth moves as a model without decay says.
inline void wander(TargetState<2>& truth, const ProcessModel<2>& model, HostTime t, std::mt19937& random) {
  TargetState<2>::Error d;
  const Vector6 a = random_vector<6>(random), b = random_vector<6>(random);
  for (int axis = 0; axis < 6; ++axis) {
    const Matrix2 Q = chain_step<2>(model.intensity[axis], 0.0, to_seconds(t - truth.t)).Q;
    const double velocity = std::sqrt(Q(1, 1));
    const double along = Q(0, 1) / velocity;
    d[6 + axis] = velocity * a[axis];
    d[axis] = along * a[axis] + std::sqrt(Q(0, 0) - along * along) * b[axis];
  }
  truth.P.setZero();
  advance(truth, model, t);
  truth.add(d);
}

}  // namespace holdfast::test

// Normal values for the tests of tracking, from a generator of a known seed.
#pragma once

#include <random>

#include <holdfast/geometry/rigid.hpp>

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

}  // namespace holdfast::test

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/vqs.hpp>
#include <holdfast/timing/clock.hpp>

using namespace holdfast;

TEST_CASE("X_AC = X_AB * X_BC maps points as its factors do") {
  const Rigid X_AB(so3::exp<double>(Vector3(0.1, -0.4, 2.0)), Vector3(1, 2, 3));
  const Rigid X_BC(so3::exp<double>(Vector3(-1.0, 0.2, 0.3)), Vector3(-0.5, 0.1, 0.9));
  const Vector3 p_C(0.3, 0.7, -1.1);
  const Rigid X_AC = X_AB * X_BC;
  CHECK((X_AC * p_C - X_AB * (X_BC * p_C)).norm() < 1e-14);
  CHECK((X_AB.inverse() * (X_AB * p_C) - p_C).norm() < 1e-14);
}

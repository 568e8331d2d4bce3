// A ball of cameras like the HiBall's, for tests of what is seen by one.
#pragma once

#include <vector>

#include <holdfast/tracking/camera_view.hpp>

namespace holdfast::test {

constexpr double focal_m = 0.037;
constexpr double pi = 3.14159265358979323846;

/// A ball of cameras: one looking up and five round it, leaning out by `lean`.
struct Ball {
  std::vector<CameraView> views;
  std::vector<Rigid> X_BC;

  explicit Ball(double lean = 1.0) {
    const Quaternion up = so3::exp<double>(Vector3(0.5 * pi, 0.0, 0.0));  // a camera looks along -Z: turned to +Y
    for (int i = 0; i < 6; ++i) {
      const double heading = 2.0 * pi * i / 5.0;
      const Vector3 axis =
          i == 5 ? Vector3(Vector3::Zero()) : Vector3(lean * std::cos(heading), 0.0, lean * std::sin(heading));
      const Quaternion q(so3::exp<double>(axis) * up);
      X_BC.emplace_back(q, q * Vector3(0.0, 0.0, -0.025));
      views.push_back({view_matrix(X_BC.back(), focal_m)});
    }
  }
};

}  // namespace holdfast::test

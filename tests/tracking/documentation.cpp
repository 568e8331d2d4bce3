// The code of docs/tracking.md, as it stands there.
#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/tracking/backward_difference.hpp>

using namespace holdfast;

TEST_CASE("the tracking page's example") {
  const TimedPose older{time_at(0.0), Rigid()}, newer{time_at(0.01), Rigid::translation(Vector3(0.001, 0, 0))};
  PoseNoise noise{.position_m = 1e-4, .orientation_rad = 2e-4};
  PoseEstimate head = backward_difference(older, newer, noise);
  double sigma_m = std::sqrt(head.pose_covariance()(0, 0));
  CHECK(sigma_m == doctest::Approx(1e-4));
  CHECK(head.velocity->v_WB.x() == doctest::Approx(0.1));
}

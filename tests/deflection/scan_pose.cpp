#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/deflection/scan_pose.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

namespace {
double difference(const Rigid& a, const Rigid& b) {
  return so3::angle_between<double>(a.q(), b.q()) + (a.p() - b.p()).norm();
}
}  // namespace

TEST_CASE("between the late poses the eye runs as interpolate() says, beyond them too") {
  test::Random random(201);
  for (int i = 0; i < 50; ++i) {
    const Rigid X_WS = random.pose(3.0, 2.0);
    const LatePoses late{X_WS * random.pose(0.2, 0.1), X_WS * random.pose(0.2, 0.1)};
    const ScanPose X_SE(X_WS, late);
    for (const double s : {-0.2, 0.0, 0.3, 0.5, 1.0, 1.4}) {
      const Rigid expected = X_WS.inverse() * interpolate(late.X_WE_begin, late.X_WE_end, s);
      CHECK(difference(X_SE.at(s), expected) < 1e-14);
    }
    CHECK(difference(X_SE.without_scan().at(0.9), X_SE.middle()) < 1e-15);
    CHECK(X_SE.without_scan().is_constant());
    CHECK_FALSE(X_SE.is_constant());
  }
}

TEST_CASE("zero motion is the identity to the last bit, whatever the pose") {
  test::Random random(202);
  for (int i = 0; i < 200; ++i) {
    const Rigid X_WS = random.pose(3.0, 1e4);
    const ScanPose X_SE(X_WS, LatePoses::at_once(X_WS));
    for (const double s : {0.0, 0.37, 1.0}) {
      CHECK(X_SE.at(s).q().coeffs() == Quaternion::Identity().coeffs());
      CHECK(X_SE.at(s).p() == Vector3::Zero());
    }
  }
}

TEST_CASE("far from the world's origin a small step is not lost") {
  // 100 km away a double still holds 1.5e-11 m; a pose composed without subtracting first would be off by more after
  // turning 1e5 m by a quaternion that is exact to 1e-16.
  test::Random random(203);
  for (int i = 0; i < 50; ++i) {
    const Rigid near = random.pose(3.0, 1.0);
    const Rigid step = random.pose(0.01, 0.01);
    const Rigid far(near.q(), near.p() + Vector3(1e5, -1e5, 3e4));
    const Rigid moved(far.q() * step.q(), far.p() + far.q() * step.p());
    CHECK((relative_pose(far, moved).p() - step.p()).norm() < 5e-11);
  }
}

TEST_CASE("turning the whole world, or moving it, changes nothing") {
  test::Random random(204);
  for (int i = 0; i < 50; ++i) {
    const Rigid X_VW = random.pose(3.0, 2.0);
    const Rigid X_WS = random.pose(3.0, 2.0);
    const LatePoses late{X_WS * random.pose(0.2, 0.1), X_WS * random.pose(0.2, 0.1)};
    const ScanPose here(X_WS, late);
    const ScanPose there(X_VW * X_WS, {X_VW * late.X_WE_begin, X_VW * late.X_WE_end});
    CHECK(difference(here.at(0.3), there.at(0.3)) < 1e-14);
  }
}

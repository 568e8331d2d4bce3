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
    const ScanPose of_three(X_WS, {X_WS, X_WS, X_WS});
    for (const double s : {0.0, 0.37, 1.0}) {
      CHECK(of_three.at(s).q().coeffs() == Quaternion::Identity().coeffs());
      CHECK(of_three.at(s).p() == Vector3::Zero());
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

TEST_CASE("through three poses: exact at begin, middle and end, and for any motion of the second order") {
  test::Random random(205);
  for (int i = 0; i < 50; ++i) {
    const Rigid X_WS = random.pose(3.0, 2.0);
    // A turn about one axis whose angle is a parabola of s, on a parabolic way.
    const Vector3 axis = random.vector(1.0).normalized(), v = random.vector(0.1), a = random.vector(0.1);
    const double rate = random.uniform(-0.2, 0.2), change = random.uniform(-0.2, 0.2);
    const Rigid X_WE_0 = X_WS * random.pose(0.2, 0.1);
    const auto X_WE = [&](double s) {
      const Vector3 turned = s * (rate + s * change) * axis;
      return Rigid(X_WE_0.q() * so3::exp<double>(turned), X_WE_0.p() + s * (v + s * a));
    };
    const ScanPose X_SE(X_WS, {X_WE(0.0), X_WE(1.0), X_WE(0.5)});
    double nearest = 1e9;
    for (int k = -5; k <= 25; ++k) {
      const double s = k / 20.0;
      CHECK(difference(X_SE.at(s), X_WS.inverse() * X_WE(s)) < 1e-14);
      const Vector3 p = X_SE.begin().p() + s * (X_SE.moved_linear() + s * X_SE.moved_quadratic());
      CHECK((p - X_SE.at(s).p()).norm() < 1e-15);
      if (s >= 0.0 && s <= 1.0) nearest = std::min(nearest, p.z());
    }
    // A parabola's least value lies at most curvature * step^2 / 4 below the samples'.
    CHECK(X_SE.least_z() <= nearest + 1e-15);
    CHECK(X_SE.least_z() > nearest - 2.0 * std::abs(X_SE.moved_quadratic().z()) * 0.05 * 0.05 / 4.0 - 1e-15);
    // Any three poses are met.
    const LatePoses late{X_WS * random.pose(0.2, 0.1), X_WS * random.pose(0.2, 0.1), X_WS * random.pose(0.2, 0.1)};
    const ScanPose any(X_WS, late);
    CHECK(difference(any.at(0.0), X_WS.inverse() * late.X_WE_begin) < 1e-14);
    CHECK(difference(any.at(0.5), X_WS.inverse() * *late.X_WE_middle) < 1e-14);
    CHECK(difference(any.at(1.0), X_WS.inverse() * late.X_WE_end) < 1e-14);
    CHECK(difference(any.without_scan().at(0.1), any.middle()) == 0.0);
  }
}

TEST_CASE("a middle pose on the even way between begin and end changes nothing; one aside is motion") {
  test::Random random(206);
  for (int i = 0; i < 50; ++i) {
    const Rigid X_WS = random.pose(3.0, 2.0);
    LatePoses late{X_WS * random.pose(0.2, 0.1), X_WS * random.pose(0.2, 0.1)};
    const ScanPose two(X_WS, late);
    late.X_WE_middle = interpolate(late.X_WE_begin, late.X_WE_end, 0.5);
    const ScanPose three(X_WS, late);
    for (const double s : {0.0, 0.2, 0.5, 0.9, 1.3}) CHECK(difference(two.at(s), three.at(s)) < 1e-14);
  }
  // There and back: the ends alone look like rest.
  const ScanPose nod({}, {Rigid(), Rigid(), Rigid::translation(Vector3(0.0, 0.0, -0.01))});
  CHECK_FALSE(nod.is_constant());
  CHECK(nod.least_z() == doctest::Approx(-0.01));
  const ScanPose still({}, {Rigid(), Rigid(), Rigid()});
  CHECK(still.is_constant());
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
    const Rigid X_WM = X_WS * random.pose(0.2, 0.1);
    const ScanPose bent_here(X_WS, {late.X_WE_begin, late.X_WE_end, X_WM});
    const ScanPose bent_there(X_VW * X_WS, {X_VW * late.X_WE_begin, X_VW * late.X_WE_end, X_VW * X_WM});
    CHECK(difference(bent_here.at(0.3), bent_there.at(0.3)) < 1e-14);
  }
}

#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/tracking/space_resection.hpp>
#include <holdfast/tracking/three_point_resection.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;

namespace {

double distance(const Rigid& a, const Rigid& b) {
  return std::max((a.p() - b.p()).norm(), so3::angle_between(a.q(), b.q()));
}

}  // namespace

TEST_CASE("three point resection: the true pose is among the answers, and all answers see the points so") {
  std::mt19937 random(3);
  int several = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Rigid X_WB(so3::exp<double>(random_vector(random, 1.5)), random_vector(random, 2.0));
    std::array<Vector3, 3> points_W;
    std::array<Vector3, 3> directions_B;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 p_B = random_vector(random, 1.0) + Vector3(0.0, 0.0, -3.0);
      points_W[i] = X_WB * p_B;
      directions_B[i] = p_B.normalized();
    }
    const ThreePointPoses poses = three_point_poses(directions_B, points_W);
    REQUIRE(poses.count >= 1);
    several += poses.count > 1;
    double nearest = 1e9;
    for (int i = 0; i < poses.count; ++i) {
      const Rigid& found = poses.X_WB[static_cast<std::size_t>(i)];
      nearest = std::min(nearest, distance(found, X_WB));
      for (std::size_t j = 0; j < 3; ++j) {
        const Vector3 seen = (found.inverse() * points_W[j]).normalized();
        CHECK((seen - directions_B[j]).norm() < 1e-4);  // defect of 1e-6 of a squared side, at thin triangles
      }
    }
    // Near the danger cylinder (Haralick et al.) answers merge and half the digits go.
    CHECK(nearest < 1e-3);
  }
  CHECK(several > 500);  // the ambiguity is real
}

TEST_CASE("three point resection refuses points on a line and directions that coincide") {
  const std::array<Vector3, 3> directions{Vector3(0, 0, -1), Vector3(0.6, 0, -0.8), Vector3(0, 0.6, -0.8)};
  CHECK(three_point_poses(directions, {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(2, 0, 0)}).count == 0);
  const std::array<Vector3, 3> same{directions[0], directions[0], directions[2]};
  CHECK(three_point_poses(same, {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)}).count == 0);
  const double nan = std::nan("");
  CHECK(three_point_poses(directions, {Vector3(nan, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)}).count == 0);
}

TEST_CASE("space resection converges on exact sightings from 30 degrees and half a metre away") {
  std::mt19937 random(4);
  const std::array<CameraView, 3> cameras{
      CameraView{view_matrix(Rigid(), 0.037)},
      CameraView{view_matrix(Rigid(so3::exp<double>(Vector3(1.0, 0.0, 0.0)), Vector3(0.0, 0.02, 0.0)), 0.037)},
      CameraView{view_matrix(Rigid(so3::exp<double>(Vector3(0.0, 1.0, 0.0)), Vector3(0.02, 0.0, 0.0)), 0.037)}};
  const std::array<Quaternion, 3> looks{Quaternion::Identity(), so3::exp<double>(Vector3(1.0, 0.0, 0.0)),
                                        so3::exp<double>(Vector3(0.0, 1.0, 0.0))};
  std::uniform_real_distribution<double> small(-0.05, 0.05);
  int converged = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Rigid X_WB(so3::exp<double>(random_vector(random, 1.0)), random_vector(random, 1.0));
    std::vector<SightedBeacon> sightings;
    for (std::size_t i = 0; i < 12; ++i) {
      const Vector3 p_B = looks[i % 3] * Vector3(Vector3(small(random), small(random), -1.0) * 2.0);
      const auto uv = cameras[i % 3].project(p_B);
      REQUIRE(uv);
      sightings.push_back({{*uv, &cameras[i % 3], 1e-12}, X_WB * p_B, 1e-6});
    }
    const Vector3 turn = random_vector(random, 1.0).normalized() * 0.5;
    const Rigid start(X_WB.q() * so3::exp<double>(turn), X_WB.p() + random_vector(random, 1.0).normalized() * 0.5);
    const Resection found = resect(sightings, start);
    if (!found.ok()) continue;
    ++converged;
    CHECK(distance(found.X_WB, X_WB) < 1e-7);
    CHECK(found.cost < 1e-6);
  }
  CHECK(converged >= 190);
  CHECK(resect({}, Rigid()).status == ResectionStatus::too_few);
}

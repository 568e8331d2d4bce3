#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/align.hpp>

using namespace holdfast;

namespace {

struct Cloud {
  std::vector<Vector3> p_A, p_B;
};

Cloud make_cloud(const Vqs& T_AB, int count, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Cloud cloud;
  for (int i = 0; i < count; ++i) {
    const Vector3 p_B(normal(random), 0.5 * normal(random), 2.0 + 0.2 * normal(random));
    const Vector3 error(normal(random), normal(random), normal(random));
    cloud.p_B.push_back(p_B);
    cloud.p_A.push_back(T_AB * p_B + noise * error);
  }
  return cloud;
}

const Rigid X_AB_true(so3::exp<double>(Vector3(0.5, -2.0, 1.0)), Vector3(3, -1, 0.5));

}  // namespace

TEST_CASE("exact points give the exact transform") {
  for (const int count : {3, 4, 50}) {
    const Cloud cloud = make_cloud(X_AB_true, count, 0.0, 51);
    const auto X_AB = align_rigid(cloud.p_A, cloud.p_B);
    REQUIRE(X_AB);
    CHECK(so3::angle_between<double>(X_AB->q(), X_AB_true.q()) < 1e-13);  // three points may be ill spread
    CHECK((X_AB->p() - X_AB_true.p()).norm() < 1e-13);
  }
}

TEST_CASE("noise: the error falls with the root of the count, and no neighbour fits better") {
  const Cloud cloud = make_cloud(X_AB_true, 900, 0.01, 52);
  const auto X_AB = align_rigid(cloud.p_A, cloud.p_B);
  REQUIRE(X_AB);
  // 10 mm over 30 (root of 900): 0.33 mm at the cloud's centre; the least spread axis pair (0.5, 0.2 m) turns by 0.6
  // mrad. Four sigma.
  CHECK(so3::angle_between<double>(X_AB->q(), X_AB_true.q()) < 2.5e-3);
  CHECK((*X_AB * Vector3(0, 0, 2) - X_AB_true * Vector3(0, 0, 2)).norm() < 1.5e-3);
  const auto cost = [&cloud](const Rigid& X) {
    double sum = 0;
    for (std::size_t i = 0; i < cloud.p_A.size(); ++i) sum += (cloud.p_A[i] - X * cloud.p_B[i]).squaredNorm();
    return sum;
  };
  const double best = cost(*X_AB);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-4, 1e-4}) {
      const Vector3 d = step * Vector3::Unit(axis);
      CHECK(cost(Rigid(so3::exp<double>(d), Vector3::Zero()) * *X_AB) > best);
      CHECK(cost(Rigid::translation(d) * *X_AB) > best);
    }
  }
}

TEST_CASE("coplanar points still give a rotation, not a mirror image") {
  std::vector<Vector3> p_A, p_B;
  for (const Vector2& c : {Vector2(0, 0), Vector2(1, 0), Vector2(1, 2), Vector2(0, 2)}) {
    p_B.emplace_back(c.x(), c.y(), 0.0);
    p_A.push_back(X_AB_true * p_B.back());
  }
  const auto X_AB = align_rigid(p_A, p_B);
  REQUIRE(X_AB);
  CHECK(so3::angle_between<double>(X_AB->q(), X_AB_true.q()) < 1e-14);
}

TEST_CASE("scale") {
  const Vqs T_AB(Vector3(3, -1, 0.5), X_AB_true.q(), 39.37);
  const Cloud cloud = make_cloud(T_AB, 20, 0.0, 53);
  const auto found = align_similarity(cloud.p_A, cloud.p_B);
  REQUIRE(found);
  CHECK(found->s() == doctest::Approx(39.37).epsilon(1e-13));
  CHECK(so3::angle_between<double>(found->q(), T_AB.q()) < 1e-13);
  CHECK((found->v() - T_AB.v()).norm() < 1e-11);
}

TEST_CASE("sets that do not determine the answer are refused") {
  const Cloud good = make_cloud(X_AB_true, 10, 0.0, 54);
  CHECK_FALSE(align_rigid({}, {}));
  CHECK_FALSE(align_rigid(std::span(good.p_A).first(2), std::span(good.p_B).first(2)));
  CHECK_FALSE(align_rigid(std::span(good.p_A).first(5), std::span(good.p_B).first(6)));
  std::vector<Vector3> line_A, line_B;
  for (int i = 0; i < 10; ++i) {
    line_B.emplace_back(0.1 * i, 0.2 * i, -0.3 * i);
    line_A.push_back(X_AB_true * line_B.back());
  }
  CHECK_FALSE(align_rigid(line_A, line_B));
  CHECK_FALSE(align_similarity(line_A, line_B));
  const std::vector<Vector3> one_place(10, Vector3(1, 2, 3));
  CHECK_FALSE(align_rigid(one_place, good.p_B));
  CHECK_FALSE(align_rigid(good.p_A, one_place));
  Cloud bad = good;
  bad.p_A[3].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(align_rigid(bad.p_A, bad.p_B));
  bad.p_A[3].y() = std::numeric_limits<double>::infinity();
  CHECK_FALSE(align_rigid(bad.p_A, bad.p_B));
}

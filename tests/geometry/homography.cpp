#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/homography.hpp>

using namespace holdfast;

namespace {
Rigid random_small_motion(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  const Vector3 phi(uniform(random), uniform(random), uniform(random));
  return Rigid(so3::exp<double>(phi), Vector3(uniform(random), uniform(random), uniform(random)));
}
}  // namespace

TEST_CASE("a turned eye sees points at any distance where the homography says") {
  std::mt19937 random(41);
  for (int i = 0; i < 20; ++i) {
    const Quaternion q_AB = random_small_motion(random).q();
    const Homography H_AB = Homography::rotation(q_AB);
    const Vector3 p_B(0.3, -0.4, -0.5 - i);
    const auto seen = H_AB.apply(*tangents_of_point(p_B));
    REQUIRE(seen);
    CHECK((*seen - *tangents_of_point(q_AB * p_B)).norm() < 1e-14);
  }
}

TEST_CASE("closed form: looking left by a yaw moves straight-ahead things right by its tangent") {
  // Eye A is eye B turned left (about +Y) by 10 degrees: R_AB is the turn back.
  const Angle yaw = degrees(10);
  const Homography H_AB = Homography::rotation(so3::exp<double>(Vector3(0, -yaw.radians(), 0)));
  CHECK((*H_AB.apply(Vector2(0, 0)) - Vector2(tan(yaw), 0)).norm() < 1e-15);
  // At height t_y the same turn gives (tan, t_y / cos): the keystone that a mere shift misses.
  CHECK((*H_AB.apply(Vector2(0, 0.5)) - Vector2(tan(yaw), 0.5 / cos(yaw))).norm() < 1e-15);
}

TEST_CASE("evaluation.md value 8: a shift errs by 15.6 arcmin at 30 degrees for a turn of 1 degree") {
  const Angle turn = degrees(1);
  const Homography H_AB = Homography::rotation(so3::exp<double>(Vector3(0, -turn.radians(), 0)));
  const Vector2 at_30(tan(degrees(30)), 0);
  const double seen = H_AB.apply(at_30)->x();
  CHECK(std::atan(seen) == doctest::Approx(degrees(31).radians()).epsilon(1e-14));
  // The difference in tangents becomes an angle by cos^2 of the field angle.
  const double difference = seen - (at_30.x() + tan(turn));
  CHECK(radians(difference * cos(degrees(30)) * cos(degrees(30))).arcmin() == doctest::Approx(15.6).epsilon(0.003));
}

TEST_CASE("a plane's points go where the moved eye sees them") {
  std::mt19937 random(42);
  for (int i = 0; i < 50; ++i) {
    const Rigid X_AB = random_small_motion(random);
    const Plane plane_B = *Plane::make(Vector3(0.2, -0.1, 1.0), Vector3(0, 0, -2.0));
    const auto H_AB = Homography::through_plane(X_AB, plane_B);
    REQUIRE(H_AB);
    const Vector3 p_B = plane_B.nearest_point(Vector3(0.1 * (i % 7), -0.08 * (i % 5), -2.0));
    const auto seen = H_AB->apply(*tangents_of_point(p_B));
    REQUIRE(seen);
    CHECK((*seen - *tangents_of_point(X_AB * p_B)).norm() < 1e-14);
    // Which way the normal points is no matter.
    const auto flipped = Homography::through_plane(X_AB, Plane{-plane_B.normal, -plane_B.offset});
    CHECK((flipped->matrix() - H_AB->matrix()).cwiseAbs().maxCoeff() < 1e-15);
    // There and back, by inverse and by the plane seen from the other eye.
    CHECK((*H_AB->inverse().apply(*seen) - *tangents_of_point(p_B)).norm() < 1e-14);
    const auto H_BA = Homography::through_plane(X_AB.inverse(), X_AB * plane_B);
    CHECK((H_BA->matrix() - H_AB->inverse().matrix()).cwiseAbs().maxCoeff() < 1e-14);
  }
}

TEST_CASE("a very far plane is a mere turn; points off the plane keep parallax") {
  const Rigid X_AB(so3::exp<double>(Vector3(0.1, -0.2, 0.05)), Vector3(0.1, 0, 0));
  const auto far = Homography::through_plane(X_AB, Plane{Vector3(0, 0, 1), -1e9});
  REQUIRE(far);
  CHECK((far->matrix() - Homography::rotation(X_AB.q()).matrix()).cwiseAbs().maxCoeff() < 2e-10);  // 0.1 m / 1e9 m
  // Moving 10 cm sideways, a point at 1 m taken for one at 2 m is misplaced by 0.1/1 - 0.1/2.
  const auto at_2_m = Homography::through_plane(Rigid::translation(Vector3(-0.1, 0, 0)), Plane{Vector3(0, 0, 1), -2.0});
  CHECK(at_2_m->apply(Vector2(0, 0))->x() == doctest::Approx(-0.05).epsilon(1e-14));
}

TEST_CASE("homographies compose like their frames") {
  std::mt19937 random(43);
  const Quaternion q_AB = random_small_motion(random).q();
  const Quaternion q_BC = random_small_motion(random).q();
  const Homography H_AC = Homography::rotation(q_AB) * Homography::rotation(q_BC);
  CHECK((H_AC.matrix() - Homography::rotation(q_AB * q_BC).matrix()).cwiseAbs().maxCoeff() < 1e-15);
  const Vector2 t_C(0.2, -0.1);
  const Vector2 t_B = *Homography::rotation(q_BC).apply(t_C);
  CHECK((*H_AC.apply(t_C) - *Homography::rotation(q_AB).apply(t_B)).norm() < 1e-14);
}

TEST_CASE("directions that end up beside or behind the eye give nothing") {
  const Homography quarter = Homography::rotation(so3::exp<double>(Vector3(0, std::numbers::pi / 2, 0)));
  // B's ahead is A's left, exactly sideways but for rounding; B's left is behind A; B's right is ahead.
  CHECK_FALSE(quarter.apply(Vector2(-1, 0)));
  REQUIRE(quarter.apply(Vector2(1, 0)));
  CHECK((*quarter.apply(Vector2(1, 0)) - Vector2(-1, 0)).norm() < 1e-15);
  CHECK_FALSE(Homography::rotation(so3::exp<double>(Vector3(0, 3, 0))).apply(Vector2(0, 0)));
}

TEST_CASE("degenerate maps are refused") {
  const Plane wall{Vector3(0, 0, 1), -2.0};
  CHECK_FALSE(Homography::through_plane(Rigid(), Plane{Vector3(0, 0, 1), 0.0}));  // through eye B
  // Eye A on the plane, and beyond it (it sees the back, mirrored).
  CHECK_FALSE(Homography::through_plane(Rigid::translation(Vector3(0, 0, 2)), wall));
  CHECK_FALSE(Homography::through_plane(Rigid::translation(Vector3(0, 0, 3)), wall));
  CHECK_FALSE(Homography::make(Matrix3::Zero()));
  Matrix3 mirror = Matrix3::Identity();
  mirror(0, 0) = -1;
  CHECK_FALSE(Homography::make(mirror));
  Matrix3 with_nan = Matrix3::Identity();
  with_nan(0, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(Homography::make(with_nan));
  CHECK(Homography::make(1e-6 * Matrix3::Identity()));
}

#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/rigid.hpp>

using namespace holdfast;

// The layout must not depend on the instruction set a translation unit is built for.
static_assert(alignof(Rigid) == alignof(double) && sizeof(Rigid) == 7 * sizeof(double));
static_assert(alignof(Rigidf) == alignof(float) && sizeof(Rigidf) == 7 * sizeof(float));
static_assert(sizeof(Vector3) == 3 * sizeof(double) && alignof(Quaternion) == alignof(double));

namespace {

template <typename Scalar>
RigidTransform<Scalar> random_rigid(std::mt19937& random, double angle) {
  std::normal_distribution<double> normal;
  const Vector3 direction(normal(random), normal(random), normal(random));
  const Vector3 p(normal(random), normal(random), normal(random));
  const Vector3 phi = angle * direction.normalized();
  return Rigid(so3::exp<double>(phi), p).cast<Scalar>();
}

template <typename Scalar>
Scalar distance(const RigidTransform<Scalar>& a, const RigidTransform<Scalar>& b) {
  return std::max(so3::angle_between<Scalar>(a.q(), b.q()), (a.p() - b.p()).norm());
}

/// Every property of a group, for three transforms whose rotations are by `angle`.
template <typename Scalar>
void check_group(double angle, Scalar tolerance) {
  std::mt19937 random(11);
  for (int i = 0; i < 20; ++i) {
    const auto X_AB = random_rigid<Scalar>(random, angle);
    const auto X_BC = random_rigid<Scalar>(random, angle);
    const auto X_CD = random_rigid<Scalar>(random, angle);
    const RigidTransform<Scalar> identity;
    INFO("angle " << angle);
    CHECK(distance(X_AB * identity, X_AB) <= tolerance);
    CHECK(distance(identity * X_AB, X_AB) <= tolerance);
    CHECK(distance(X_AB * X_AB.inverse(), identity) <= tolerance);
    CHECK(distance(X_AB.inverse() * X_AB, identity) <= tolerance);
    CHECK(distance(X_AB.inverse().inverse(), X_AB) <= tolerance);
    CHECK(distance((X_AB * X_BC) * X_CD, X_AB * (X_BC * X_CD)) <= tolerance);
    CHECK(distance((X_AB * X_BC).inverse(), X_BC.inverse() * X_AB.inverse()) <= tolerance);
    const VectorOf<Scalar, 3> p_C(Scalar(0.3), Scalar(-0.7), Scalar(1.1));
    CHECK(((X_AB * X_BC) * p_C - X_AB * (X_BC * p_C)).norm() <= tolerance);
    const MatrixOf<Scalar, 4> difference = (X_AB * X_BC).matrix() - X_AB.matrix() * X_BC.matrix();
    CHECK(difference.cwiseAbs().maxCoeff() <= tolerance);
  }
}

}  // namespace

TEST_CASE("rigid transforms are a group: at identity, near it, at random, near pi") {
  for (const double angle : {0.0, 1e-9, 1e-6, 1e-3, 0.7, 2.0, std::numbers::pi - 1e-9, std::numbers::pi}) {
    check_group<double>(angle, 1e-14);  // products of numbers up to about 5, a dozen roundings
    check_group<float>(angle, 1e-5F);   // the same in float
  }
}

TEST_CASE("letters: X_AB is the pose of B in A") {
  // B stands at (1, 2, 3) in A and is turned a quarter left about A's +Y: B's -Z (ahead) is A's -X.
  const Rigid X_AB(so3::exp<double>(Vector3(0, std::numbers::pi / 2, 0)), Vector3(1, 2, 3));
  CHECK((X_AB * Vector3(0, 0, -1) - Vector3(0, 2, 3)).norm() < 1e-15);
  CHECK((X_AB * Vector3(0, 0, 0) - Vector3(1, 2, 3)).norm() == 0.0);
  CHECK((X_AB.inverse() * Vector3(1, 2, 3)).norm() < 1e-15);
}

TEST_CASE("a chain of a million products stays a rotation") {
  std::mt19937 random(12);
  const Rigid step = random_rigid<double>(random, 0.01);
  const Rigidf step_f = step.cast<float>();
  Rigid X;
  Rigidf X_f;
  for (int i = 0; i < 1'000'000; ++i) {
    X = X * step;
    X_f = X_f * step_f;
  }
  CHECK(std::abs(X.q().norm() - 1.0) < 1e-15);
  CHECK(std::abs(X_f.q().norm() - 1.0F) < 3e-7F);
  // One axis: the chain's angle is a million steps of 0.01 rad, less whole turns. Each step's rounding of 1e-16 adds up
  // at worst.
  const double expected = std::remainder(1e6 * 0.01, 2.0 * std::numbers::pi);
  CHECK(so3::angle_between<double>(X.q(), Quaternion::Identity()) == doctest::Approx(std::abs(expected)).epsilon(1e-9));
}

TEST_CASE("make refuses bad numbers and normalises good ones") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Vector3 p(1, 2, 3);
  CHECK_FALSE(Rigid::make(Quaternion(0, 0, 0, 0), p));
  CHECK_FALSE(Rigid::make(Quaternion(nan, 0, 0, 0), p));
  CHECK_FALSE(Rigid::make(Quaternion(inf, 0, 0, 0), p));
  CHECK_FALSE(Rigid::make(Quaternion(2.1, 0, 0, 0), p));
  CHECK_FALSE(Rigid::make(Quaternion(0.4, 0, 0, 0), p));
  CHECK_FALSE(Rigid::make(Quaternion::Identity(), Vector3(1, nan, 3)));
  CHECK_FALSE(Rigid::make(Quaternion::Identity(), Vector3(1, 2, -inf)));
  const auto X = Rigid::make(Quaternion(1.2, 0.3, 0, 0), p);
  REQUIRE(X);
  CHECK(std::abs(X->q().norm() - 1.0) < 1e-15);
  CHECK(X->is_finite());
}

TEST_CASE("from_matrix undoes matrix, and refuses what is not rigid") {
  std::mt19937 random(13);
  for (const double angle : {0.0, 1e-9, 1e-3, 2.0, std::numbers::pi}) {
    const Rigid X = random_rigid<double>(random, angle);
    const auto back = Rigid::from_matrix(X.matrix());
    REQUIRE(back);
    CHECK(distance(*back, X) < 2e-15);
    const auto back_f = Rigidf::from_matrix(X.cast<float>().matrix());
    REQUIRE(back_f);
    CHECK(distance(back_f->cast<double>(), X) < 2e-6);  // ten float roundings
  }
  const Matrix4 good = random_rigid<double>(random, 1.0).matrix();
  const auto spoiled = [&good](int row, int column, double value) {
    Matrix4 m = good;
    m(row, column) = value;
    return Rigid::from_matrix(m);
  };
  CHECK_FALSE(spoiled(0, 0, good(0, 0) + 1e-4));                         // shear
  CHECK_FALSE(spoiled(3, 0, 1e-3));                                      // projection
  CHECK_FALSE(spoiled(3, 3, 2.0));                                       // homogeneous scale
  CHECK_FALSE(spoiled(1, 3, std::numeric_limits<double>::quiet_NaN()));  // position
  CHECK_FALSE(spoiled(1, 1, std::numeric_limits<double>::infinity()));
  Matrix4 mirror = good;
  mirror.col(0) = -mirror.col(0);
  CHECK_FALSE(Rigid::from_matrix(mirror));
  Matrix4 scaled = good;
  scaled.topLeftCorner<3, 3>() *= 1.01;
  CHECK_FALSE(Rigid::from_matrix(scaled));
}

TEST_CASE("interpolate meets its ends, its middle, and extrapolates") {
  std::mt19937 random(14);
  const Rigid a = random_rigid<double>(random, 1.0);
  const Rigid b = random_rigid<double>(random, 2.0);
  CHECK(distance(interpolate(a, b, 0.0), a) < 1e-15);
  CHECK(distance(interpolate(a, b, 1.0), b) < 2e-15);
  const Rigid middle = interpolate(a, b, 0.5);
  CHECK(so3::angle_between<double>(a.q(), middle.q()) ==
        doctest::Approx(so3::angle_between<double>(middle.q(), b.q())).epsilon(1e-14));
  CHECK((middle.p() - 0.5 * (a.p() + b.p())).norm() < 1e-15);
  CHECK(distance(interpolate(a, interpolate(a, b, 0.5), 2.0), b) < 1e-14);
  // The same whichever world the poses are told in (rotation part and straight lines are not tied to a frame).
  const Rigid X_WA = random_rigid<double>(random, 2.5);
  CHECK(distance(X_WA * interpolate(a, b, 0.3), interpolate(X_WA * a, X_WA * b, 0.3)) < 2e-15 * 4);
}

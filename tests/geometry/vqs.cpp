#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/vqs.hpp>

using namespace holdfast;

static_assert(alignof(Vqs) == alignof(double) && sizeof(Vqs) == 8 * sizeof(double));

namespace {

template <typename Scalar>
VqsTransform<Scalar> random_vqs(std::mt19937& random, double angle) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> log_scale(-2.0, 2.0);
  const Vector3 direction(normal(random), normal(random), normal(random));
  const Vector3 v(normal(random), normal(random), normal(random));
  const Vector3 phi = angle * direction.normalized();
  return Vqs(v, so3::exp<double>(phi), std::exp(log_scale(random))).cast<Scalar>();
}

template <typename Scalar>
Scalar distance(const VqsTransform<Scalar>& a, const VqsTransform<Scalar>& b) {
  const Scalar of_scale = std::abs(std::log(a.s() / b.s()));
  return std::max({so3::angle_between<Scalar>(a.q(), b.q()), (a.v() - b.v()).norm(), of_scale});
}

template <typename Scalar>
void check_group(double angle, Scalar tolerance) {
  std::mt19937 random(21);
  for (int i = 0; i < 20; ++i) {
    const auto T_AB = random_vqs<Scalar>(random, angle);
    const auto T_BC = random_vqs<Scalar>(random, angle);
    const auto T_CD = random_vqs<Scalar>(random, angle);
    const VqsTransform<Scalar> identity;
    INFO("angle " << angle);
    // v grows with the product of three scales up to e^2 each: tolerance is relative to that.
    const Scalar size = std::max({Scalar(1), T_AB.s() * T_BC.s(), T_AB.s(), Scalar(1) / (T_AB.s() * T_BC.s()),
                                  Scalar(1) / T_BC.s(), Scalar(1) / T_AB.s()});
    const Scalar most = tolerance * size;
    CHECK(distance(T_AB * identity, T_AB) <= most);
    CHECK(distance(identity * T_AB, T_AB) <= most);
    CHECK(distance(T_AB * T_AB.inverse(), identity) <= most);
    CHECK(distance(T_AB.inverse() * T_AB, identity) <= most);
    CHECK(distance(T_AB.inverse().inverse(), T_AB) <= most);
    CHECK(distance((T_AB * T_BC) * T_CD, T_AB * (T_BC * T_CD)) <= most);
    CHECK(distance((T_AB * T_BC).inverse(), T_BC.inverse() * T_AB.inverse()) <= most);
    const VectorOf<Scalar, 3> p_C(Scalar(0.3), Scalar(-0.7), Scalar(1.1));
    CHECK(((T_AB * T_BC) * p_C - T_AB * (T_BC * p_C)).norm() <= most);
    const MatrixOf<Scalar, 4> difference = (T_AB * T_BC).matrix() - T_AB.matrix() * T_BC.matrix();
    CHECK(difference.cwiseAbs().maxCoeff() <= most);
  }
}

}  // namespace

TEST_CASE("VQS transforms are a group: at identity, near it, at random, near pi") {
  for (const double angle : {0.0, 1e-9, 1e-6, 1e-3, 0.7, 2.0, std::numbers::pi - 1e-9, std::numbers::pi}) {
    check_group<double>(angle, 1e-14);  // a dozen roundings of numbers up to about 5
    check_group<float>(angle, 1e-5F);
  }
}

TEST_CASE("000 section 4 in closed form: p_A = s (q p_B q^-1) + v") {
  // A quarter turn about +Z, twice the size, moved to (1, 2, 3).
  const Vqs T_AB(Vector3(1, 2, 3), so3::exp<double>(Vector3(0, 0, std::numbers::pi / 2)), 2.0);
  CHECK((T_AB * Vector3(1, 0, 0) - Vector3(1, 4, 3)).norm() < 1e-15);
  CHECK((T_AB * Vector3(0, 1, 5) - Vector3(-1, 2, 13)).norm() < 2e-15);
  // Composition: [v_AB + s_AB q_AB v_BC, q_AB q_BC, s_AB s_BC].
  const Vqs T_BC(Vector3(0.5, 0, 0), so3::exp<double>(Vector3(0, 0, std::numbers::pi / 2)), 0.25);
  const Vqs T_AC = T_AB * T_BC;
  CHECK((T_AC.v() - Vector3(1, 3, 3)).norm() < 1e-15);
  CHECK(T_AC.s() == 0.5);
  CHECK((T_AC * Vector3(1, 0, 0) - Vector3(0.5, 3, 3)).norm() < 1e-15);  // a half turn at half size
}

TEST_CASE("the inverse is not made of the members' inverses (000 section 7.4)") {
  const Vqs T_AB(Vector3(1, 2, 3), so3::exp<double>(Vector3(0, 0, std::numbers::pi / 2)), 2.0);
  const Vqs T_BA = T_AB.inverse();
  CHECK(T_BA.s() == 0.5);
  // q^-1 (-v / s): (-0.5, -1, -1.5) turned a quarter clockwise.
  CHECK((T_BA.v() - Vector3(-1, 0.5, -1.5)).norm() < 1e-15);
  const Vqs member_wise(Vector3(-T_AB.v()), T_AB.q().conjugate(), 1.0 / T_AB.s());
  CHECK(distance(T_AB * member_wise, Vqs()) > 1.0);
}

TEST_CASE("a rigid transform is a VQS of scale 1, also in mixed products") {
  const Rigid X_AB(so3::exp<double>(Vector3(0.1, -0.4, 2.0)), Vector3(1, 2, 3));
  const Vqs T_BC(Vector3(0.5, 1, 0), so3::exp<double>(Vector3(0.3, 0, 0.2)), 0.25);
  const Vector3 p_C(1, -2, 0.5);
  CHECK((X_AB * T_BC * p_C - X_AB * (T_BC * p_C)).norm() < 1e-14);
  CHECK((T_BC * X_AB * p_C - T_BC * (X_AB * p_C)).norm() < 1e-14);
  CHECK(distance(Vqs(X_AB.inverse()), Vqs(X_AB).inverse()) < 1e-15);
  CHECK(Vqs(X_AB).s() == 1.0);
  CHECK((T_BC.rigid().p() - T_BC.v()).norm() == 0.0);
}

TEST_CASE("a chain of a million products stays unit") {
  std::mt19937 random(22);
  const Vqs step(Vector3(1e-6, 0, 0), so3::exp<double>(Vector3(0.004, 0.003, -0.01)), 1.0);
  Vqs T;
  Vqsf T_f;
  const Vqsf step_f = step.cast<float>();
  for (int i = 0; i < 1'000'000; ++i) {
    T = T * step;
    T_f = T_f * step_f;
  }
  CHECK(std::abs(T.q().norm() - 1.0) < 1e-15);
  CHECK(std::abs(T_f.q().norm() - 1.0F) < 3e-7F);
  CHECK(T.s() == 1.0);
}

TEST_CASE("make refuses bad numbers") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Vector3 v(1, 2, 3);
  const Quaternion q = Quaternion::Identity();
  CHECK(Vqs::make(v, q, 2.0));
  CHECK_FALSE(Vqs::make(v, q, 0.0));
  CHECK_FALSE(Vqs::make(v, q, -1.0));
  CHECK_FALSE(Vqs::make(v, q, nan));
  CHECK_FALSE(Vqs::make(v, q, inf));
  CHECK_FALSE(Vqs::make(Vector3(nan, 0, 0), q, 1.0));
  CHECK_FALSE(Vqs::make(v, Quaternion(0, 0, 0, 0), 1.0));
  CHECK_FALSE(Vqs::make(v, Quaternion(1, nan, 0, 0), 1.0));
  CHECK_FALSE(Vqs::make(v, Quaternion(0.3, 0.3, 0, 0), 1.0));
}

TEST_CASE("to a 4x4 matrix and back") {
  std::mt19937 random(23);
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, std::numbers::pi - 1e-9, std::numbers::pi}) {
    for (int i = 0; i < 10; ++i) {
      const Vqs T = random_vqs<double>(random, angle);
      const auto back = Vqs::from_matrix(T.matrix());
      REQUIRE(back);
      CHECK(distance(*back, T) < 3e-15);
      const auto back_f = Vqsf::from_matrix(T.cast<float>().matrix());
      REQUIRE(back_f);
      CHECK(distance(back_f->cast<double>(), T) < 2e-6);  // ten float roundings
    }
  }
  // Scale may be far from 1: millimetres, kilometres.
  const Vqs small(Vector3(1, 2, 3), so3::exp<double>(Vector3(0.3, 2, 1)), 1e-9);
  REQUIRE(Vqs::from_matrix(small.matrix()));
  CHECK(distance(*Vqs::from_matrix(small.matrix()), small) < 3e-15);
}

TEST_CASE("from_matrix refuses what VQS cannot hold") {
  std::mt19937 random(24);
  const Matrix4 good = random_vqs<double>(random, 1.0).matrix();
  REQUIRE(Vqs::from_matrix(good));
  const Matrix3 A = good.topLeftCorner<3, 3>();
  const auto with_block = [&good](const Matrix3& block) {
    Matrix4 m = good;
    m.topLeftCorner<3, 3>() = block;
    return Vqs::from_matrix(m);
  };
  const auto with_element = [&good](int row, int column, double value) {
    Matrix4 m = good;
    m(row, column) = value;
    return Vqs::from_matrix(m);
  };
  Matrix3 shear = Matrix3::Identity();
  shear(0, 1) = 0.01;
  const Vector3 stretch(1.0, 1.0, 1.01);
  const Vector3 mirror(1.0, 1.0, -1.0);
  CHECK_FALSE(with_block(A * shear));
  CHECK_FALSE(with_block(A * stretch.asDiagonal()));
  CHECK_FALSE(with_block(A * mirror.asDiagonal()));
  CHECK_FALSE(with_block(Matrix3::Zero()));
  CHECK_FALSE(with_block(A * 1e150));   // the determinant overflows
  CHECK_FALSE(with_block(A * 1e-150));  // it underflows
  CHECK_FALSE(with_element(3, 1, 0.01));
  CHECK_FALSE(with_element(3, 3, 0.5));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      CHECK_FALSE(with_element(row, column, nan));
      CHECK_FALSE(with_element(row, column, std::numeric_limits<double>::infinity()));
    }
  }
}

TEST_CASE("interpolation: vector linear, rotation at constant rate, scale at constant ratio") {
  const Vqs a(Vector3(0, 0, 0), Quaternion::Identity(), 1.0);
  const Vqs b(Vector3(2, 4, 6), so3::exp<double>(Vector3(0, 1.0, 0)), 16.0);
  CHECK(distance(interpolate(a, b, 0.0), a) < 1e-15);
  CHECK(distance(interpolate(a, b, 1.0), b) < 1e-15);
  const Vqs quarter(Vector3(0.5, 1, 1.5), so3::exp<double>(Vector3(0, 0.25, 0)), 2.0);
  CHECK(distance(interpolate(a, b, 0.25), quarter) < 1e-15);
  const Vqs beyond(Vector3(3, 6, 9), so3::exp<double>(Vector3(0, 1.5, 0)), 64.0);
  CHECK(distance(interpolate(a, b, 1.5), beyond) < 1e-14);
}

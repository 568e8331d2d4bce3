#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/geometry/so3.hpp>

using namespace holdfast;

namespace {

constexpr double pi = std::numbers::pi;

template <typename Scalar>
VectorOf<Scalar, 3> random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Vector3 v(normal(random), normal(random), normal(random));
  const Vector3 unit = v.normalized();
  return unit.cast<Scalar>();
}

/// Angles at which the formulas change branch or lose digits, and ordinary ones.
const std::vector<double> telling_angles = {0.0,  1e-12,  1e-9, 1e-6, 1e-4,      2e-3,      3.1e-3,    3.2e-3,
                                            9e-3, 1.1e-2, 0.09, 0.11, 0.31,      0.32,      0.49,      0.51,
                                            1.0,  2.0,    3.0,  3.14, pi - 1e-3, pi - 1e-6, pi - 1e-9, pi - 1e-12};

template <typename Scalar>
void check_round_trip(Scalar relative, Scalar absolute) {
  std::mt19937 random(1);
  for (const double angle : telling_angles) {
    for (int i = 0; i < 20; ++i) {
      const VectorOf<Scalar, 3> phi = random_direction<Scalar>(random) * Scalar(angle);
      const QuaternionOf<Scalar> q = so3::exp<Scalar>(phi);
      CHECK(std::abs(q.norm() - Scalar(1)) <= absolute);
      const VectorOf<Scalar, 3> back = so3::log<Scalar>(q);
      INFO("angle " << angle << " off by " << (back - phi).norm());
      CHECK((back - phi).norm() <= relative * phi.norm());
      // q and -q are one rotation.
      const QuaternionOf<Scalar> negative(-q.w(), -q.x(), -q.y(), -q.z());
      CHECK((so3::log<Scalar>(negative) - phi).norm() <= relative * phi.norm());
    }
  }
}

}  // namespace

TEST_CASE("exp and log undo each other, from nothing to pi") {
  // A few roundings of the scalar type, relative to the vector itself: tiny rotations keep all their digits.
  check_round_trip<double>(1e-15, 1e-15);
}

TEST_CASE("exp and log undo each other in float") {
  // Near pi a float angle may round to above pi, where log rightly answers the other way round: leave those out.
  std::mt19937 random(2);
  for (const double angle : telling_angles) {
    if (angle > pi - 1e-5) continue;
    for (int i = 0; i < 20; ++i) {
      const VectorOf<float, 3> phi = random_direction<float>(random) * static_cast<float>(angle);
      const QuaternionOf<float> q = so3::exp<float>(phi);
      INFO("angle " << angle);
      CHECK(std::abs(q.norm() - 1.0F) < 3e-7F);                        // 2-3 float roundings
      CHECK((so3::log<float>(q) - phi).norm() <= 1e-6F * phi.norm());  // 8 float roundings
    }
  }
}

TEST_CASE("exp is Rodrigues' formula and agrees with an axis and angle") {
  std::mt19937 random(3);
  for (const double angle : telling_angles) {
    const Vector3 axis = random_direction<double>(random);
    const Vector3 phi = angle * axis;
    const Matrix3 h = so3::hat<double>(axis);
    const Matrix3 rodrigues = Matrix3::Identity() + std::sin(angle) * h + (1.0 - std::cos(angle)) * h * h;
    const Matrix3 R = so3::exp<double>(phi).toRotationMatrix();
    CHECK((R - rodrigues).cwiseAbs().maxCoeff() < 2e-15);  // elements of size 1, a few roundings
  }
  const Quaternion quarter_turn = so3::exp<double>(Vector3(0, 0, pi / 2));
  CHECK((quarter_turn * Vector3(1, 0, 0) - Vector3(0, 1, 0)).norm() < 1e-15);  // anticlockwise about +Z
}

TEST_CASE("exp of one axis adds angles") {
  std::mt19937 random(4);
  const Vector3 axis = random_direction<double>(random);
  for (const double a : {1e-9, 1e-4, 0.3, 1.7}) {
    for (const double b : {-0.2, 1e-6, 1.1}) {
      const Quaternion product = so3::exp<double>(a * axis) * so3::exp<double>(b * axis);
      CHECK((so3::log<double>(product) - (a + b) * axis).norm() < 2e-15);
    }
  }
}

TEST_CASE("at exactly pi log gives length pi about the axis, with either sign") {
  const Vector3 axis = Vector3(2, -1, 0.5).normalized();
  const Vector3 phi = so3::log<double>(Quaternion(0.0, axis.x(), axis.y(), axis.z()));
  CHECK(std::abs(phi.norm() - pi) < 1e-15);
  CHECK(phi.cross(axis).norm() < 1e-15);
}

TEST_CASE("hat is the cross product") {
  std::mt19937 random(5);
  for (int i = 0; i < 10; ++i) {
    const Vector3 a = random_direction<double>(random);
    const Vector3 b = random_direction<double>(random);
    CHECK((so3::hat<double>(a) * b - a.cross(b)).norm() < 1e-15);
    CHECK((so3::hat<double>(a) + so3::hat<double>(a).transpose()).norm() == 0.0);
  }
}

TEST_CASE("Jacobians are the derivatives they say, at ordinary, small and large angles") {
  std::mt19937 random(6);
  for (const double angle :
       {0.0, 1e-9, 1e-6, 1e-3, 3.1e-3, 3.3e-3, 0.0099, 0.0101, 0.3, 0.49, 0.51, 1.5, 3.0, pi - 1e-6, pi}) {
    const Vector3 phi = angle * random_direction<double>(random);
    const Quaternion q = so3::exp<double>(phi);
    // Perturbation d of phi, seen as a small rotation on the left of exp(phi), and on its right.
    const auto on_left = [&](const Vector3& d) -> Vector3 {
      const Vector3 sum = phi + d;
      return so3::log<double>(so3::exp<double>(sum) * q.conjugate());
    };
    const auto on_right = [&](const Vector3& d) -> Vector3 {
      const Vector3 sum = phi + d;
      return so3::log<double>(q.conjugate() * so3::exp<double>(sum));
    };
    const Vector3 zero = Vector3::Zero();
    INFO("angle " << angle);
    // Truncation h^2/6 with h = 6e-6 and rounding 1e-16/h: both below 1e-10.
    CHECK((numeric_jacobian(on_left, zero) - so3::left_jacobian<double>(phi)).cwiseAbs().maxCoeff() < 1e-10);
    CHECK((numeric_jacobian(on_right, zero) - so3::right_jacobian<double>(phi)).cwiseAbs().maxCoeff() < 1e-10);
    // The inverses are checked as inverses: log itself has a fold at pi, across which no difference can be taken.
    const Matrix3 left = so3::left_jacobian<double>(phi) * so3::left_jacobian_inverse<double>(phi);
    const Matrix3 right = so3::right_jacobian_inverse<double>(phi) * so3::right_jacobian<double>(phi);
    CHECK((left - Matrix3::Identity()).cwiseAbs().maxCoeff() < 1e-14);
    CHECK((right - Matrix3::Identity()).cwiseAbs().maxCoeff() < 1e-14);
  }
}

TEST_CASE("inverse Jacobians are derivatives of log") {
  std::mt19937 random(7);
  for (const double angle : {0.0, 1e-9, 1e-5, 1e-3, 0.0101, 0.4, 1.5, 3.0, pi - 1e-3}) {
    const Vector3 phi = angle * random_direction<double>(random);
    const Quaternion q = so3::exp<double>(phi);
    const auto left = [&](const Vector3& d) -> Vector3 { return so3::log<double>(so3::exp<double>(d) * q); };
    const auto right = [&](const Vector3& d) -> Vector3 { return so3::log<double>(q * so3::exp<double>(d)); };
    const Vector3 zero = Vector3::Zero();
    INFO("angle " << angle);
    // Rounding of log, about 4e-16 for lengths near pi, over h = 6e-6: below 3e-10.
    CHECK((numeric_jacobian(left, zero) - so3::left_jacobian_inverse<double>(phi)).cwiseAbs().maxCoeff() < 3e-10);
    CHECK((numeric_jacobian(right, zero) - so3::right_jacobian_inverse<double>(phi)).cwiseAbs().maxCoeff() < 3e-10);
  }
}

TEST_CASE("left and right Jacobians differ by the rotation itself") {
  std::mt19937 random(8);
  for (const double angle : telling_angles) {
    const Vector3 phi = angle * random_direction<double>(random);
    const Matrix3 R = so3::exp<double>(phi).toRotationMatrix();
    CHECK((so3::left_jacobian<double>(phi) - R * so3::right_jacobian<double>(phi)).cwiseAbs().maxCoeff() < 2e-15);
  }
}

TEST_CASE("float Jacobians agree with double ones at every angle") {
  std::mt19937 random(9);
  for (const double angle : telling_angles) {
    const VectorOf<float, 3> phi_f = random_direction<float>(random) * static_cast<float>(angle);
    const Vector3 phi = phi_f.cast<double>();
    const Matrix3 left_f = so3::left_jacobian<float>(phi_f).cast<double>();
    const Matrix3 inverse_f = so3::left_jacobian_inverse<float>(phi_f).cast<double>();
    INFO("angle " << angle);
    // Elements up to 2 with a few float roundings; a wrong branch limit would show as 1e-4 and more.
    CHECK((left_f - so3::left_jacobian<double>(phi)).cwiseAbs().maxCoeff() < 5e-7);
    CHECK((inverse_f - so3::left_jacobian_inverse<double>(phi)).cwiseAbs().maxCoeff() < 2e-6);
  }
}

TEST_CASE("interpolation runs at constant rate by the shorter way and extrapolates") {
  std::mt19937 random(10);
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0}) {
    const Quaternion a = so3::exp<double>(random_direction<double>(random) * 2.0);
    const Vector3 step = random_direction<double>(random) * angle;
    const Quaternion b = a * so3::exp<double>(step);
    for (const double s : {-0.5, 0.0, 0.25, 1.0, 1.5}) {
      const Quaternion expected = a * so3::exp<double>(Vector3(s * step));
      CHECK(so3::angle_between<double>(so3::interpolate<double>(a, b, s), expected) < 2e-15);
      const Quaternion minus_b(-b.w(), -b.x(), -b.y(), -b.z());
      CHECK(so3::angle_between<double>(so3::interpolate<double>(a, minus_b, s), expected) < 2e-15);
    }
  }
}

TEST_CASE("angle_between keeps digits of tiny angles, which acos would lose") {
  const Quaternion a = so3::exp<double>(Vector3(0.3, -1.0, 0.2));
  const Quaternion b = a * so3::exp<double>(Vector3(0, 1e-9, 0));
  CHECK(so3::angle_between<double>(a, b) == doctest::Approx(1e-9).epsilon(1e-6));  // a and b carry roundings of 1e-16
  CHECK(so3::angle_between<double>(a, a * so3::exp<double>(Vector3(2, 0, 0))) == doctest::Approx(2.0).epsilon(1e-15));
}

TEST_CASE("is_rotation tells rotations from other matrices") {
  const Matrix3 R = so3::exp<double>(Vector3(0.3, -1.0, 0.2)).toRotationMatrix();
  CHECK(so3::is_rotation<double>(R, 1e-12));
  CHECK_FALSE(so3::is_rotation<double>(Matrix3(-R), 1e-12));
  CHECK_FALSE(so3::is_rotation<double>(Matrix3(1.001 * R), 1e-6));
  CHECK_FALSE(so3::is_rotation<double>(Matrix3(Matrix3::Zero()), 1e-6));
  Matrix3 with_nan = R;
  with_nan(1, 1) = std::nan("");
  CHECK_FALSE(so3::is_rotation<double>(with_nan, 1e-6));
}

TEST_CASE("the shortest rotation between two directions") {
  std::mt19937 random(21);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 a(normal(random), normal(random), normal(random));
    const Vector3 other(normal(random), normal(random), normal(random));
    // Every other pair nearly or exactly opposite.
    const double off = i % 4 == 1 ? 0.0 : std::pow(10.0, -static_cast<double>(i % 17));
    const Vector3 b = i % 2 == 0 ? other : Vector3(-2.0 * a + off * other);
    const Quaternion q = so3::between<double>(a, b);
    CHECK(q.norm() == doctest::Approx(1.0).epsilon(1e-14));
    CHECK((q * a.normalized() - b.normalized()).norm() < 1e-14);
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    CHECK(std::abs(so3::log<double>(q).norm() - angle) < 1e-13);
  }
}

#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/geometry/numeric_jacobian.hpp>

using namespace holdfast;

TEST_CASE("a linear map is its own Jacobian, of any shape") {
  MatrixOf<double, 2, 3> A;
  A << 1, -2, 3, 0.5, 4, -1;
  const auto f = [&A](const Vector3& x) -> Vector2 { return A * x; };
  const MatrixOf<double, 2, 3> J = numeric_jacobian(f, Vector3(0.1, 20, -3));
  CHECK((J - A).cwiseAbs().maxCoeff() < 2e-9);  // values near 80 round to 1e-14, over twice a step of 6e-6
}

TEST_CASE("a curved map: polar to Cartesian") {
  const auto f = [](const Vector2& x) { return Vector2(x[0] * std::cos(x[1]), x[0] * std::sin(x[1])); };
  const Vector2 x(2.0, 0.7);
  Matrix2 expected;
  expected << std::cos(0.7), -2 * std::sin(0.7), std::sin(0.7), 2 * std::cos(0.7);
  CHECK((numeric_jacobian(f, x) - expected).cwiseAbs().maxCoeff() < 1e-10);
  // With a coarse step the error is h^2/6 times the third derivative, here 2: central, not one-sided (which would give
  // 1e-3).
  CHECK((numeric_jacobian(f, x, 1e-3) - expected).cwiseAbs().maxCoeff() < 4e-7);
}

TEST_CASE("a number as output gives a row; float works") {
  const auto length = [](const Vector3& x) { return x.norm(); };
  const MatrixOf<double, 1, 3> J = numeric_jacobian(length, Vector3(3, 0, 4));
  CHECK((J - MatrixOf<double, 1, 3>(0.6, 0, 0.8)).norm() < 1e-10);
  const auto square = [](const VectorOf<float, 1>& x) -> VectorOf<float, 1> { return VectorOf<float, 1>(x[0] * x[0]); };
  CHECK(std::abs(numeric_jacobian(square, VectorOf<float, 1>(3.0F))(0, 0) - 6.0F) <
        1e-3F);  // cube root of epsilon squared
}

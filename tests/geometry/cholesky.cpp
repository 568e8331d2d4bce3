#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/cholesky.hpp>

using namespace holdfast;

namespace {

template <int Rows, int Columns>
MatrixOf<double, Rows, Columns> random_matrix(std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  MatrixOf<double, Rows, Columns> A;
  for (int i = 0; i < Rows; ++i) {
    for (int j = 0; j < Columns; ++j) A(i, j) = any(random);
  }
  return A;
}

template <int Size>
MatrixOf<double, Size> random_covariance(std::mt19937& random) {
  const MatrixOf<double, Size> A = random_matrix<Size, Size>(random);
  MatrixOf<double, Size> S = MatrixOf<double, Size>::Identity() * 0.1;
  S += A.lazyProduct(A.transpose());
  return S;
}

template <int Size>
void check_factor() {
  std::mt19937 random(7);
  for (int sample = 0; sample < 50; ++sample) {
    const MatrixOf<double, Size> S = random_covariance<Size>(random);
    MatrixOf<double, Size> L;
    REQUIRE(cholesky<Size>(S, L));
    // Condition is at most about 10 Size^2: a thousand roundings.
    CHECK((L.lazyProduct(L.transpose()) - S).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((S.lazyProduct(inverse_by<Size>(L)) - MatrixOf<double, Size>::Identity()).cwiseAbs().maxCoeff() < 1e-11);
    const VectorOf<double, Size> v = random_matrix<Size, 1>(random);
    const VectorOf<double, Size> x = solved_by<Size, 1>(L, v);
    CHECK((S.lazyProduct(x) - v).cwiseAbs().maxCoeff() < 1e-11);
    CHECK(squared_distance<Size>(L, v) == doctest::Approx(v.dot(x)).epsilon(1e-11));
    const VectorOf<double, Size> back = L.transpose().lazyProduct(back_substituted<Size, 1>(L, v));
    CHECK((back - v).cwiseAbs().maxCoeff() < 1e-11);
  }
}

}  // namespace

TEST_CASE("a factor gives back its matrix, and solves by it") {
  check_factor<1>();
  check_factor<3>();
  check_factor<12>();
}

TEST_CASE("only the lower triangle is read, and zeros are above it") {
  std::mt19937 random(8);
  Matrix3 S = random_covariance<3>(random), L, L_of_lower;
  REQUIRE(cholesky<3>(S, L));
  S(0, 1) = S(0, 2) = S(1, 2) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(cholesky<3>(S, L_of_lower));
  CHECK(L == L_of_lower);
  CHECK(L(0, 2) == 0.0);
}

TEST_CASE("what is no covariance has no factor") {
  Matrix3 L;
  CHECK_FALSE(cholesky<3>(Matrix3::Zero(), L));
  CHECK_FALSE(cholesky<3>(Matrix3(-Matrix3::Identity()), L));
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
  for (const double number : bad) {
    for (int i = 0; i < 3; ++i) {
      Matrix3 S = Matrix3::Identity();
      S(i, 0) = number;
      CHECK_FALSE(cholesky<3>(S, L));
    }
  }
  Matrix3 indefinite = Matrix3::Identity();
  indefinite(1, 0) = 1.0 + 1e-12;
  CHECK_FALSE(cholesky<3>(indefinite, L));
}

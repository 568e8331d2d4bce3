#include <array>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/optics/lens.hpp>

using namespace holdfast;

TEST_CASE("each problem has a description of its own") {
  std::vector<std::string_view> seen;
  for (const LensProblem p :
       {LensProblem::none, LensProblem::not_finite, LensProblem::too_many_coefficients, LensProblem::folds_at_centre,
        LensProblem::zero_scale, LensProblem::radius_not_positive}) {
    const std::string_view text = describe(p);
    CHECK(text != "unknown problem");
    for (const std::string_view other : seen) CHECK(other != text);
    seen.push_back(text);
  }
}

TEST_CASE("polynomials, radial lenses and placements name their problems") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(RadialLens::problem_of(0.2) == LensProblem::none);
  CHECK(RadialLens::problem_of(nan) == LensProblem::not_finite);
  CHECK(PolynomialLens::problem_of(std::array{0.1, 0.2}) == LensProblem::none);
  CHECK(PolynomialLens::problem_of(std::array{0.1, nan}) == LensProblem::not_finite);
  CHECK(PolynomialLens::problem_of(std::array{0.1}, 0.0) == LensProblem::folds_at_centre);
  CHECK(PolynomialLens::problem_of(std::array{0.1}, nan) == LensProblem::not_finite);
  CHECK(PolynomialLens::problem_of(std::vector<double>(16, 0.0)) == LensProblem::none);
  CHECK(PolynomialLens::problem_of(std::vector<double>(17, 0.0)) == LensProblem::too_many_coefficients);
  CHECK(problem_of(LensPlacement{}) == LensProblem::none);
  CHECK(problem_of(LensPlacement{Vector2::Zero(), Vector2(-1.0, 2.0)}) == LensProblem::none);
  CHECK(problem_of(LensPlacement{Vector2::Zero(), Vector2(1.0, 0.0)}) == LensProblem::zero_scale);
  CHECK(problem_of(LensPlacement{Vector2(nan, 0.0), Vector2(1.0, 1.0)}) == LensProblem::not_finite);
  CHECK(problem_of(LensPlacement{Vector2::Zero(), Vector2(1.0, nan)}) == LensProblem::not_finite);
}

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/optics/tangents.hpp>

using namespace holdfast;

namespace {
// The numbers below are computed in doubles from doubles: a few roundings.
constexpr double rounding = 1e-14;
const double nan_value = std::numeric_limits<double>::quiet_NaN();
}  // namespace

TEST_CASE("the Flight Helmet's virtual image gives 66.3 by 53.5 degrees") {
  const FieldTangents t = tangents_of(VirtualImage{1.57, 1.19, -1.18, -0.187, 0.0}).value();
  CHECK(t.left == doctest::Approx(-(0.785 + 0.187) / 1.18).epsilon(rounding));
  CHECK(t.right == doctest::Approx((0.785 - 0.187) / 1.18).epsilon(rounding));
  // Table 8.1's numbers have three digits: 0.05 degrees.
  CHECK(fov_horizontal(t).degrees() == doctest::Approx(66.35).epsilon(0.05 / 66));
  CHECK(fov_vertical(t).degrees() == doctest::Approx(53.5).epsilon(0.05 / 53));
  // The paper's own formulas for the four parts (7.7).
  CHECK(fov_left(t).radians() == doctest::Approx(std::atan((1.57 / 2 + 0.187) / 1.18)).epsilon(rounding));
  CHECK(fov_right(t).radians() == doctest::Approx(std::atan((1.57 / 2 - 0.187) / 1.18)).epsilon(rounding));
}

TEST_CASE("image_of undoes tangents_of at any distance") {
  const VirtualImage image{1.57, 1.19, -1.18, -0.187, 0.03};
  const VirtualImage back = image_of(tangents_of(image).value(), image.z_p);
  CHECK(back.w_x == doctest::Approx(image.w_x).epsilon(rounding));
  CHECK(back.w_y == doctest::Approx(image.w_y).epsilon(rounding));
  CHECK(back.x_cw == doctest::Approx(image.x_cw).epsilon(rounding));
  CHECK(back.y_cw == doctest::Approx(image.y_cw).epsilon(rounding));
}

TEST_CASE("x_cw follows half the IPD, oppositely for the two eyes") {
  const double x_H_CW = 0.218;  // the Flight Helmet's: |x_cw| = 0.187 at IPD 62 mm
  CHECK(x_cw_of_ipd(-x_H_CW, 0.062, EyeSide::left) == doctest::Approx(-0.187).epsilon(rounding));
  CHECK(x_cw_of_ipd(x_H_CW, 0.062, EyeSide::right) == doctest::Approx(0.187).epsilon(rounding));
  CHECK(x_cw_of_ipd(-x_H_CW, 0.072, EyeSide::left) - x_cw_of_ipd(-x_H_CW, 0.062, EyeSide::left) ==
        doctest::Approx(0.005).epsilon(1e-12));  // a difference of two numbers of size 0.2
}

TEST_CASE("angles and tangents say the same") {
  const FieldTangents t = tangents_of(FieldAngles{degrees(-50), degrees(35), degrees(-45), degrees(40)}).value();
  CHECK(t.left == doctest::Approx(-1.1917535925942100).epsilon(rounding));
  CHECK(t.down == doctest::Approx(-1.0).epsilon(rounding));
  const FieldAngles back = angles_of(t);
  CHECK(back.left.degrees() == doctest::Approx(-50).epsilon(rounding));
  CHECK(back.right.degrees() == doctest::Approx(35).epsilon(rounding));
  CHECK(back.up.degrees() == doctest::Approx(40).epsilon(rounding));
}

TEST_CASE("swapped angles are a mirrored picture, not an error") {
  const FieldResult result = tangents_of(FieldAngles{degrees(35), degrees(-50), degrees(40), degrees(-45)});
  REQUIRE(result.ok());
  CHECK(is_mirrored_x(result.value()));
  CHECK(is_mirrored_y(result.value()));
  CHECK_FALSE(is_mirrored_x(symmetric_tangents(degrees(90), degrees(60)).value()));
}

TEST_CASE("a symmetric field is centred") {
  const FieldTangents t = symmetric_tangents(degrees(90), degrees(60)).value();
  CHECK(t.right == doctest::Approx(1.0).epsilon(rounding));
  CHECK(t.left == -t.right);
  CHECK(t.up == doctest::Approx(1.0 / std::sqrt(3.0)).epsilon(rounding));
  CHECK(t.down == -t.up);
}

TEST_CASE("impossible fields name their problem") {
  CHECK(problem_of(FieldTangents{0.5, 0.5, -1, 1}) == FieldProblem::zero_width);
  CHECK(problem_of(FieldTangents{-1, 1, 0.1, 0.1}) == FieldProblem::zero_height);
  CHECK(problem_of(FieldTangents{-1, nan_value, -1, 1}) == FieldProblem::not_finite);
  CHECK(tangents_of(FieldAngles{degrees(-90), degrees(35), degrees(-45), degrees(40)}).problem ==
        FieldProblem::angle_beyond_90);
  CHECK(tangents_of(FieldAngles{degrees(nan_value), degrees(35), degrees(-45), degrees(40)}).problem ==
        FieldProblem::not_finite);
  CHECK(symmetric_tangents(degrees(180), degrees(60)).problem == FieldProblem::angle_beyond_90);
  CHECK(symmetric_tangents(degrees(0), degrees(60)).problem == FieldProblem::zero_width);
  CHECK(tangents_of(VirtualImage{1, 1, 1.0, 0, 0}).problem == FieldProblem::image_not_in_front);
  CHECK(tangents_of(VirtualImage{1, 1, 0.0, 0, 0}).problem == FieldProblem::image_not_in_front);
  CHECK(tangents_of(VirtualImage{-1, 1, -1.0, 0, 0}).problem == FieldProblem::extent_not_positive);
  CHECK(tangents_of(VirtualImage{1, 1, nan_value, 0, 0}).problem == FieldProblem::not_finite);
  CHECK(describe(FieldProblem::angle_beyond_90).find("90 degrees") != std::string_view::npos);
}

TEST_CASE("mirroring twice changes nothing") {
  const FieldTangents t{-1.2, 0.8, -0.9, 1.1};
  CHECK(mirrored(t) == FieldTangents{-0.8, 1.2, -0.9, 1.1});
  CHECK(mirrored(mirrored(t)) == t);
}

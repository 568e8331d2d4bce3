#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/coverage.hpp>

using namespace holdfast;

TEST_CASE("an eye's own picture covers its view, with and without an exactly corrected lens") {
  const EyeModel eye = default_hmd().left;
  CHECK(coverage_missing_pct(eye, LensMode::none) == 0.0);
  CHECK(coverage_missing_pct(eye, LensMode::exact) == 0.0);
}

TEST_CASE("half a picture covers half the view, mirrored or not") {
  const EyeModel eye = default_hmd().left;
  FieldTangents half = eye.tangents;
  half.right = 0.0;
  CHECK(coverage_missing_pct(eye, LensMode::none, half) == doctest::Approx(50.0));
  const FieldTangents turned{half.right, half.left, half.up, half.down};  // edges swapped: the picture is mirrored
  CHECK(coverage_missing_pct(eye, LensMode::none, turned) == doctest::Approx(50.0));
}

TEST_CASE("a picture deflected by 1 degree uncovers about a sixtieth of 60 degrees, unless it was drawn larger") {
  const EyeModel eye = default_hmd().left;
  const Quaternion q_SE = so3::exp<double>(Vector3(0.0, degrees(1.0).radians(), 0.0));
  const double missing = coverage_missing_pct(eye, LensMode::none, eye.tangents, q_SE);
  // At the side (tan 30 - tan 29) / (2 tan 30) = 2.0 %; at that side's corners the keystone takes up to 1 % of the
  // height more, and the grid's columns are 0.8 % wide.
  CHECK(missing > 1.2);
  CHECK(missing < 3.2);
  FieldTangents larger = eye.tangents;
  for (double* edge : {&larger.left, &larger.right, &larger.down, &larger.up}) *edge *= 1.05;
  CHECK(coverage_missing_pct(eye, LensMode::none, larger, q_SE) == 0.0);
}

#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/coverage.hpp>
#include <holdfast/deflection/deflect.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

namespace {
Coverage coverage_of(const EyeModel& eye, LensMode mode, const FieldTangents& rendered, const Rigid& X_WE = {}) {
  const RenderedView view{{}, rendered, eye.resolution, {}};
  const DeflectionResult result = deflect({}, view, LatePoses::at_once(X_WE));
  REQUIRE(result.ok());
  return coverage(ComposedWarp(eye, mode, DisplayTiming{}, view, result.H_SE));
}
}  // namespace

TEST_CASE("an eye's own picture covers its view, with and without an exactly corrected lens") {
  const EyeModel eye = default_hmd().left;
  CHECK(coverage_of(eye, LensMode::none, eye.tangents).missing_pct() == 0.0);
  CHECK(coverage_of(eye, LensMode::exact, eye.tangents).missing_pct() == 0.0);
}

TEST_CASE("half a picture covers half the view, mirrored or not") {
  const EyeModel eye = default_hmd().left;
  FieldTangents half = eye.tangents;
  half.right = 0.0;
  CHECK(coverage_of(eye, LensMode::none, half).missing_pct() == doctest::Approx(50.0));
  const FieldTangents turned{half.right, half.left, half.up, half.down};  // edges swapped: the picture is mirrored
  CHECK(coverage_of(eye, LensMode::none, turned).missing_pct() == doctest::Approx(50.0));
}

TEST_CASE("a picture deflected by 1 degree uncovers about a sixtieth of 60 degrees, unless it was drawn larger") {
  const EyeModel eye = default_hmd().left;
  const Rigid X_WE = Rigid::rotation(so3::exp<double>(Vector3(0.0, degrees(1.0).radians(), 0.0)));
  const double missing = coverage_of(eye, LensMode::none, eye.tangents, X_WE).missing_pct();
  // At the side (tan 30 - tan 29) / (2 tan 30) = 2.0 %; at that side's corners the keystone takes up to 1 % of the
  // height more, and the grid's columns are 0.8 % wide.
  CHECK(missing > 1.2);
  CHECK(missing < 3.2);
  FieldTangents larger = eye.tangents;
  for (double* edge : {&larger.left, &larger.right, &larger.down, &larger.up}) *edge *= 1.05;
  CHECK(coverage_of(eye, LensMode::none, larger, X_WE).missing_pct() == 0.0);
}

TEST_CASE("the mask says which directions the numbers count") {
  const EyeModel eye = default_hmd({640, 480}).left;
  FieldTangents rendered = eye.tangents;
  rendered.up = 0.0;  // the lower half alone
  const RenderedView view{{}, rendered, {640, 240}, {}};
  const ComposedWarp warp(eye, LensMode::none, DisplayTiming{}, view, ScanHomography());
  std::vector<SourceState> mask(8 * 6);
  const Coverage counted = coverage(warp, {8, 6}, mask);
  CHECK(counted.directions == 48);
  CHECK(counted.covered == 24);
  CHECK(counted.outside == 24);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    CHECK(mask[i] == (i < 24 ? SourceState::covered : SourceState::outside));  // row 0 is the bottom
  }
}

TEST_CASE("directions that the lens cannot show count as missing") {
  EyeModel eye = default_hmd({640, 480}).left;
  eye.lens = Lens(RadialLens{-0.4}, placed_at(0.5));  // folds over inside the panel
  const RenderedView view{{}, eye.tangents, eye.resolution, {}};
  const ComposedWarp warp(eye, LensMode::exact, DisplayTiming{}, view, ScanHomography());
  const Coverage counted = coverage(warp);
  CHECK(counted.not_seen > 0);
  CHECK(counted.not_seen + counted.covered == counted.directions);
  CHECK(counted.missing_pct() == doctest::Approx(100.0 * double(counted.not_seen) / double(counted.directions)));
}

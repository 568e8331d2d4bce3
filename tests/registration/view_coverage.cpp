#include <doctest/doctest.h>

#include <holdfast/registration/view_coverage.hpp>

using namespace holdfast;

namespace {

ShownPicture picture_of(const EyeModel& eye, DeflectionKind kind, const Rigid& X_SE, const DeflectionBudget& budget) {
  ShownPicture picture;
  const FieldTangents wider = overfilled(eye.tangents, budget);
  picture.view = {Rigid(so3::exp<double>(Vector3(0.1, 0.2, 0.3)), Vector3(1, 2, 3)), wider, overfilled_size(eye, wider),
                  HostTime{}};
  picture.how.kind = kind;
  picture.late = LatePoses::at_once(picture.view.X_WS * X_SE);
  picture.deflection = deflect(picture.how, picture.view, picture.late);
  return picture;
}

Rigid yaw(double degrees_left) {
  return Rigid::rotation(so3::exp<double>(Vector3(0.0, degrees(degrees_left).radians(), 0.0)));
}

}  // namespace

TEST_CASE("without depth the numbers are those of the composed warp") {
  const EyeModel eye = default_hmd().left;
  const DisplayTiming timing;
  for (const LensMode lens : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
    for (const double turned : {0.0, 1.0, 7.0}) {
      const ShownPicture picture = picture_of(eye, DeflectionKind::rotation, yaw(turned), {});
      ViewCoverageMeter meter({eye, eye, lens, timing});
      const Coverage own = meter.measure(picture, {});
      const Coverage by_warp =
          coverage(ComposedWarp(eye, lens, timing, picture.view, picture.deflection.H_SE), {96, 54});
      CHECK(own.directions == by_warp.directions);
      CHECK(own.covered == by_warp.covered);
    }
  }
}

TEST_CASE("an eye's own picture covers its view; turned by 1 degree it misses a sixtieth, unless it was drawn larger") {
  const EyeModel eye = default_hmd().left;
  const DisplayTiming timing;
  ViewCoverageMeter meter({eye, eye, LensMode::exact, timing});
  CHECK(meter.measure(picture_of(eye, DeflectionKind::none, Rigid(), {}), {}).missing_pct() == 0.0);
  const Coverage turned = meter.measure(picture_of(eye, DeflectionKind::rotation, yaw(1.0), {}), {});
  // At the side (tan 30 - tan 29) / (2 tan 30) = 2.0 %; keystone and the grid's columns of 1 % add to either side.
  CHECK(turned.missing_pct() > 1.0);
  CHECK(turned.missing_pct() < 3.3);
  const DeflectionBudget enough{degrees(1.01), degrees(0.0), degrees(0.0)};
  CHECK(meter.measure(picture_of(eye, DeflectionKind::rotation, yaw(1.0), enough), {}).missing_pct() == 0.0);
}

TEST_CASE("a disc that moves aside reveals a strip as wide as its parallax") {
  const EyeModel eye = default_hmd().left;
  const DisplayTiming timing;
  ViewCoverageMeter meter({eye, eye, LensMode::none, timing}, {960, 540});
  // 20 mm aside: against infinity the disc at 0.5 m moves by 0.04 of tangent, less than its diameter of 0.4.
  const ShownPicture picture =
      picture_of(eye, DeflectionKind::depth, Rigid::translation(Vector3(0.02, 0.0, 0.0)), {degrees(5), {}, {}});
  Disc disc;
  disc.centre_W = picture.view.X_WS * Vector3(0.0, 0.0, -0.5);
  disc.normal_W = picture.view.X_WS.q() * Vector3::UnitZ();
  disc.radius_m = 0.1;
  RegistrationScene scene;
  scene.discs = {disc};
  // Two circles of radius r at distance d share 2 r^2 acos(d / 2r) - d/2 sqrt(4 r^2 - d^2); what one has alone shows.
  const double r = 0.2, d = 0.04;
  const double shared = 2.0 * r * r * std::acos(d / (2.0 * r)) - d / 2.0 * std::sqrt(4.0 * r * r - d * d);
  const FieldTangents& t = eye.tangents;
  const double view = (t.right - t.left) * (t.up - t.down);
  const double expected = 100.0 * (std::numbers::pi * r * r - shared) / view;
  const Coverage found = meter.measure(picture, scene);
  CHECK(found.disocclusion_pct() == doctest::Approx(expected).epsilon(0.02));  // a strip of 22 cells
  CHECK(found.missing_pct() == 0.0);
  // A turn alone reveals nothing.
  CHECK(
      meter.measure(picture_of(eye, DeflectionKind::depth, yaw(2.0), {degrees(5), {}, {}}), scene).disocclusion_pct() ==
      0.0);
}

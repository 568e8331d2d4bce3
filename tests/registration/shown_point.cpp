#include <random>

#include <doctest/doctest.h>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/shown_point.hpp>

using namespace holdfast;

namespace {

/// A picture drawn wider than the panel, deflected to an eye that turned and moved, and went on doing so during the scan.
ShownPicture picture_of(const EyeModel& eye, const DeflectionSettings& how, std::mt19937& random) {
  std::uniform_real_distribution<double> turn(-0.03, 0.03), move(-0.02, 0.02), part(-0.3, 0.3);
  const auto pose = [&](double size) {
    return Rigid(so3::exp<double>(size * Vector3(turn(random), turn(random), turn(random))),
                 size * Vector3(move(random), move(random), move(random)));
  };
  ShownPicture picture;
  const FieldTangents wider = overfilled(eye.tangents, {degrees(8), degrees(8), degrees(4)});
  picture.view = {Rigid(so3::exp<double>(Vector3(0.4, -1.1, 0.2)), Vector3(0.3, 1.6, -0.2)), wider,
                  overfilled_size(eye, wider), HostTime{}};
  picture.how = how;
  picture.late.X_WE_begin = picture.view.X_WS * pose(1.0);
  picture.late.X_WE_end = picture.late.X_WE_begin * pose(0.3);
  picture.deflection = deflect(how, picture.view, picture.late);
  REQUIRE(picture.is_deflected());
  return picture;
}

DisplayTiming timing_of(ScanOut scan_out, ScanDirection direction) {
  DisplayTiming timing;
  timing.scan_out = scan_out;
  timing.scan_duration = std::chrono::milliseconds(11);
  timing.scan_direction = direction;
  return timing;
}

}  // namespace

TEST_CASE("a point is seen where the composed warp says") {
  std::mt19937 random(5);
  const HmdModel hmd = default_hmd();
  for (const bool upside_down : {false, true}) {
    EyeModel eye = hmd.left;
    eye.upside_down = upside_down;
    for (const DeflectionKind kind :
         {DeflectionKind::shift, DeflectionKind::shift_roll, DeflectionKind::rotation, DeflectionKind::plane}) {
      for (const LensMode lens : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
        for (const ScanDirection direction : scan_directions) {
          const DisplayTiming timing = timing_of(ScanOut::rolling, direction);
          const ShownPicture picture = picture_of(eye, {kind, 1.3, true}, random);
          const ShownOn on{eye, eye, lens, timing};
          const ComposedWarp warp(eye, lens, timing, picture.view, picture.deflection.H_SE);
          std::uniform_real_distribution<double> tangent(-0.25, 0.25);
          for (int i = 0; i < 10; ++i) {
            const Vector2 t_S(tangent(random), tangent(random));
            const Vector3 p_W = picture.view.X_WS * Vector3(1.7 * direction_of_tangents(t_S));
            const auto seen = shown_point(picture, on, p_W);
            const auto expected = warp.seen_pixel(source_pixel_of_tangent(picture.view, t_S));
            REQUIRE(seen.has_value() == expected.has_value());
            // Line fractions agree to 1e-14; pixels to rounding.
            if (seen) CHECK((*seen - *expected).norm() < 1e-8);
          }
        }
      }
    }
  }
}

TEST_CASE("by depth a point is seen where the late eye of its line has it") {
  std::mt19937 random(6);
  const EyeModel eye = default_hmd().left;
  const DisplayTiming timing = timing_of(ScanOut::rolling, ScanDirection::top_to_bottom);
  const ShownPicture picture = picture_of(eye, {DeflectionKind::depth, 2.0, true}, random);
  const ShownOn on{eye, eye, LensMode::exact, timing};
  std::uniform_real_distribution<double> tangent(-0.25, 0.25), depth(0.4, 5.0);
  for (int i = 0; i < 50; ++i) {
    const Vector3 p_W =
        picture.view.X_WS * Vector3(depth(random) * direction_of_tangents(Vector2(tangent(random), tangent(random))));
    const auto seen = shown_point(picture, on, p_W);
    REQUIRE(seen);
    const double s = on.line_fraction(*drawn_pixel(eye, LensMode::exact, *seen));
    const Rigid X_WE = interpolate(picture.late.X_WE_begin, picture.late.X_WE_end, s);
    CHECK((*seen - *project(eye, X_WE.inverse() * p_W)).norm() < 1e-8);
  }
}

TEST_CASE("a disc followed along its outline has the centroid of the conic") {
  std::mt19937 random(7);
  const EyeModel eye = default_hmd().left;
  for (const DeflectionKind kind : {DeflectionKind::shift_roll, DeflectionKind::rotation, DeflectionKind::depth}) {
    ShownPicture picture = picture_of(eye, {kind, 2.0, true}, random);
    Disc disc;
    disc.centre_W = picture.view.X_WS * Vector3(0.1, -0.08, -0.7);
    disc.normal_W = picture.view.X_WS.q() * Vector3(0.2, 0.3, 1.0).normalized();
    disc.radius_m = 0.02;
    const DisplayTiming global = timing_of(ScanOut::global, ScanDirection::top_to_bottom);
    const DisplayTiming rolling = timing_of(ScanOut::rolling, ScanDirection::top_to_bottom);
    ShownPicture at_once = picture;
    at_once.late.X_WE_end = at_once.late.X_WE_begin;
    at_once.deflection = deflect(picture.how, picture.view, at_once.late);
    // Nearly at once: the path along the outline is taken, and must meet the conic's.
    const Rigid& begin = picture.late.X_WE_begin;
    picture.late.X_WE_end = Rigid(begin.q(), begin.p() + Vector3(1e-13, 0, 0));
    picture.deflection = deflect(picture.how, picture.view, picture.late);
    REQUIRE_FALSE(picture.deflection.X_SE.is_constant());
    const auto outline = shown_centroid(picture, {eye, eye, LensMode::none, rolling}, disc);
    const auto conic = shown_centroid(at_once, {eye, eye, LensMode::none, global}, disc);
    REQUIRE(outline);
    REQUIRE(conic);
    CHECK((*outline - *conic).norm() < 1e-8);
  }
}

TEST_CASE("what was not drawn is not shown") {
  const EyeModel eye = default_hmd().left;
  const DisplayTiming timing;
  ShownPicture picture;
  picture.view = {Rigid(), eye.tangents, eye.resolution, HostTime{}};
  picture.how.kind = DeflectionKind::rotation;
  picture.late = LatePoses::at_once(Rigid::rotation(so3::exp<double>(Vector3(0.0, degrees(10).radians(), 0.0))));
  picture.deflection = deflect(picture.how, picture.view, picture.late);
  Disc disc;
  disc.radius_m = 0.02;
  const ShownOn on{eye, eye, LensMode::none, timing};
  // The eye turned left by 10 degrees: what it sees at its left edge lies 37 degrees to the left of S, outside its 30.
  disc.centre_W = Vector3(-std::tan(degrees(37).radians()), 0.0, -1.0);
  REQUIRE(project_disc(eye, picture.late.X_WE_begin, disc)->is_inside(eye.resolution));
  CHECK_FALSE(shown_centroid(picture, on, disc));
  disc.centre_W = Vector3(-std::tan(degrees(20).radians()), 0.0, -1.0);
  CHECK(shown_centroid(picture, on, disc));
  disc.centre_W.z() = 1.0;  // behind
  CHECK_FALSE(shown_centroid(picture, on, disc));
  CHECK_FALSE(shown_point(picture, on, disc.centre_W));
  // A point as well as a disc: the picture's left edge is at -30 degrees, the deflected one's on the panel at -20.
  const auto at = [](double azimuth_deg) { return Vector3(std::tan(degrees(azimuth_deg).radians()), 0.0, -1.0); };
  CHECK(shown_point(picture, on, at(-29.9)));
  CHECK_FALSE(shown_point(picture, on, at(-30.1)));
  const auto beyond = place_in_view(picture, on, at(-30.1));
  REQUIRE(beyond);
  CHECK((*beyond - *project(eye, picture.late.X_WE_begin.inverse() * at(-30.1))).norm() < 1e-9);
  ShownPicture as_drawn = picture;
  as_drawn.how.kind = DeflectionKind::none;
  CHECK(shown_point(as_drawn, on, at(-29.9)));
  CHECK_FALSE(shown_point(as_drawn, on, at(-30.1)));
}

TEST_CASE("at a lens's edge a point and a real disc are seen on the line that lights them, in every scan direction") {
  // The lens ends inside the panel, and the head turns by 2.2 degrees during the scan: near the edge a thing is within the
  // lens for a part of the lines only.
  HmdModel hmd = default_hmd();
  hmd.left.X_HE = Rigid();
  EyeModel& eye = hmd.left;
  eye.lens = Lens(RadialLens{-0.5}, placed_at(0.4));
  const auto motion = make_yaw_ramp({degrees(-40), degrees(40), degrees(200), Duration{0}}, std::chrono::seconds(1));
  for (const ScanDirection direction : scan_directions) {
    const DisplayTiming timing = timing_of(ScanOut::rolling, direction);
    const HostTime t_display = time_at(0.2);
    const auto X_WE = [&](double s) { return motion->at(t_display + line_time_from_middle(timing, s)).X_WB; };
    ShownPicture picture;
    const FieldTangents wider = overfilled(eye.tangents, {degrees(8), degrees(8), degrees(4)});
    picture.view = {X_WE(0.5), wider, overfilled_size(eye, wider), t_display};
    picture.how = {DeflectionKind::depth, 2.0, true};
    picture.late = {X_WE(0.0), X_WE(1.0), X_WE(0.5)};
    picture.deflection = deflect(picture.how, picture.view, picture.late);
    REQUIRE(picture.is_deflected());
    const ShownOn on{eye, eye, LensMode::exact, timing};
    int found = 0, edge = 0;
    for (int i = 0; i < 360; ++i) {
      // A direction of what the panel shows near the lens's edge, at the time at which it is lit there.
      const double r = eye.lens.valid_radius() * (0.7 + 0.18 * (i % 7) / 6.0), a = degrees(i).radians();
      const Vector2 panel(r * std::cos(a), r * std::sin(a));
      const Vector2 panel_px = pixel_of_tangent(eye, panel);
      const auto t_E = eye.lens.distort(panel);
      if (!t_E || !is_inside(eye, panel_px)) continue;
      const double s = on.line_fraction(panel_px);
      const Vector3 p_W = X_WE(s) * direction_of_tangents(*t_E);
      const Vector2 expected = pixel_of_tangent(eye, *t_E);
      const auto seen = shown_point(picture, on, p_W);
      REQUIRE(seen);
      // The parabola through the late poses of an even turn is that turn, but for times in whole nanoseconds.
      CHECK((*seen - expected).norm() < 1e-4);
      Disc disc;
      disc.centre_W = p_W;
      disc.normal_W = X_WE(s).q() * Vector3::UnitZ();
      disc.radius_m = 1e-4;
      const auto real = real_ellipse(*motion, eye, timing, LensMode::exact, disc, t_display, X_WE(0.5));
      REQUIRE(real);
      CHECK((real->centroid - expected).norm() < 1e-3);
      const auto at_middle = tangents_of_point(X_WE(0.5).inverse() * p_W);
      edge += at_middle && eye.lens.undistort(*at_middle) ? 0 : 1;
      ++found;
    }
    MESSAGE(name_of(direction), ": ", edge, " of ", found, " lie outside the lens for the middle line");
    CHECK(found > 100);
    // Scanned the way in which things move past a head that turns left, they are nearer to the middle at the middle line.
    CHECK((edge > 5 || direction == ScanDirection::left_to_right));
  }
}

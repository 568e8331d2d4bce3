#include <doctest/doctest.h>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/deflect.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

TEST_CASE("source and panel pixels are each other's inverse, for every lens, colour, panel and scan direction") {
  test::Random random(501);
  double worst = 0.0;
  int count = 0;
  for (int i = 0; i < 200; ++i) {
    const EyeModel eye = random.eye();
    const DisplayTiming timing = random.timing(i % 4 != 0);
    const RenderedView view = random.view(eye);
    const LatePoses late{view.X_WS * random.pose(0.1, 0.05), view.X_WS * random.pose(0.1, 0.05)};
    for (const DeflectionKind kind : deflection_kinds) {
      const DeflectionResult result = deflect({kind, 1.0}, view, late);
      REQUIRE(result.ok());
      for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
        const ComposedWarp warp(eye, mode, timing, view, result.H_SE);
        const Color color =
            std::array{Color::red, Color::green, Color::blue}[static_cast<std::size_t>(random.index(3))];
        const Vector2 seen(random.uniform(0.1, 0.9) * eye.resolution.width,
                           random.uniform(0.1, 0.9) * eye.resolution.height);
        const auto source = warp.source_pixel_seen(seen, color);
        if (!source) continue;
        const auto back = warp.seen_pixel(*source, color);
        if (!back) continue;
        worst = std::max(worst, (*back - seen).norm());
        const auto panel = warp.panel_pixel(*source, color);
        REQUIRE(panel);
        CHECK((*warp.source_pixel(*panel, color) - *source).norm() < 1e-8);
        ++count;
      }
    }
  }
  MESSAGE("seen_pixel of source_pixel_seen: worst ", worst, " px over ", count, " pixels");
  CHECK(count > 4000);
  // The line fraction is found to 1e-13, positions to a few roundings of 2000 px and the lens inverse's 1e-13 of tangent.
  CHECK(worst < 1e-9);
}

TEST_CASE("at a lens's edge, what the panel shows is found where it lights, in every scan direction") {
  // The lens folds over inside the panel. Near its edge a thing is shown for some lines of the scan only, as the eye
  // turns by 4 degrees during it: often not for the middle one. (At the very fold its things move faster than the scan.)
  EyeModel eye = default_hmd({1000, 900}).left;
  eye.tangents = {-0.7, 0.6, -0.6, 0.55};
  eye.lens = Lens(RadialLens{-0.5}, placed_at(0.75, Vector2(0.03, -0.02)), 0.0);
  test::Random random(505);
  for (const ScanDirection direction : scan_directions) {
    DisplayTiming timing = random.timing(true);
    timing.scan_direction = direction;
    int edge = 0, count = 0;
    double worst = 0.0;
    for (int i = 0; i < 40; ++i) {
      const RenderedView view{random.pose(3, 3), {-1.2, 1.2, -1.2, 1.2}, {1200, 1200}, {}};
      const Vector3 turn = degrees(4.0).radians() * random.vector(1.0).normalized();
      const LatePoses late{view.X_WS, view.X_WS * Rigid::rotation(so3::exp<double>(turn))};
      const DeflectionResult result = deflect({}, view, late);
      const ComposedWarp warp(eye, LensMode::exact, timing, view, result.H_SE);
      const double radius = eye.lens.valid_radius();
      for (int k = 0; k < 40; ++k) {
        const double angle = random.uniform(-3.14, 3.14), r = radius * random.uniform(0.7, 0.88);
        const Vector2 tangent = eye.lens.centre() + r * Vector2(std::cos(angle), std::sin(angle));
        const Vector2 panel = pixel_of_tangent(eye, tangent);
        if (!is_inside(eye, panel)) continue;
        const auto source = warp.source_pixel(panel);
        if (!source) continue;
        const auto middle = result.H_SE.displayed_tangent(tangent_of_source_pixel(view, *source), 0.5);
        edge += middle && eye.lens.undistort(*middle) ? 0 : 1;
        const auto back = warp.panel_pixel(*source);
        CAPTURE(panel.x());
        CAPTURE(panel.y());
        REQUIRE(back);
        // The line is found to 1e-13; at 0.88 of its radius the lens moves things 4 times as fast as they go.
        worst = std::max(worst, (*back - panel).norm());
        ++count;
      }
    }
    MESSAGE(name_of(direction), ": ", edge, " of ", count, " are not shown by the middle line; worst ", worst, " px");
    CHECK(edge > 50);
    CHECK(worst < 1e-8);
  }
}

TEST_CASE("without motion it is the lens alone") {
  test::Random random(502);
  for (int i = 0; i < 50; ++i) {
    const EyeModel eye = random.eye();
    // Drawn with the panel's own edges, so that source pixels are the panel's.
    const RenderedView view{random.pose(3, 3), panel_tangents(eye), eye.resolution, {}};
    const DeflectionResult still = deflect({}, view, LatePoses::at_once(view.X_WS));
    for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
      const ComposedWarp warp(eye, mode, random.timing(true), view, still.H_SE);
      const Vector2 pixel(random.uniform(0, eye.resolution.width), random.uniform(0, eye.resolution.height));
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        const auto expected = ideal_pixel_at_panel(eye, mode, pixel, color);
        const auto source = warp.source_pixel(pixel, color);
        REQUIRE(source.has_value() == expected.has_value());
        if (source) CHECK((*source - *expected).norm() < 1e-10);
        const auto seen_expected = ideal_pixel(eye, mode, pixel, color);
        const auto seen = warp.source_pixel_seen(pixel, color);
        REQUIRE(seen.has_value() == seen_expected.has_value());
        if (seen) CHECK((*seen - *seen_expected).norm() < 1e-9);
      }
    }
  }
}

TEST_CASE("each panel line takes its own pose, in every scan direction, also on a panel mounted upside down") {
  for (const ScanDirection direction : scan_directions) {
    for (const bool upside_down : {false, true}) {
      EyeModel eye = default_hmd({640, 480}).left;
      eye.upside_down = upside_down;
      DisplayTiming timing;
      timing.scan_out = ScanOut::rolling;
      timing.scan_duration = from_milliseconds(10);
      timing.scan_direction = direction;
      const RenderedView view{{}, eye.tangents, eye.resolution, {}};
      // The eye turns left during the scan from 0 to 2 degrees.
      const LatePoses late{{}, Rigid::rotation(so3::exp<double>(Vector3(0, degrees(2).radians(), 0)))};
      const DeflectionResult result = deflect({}, view, late);
      const ComposedWarp warp(eye, LensMode::none, timing, view, result.H_SE);
      const Vector2 size(640, 480);
      for (const Vector2& pixel : {Vector2(100, 50), Vector2(320, 240), Vector2(500, 430)}) {
        const double s = line_fraction_of_pixel(direction, pixel, size);
        CHECK(warp.line_fraction(pixel) == doctest::Approx(s).epsilon(1e-14));
        const Vector2 t_E = tangent_of_pixel(eye, pixel);
        const Angle azimuth = radians(std::atan(t_E.x())) - degrees(2 * s);  // the source was drawn looking ahead
        const Vector2 t_S = tangent_of_source_pixel(view, *warp.source_pixel(pixel));
        CHECK(std::atan(t_S.x()) == doctest::Approx(azimuth.radians()).epsilon(1e-6));
      }
      // A global display takes the middle's for all.
      timing.scan_out = ScanOut::global;
      const ComposedWarp global(eye, LensMode::none, timing, view, result.H_SE);
      CHECK(global.line_fraction(Vector2(100, 50)) == 0.5);
    }
  }
}

TEST_CASE("the matrices for shaders say what the warp says") {
  test::Random random(503);
  for (int i = 0; i < 50; ++i) {
    const EyeModel eye = random.eye();
    const RenderedView view = random.view(eye);
    const LatePoses late{view.X_WS * random.pose(0.1, 0.05), view.X_WS * random.pose(0.1, 0.05)};
    const DeflectionResult result = deflect({DeflectionKind::plane, 1.5}, view, late);
    const ComposedWarp warp(eye, LensMode::none, random.timing(true), view, result.H_SE);
    const SourceMatrices M = warp.source_matrices();
    for (int k = 0; k < 10; ++k) {
      const Vector2 uv(random.uniform(0, 1), random.uniform(0, 1));
      const Vector2 pixel(uv.x() * eye.resolution.width, uv.y() * eye.resolution.height);
      const Vector2 t_E = tangent_of_pixel(eye, pixel);
      const double s = warp.line_coefficients().dot(Vector3(uv.x(), uv.y(), 1.0));
      const Vector3 source = M.at(s) * Vector3(t_E.x(), t_E.y(), 1.0);
      const auto expected = warp.source_pixel(pixel);
      REQUIRE(expected.has_value() == (source.z() > 0.0));
      if (!expected) continue;
      const Vector2 shown(source.x() / source.z() * view.size.width, source.y() / source.z() * view.size.height);
      CHECK((shown - *expected).norm() < 1e-9 * (1.0 + expected->norm()));
    }
  }
}

TEST_CASE("left and right eyes mirror through the whole warp") {
  test::Random random(504);
  const auto mirrored_pose = [](const Rigid& X) {
    return Rigid(Quaternion(X.q().w(), X.q().x(), -X.q().y(), -X.q().z()), Vector3(-X.p().x(), X.p().y(), X.p().z()));
  };
  for (int i = 0; i < 50; ++i) {
    EyeModel eye = random.eye();
    eye.upside_down = false;
    const EyeModel other = mirrored(eye);
    DisplayTiming timing = random.timing(true);
    timing.scan_direction = ScanDirection::left_to_right;
    DisplayTiming other_timing = timing;
    other_timing.scan_direction = ScanDirection::right_to_left;
    const RenderedView view = random.view(eye);
    RenderedView other_view = view;
    other_view.X_WS = mirrored_pose(view.X_WS);
    other_view.tangents = mirrored(view.tangents);
    const LatePoses late{view.X_WS * random.pose(0.1, 0.05), view.X_WS * random.pose(0.1, 0.05)};
    const LatePoses other_late{mirrored_pose(late.X_WE_begin), mirrored_pose(late.X_WE_end)};
    for (const DeflectionKind kind : deflection_kinds) {
      const auto a = deflect({kind, 0.9}, view, late), b = deflect({kind, 0.9}, other_view, other_late);
      const ComposedWarp warp(eye, LensMode::exact, timing, view, a.H_SE);
      const ComposedWarp other_warp(other, LensMode::exact, other_timing, other_view, b.H_SE);
      const Vector2 pixel(random.uniform(0, eye.resolution.width), random.uniform(0, eye.resolution.height));
      const auto source = warp.source_pixel(pixel);
      const auto other_source = other_warp.source_pixel(Vector2(eye.resolution.width - pixel.x(), pixel.y()));
      REQUIRE(source.has_value() == other_source.has_value());
      if (!source) continue;
      CHECK((Vector2(view.size.width - source->x(), source->y()) - *other_source).norm() < 1e-9);
    }
  }
}

TEST_CASE("what the lens cannot show, and what lies behind the source eye, has no source") {
  EyeModel eye = default_hmd().left;
  eye.lens = Lens(RadialLens{-0.4}, placed_at(0.5));  // folds over inside the panel
  const RenderedView view{{}, eye.tangents, eye.resolution, {}};
  const ComposedWarp warp(eye, LensMode::exact, DisplayTiming{}, view, ScanHomography());
  CHECK_FALSE(warp.source_pixel(Vector2(0.5, 0.5)).has_value());
  CHECK(warp.sample(Vector2(0.5, 0.5)).state == SourceState::not_seen);
  CHECK(warp.source_pixel(Vector2(640, 360)).has_value());
  // Turned by 80 degrees: the view's far side is more than 90 degrees from the source's axis.
  const auto turned =
      deflect({}, view, LatePoses::at_once(Rigid::rotation(so3::exp<double>(Vector3(0, degrees(80).radians(), 0)))));
  REQUIRE(turned.ok());
  const EyeModel plain = default_hmd().left;
  const ComposedWarp far_aside(plain, LensMode::none, DisplayTiming{}, view, turned.H_SE);
  CHECK(far_aside.sample(Vector2(1, 360)).state == SourceState::not_seen);
  CHECK(far_aside.sample(Vector2(1279, 360)).state == SourceState::outside);
}

// The outline of what a panel shows, and the overfilled picture that follows from it.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/deflection/coverage.hpp>

#include "pipeline/pipeline_heads.hpp"

using namespace holdfast;
using namespace holdfast::test;

TEST_CASE("without lens the outline's bounds are the panel's field") {
  HmdModel hmd = rolling_hmd();
  hmd.left.tangents = {-0.9, 0.6, -0.7, 0.5};
  CHECK(FieldOutline(hmd.left, LensMode::none, hmd.timing).bounds() == hmd.left.tangents);
  hmd.left.upside_down = true;  // the same field, the first line at the other end
  const FieldOutline turned(hmd.left, LensMode::none, hmd.timing);
  CHECK(turned.bounds() == hmd.left.tangents);
  for (const FieldOutline::Point& p : turned.points()) {
    if (p.t_E.y() == 0.5) CHECK(p.line_fraction == 1.0);
    if (p.t_E.y() == -0.7) CHECK(p.line_fraction == 0.0);
  }
}

TEST_CASE("line fractions are those of the scan direction; a global display has the middle everywhere") {
  for (const ScanDirection direction : scan_directions) {
    const HmdModel hmd = rolling_hmd(direction);
    const FieldTangents& f = hmd.left.tangents;
    const FieldOutline outline(hmd.left, LensMode::none, hmd.timing);
    for (const FieldOutline::Point& p : outline.points()) {
      const Vector2 pixel = pixel_of_tangent(hmd.left, p.t_E);
      const double expected = line_fraction_of_pixel(direction, pixel, Vector2(1280, 720));
      CHECK(std::abs(p.line_fraction - expected) < 1e-14);
      CHECK(p.t_E.x() >= f.left);
    }
  }
  const FieldOutline global(default_hmd().left, LensMode::none, default_hmd().timing);
  for (const FieldOutline::Point& p : global.points()) CHECK(p.line_fraction == 0.5);
}

TEST_CASE("every panel pixel shows something within the bounds, with lenses per colour") {
  HmdModel hmd = rolling_hmd();
  EyeModel& eye = hmd.left;
  eye.lens_red = eye.lens.with_placement({Vector2(0.02, -0.01), 1.02 * eye.lens.placement().scale});
  eye.lens_blue = eye.lens.with_placement({Vector2(-0.01, 0.01), 0.97 * eye.lens.placement().scale});
  const FieldTangents bounds = FieldOutline(eye, LensMode::exact, hmd.timing).bounds();
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    for (int x = 0; x <= 64; ++x) {
      for (int y = 0; y <= 36; ++y) {
        const auto t = ideal_tangent_at_panel(eye.lens_of(color), LensMode::exact,
                                              tangent_of_pixel(eye, Vector2(20.0 * x, 20.0 * y)));
        REQUIRE(t.has_value());
        // Between the outline's points: a side of 0.8 in eighths, bent with radius 0.5 or more, bulges by 0.003 less.
        CHECK(t->x() >= bounds.left - 3e-3);
        CHECK(t->x() <= bounds.right + 3e-3);
        CHECK(t->y() >= bounds.down - 3e-3);
        CHECK(t->y() <= bounds.up + 3e-3);
      }
    }
  }
}

TEST_CASE("a lens that shows only a part of its panel has that part's outline") {
  // Folds over at r = 1 / sqrt(3 * 0.5) = 0.816 of a panel that reaches to 1.
  HmdModel hmd = default_hmd({1000, 1000});
  hmd.left.tangents = {-1.0, 1.0, -1.0, 1.0};
  hmd.left.lens = RadialLens{-0.5};
  const FieldOutline outline(hmd.left, LensMode::exact, hmd.timing);
  REQUIRE(outline.points().size() == 32);
  const double fold = std::sqrt(1.0 / 1.5);
  const double seen = fold * (1.0 - 0.5 * fold * fold);
  for (const FieldOutline::Point& p : outline.points()) {
    CHECK(p.t_E.norm() <= seen + 1e-12);
    CHECK(p.t_E.norm() > 0.98 * seen);  // the lens answers up to a little before its fold
  }
}

TEST_CASE("a picture covers the view within its budget, and lacks what lies beyond") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  HmdModel hmd = rolling_hmd();
  hmd.left.tangents = {-0.9, 0.6, -0.7, 0.5};
  const DeflectionBudget budget{degrees(3.0), degrees(2.0), degrees(4.0)};
  for (const LensMode lens : {LensMode::none, LensMode::exact}) {
    const FieldOutline outline(hmd.left, lens, hmd.timing);
    const EyePicture picture = *overfilled_picture(hmd.left, outline, budget);
    const RenderedView view{Rigid(), picture.tangents, picture.size, HostTime{}};
    const auto late = [&](double share) {
      const Vector3 y(0.0, share * unit(random) * budget.yaw.radians(), 0.0);
      const Vector3 x(share * unit(random) * budget.pitch.radians(), 0.0, 0.0);
      const Vector3 z(0.0, 0.0, share * unit(random) * budget.roll.radians());
      return Rigid::rotation(so3::exp<double>(y) * so3::exp<double>(x) * so3::exp<double>(z));
    };
    for (int i = 0; i < 300; ++i) {
      const DeflectionResult deflection = deflect(DeflectionSettings{}, view, {late(1.0), late(1.0)});
      REQUIRE(deflection.ok());
      // Between two poses within the budget the parabola may reach past it by its own error.
      CHECK(outline.lacking(picture.tangents, deflection.H_SE) < 1e-5);
    }
    for (const double sign : {-1.0, 1.0}) {
      const Rigid beyond = Rigid::rotation(so3::exp<double>(Vector3(0, sign * degrees(15.0).radians(), 0)));
      const DeflectionResult deflection = deflect(DeflectionSettings{}, view, LatePoses::at_once(beyond));
      // 12 degrees more than the budget, 0.2 of tangent, less what the room for roll (4 degrees of 1 or 1.4) makes up.
      CHECK(outline.lacking(picture.tangents, deflection.H_SE) > 0.05);
    }
    // As dense as the panel: the pixels grow with the field.
    CHECK(picture.size.width ==
          doctest::Approx(1280 * (picture.tangents.right - picture.tangents.left) / 1.5).epsilon(1e-3));
  }
}

TEST_CASE("what the outline says of covered views, a grid over the whole view confirms") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int covered = 0, lacking = 0;
  for (int i = 0; i < 60; ++i) {
    HmdModel hmd = rolling_hmd(scan_directions[std::size_t(i) % 4]);
    EyeModel& eye = hmd.left;
    eye.upside_down = i % 3 == 0;
    eye.tangents = {-0.8 + 0.2 * unit(random), 0.7 + 0.2 * unit(random), -0.6 + 0.1 * unit(random),
                    0.5 + 0.1 * unit(random)};
    const LensMode lens = i % 2 == 0 ? LensMode::none : LensMode::exact;
    const FieldOutline outline(eye, lens, hmd.timing);
    const EyePicture picture = *overfilled_picture(eye, outline, {degrees(3.0), degrees(3.0), degrees(3.0)});
    const RenderedView view{Rigid(), picture.tangents, picture.size, HostTime{}};
    const auto late = [&] {
      return Rigid::rotation(so3::exp<double>(Vector3(0.12 * unit(random), 0.12 * unit(random), 0.12 * unit(random))));
    };
    const DeflectionResult deflection = deflect(DeflectionSettings{}, view, {late(), late()});
    const double beyond = outline.lacking(picture.tangents, deflection.H_SE);
    const Coverage grid = coverage(ComposedWarp(eye, lens, hmd.timing, view, deflection.H_SE));
    CAPTURE(i);
    CAPTURE(beyond);
    if (beyond <= 0.0) CHECK(grid.outside == 0);
    // The outermost directions of the grid lie half a cell, 0.006, inside the outline.
    if (lens == LensMode::none && beyond > 0.03) CHECK(grid.outside > 0);
    ++(beyond <= 0.0 ? covered : lacking);
  }
  CHECK(covered > 10);
  CHECK(lacking > 10);
}

TEST_CASE("an eye whose lens shows nothing has no outline and no picture") {
  HmdModel hmd = rolling_hmd();
  hmd.left.lens = Lens(RadialLens{-0.5}, LensPlacement{Vector2(50.0, 0.0), Vector2(1.0, 1.0)});
  const FieldOutline outline(hmd.left, LensMode::exact, hmd.timing);
  CHECK(outline.points().empty());
  CHECK_FALSE(overfilled_picture(hmd.left, outline, {}).has_value());
  CHECK(problem_of(hmd, FrameLoopSettings{})->member == "eye.lens");
}

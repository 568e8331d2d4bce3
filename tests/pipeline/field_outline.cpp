// The outline of what a panel shows, and the overfilled picture that follows from it.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

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

namespace {

double px_per_tangent(const EyeModel& eye) {
  return pixels_per_tangent(eye).cwiseAbs().maxCoeff();
}

/// The outline by sampling alone: 16000 points a colour, each where the lens ends towards the panel's middle.
std::vector<FieldOutline::Point> dense_outline(const EyeModel& eye, LensMode mode, const DisplayTiming& timing) {
  std::vector<FieldOutline::Point> points;
  const FieldTangents f = panel_tangents(eye);
  const Vector3 line = line_fraction_coefficients(timing);
  constexpr int n = 4000;
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    for (int i = 0; i < 4 * n; ++i) {
      const double a = static_cast<double>(i % n) / n;
      const Vector2 border = i < n       ? Vector2(a, 0)
                             : i < 2 * n ? Vector2(1, a)
                             : i < 3 * n ? Vector2(1 - a, 1)
                                         : Vector2(0, 1 - a);
      const auto at = [&](double out) {
        const Vector2 uv = Vector2(0.5, 0.5) + out * (border - Vector2(0.5, 0.5));
        const Vector2 panel(f.left + uv.x() * (f.right - f.left), f.down + uv.y() * (f.up - f.down));
        return std::pair(uv, ideal_tangent_at_panel(eye.lens_of(color), mode, panel));
      };
      double inside = 1.0;
      if (!at(1.0).second) {
        double outside = 1.0;
        inside = 0.0;
        for (int k = 0; k < 40; ++k)
          (at(0.5 * (inside + outside)).second ? inside : outside) = 0.5 * (inside + outside);
      }
      const auto [uv, t_E] = at(inside);
      points.push_back({*t_E, line.dot(Vector3(uv.x(), uv.y(), 1.0))});
    }
  }
  return points;
}

double lacking_of(const std::vector<FieldOutline::Point>& points, const FieldTangents& picture,
                  const ScanHomography& H_SE) {
  double most = -1e9;
  for (const FieldOutline::Point& p : points) {
    const Vector2 t_S = *H_SE.source_tangent(p.t_E, p.line_fraction);
    most =
        std::max({most, picture.left - t_S.x(), t_S.x() - picture.right, picture.down - t_S.y(), t_S.y() - picture.up});
  }
  return most;
}

/// Headsets whose outlines bulge outward, break off or have corners.
std::vector<std::pair<std::string, EyeModel>> bent_eyes() {
  EyeModel eye = default_hmd({1280, 1200}).left;
  eye.tangents = {-1.0, 0.8, -0.9, 0.85};
  std::vector<std::pair<std::string, EyeModel>> eyes;
  const auto add = [&](const std::string& name, const Lens& lens) {
    eyes.emplace_back(name, eye);
    eyes.back().second.lens = lens;
  };
  add("pincushion", Lens(RadialLens{0.25}));
  add("barrel", Lens(RadialLens{-0.12}));
  add("barrel beside the middle", Lens(RadialLens{-0.12}, placed_at(1.0, Vector2(0.2, -0.15))));
  add("folds over before the corners", Lens(RadialLens{-0.25}));
  add("folds over inside the panel", Lens(RadialLens{-0.5}, placed_at(0.9, Vector2(0.05, 0.1))));
  add("barrel, then pincushion", Lens(PolynomialLens(std::vector{-0.3, 0.12})));
  eyes.emplace_back("barrel, canted, upside down", eyes[2].second);
  eyes.back().second.X_HE = eye_pose(EyeSide::left, 0.064, degrees(12.0), degrees(5.0));
  eyes.back().second.upside_down = true;
  eyes.emplace_back("a lens per colour", eyes[1].second);
  eyes.back().second.lens_red = Lens(RadialLens{-0.1}, placed_at(1.02, Vector2(0.02, -0.01)));
  eyes.back().second.lens_blue = Lens(RadialLens{-0.5}, placed_at(0.95));
  return eyes;
}

}  // namespace

TEST_CASE("the outline's bounds are those of dense sampling, at most a quarter of a pixel wider") {
  for (const auto& bent : bent_eyes()) {
    CAPTURE(bent.first);
    const EyeModel& eye = bent.second;
    const DisplayTiming timing;
    const FieldOutline outline(eye, LensMode::exact, timing);
    const FieldTangents found = outline.bounds();
    FieldTangents truth{1e9, -1e9, 1e9, -1e9};
    for (const FieldOutline::Point& p : dense_outline(eye, LensMode::exact, timing)) {
      truth = {std::min(truth.left, p.t_E.x()), std::max(truth.right, p.t_E.x()), std::min(truth.down, p.t_E.y()),
               std::max(truth.up, p.t_E.y())};
    }
    const double px = px_per_tangent(eye);
    const double wider[4] = {truth.left - found.left, found.right - truth.right, truth.down - found.down,
                             found.up - truth.up};
    for (const double w : wider) {
      CHECK(w * px > -0.02);  // a parabola's third order, and what 4000 points a side leave out
      CHECK(w * px < 0.26);
    }
    MESSAGE(bent.first, ": ", outline.points().size(), " points; wider by ", px * *std::min_element(wider, wider + 4),
            " to ", px * *std::max_element(wider, wider + 4), " px");
    CHECK(outline.points().size() < 1500);
  }
}

TEST_CASE("what a deflected picture lacks is what dense sampling finds") {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto& bent : bent_eyes()) {
    CAPTURE(bent.first);
    const EyeModel& eye = bent.second;
    const double px = px_per_tangent(eye);
    double least = 1e9, most = -1e9;
    for (const ScanDirection direction : scan_directions) {
      DisplayTiming timing = rolling_hmd(direction).timing;
      const FieldOutline outline(eye, LensMode::exact, timing);
      const auto dense = dense_outline(eye, LensMode::exact, timing);
      const RenderedView view{Rigid(), outline.bounds(), {1280, 1200}, {}};
      for (int i = 0; i < 10; ++i) {
        const auto turn = [&](double size) {
          return Rigid::rotation(
              so3::exp<double>(Vector3(size * unit(random), size * unit(random), size * unit(random))));
        };
        // Turned by some degrees, and by up to 2.2 degrees about each axis during the scan: 200 deg/s, 11.1 ms.
        const Rigid begin = turn(0.06);
        const DeflectionResult deflection = deflect({}, view, {begin, begin * turn(0.0388)});
        REQUIRE(deflection.ok());
        const double beyond =
            px * (outline.lacking(view.tangents, deflection.H_SE) - lacking_of(dense, view.tangents, deflection.H_SE));
        least = std::min(least, beyond);
        most = std::max(most, beyond);
      }
    }
    MESSAGE(bent.first, ": lacking differs from dense sampling by ", least, " to ", most, " px");
    CHECK(least > -0.1);
    CHECK(most < 0.4);  // the bulge's 0.25, magnified at the edges of a turned picture
  }
}

TEST_CASE("a lens that shows only a part of its panel has that part's outline") {
  // Folds over at r = 1 / sqrt(3 * 0.5) = 0.816 of a panel that reaches to 1.
  HmdModel hmd = default_hmd({1000, 1000});
  hmd.left.tangents = {-1.0, 1.0, -1.0, 1.0};
  hmd.left.lens = RadialLens{-0.5};
  const FieldOutline outline(hmd.left, LensMode::exact, hmd.timing);
  const double fold = std::sqrt(1.0 / 1.5);
  const double seen = fold * (1.0 - 0.5 * fold * fold);
  const double quarter_px = 0.25 / 500.0;
  for (const FieldOutline::Point& p : outline.points()) {
    CHECK(p.t_E.norm() <= seen + quarter_px);
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

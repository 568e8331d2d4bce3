#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/coverage.hpp>
#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/depth_search.hpp>

#include "deflection/depth_scene.hpp"
#include "deflection/setups.hpp"

using namespace holdfast;

namespace {

EyeModel plain_eye(const PixelSize& size) {
  EyeModel eye = default_hmd(size).left;
  eye.lens = NoLens{};
  return eye;
}

struct Judgement {
  int compared = 0, wrong_state = 0, disoccluded = 0, wrong_at_edge = 0, at_edge = 0;
  double worst_px = 0.0, sum_px2 = 0.0;
};

/// Every third pixel of the eye's picture against the truth of the scene.
Judgement judge(const test::DepthScene& scene, const DepthSearch& search, const EyeModel& eye, const RenderedView& view,
                const DisplayTiming& timing) {
  const ComposedWarp warp(eye, LensMode::none, timing, view, search);
  Judgement result;
  for (int y = 1; y < eye.resolution.height; y += 3) {
    for (int x = 1; x < eye.resolution.width; x += 3) {
      const Vector2 pixel(x + 0.5, y + 0.5);
      const Rigid X_SE = search.X_SE().at(warp.line_fraction(pixel));
      const auto truth = scene.truth(X_SE, tangent_of_pixel(eye, pixel));
      if (!truth || !is_inside(view, source_pixel_of_tangent(view, truth->t_S))) continue;
      const SourceSample found = warp.sample(pixel);
      const double error = (found.pixel - source_pixel_of_tangent(view, truth->t_S)).norm();
      const bool right = truth->was_seen ? found.state == SourceState::covered && error < 0.1
                                         : found.state == SourceState::disoccluded;
      ++result.compared;
      result.disoccluded += truth->was_seen ? 0 : 1;
      if (test::near_edge(search.surface(), truth->t_S, 1) ||
          test::near_edge(search.surface(), tangent_of_source_pixel(view, found.pixel), 1)) {
        ++result.at_edge;
        result.wrong_at_edge += right ? 0 : 1;
        continue;
      }
      result.wrong_state += (found.state == SourceState::covered) == truth->was_seen ? 0 : 1;
      if (truth->was_seen && found.state == SourceState::covered) {
        result.worst_px = std::max(result.worst_px, error);
        result.sum_px2 += error * error;
      }
    }
  }
  return result;
}

}  // namespace

TEST_CASE("a mere turn is the rotation's homography, whatever the depths; zero motion shows each pixel itself") {
  const RenderedView view = test::wide_view({320, 240});
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  test::Random random(801);
  for (int i = 0; i < 20; ++i) {
    const LatePoses late{view.X_WS * Rigid::rotation(random.turn(0.1)), view.X_WS * Rigid::rotation(random.turn(0.1))};
    const DeflectionResult depth = deflect({DeflectionKind::depth}, view, late);
    const DepthSearch search(surface, depth.X_SE);
    for (const double s : {0.0, 0.5, 1.0}) {
      const Vector2 t_E(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3));
      const auto found = search.source(t_E, s);
      REQUIRE(found);
      CHECK(found->state == SourceState::covered);
      CHECK((found->t_S - *depth.H_SE.source_tangent(t_E, s)).norm() < 1e-14);
    }
  }
  const DepthSearch still(surface, ScanPose());
  for (int i = 0; i < 100; ++i) {
    const Vector2 t_E(random.uniform(-0.6, 0.6), random.uniform(-0.4, 0.4));
    const auto found = still.source(t_E, 0.3);
    REQUIRE(found);
    CHECK(found->state == SourceState::covered);
    CHECK((found->t_S - t_E).norm() < 1e-15);
  }
}

TEST_CASE("slanted planes are met exactly from anywhere, line by line, in every scan direction") {
  const PixelSize size{320, 240};
  const RenderedView view = test::wide_view(size);
  const EyeModel eye = plain_eye(size);
  test::Random random(802);
  double worst = 0.0;
  int compared = 0;
  for (int i = 0; i < 8; ++i) {
    test::DepthScene scene;
    scene.planes.push_back(
        *Plane::make(Vector3(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 1), Vector3(0, 0, -1.5)));
    DepthSurface surface;
    REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
    const LatePoses late{view.X_WS * random.pose(0.03, 0.03), view.X_WS * random.pose(0.03, 0.03)};
    const DeflectionResult result = deflect({DeflectionKind::depth}, view, late);
    REQUIRE(result.ok());
    const DepthSearch search(surface, result.X_SE);
    const Judgement judged = judge(scene, search, eye, view, random.timing(true));
    worst = std::max(worst, judged.worst_px);
    compared += judged.compared;
    CHECK(judged.wrong_state == 0);
    CHECK(judged.at_edge == 0);
  }
  MESSAGE("depth search, slanted planes, moved by up to 5 cm and 3 deg: worst ", worst, " px over ", compared,
          " pixels");
  REQUIRE(compared > 10000);
  // Single-precision distances: 4e-7 of w / m, times 0.05 m, times 240 px per tangent = 5e-6 px.
  CHECK(worst < 1e-4);
}

TEST_CASE("depth: at most 0.1 px where not disoccluded, and disocclusion where it is") {
  const PixelSize size{640, 480};
  const RenderedView view = test::wide_view(size);
  const EyeModel eye = plain_eye(size);
  const test::DepthScene scene = test::room();
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
  // Sideways, up, forward and back, with turns; 5 cm is 0.5 m/s during 100 ms.
  for (const Vector3& moved : {Vector3(0.05, 0, 0), Vector3(-0.03, 0.04, 0), Vector3(0.01, -0.02, -0.05),
                               Vector3(0.02, 0.02, 0.05), Vector3(0.01, 0, 0)}) {
    const Rigid step(so3::exp<double>(Vector3(0.02, -0.01, 0.03)), moved);
    const DeflectionResult result = deflect({DeflectionKind::depth}, view, LatePoses::at_once(view.X_WS * step));
    REQUIRE(result.ok());
    const DepthSearch search(surface, result.X_SE);
    const Judgement judged = judge(scene, search, eye, view, DisplayTiming{});
    MESSAGE("depth search, moved by (", moved.x(), ", ", moved.y(), ", ", moved.z(), ") m: worst ", judged.worst_px,
            " px, RMS ", std::sqrt(judged.sum_px2 / judged.compared), " px; truly disoccluded ",
            100.0 * judged.disoccluded / judged.compared, " %, wrong away from edges ", judged.wrong_state,
            ", within a pixel of an edge ", judged.wrong_at_edge, " of ", judged.at_edge, " of ", judged.compared);
    CHECK(judged.compared > 30000);
    CHECK(judged.worst_px < 0.1);
    CHECK(judged.wrong_state == 0);
    CHECK(judged.disoccluded > 20);
    // The edge itself is known to half a pixel: some of the pixels next to it take the other side.
    CHECK(judged.wrong_at_edge < 0.35 * judged.at_edge);
  }
}

TEST_CASE("evaluation.md value 7: depth removes the parallax that a rotation leaves, and reports what it reveals") {
  // A board at 1 m before a wall at 2 m; 0.5 m/s during 20 ms: 10 mm to the right.
  const PixelSize size{640, 480};
  const RenderedView view = test::wide_view(size);
  const EyeModel eye = plain_eye(size);
  test::DepthScene scene;
  scene.planes.push_back(Plane{Vector3(0, 0, 1), -2.0});
  scene.boards.push_back({1.0, -0.2, 0.2, -0.2, 0.2});
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
  const Rigid X_WE = view.X_WS * Rigid::translation(Vector3(0.5 * 0.020, 0, 0));
  const LatePoses late = LatePoses::at_once(X_WE);
  const Vector3 p_W = view.X_WS * Vector3(0.05, 0.02, -1.0);
  const Vector2 drawn = source_pixel_of_tangent(view, *tangents_of_point(view.X_WS.inverse() * p_W));
  const Vector2 real = *project(eye, X_WE.inverse() * p_W);
  const DeflectionResult rotation = deflect({DeflectionKind::rotation}, view, late);
  const DeflectionResult depth = deflect({DeflectionKind::depth}, view, late);
  const ComposedWarp by_rotation(eye, LensMode::none, DisplayTiming{}, view, rotation.H_SE);
  const ComposedWarp by_depth(eye, LensMode::none, DisplayTiming{}, view, DepthSearch(surface, depth.X_SE));
  const Angle left = angle_between_pixels(eye, *by_rotation.seen_pixel(drawn), real);
  const Angle none = angle_between_pixels(eye, *by_depth.seen_pixel(drawn), real);
  const Coverage revealed = coverage(by_depth, {640, 480});
  MESSAGE("0.5 m/s, 20 ms, 1 m: rotation leaves ", left.arcmin(), " arcmin, depth ", none.arcmin(),
          " arcmin; disoccluded ", revealed.disocclusion_pct(), " %");
  CHECK(left.arcmin() == doctest::Approx(34.4).epsilon(0.01));  // off the axis a little less
  CHECK(none.arcmin() < 1e-3);
  CHECK((*by_depth.source_pixel(real) - drawn).norm() < 1e-3);
  // Moving right, the board slides left before the wall and uncovers a strip at its right: 10 mm (1/1 - 1/2) of tangent
  // times the board's height, of the view's area.
  const FieldTangents& t = eye.tangents;
  const double expected = 100.0 * (0.01 * 0.5 * 0.4) / ((t.right - t.left) * (t.up - t.down));
  CHECK(revealed.disocclusion_pct() == doctest::Approx(expected).epsilon(0.15));
  // The guess is the wall beside the board, not the board.
  const Vector2 board_edge_E(0.2 - 0.01, 0.0);
  const auto guess = by_depth.depth()->source(Vector2(board_edge_E + Vector2(0.002, 0.0)), 0.5);
  REQUIRE(guess);
  CHECK(guess->state == SourceState::disoccluded);
  CHECK(guess->w == doctest::Approx(0.5));
  // The middle of the wall's second pixel beside the board's edge, which lies half a pixel from the true one at most.
  const double beside_px =
      source_pixel_of_tangent(view, guess->t_S).x() - source_pixel_of_tangent(view, Vector2(0.2, 0.0)).x();
  CHECK(beside_px >= 1.0);
  CHECK(beside_px <= 2.0);
}

TEST_CASE("what a nearer thing hides is not shown through it, and the first surface wins") {
  // Moving right, the wall's points that pass behind the board's right edge are hidden by the board.
  const PixelSize size{640, 480};
  const RenderedView view = test::wide_view(size);
  test::DepthScene scene;
  scene.planes.push_back(Plane{Vector3(0, 0, 1), -2.0});
  scene.boards.push_back({0.5, -0.1, 0.1, -0.1, 0.1});
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
  const DeflectionResult result =
      deflect({DeflectionKind::depth}, view, LatePoses::at_once(view.X_WS * Rigid::translation(Vector3(0.05, 0, 0))));
  const DepthSearch search(surface, result.X_SE);
  // The board's middle is at tangent -0.1 now; S saw there its left half and, left of it, the wall.
  for (const double x : {-0.29, -0.25, -0.2, -0.1, 0.05, 0.09}) {
    const auto found = search.source(Vector2(x, 0.02), 0.5);
    REQUIRE(found);
    CHECK(found->state == SourceState::covered);
    CHECK(found->w == doctest::Approx(2.0));
    CHECK(found->t_S.x() == doctest::Approx(x + 0.1).epsilon(1e-6));
  }
  // Just outside its left edge the wall is seen, where S saw it: covered, as S saw more of the wall on that side.
  const auto beside = search.source(Vector2(-0.32, 0.02), 0.5);
  REQUIRE(beside);
  CHECK(beside->state == SourceState::covered);
  CHECK(beside->w == doctest::Approx(0.5));
  CHECK(beside->t_S.x() == doctest::Approx(-0.32 + 0.025).epsilon(1e-6));
}

TEST_CASE("stepping through a board: what lies behind it is seen only where S saw it") {
  const RenderedView view = test::wide_view({320, 240});
  test::DepthScene scene;
  scene.planes.push_back(Plane{Vector3(0, 0, 1), -2.0});
  scene.boards.push_back({0.5, -0.1, 0.1, -0.1, 0.1});
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
  const DeflectionResult result =
      deflect({DeflectionKind::depth}, view, LatePoses::at_once(view.X_WS * Rigid::translation(Vector3(0, 0, -0.6))));
  const DepthSearch search(surface, result.X_SE);
  CHECK(search.source(Vector2(0.01, 0.0), 0.5)->state == SourceState::disoccluded);
  const auto aside = search.source(Vector2(0.4, 0.0), 0.5);  // at x = 0.56 on the wall, which S saw at 0.28
  CHECK(aside->state == SourceState::covered);
  CHECK(aside->t_S.x() == doctest::Approx(0.28).epsilon(1e-6));
}

TEST_CASE("beyond the picture's edges the source is outside; sky is infinitely far") {
  const RenderedView view = test::wide_view({320, 240});
  DepthSurface surface;
  REQUIRE(surface.update(view, test::DepthScene{}.depth_image(view)) == DepthProblem::none);
  const DepthSearch search(surface, ScanPose({}, LatePoses::at_once(Rigid::translation(Vector3(0.3, 0.1, -0.2)))));
  const auto sky = search.source(Vector2(0.3, -0.2), 0.5);
  REQUIRE(sky);
  CHECK(sky->state == SourceState::covered);
  CHECK((sky->t_S - Vector2(0.3, -0.2)).norm() < 1e-15);
  CHECK(sky->w == 0.0);
  CHECK(search.source(Vector2(0.9, 0.0), 0.5)->state == SourceState::outside);
  CHECK((*search.displayed_tangent(Vector2(0.3, -0.2), 0.5) - Vector2(0.3, -0.2)).norm() < 1e-15);
  const DepthSearch behind(surface,
                           ScanPose({}, LatePoses::at_once(Rigid::rotation(so3::exp<double>(Vector3(0, 3, 0))))));
  CHECK_FALSE(behind.source(Vector2(0, 0), 0.5).has_value());
}

TEST_CASE("there and back by depth, with lens, line by line") {
  const PixelSize size{640, 480};
  const RenderedView view = test::wide_view(size);
  const EyeModel eye = default_hmd(size).left;
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  test::Random random(803);
  int count = 0;
  double worst = 0.0;
  for (int i = 0; i < 30; ++i) {
    const LatePoses late{view.X_WS * random.pose(0.03, 0.03), view.X_WS * random.pose(0.03, 0.03)};
    const DeflectionResult result = deflect({DeflectionKind::depth}, view, late);
    const ComposedWarp warp(eye, LensMode::exact, random.timing(true), view, DepthSearch(surface, result.X_SE));
    for (int k = 0; k < 30; ++k) {
      const Vector2 seen(random.uniform(20, 620), random.uniform(20, 460));
      const SourceSample found = warp.sample_seen(seen);
      if (found.state != SourceState::covered) continue;
      if (test::near_edge(surface, tangent_of_source_pixel(view, found.pixel), 1)) continue;
      const auto back = warp.seen_pixel(found.pixel);
      REQUIRE(back);
      worst = std::max(worst, (*back - seen).norm());
      ++count;
    }
  }
  MESSAGE("depth: seen_pixel of source_pixel_seen: worst ", worst, " px over ", count, " pixels");
  CHECK(count > 500);
  // Exact inside a facet; where the ray meets the step between two facets of the ball, by that step's parallax.
  CHECK(worst < 1e-3);
}

TEST_CASE("a surface without a depth image shows nothing") {
  const DepthSurface empty;
  const DepthSearch search(empty, ScanPose());
  CHECK_FALSE(search.source(Vector2(0, 0), 0.5).has_value());
  CHECK_FALSE(search.displayed_tangent(Vector2(0, 0), 0.5).has_value());
  const EyeModel eye = plain_eye({64, 48});
  const ComposedWarp warp(eye, LensMode::none, DisplayTiming{}, test::wide_view({64, 48}), search);
  CHECK(coverage(warp).not_seen == coverage(warp).directions);
}

TEST_CASE("directions that are no numbers have no source") {
  const RenderedView view = test::wide_view({64, 48});
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  const DepthSearch search(surface, ScanPose({}, LatePoses::at_once(Rigid::translation(Vector3(0.01, 0, 0)))));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_FALSE(search.source(Vector2(bad, 0.0), 0.5).has_value());
    CHECK_FALSE(search.source(Vector2(0.0, bad), 0.5).has_value());
  }
}

TEST_CASE("left and right mirror by depth too; a mirrored picture shows the same") {
  const RenderedView view = test::wide_view({160, 120});
  const DepthImage depth = test::room().depth_image(view);
  DepthImage reversed = depth;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) reversed.distance_m[static_cast<std::size_t>(y * 160 + x)] = depth.at(159 - x, y);
  }
  RenderedView other_view = view, turned_over = view;
  other_view.tangents = mirrored(view.tangents);
  std::swap(turned_over.tangents.left, turned_over.tangents.right);
  DepthSurface surface, other, over;
  REQUIRE(surface.update(view, depth) == DepthProblem::none);
  REQUIRE(other.update(other_view, reversed) == DepthProblem::none);
  REQUIRE(over.update(turned_over, reversed) == DepthProblem::none);
  const auto mirrored_pose = [](const Rigid& X) {
    return Rigid(Quaternion(X.q().w(), X.q().x(), -X.q().y(), -X.q().z()), Vector3(-X.p().x(), X.p().y(), X.p().z()));
  };
  test::Random random(804);
  int covered = 0, disoccluded = 0;
  for (int i = 0; i < 200; ++i) {
    const LatePoses late{random.pose(0.03, 0.05), random.pose(0.03, 0.05)};
    const DepthSearch search(surface, ScanPose({}, late)), over_search(over, ScanPose({}, late));
    const DepthSearch other_search(other, ScanPose({}, {mirrored_pose(late.X_WE_begin), mirrored_pose(late.X_WE_end)}));
    for (int k = 0; k < 10; ++k) {
      const Vector2 t_E(random.uniform(-0.5, 0.5), random.uniform(-0.35, 0.35));
      const double s = random.uniform(0, 1);
      const auto a = search.source(t_E, s), b = other_search.source(Vector2(-t_E.x(), t_E.y()), s);
      const auto c = over_search.source(t_E, s);
      REQUIRE((a && b && c));
      covered += a->state == SourceState::covered ? 1 : 0;
      disoccluded += a->state == SourceState::disoccluded ? 1 : 0;
      CHECK(a->state == b->state);
      CHECK(a->state == c->state);
      CHECK((Vector2(-a->t_S.x(), a->t_S.y()) - b->t_S).norm() < 1e-12);
      CHECK((a->t_S - c->t_S).norm() < 1e-12);
    }
  }
  CHECK(covered > 1500);
  CHECK(disoccluded > 20);
}

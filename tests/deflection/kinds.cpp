// The table of docs/deflection.md: what each kind of deflection leaves of each motion, in one room seen by one eye.
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/deflect.hpp>

#include "deflection/depth_scene.hpp"
#include "deflection/setups.hpp"

using namespace holdfast;

namespace {

struct Motion {
  std::string name;
  LatePoses X_SE;  // the late eye in the frame of the picture
  bool rolling = false;
};

Rigid turned(double pitch_deg, double yaw_deg, double roll_deg, const Vector3& step = Vector3::Zero()) {
  const Vector3 phi(degrees(pitch_deg).radians(), degrees(yaw_deg).radians(), degrees(roll_deg).radians());
  return {so3::exp<double>(phi), step};
}

std::vector<Motion> motions() {
  const double half = 100.0 * 0.0111 / 2.0;  // degrees from the scan's middle to its ends
  return {{"yaw 3 deg", LatePoses::at_once(turned(0, 3, 0)), false},
          {"roll 3 deg", LatePoses::at_once(turned(0, 0, 3)), false},
          {"10 mm right", LatePoses::at_once(turned(0, 0, 0, Vector3(0.01, 0, 0))), false},
          {"turn and 30 mm", LatePoses::at_once(turned(1, 2, 1, Vector3(0.02, 0.01, -0.02))), false},
          {"100 deg/s scan", {turned(0, 3 - half, 0), turned(0, 3 + half, 0)}, true}};
}

/// What the eye should see of the picture, on a grid of its pixels; without what S did not see, or what lies within 2 px
/// of a depth edge in the picture or as E sees it.
struct Expected {
  Vector2 pixel, source;
};
std::vector<Expected> expected_pixels(const ComposedWarp& by_depth, const test::DepthScene& scene) {
  const DepthSearch& search = *by_depth.depth();
  const RenderedView& view = by_depth.view();
  std::vector<Expected> pixels;
  for (int y = 4; y < by_depth.eye().resolution.height; y += 8) {
    for (int x = 4; x < by_depth.eye().resolution.width; x += 8) {
      const Vector2 pixel(x + 0.5, y + 0.5);
      const double s = by_depth.line_fraction(pixel);
      const auto truth = scene.truth(search.X_SE().at(s), tangent_of_pixel(by_depth.eye(), pixel));
      if (!truth || !truth->was_seen || test::near_edge(search.surface(), truth->t_S, 2)) continue;
      const Vector2 source = source_pixel_of_tangent(view, truth->t_S);
      const Vector2 searched = tangent_of_source_pixel(view, by_depth.sample(pixel).pixel);
      if (!is_inside(view, source) || test::near_edge(search.surface(), searched, 2)) continue;
      pixels.push_back({pixel, source});
    }
  }
  return pixels;
}

/// RMS distance, in source px, from what is shown to what should be.
double rms_px(const ComposedWarp& warp, const std::vector<Expected>& expected) {
  double sum = 0.0;
  for (const Expected& e : expected) sum += (*warp.source_pixel(e.pixel) - e.source).squaredNorm();
  return std::sqrt(sum / double(expected.size()));
}

}  // namespace

TEST_CASE("what each kind of deflection leaves of each motion") {
  const EyeModel eye = default_hmd().left;
  FieldTangents wider = eye.tangents;
  for (double* edge : {&wider.left, &wider.right, &wider.down, &wider.up}) *edge *= 1.15;
  // As many pixels per tangent as the panel: 1280 * 1.15.
  const RenderedView view{turned(20, 50, 10, Vector3(1, 2, 3)), wider, {1472, 828}, {}};
  const test::DepthScene scene = test::room();
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);

  struct Row {
    std::string name;
    DeflectionSettings settings;
    std::vector<double> rms;
  };
  std::vector<Row> rows;
  for (const DeflectionKind kind : deflection_kinds) {
    if (kind == DeflectionKind::rotation) rows.push_back({"rotation, all lines alike", {kind, 2.0, false}, {}});
    rows.push_back({std::string(name_of(kind)), {kind, 1.2, true}, {}});
  }
  std::ostringstream table;
  table << "| kind |";
  for (const Motion& motion : motions()) table << ' ' << motion.name << " |";
  for (Row& row : rows) {
    table << "\n| " << row.name << " |" << std::fixed << std::setprecision(3);
    for (const Motion& motion : motions()) {
      const LatePoses late{view.X_WS * motion.X_SE.X_WE_begin, view.X_WS * motion.X_SE.X_WE_end};
      const DeflectionResult result = deflect(row.settings, view, late);
      REQUIRE(result.ok());
      DisplayTiming timing;
      timing.scan_out = motion.rolling ? ScanOut::rolling : ScanOut::global;
      timing.scan_duration = from_milliseconds(11.1);
      const ComposedWarp by_depth(eye, LensMode::none, timing, view, DepthSearch(surface, ScanPose(view.X_WS, late)));
      const ComposedWarp by_matrix(eye, LensMode::none, timing, view, result.H_SE);
      const std::vector<Expected> expected = expected_pixels(by_depth, scene);
      REQUIRE(expected.size() > 5000);
      row.rms.push_back(rms_px(row.settings.kind == DeflectionKind::depth ? by_depth : by_matrix, expected));
      table << ' ' << row.rms.back() << " |";
    }
  }
  MESSAGE("RMS px:\n", table.str());

  const auto& none = rows[0].rms;
  const auto& shift = rows[1].rms;
  const auto& shift_roll = rows[2].rms;
  const auto& alike = rows[3].rms;
  const auto& rotation = rows[4].rms;
  const auto& plane = rows[5].rms;
  const auto& depth = rows[6].rms;
  CHECK(none[0] > 50.0);  // 3 degrees are 58 px at the centre
  CHECK(shift[0] < 0.2 * none[0]);
  CHECK(shift[1] == doctest::Approx(none[1]).epsilon(1e-6));
  CHECK(shift_roll[1] < 1e-9);
  CHECK(rotation[0] < 1e-9);
  CHECK(rotation[1] < 1e-9);
  CHECK(rotation[2] == doctest::Approx(none[2]).epsilon(1e-6));
  CHECK(plane[2] < rotation[2]);
  CHECK(alike[4] > 2.0);
  CHECK(rotation[4] < 1e-3);
  for (const double rms : depth) CHECK(rms < 0.1);
}

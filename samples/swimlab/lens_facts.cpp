#include "lens_facts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <holdfast/io/lens_writer.hpp>

namespace swimlab {

using namespace holdfast;

namespace {

constexpr int samples_a_side = 201;

void measure_residual(const EyeModel& eye, const Lens& lens, LensFacts& facts) {
  const Vector2 px = pixels_per_tangent(eye).cwiseAbs();
  double squares = 0.0;
  int dark = 0, count = 0;
  for (int row = 0; row < samples_a_side; ++row) {
    for (int column = 0; column < samples_a_side; ++column) {
      const Vector2 pixel(eye.resolution.width * (column + 0.5) / samples_a_side,
                          eye.resolution.height * (row + 0.5) / samples_a_side);
      const auto seen = lens.distort(tangent_of_pixel(eye, pixel));
      if (!seen) {
        ++dark;
        continue;
      }
      const auto panel = lens.undistort(*seen);
      const auto again = panel ? lens.distort(*panel) : std::nullopt;
      if (!again) {
        ++facts.unanswered;
        continue;
      }
      const double off = (*again - *seen).cwiseProduct(px).norm();
      squares += off * off;
      facts.residual_max_px = std::max(facts.residual_max_px, off);
      ++count;
    }
  }
  facts.residual_rms_px = count > 0 ? std::sqrt(squares / count) : 0.0;
  facts.dark_pct = 100.0 * dark / (samples_a_side * samples_a_side);
}

/// Along one direction from the lens's centre, to the panel's rim.
std::optional<LensEnd> end_along(const EyeModel& eye, const Lens& lens, const Vector2& direction) {
  const Vector2 centre = pixel_of_tangent(eye, lens.centre());
  double rim = 1e300;
  for (int axis = 0; axis < 2; ++axis) {
    const double size = axis == 0 ? eye.resolution.width : eye.resolution.height;
    if (direction[axis] > 0.0) rim = std::min(rim, (size - centre[axis]) / direction[axis]);
    if (direction[axis] < 0.0) rim = std::min(rim, -centre[axis] / direction[axis]);
  }
  const auto seen = [&](double r) { return lens.distort(tangent_of_pixel(eye, Vector2(centre + r * direction))); };
  if (!(rim > 0.0) || seen(rim) || !seen(0.0)) return std::nullopt;
  double inside = 0.0, outside = rim;
  for (int i = 0; i < 60; ++i) {
    const double middle = (inside + outside) / 2.0;
    (seen(middle) ? inside : outside) = middle;
  }
  return LensEnd{inside, centre + inside * direction, radians(std::atan(seen(inside)->norm()))};
}

void find_ends(const EyeModel& eye, const Lens& lens, LensFacts& facts) {
  constexpr int directions = 720;
  for (int i = 0; i < directions; ++i) {
    const double a = 2.0 * std::numbers::pi * i / directions;
    const auto end = end_along(eye, lens, Vector2(std::cos(a), std::sin(a)));
    if (!end) continue;
    if (!facts.first_end || end->radius_px < facts.first_end->radius_px) facts.first_end = end;
    if (!facts.last_end || end->radius_px > facts.last_end->radius_px) facts.last_end = end;
  }
}

std::optional<SampleFacts> sample_facts(const Lens& lens) {
  const auto* model = lens.model_if<PointMeshLens>();
  if (model == nullptr) return std::nullopt;
  const PointMesh& mesh = model->mesh();
  SampleFacts facts{mesh.samples.size(), mesh.triangles.size() + mesh.folds.size()};
  for (const PointMeshFold& fold : mesh.folds) ++(fold.area_ratio > 0.0 ? facts.cut_off : facts.folded);
  return facts;
}

}  // namespace

std::vector<LensFacts> facts_of(const EyeModel& eye) {
  const bool chromatic = eye.lens_red || eye.lens_blue;
  std::vector<LensFacts> all;
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    if (!chromatic && color != Color::green) continue;
    constexpr std::array names{"red", "green", "blue"};
    const Lens& lens = eye.lens_of(color);
    LensFacts& facts = all.emplace_back();
    facts.color = chromatic ? names[static_cast<std::size_t>(color)] : "all";
    facts.model = io::detail::lens_json(lens).at("model").get<std::string>();
    facts.valid_radius_px = lens.valid_radius() * pixels_per_tangent(eye).cwiseAbs().minCoeff();
    measure_residual(eye, lens, facts);
    find_ends(eye, lens, facts);
    facts.samples = sample_facts(lens);
  }
  return all;
}

}  // namespace swimlab

#include <chrono>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/optics.hpp>

using namespace holdfast;

namespace {

/// The tangents in S of a point at t_E and depth d, by the definition.
Vector2 moved(const Vector2& t_E, double depth, const Vector3& angles, const Vector3& p_SE) {
  const Quaternion q_SE = so3::exp<double>(Vector3(0.0, angles.x(), 0.0)) *
                          so3::exp<double>(Vector3(angles.y(), 0.0, 0.0)) *
                          so3::exp<double>(Vector3(0.0, 0.0, angles.z()));
  const Vector3 p_S = q_SE * (depth * Vector3(t_E.x(), t_E.y(), -1.0)) + p_SE;
  REQUIRE(p_S.z() < 0.0);
  return tangents_of_point(p_S).value();
}

struct Sampled {
  FieldTangents reached;  ///< the extremes that were met
  double outside = 0.0;   ///< the farthest beyond the field
};

/// Random points of the field under random motions within the budget, many of them at the ends of their ranges.
Sampled sample(const FieldTangents& field, const DeflectionBudget& budget, const FieldTangents& wide, unsigned seed,
               int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto within = [&](double low, double high) {
    const double u = uniform(random);
    return low + (high - low) * (u < 0.3 ? 0.0 : u > 0.7 ? 1.0 : (u - 0.3) / 0.4);
  };
  Sampled out;
  out.reached = {1e9, -1e9, 1e9, -1e9};
  for (int i = 0; i < count; ++i) {
    const Vector2 t_E(within(field.left, field.right), within(field.down, field.up));
    const Vector3 angles(within(-budget.yaw.radians(), budget.yaw.radians()),
                         within(-budget.pitch.radians(), budget.pitch.radians()),
                         within(-budget.roll.radians(), budget.roll.radians()));
    Vector3 p_SE = Vector3::Zero();
    double depth = 1.0;
    if (budget.translation_m > 0.0) {
      // The worst directions are level or upright, but some are tried in space and at a part of the way.
      const double a = 2.0 * std::numbers::pi * uniform(random);
      std::normal_distribution<double> normal;
      const int kind = i % 4;
      p_SE = kind == 0   ? Vector3(std::cos(a), 0.0, std::sin(a))
             : kind == 1 ? Vector3(0.0, std::cos(a), std::sin(a))
                         : Vector3(Vector3(normal(random), normal(random), normal(random)).normalized());
      p_SE *= budget.translation_m * (kind == 3 ? uniform(random) : 1.0);
      depth = budget.nearest_m * (1.0 + (kind == 3 ? uniform(random) : 0.0));
    }
    const Vector2 t = moved(t_E, depth, angles, p_SE);
    out.reached = {std::min(out.reached.left, t.x()), std::max(out.reached.right, t.x()),
                   std::min(out.reached.down, t.y()), std::max(out.reached.up, t.y())};
    out.outside = std::max({out.outside, wide.left - t.x(), t.x() - wide.right, wide.down - t.y(), t.y() - wide.up});
  }
  return out;
}

FieldTangents random_field(std::mt19937& random) {
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const double x = uniform(-0.6, 0.6), y = uniform(-0.6, 0.6);  // some have the axis outside
  const double half_w = uniform(0.1, 0.7), half_h = uniform(0.1, 0.7);
  return {x - half_w, x + half_w, y - half_h, y + half_h};
}

}  // namespace

TEST_CASE("no budget: the field itself, to the last bit") {
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const FieldTangents field = random_field(random);
    CHECK(overfilled(field, {}) == field);
    CHECK(overfilled_size({1280, 720}, field, overfilled(field, {})) == PixelSize{1280, 720});
  }
}

TEST_CASE("closed forms for one angle") {
  const FieldTangents field{-0.6, 0.5, -0.3, 0.4};
  const Angle a = degrees(5.0);
  // Yaw alone: the edges' own angles grow by it; the far corners rise by 1 / (cos a - |x| sin a), being turned nearer
  // to the plane of the eye.
  const FieldTangents yaw = overfilled(field, {a, {}, {}});
  CHECK(yaw.right == doctest::Approx(std::tan(std::atan(0.5) + a.radians())).epsilon(1e-13));
  CHECK(yaw.left == doctest::Approx(-std::tan(std::atan(0.6) + a.radians())).epsilon(1e-13));
  CHECK(yaw.up == doctest::Approx(0.4 / (cos(a) - 0.6 * sin(a))).epsilon(1e-13));
  CHECK(yaw.down == doctest::Approx(-0.3 / (cos(a) - 0.6 * sin(a))).epsilon(1e-13));
  const FieldTangents pitch = overfilled(field, {{}, a, {}});
  CHECK(pitch.up == doctest::Approx(std::tan(std::atan(0.4) + a.radians())).epsilon(1e-13));
  CHECK(pitch.right == doctest::Approx(0.5 / (cos(a) - 0.4 * sin(a))).epsilon(1e-13));
  // Roll alone: corners move on circles.
  const FieldTangents roll = overfilled(field, {{}, {}, a});
  CHECK(roll.right == doctest::Approx(0.5 * cos(a) + 0.4 * sin(a)).epsilon(1e-13));
  CHECK(roll.up == doctest::Approx(0.4 * cos(a) + 0.6 * sin(a)).epsilon(1e-13));
  // A roll by 90 degrees passes the near corners' own radius on the way.
  CHECK(overfilled(field, {{}, {}, degrees(90)}).right == doctest::Approx(std::hypot(0.5, 0.4)).epsilon(1e-13));
  CHECK(overfilled(field, {{}, {}, degrees(90)}).left == doctest::Approx(-std::hypot(0.6, 0.4)).epsilon(1e-13));
  // Moving sideways by d at depth z with nothing turned: the sphere's tangent plane.
  const FieldTangents moved_eye = overfilled(field, {{}, {}, {}, 0.02, 0.5});
  CHECK(moved_eye.right ==
        doctest::Approx(std::tan(std::atan(0.5) + std::asin(0.04 / std::hypot(0.5, 1.0)))).epsilon(1e-13));
}

TEST_CASE("nothing within the budget is left uncovered, and a little less would leave something") {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (unsigned i = 0; i < 30; ++i) {
    CAPTURE(i);
    const FieldTangents field = random_field(random);
    DeflectionBudget budget{degrees(uniform(0, 12)), degrees(uniform(0, 10)), degrees(uniform(0, 15))};
    if (i % 3 == 0) {
      budget.translation_m = uniform(0.0, 0.03);
      budget.nearest_m = uniform(0.4, 2.0);
    }
    const FieldResult wide = try_overfilled(field, budget);
    REQUIRE(wide.ok());
    const Sampled sampled = sample(field, budget, wide.value(), i, 60'000);
    CHECK(sampled.outside < 1e-12);  // rounding of tangents of about 1
    // Tight: samples at the ends of all ranges come to the extremes, but for a motion in just the worst direction, or
    // one inside its range: they come near with their number.
    const double near = budget.translation_m > 0.0 ? 4e-3 : 1e-4;
    const FieldTangents& t = wide.value();
    CHECK(sampled.reached.right > t.right - near);
    CHECK(sampled.reached.left < t.left + near);
    CHECK(sampled.reached.up > t.up - near);
    CHECK(sampled.reached.down < t.down + near);
  }
}

TEST_CASE("a mirrored field needs the mirrored overfill") {
  std::mt19937 random(8);
  for (int i = 0; i < 10; ++i) {
    const FieldTangents field = random_field(random);
    const DeflectionBudget budget{degrees(4), degrees(3), degrees(5), 0.01, 0.7};
    CHECK(overfilled(mirrored(field), budget) == mirrored(overfilled(field, budget)));
    // Edges in swapped order, a mirrored picture, stay so.
    const FieldTangents swapped{field.right, field.left, field.down, field.up};
    const FieldTangents wide = overfilled(field, budget);
    CHECK(overfilled(swapped, budget) == FieldTangents{wide.right, wide.left, wide.down, wide.up});
  }
}

TEST_CASE("pixels stay as dense") {
  const PixelSize size{1280, 720};
  const FieldTangents field{-0.6, 0.5, -0.3, 0.4};
  const FieldTangents wide = overfilled(field, {degrees(5), degrees(4), degrees(3)});
  const PixelSize more = overfilled_size(size, field, wide);
  const double density = size.width / 1.1, wide_density = more.width / (wide.right - wide.left);
  CHECK(wide_density >= density);
  CHECK(wide_density < density * (more.width + 1.0) / more.width);
  CHECK(more.height / (wide.up - wide.down) >= size.height / 0.7);
}

TEST_CASE("whole pixels: every pixel of the panel's own picture is one of the wider one") {
  EyeModel eye = default_hmd().left;
  const EyePicture wide = whole_pixels(eye, overfilled(eye.tangents, {degrees(5), degrees(4), degrees(3)}));
  const Vector2 px = pixels_per_tangent(eye);
  CHECK(wide.size.width / (wide.tangents.right - wide.tangents.left) == doctest::Approx(px.x()).epsilon(1e-13));
  CHECK(wide.size.height / (wide.tangents.up - wide.tangents.down) == doctest::Approx(px.y()).epsilon(1e-13));
  const double shift = (eye.tangents.left - wide.tangents.left) * px.x();
  CHECK(std::abs(shift - std::round(shift)) < 1e-9);
  const FieldTangents least = overfilled(eye.tangents, {degrees(5), degrees(4), degrees(3)});
  CHECK(wide.tangents.right >= least.right - 1e-12);
  CHECK(wide.tangents.right < least.right + 1.01 / px.x());
  CHECK(whole_pixels(eye, eye.tangents).size == eye.resolution);
}

TEST_CASE("through the lens: what the panel shows, deflected") {
  const EyeModel eye = default_hmd().left;
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  const FieldTangents shown = shown_field(mesh).value();
  // The corners are seen farthest out: r (1 + k r^2).
  const double x = eye.tangents.right, y = eye.tangents.up, s = 1.0 + 0.1933 * (x * x + y * y) / (y * y);
  CHECK(shown.right == doctest::Approx(x * s).epsilon(1e-6));  // float
  CHECK(shown.down == doctest::Approx(-y * s).epsilon(1e-6));
  const DeflectionBudget budget{degrees(5), degrees(4), degrees(3)};
  const FieldTangents wide = overfilled(mesh, budget).value();
  const FieldTangents whole = overfilled(shown, budget);
  CHECK(wide.right <= whole.right + 1e-12);
  CHECK(wide.right > shown.right);
  // Any point of the panel, turned by anything within the budget.
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 20'000; ++i) {
    const Vector2 t_E = *eye.lens.distort(Vector2((2 * uniform(random) - 1) * x, (2 * uniform(random) - 1) * y));
    const Vector3 angles((2 * uniform(random) - 1) * budget.yaw.radians(),
                         (2 * uniform(random) - 1) * budget.pitch.radians(),
                         (2 * uniform(random) - 1) * budget.roll.radians());
    const Vector2 t = moved(t_E, 1.0, angles, Vector3::Zero());
    CHECK(t.x() < wide.right + 1e-6);
    CHECK(t.y() > wide.down - 1e-6);
  }
}

TEST_CASE("per scanline: lines lit early need less") {
  const EyeModel eye = default_hmd().left;
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact, {.max_error_px = 0.5});
  const DeflectionBudget last{degrees(6), degrees(5), degrees(4)};
  const FieldTangents all = overfilled(mesh, last).value();
  const auto same = [](const FieldTangents& a, const FieldTangents& b, double by) {
    return std::abs(a.left - b.left) < by && std::abs(a.right - b.right) < by && std::abs(a.down - b.down) < by &&
           std::abs(a.up - b.up) < by;
  };
  CHECK(same(overfilled(mesh, last, last, ScanDirection::top_to_bottom).value(), all, 1e-9));
  // From the top: the picture's top is lit first, and need not be widened upward by the whole pitch.
  const FieldTangents down = overfilled(mesh, {}, last, ScanDirection::top_to_bottom).value();
  CHECK(down.down == doctest::Approx(all.down).epsilon(1e-9));
  CHECK(down.up < all.up - 0.02);
  CHECK(down.up >= shown_field(mesh).value().up);
  const FieldTangents up = overfilled(mesh, {}, last, ScanDirection::bottom_to_top).value();
  CHECK(up.up == doctest::Approx(-down.down).epsilon(1e-9));  // the eye is symmetric
  CHECK(up.right == doctest::Approx(down.right).epsilon(1e-9));
  const FieldTangents right = overfilled(mesh, {}, last, ScanDirection::left_to_right).value();
  CHECK(right.right == doctest::Approx(all.right).epsilon(1e-9));
  CHECK(right.left > all.left + 0.02);
  // Each point with the motion of its own line stays inside.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 20'000; ++i) {
    const Vector2 uv(uniform(random), uniform(random));
    const Vector2 pixel(uv.x() * eye.resolution.width, uv.y() * eye.resolution.height);
    const Vector2 t_E = *eye.lens.distort(tangent_of_pixel(eye, pixel));
    const double share = 1.0 - uv.y();
    const Vector3 angles = share * Vector3(uniform(random) < 0.5 ? -last.yaw.radians() : last.yaw.radians(),
                                           uniform(random) < 0.5 ? -last.pitch.radians() : last.pitch.radians(),
                                           uniform(random) < 0.5 ? -last.roll.radians() : last.roll.radians());
    const Vector2 t = moved(t_E, 1.0, angles, Vector3::Zero());
    // The mesh is 0.5 px true at 1108 px per tangent.
    CHECK(t.x() < down.right + 5e-4);
    CHECK(t.x() > down.left - 5e-4);
    CHECK(t.y() < down.up + 5e-4);
    CHECK(t.y() > down.down - 5e-4);
  }
}

TEST_CASE("a budget from how heads move") {
  const HeadDynamics head;  // 0.3 rad/s and 2.5 rad/s^2 per axis, 0.25 m/s and 0.6 m/s^2
  const DeflectionBudget budget = budget_of(head, std::chrono::milliseconds(50), 0.5, 3.0);
  CHECK(budget.yaw.radians() == doctest::Approx(3 * std::hypot(0.3 * 0.05, 2.5 * 0.05 * 0.05 / 2)).epsilon(1e-12));
  CHECK(budget.yaw == budget.roll);
  CHECK(budget.translation_m ==
        doctest::Approx(std::sqrt(3.0) * 3 * std::hypot(0.25 * 0.05, 0.6 * 0.05 * 0.05 / 2)).epsilon(1e-12));
  CHECK(budget.nearest_m == 0.5);
  CHECK(budget_of(head, std::chrono::milliseconds(0)).pitch == radians(0.0));
}

TEST_CASE("bad input is named") {
  const FieldTangents field{-1.0, 1.0, -1.0, 1.0};
  CHECK(try_overfilled({1.0, 1.0, -1.0, 1.0}, {}).problem == FieldProblem::zero_width);
  CHECK(try_overfilled(field, {degrees(46), {}, {}}).problem == FieldProblem::angle_beyond_90);
  CHECK(try_overfilled(field, {{}, {}, {}, 0.5, 0.5}).problem == FieldProblem::angle_beyond_90);
  CHECK(try_overfilled(field, {{}, {}, {}, 2.0, 0.5}).problem == FieldProblem::angle_beyond_90);
  CHECK(try_overfilled(field, {degrees(-1), {}, {}}).problem == FieldProblem::angle_beyond_90);
  CHECK(try_overfilled(field, {radians(std::nan("")), {}, {}}).problem == FieldProblem::not_finite);
  CHECK(try_overfilled(field, {{}, {}, {}, -0.1, 1.0}).problem == FieldProblem::extent_not_positive);
  CHECK(try_overfilled(field, {{}, {}, {}, 0.1, 0.0}).problem == FieldProblem::extent_not_positive);
  CHECK(overfilled_points({}, {}).problem == FieldProblem::zero_width);
  CHECK(overfilled(PredistortionMesh{}, {}).problem == FieldProblem::zero_width);
  CHECK(shown_field(PredistortionMesh{}).problem == FieldProblem::zero_width);
}

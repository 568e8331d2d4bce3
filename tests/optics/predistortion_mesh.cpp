#include <filesystem>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/optics/optics.hpp>

#include "mesh_checks.hpp"

using namespace holdfast;
using namespace holdfast::test;

namespace {

/// The default headset's left eye with red and blue bent a little differently.
EyeModel chromatic_eye() {
  EyeModel eye = default_hmd().left;
  const double half_height = eye.tangents.up;
  eye.lens_red = Lens(RadialLens{0.185}, placed_at(half_height));
  eye.lens_blue = Lens(PolynomialLens(std::vector{0.2, 0.01}, 1.01), placed_at(half_height, Vector2(0.002, 0.0)));
  return eye;
}

/// A lens that folds inside the panel: r (1 - 0.15 r^2) is largest at r = 1.49, and the panel's corners are at 2.04.
EyeModel folding_eye() {
  EyeModel eye = default_hmd().left;
  eye.lens = Lens(RadialLens{-0.15}, placed_at(eye.tangents.up));
  return eye;
}

EyeModel random_eye(std::mt19937& random) {
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  EyeModel eye;
  eye.side = uniform(0, 1) < 0.5 ? EyeSide::left : EyeSide::right;
  eye.upside_down = uniform(0, 1) < 0.3;
  eye.resolution = {static_cast<int>(uniform(200, 1500)), static_cast<int>(uniform(200, 1500))};
  eye.tangents = {uniform(-1.3, -0.4), uniform(0.4, 1.3), uniform(-1.3, -0.4), uniform(0.4, 1.3)};
  if (uniform(0, 1) < 0.2) std::swap(eye.tangents.left, eye.tangents.right);
  const auto lens = [&] {
    const std::vector<double> k{uniform(-0.2, 0.3), uniform(-0.1, 0.2), uniform(-0.05, 0.1)};
    return Lens(PolynomialLens(k, uniform(0.97, 1.03)),
                placed_at(uniform(0.8, 1.2), Vector2(uniform(-0.1, 0.1), uniform(-0.1, 0.1))));
  };
  eye.lens = lens();
  if (uniform(0, 1) < 0.3) {
    eye.lens_red = eye.lens;
    eye.lens_blue = Lens(eye.lens.model(), {Vector2(eye.lens.centre() + Vector2(0.003, 0.0)),
                                            Vector2(eye.lens.placement().scale * 1.02)});
  }
  return eye;
}

}  // namespace

TEST_CASE("the error between the vertices keeps to the bound, and the bound decides the vertices") {
  const EyeModel eye = default_hmd().left;
  std::size_t coarser = 1'000'000;
  for (const double bound : {0.01, 0.05, 0.2, 1.0}) {
    CAPTURE(bound);
    const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact, {.max_error_px = bound});
    REQUIRE(mesh.ok());
    CHECK(mesh.max_error_px <= bound);
    const double measured = dense_error_px(eye, LensMode::exact, mesh, 5);
    CHECK(measured <= mesh.max_error_px);
    CHECK(measured > 0.7 * mesh.max_error_px);  // what is stated is not far too much
    CHECK(mesh.vertices.size() < coarser);
    coarser = mesh.vertices.size();
  }
  // 0.05 px at 1280 x 720. Triangles d along the radius and L across err by (f'' d^2 + A L^2) / 8, with f'' = 6 k r and
  // A = 2 k r in the lens's unit of 360 px. With half of the bound each their area d L / 2 is 2 e / sqrt(f'' A): 19,000 of
  // them at r = 400 px, the mean, if each had all of the bound; a fifth more for the margin, and what rings cannot share.
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  CHECK(mesh.triangle_count() > 19'000);
  CHECK(mesh.triangle_count() < 30'000);
  CHECK_FALSE(mesh.per_color);
}

TEST_CASE("vertices show exactly what the lens shows") {
  const EyeModel eye = chromatic_eye();
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  REQUIRE(mesh.per_color);
  for (const PredistortionVertex& v : mesh.vertices) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto exact = ideal_tangent_at_panel(eye.lens_of(static_cast<Color>(c)), LensMode::exact,
                                                tangent_of_pixel(eye, panel_pixel(eye, v)));
      REQUIRE(exact.has_value());
      CHECK((tangent(v, c) - *exact).norm() < 1.5e-7);  // float: half a unit in the last place of tangents up to 2
    }
  }
}

TEST_CASE("the mesh tiles the panel: no tear, no overlap") {
  for (const double bound : {0.05, 0.7}) {
    const PredistortionMesh mesh = adaptive_mesh(default_hmd().left, LensMode::exact, {.max_error_px = bound});
    // Triangles the right way round, whose areas sum to the panel's and whose outline is its rim, tile it.
    CHECK(inner_outline(mesh).empty());
    CHECK(covered(mesh) == 1.0);
    CHECK(folds(default_hmd().left, mesh) == 0);
  }
}

TEST_CASE("the bound holds in every colour") {
  const EyeModel eye = chromatic_eye();
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  REQUIRE(mesh.ok());
  CHECK(mesh.per_color);
  CHECK(dense_error_px(eye, LensMode::exact, mesh, 3) <= mesh.max_error_px);
  CHECK(mesh.max_error_px <= 0.05);
}

TEST_CASE("random headsets: bound, tears, folds, mirrors and half turns") {
  std::mt19937 random(11);
  for (int i = 0; i < 25; ++i) {
    CAPTURE(i);
    const EyeModel eye = random_eye(random);
    const AdaptiveMeshOptions options{.max_error_px = 0.3};
    const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact, options);
    REQUIRE(mesh.ok());
    CHECK(mesh.max_error_px <= 0.3);
    CHECK(dense_error_px(eye, LensMode::exact, mesh, 4) <= mesh.max_error_px);
    CHECK(folds(eye, mesh) == 0);
    inner_outline(mesh);

    const PredistortionMesh other = adaptive_mesh(mirrored(eye), LensMode::exact, options);
    REQUIRE(other.vertices.size() == mesh.vertices.size());
    REQUIRE(other.triangles.size() == mesh.triangles.size());
    bool same = true;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      PredistortionVertex expected = mesh.vertices[v];
      expected.panel_x = 1.0f - expected.panel_x;
      for (auto& t : expected.tangent) t[0] = -t[0];
      same = same && other.vertices[v] == expected;
    }
    CHECK(same);

    EyeModel turned = eye;
    turned.upside_down = !eye.upside_down;
    const PredistortionMesh half_turn = adaptive_mesh(turned, LensMode::exact, options);
    REQUIRE(half_turn.vertices.size() == mesh.vertices.size());
    same = half_turn.triangles == mesh.triangles;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      PredistortionVertex expected = mesh.vertices[v];
      expected.panel_x = 1.0f - expected.panel_x;
      expected.panel_y = 1.0f - expected.panel_y;
      same = same && half_turn.vertices[v] == expected;
    }
    CHECK(same);
  }
}

TEST_CASE("both eyes at once: the same meshes to the last bit, mirror images or not") {
  const auto check = [](const HmdModel& hmd, const AdaptiveMeshOptions& options) {
    AdaptiveMeshOptions of_right = options;
    if (options.field) of_right.field = mirrored(*options.field);
    const EyeMeshes both = adaptive_meshes(hmd, LensMode::exact, options);
    const PredistortionMesh left = adaptive_mesh(hmd.left, LensMode::exact, options);
    const PredistortionMesh right = adaptive_mesh(hmd.right, LensMode::exact, of_right);
    REQUIRE(both.right.ok());
    CHECK(both.left.vertices == left.vertices);
    CHECK(both.left.triangles == left.triangles);
    CHECK(both.right.vertices == right.vertices);
    CHECK(both.right.triangles == right.triangles);
    CHECK(both.right.max_error_px == right.max_error_px);
    CHECK(both.right.per_color == right.per_color);
    CHECK(both.right.resolution == right.resolution);
  };
  HmdModel hmd = default_hmd();
  check(hmd, {.max_error_px = 0.3});
  hmd.left.tangents.left -= 0.1;  // no longer mirror images
  check(hmd, {.max_error_px = 0.3});
  hmd.right = mirrored(hmd.left);
  check(hmd, {.max_error_px = 0.3});
  check(hmd, {.max_error_px = 0.3, .field = FieldTangents{-0.5, 0.4, -0.3, 0.3}});
  hmd.left.upside_down = hmd.right.upside_down = true;
  check(hmd, {.max_error_px = 0.3});
  hmd.right.lens_red = Lens(RadialLens{0.19}, hmd.right.lens.placement());
  check(hmd, {.max_error_px = 0.3});
  hmd.left.resolution.width = 0;
  CHECK(adaptive_meshes(hmd, LensMode::exact).left.problem == MeshProblem::no_pixels);
}

namespace {

/// The Rift DK2's lens: a kink at 0.949 of r_max.
Lens kinked_lens(double r_max, double chroma) {
  CatmullRomCoefficients c;
  c.knots = {1.003, 1.02, 1.042, 1.066, 1.094, 1.126, 1.162, 1.203, 1.25, 1.31, 1.38};
  c.r_max = r_max;
  c.chroma = {chroma, chroma};
  return Lens(CatmullRomLens(c));
}
EyeModel kinked_eye() {
  EyeModel eye;
  eye.resolution = {480, 540};
  eye.tangents = {-0.86, 0.88, -0.98, 0.97};
  eye.lens = kinked_lens(1.0, 0.0);
  return eye;
}

/// The bound, tears, overlaps and folds.
void check_mesh(const EyeModel& eye, const AdaptiveMeshOptions& options) {
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact, options);
  REQUIRE(mesh.ok());
  CHECK(mesh.max_error_px <= options.max_error_px);
  CHECK(dense_error_px(eye, LensMode::exact, mesh, 4) <= mesh.max_error_px);
  CHECK(folds(eye, mesh) == 0);
  const std::vector<Edge> inner = inner_outline(mesh);
  if (options.field || std::isfinite(eye.lens.valid_radius())) return;
  CHECK(inner.empty());
  CHECK(covered(mesh) == 1.0);
}

}  // namespace

TEST_CASE("a kink lies between triangles, whatever else cuts them") {
  EyeModel eye = kinked_eye();
  check_mesh(eye, {});
  // Met by chance, it would take triangles of some 0.3 px: ten times as many.
  CHECK(adaptive_mesh(eye, LensMode::exact).vertices.size() < 13'000);
  check_mesh(eye, {.max_error_px = 1.0});
  check_mesh(eye, {.field = FieldTangents{-1.3, 1.3, -1.3, 1.3}});
  eye.lens_red = kinked_lens(1.0, -0.01);
  check_mesh(eye, {});
  eye.lens_blue = kinked_lens(0.99, 0.01);
  check_mesh(eye, {.max_error_px = 0.1});
  // Round centres of their own: bisection, cut along three circles.
  eye.lens_blue = eye.lens_blue->with_placement(placed_at(1.0, Vector2(0.004, -0.003)));
  check_mesh(eye, {.max_error_px = 0.1});
}

TEST_CASE("rings: bounds from fine to coarse, panels of any shape, lenses squeezed or off the middle") {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  int checked = 0;
  for (int i = 0; i < 40; ++i) {
    CAPTURE(i);
    EyeModel eye;
    eye.resolution = {static_cast<int>(uniform(40, 700)), static_cast<int>(uniform(40, 700))};
    eye.tangents = {uniform(-1.2, -0.05), uniform(0.05, 1.2), uniform(-1.2, -0.05), uniform(0.05, 1.2)};
    const LensPlacement place{Vector2(uniform(-0.05, 0.05), uniform(-0.05, 0.05)),
                              Vector2(uniform(0.8, 1.2) * (i % 2 ? 1.0 : -1.0), uniform(0.8, 1.2))};
    const int kind = i % 5;
    if (kind == 0) eye.lens = Lens(RadialLens{uniform(-0.3, 0.4)}, place);
    if (kind == 1) eye.lens = Lens(ViveLens({uniform(-0.2, 0.0), uniform(-0.1, 0.1), uniform(-0.05, 0.0), 0.0}), place);
    if (kind == 2) eye.lens = Lens(PowerSeriesLens(std::vector{1.0, uniform(-0.1, 0.1), uniform(-0.1, 0.3)}), place);
    if (kind == 3) eye.lens = Lens(PolynomialLens(std::vector{0.22, uniform(-0.4, 0.4)}), place);
    if (kind == 4) eye.lens = Lens(kinked_lens(uniform(0.4, 1.5), 0.01).model(), place);
    // The mesh is for lenses that enlarge up to 8 times; a Vive's may have its pole on the panel.
    const FieldTangents& t = eye.tangents;
    bool enlarges = false;
    for (const Vector2& corner :
         {Vector2(t.left, t.down), Vector2(t.right, t.down), Vector2(t.left, t.up), Vector2(t.right, t.up)}) {
      const bool shows = eye.lens.distort(corner).has_value();
      enlarges = enlarges || (shows ? eye.lens.distort_jacobian(corner).norm() > 8.0 : kind == 1);
    }
    if (enlarges) continue;
    ++checked;
    check_mesh(eye, {.max_error_px = std::exp(uniform(std::log(0.02), std::log(20.0)))});
  }
  CHECK(checked > 30);
}

TEST_CASE("where the lens folds the picture ends in a smooth line") {
  const EyeModel eye = folding_eye();
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  REQUIRE(mesh.ok());
  CHECK(dense_error_px(eye, LensMode::exact, mesh, 3) <= mesh.max_error_px);
  CHECK(folds(eye, mesh) == 0);
  // The stated end: where det J / |J| = 1/32, with J = diag(1 + 3 k r^2, 1 + k r^2) along and across the radius.
  const auto scale = [](double r) {
    const double along = 1.0 - 0.45 * r * r, across = 1.0 - 0.15 * r * r;
    return along * across / std::hypot(along, across) - 1.0 / 32.0;
  };
  double inside = 0.5, outside = 1.49;
  for (int i = 0; i < 60; ++i) (scale((inside + outside) / 2) > 0 ? inside : outside) = (inside + outside) / 2;
  const double radius_px = inside * eye.resolution.height / 2.0;
  const Vector2 middle(eye.resolution.width / 2.0, eye.resolution.height / 2.0);
  const std::vector<Edge> border = inner_outline(mesh);
  REQUIRE(border.size() > 20);
  for (const Edge& edge : border) {
    const Vector2 a = panel_pixel(eye, mesh.vertices[edge.first]) - middle;
    const Vector2 b = panel_pixel(eye, mesh.vertices[edge.second]) - middle;
    // Vertices: a border is found to 1/1024 of an edge of at most 32 px. Chords: to the tolerance that was asked for.
    CHECK(std::abs(a.norm() - radius_px) < 0.035);
    CHECK(std::abs(((a + b) / 2.0).norm() - radius_px) < 0.1);
  }
  // What is drawn is the panel's part of the disc: its area by columns.
  double area = 0.0;
  constexpr int columns = 100'000;
  for (int i = 0; i < columns; ++i) {
    const double x = (i + 0.5) / columns * eye.resolution.width - middle.x();
    const double half = std::sqrt(std::max(0.0, radius_px * radius_px - x * x));
    area += 2.0 * std::min(half, middle.y()) / eye.resolution.height / columns;
  }
  // The tolerance of 0.1 px over the border's length, some 900 px, over 921,600 px.
  CHECK(covered(mesh) == doctest::Approx(area).epsilon(1e-4));
}

TEST_CASE("a field cuts the mesh along its edges") {
  const EyeModel eye = chromatic_eye();
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact, {.field = eye.tangents});
  REQUIRE(mesh.ok());
  CHECK(dense_error_px(eye, LensMode::exact, mesh, 3) <= mesh.max_error_px);
  const FieldTangents& f = eye.tangents;
  for (const PredistortionVertex& v : mesh.vertices) {
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK(v.tangent[c][0] >= f.left - 1e-7);  // the last two: rounding to float
      CHECK(v.tangent[c][0] <= f.right + 1e-7);
      CHECK(v.tangent[c][1] >= f.down - 1e-7);
      CHECK(v.tangent[c][1] <= f.up + 1e-7);
    }
  }
  const Vector2 px = pixels_per_tangent(eye);
  std::size_t at_corners = 0;
  for (const Edge& edge : inner_outline(mesh)) {
    double nearest = 1e9;  // of any colour to any edge of the field, at the chord's middle
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector2 t = (tangent(mesh.vertices[edge.first], c) + tangent(mesh.vertices[edge.second], c)) / 2.0;
      nearest = std::min({nearest, (t.x() - f.left) * px.x(), (f.right - t.x()) * px.x(), (t.y() - f.down) * px.y(),
                          (f.up - t.y()) * px.y()});
    }
    // 0.1 px of the panel, where the lens magnifies up to 1 + 3 k r^2 = 3.4 times; at the four corners of the field,
    // which the mesh cuts off, an edge of half a pixel.
    CHECK(nearest < 2.0);
    at_corners += nearest > 0.34 ? 1 : 0;
  }
  CHECK(at_corners <= 12);
}

TEST_CASE("without a lens, or left uncorrected, every point shows itself") {
  for (const LensMode mode : {LensMode::none, LensMode::uncorrected}) {
    const EyeModel eye = chromatic_eye();
    const PredistortionMesh mesh = adaptive_mesh(eye, mode);
    REQUIRE(mesh.ok());
    CHECK(mesh.vertices.size() <= 8);
    CHECK(covered(mesh) == 1.0);
    CHECK_FALSE(mesh.per_color);
    CHECK(dense_error_px(eye, mode, mesh, 100) <= mesh.max_error_px);
    CHECK(mesh.max_error_px < 1e-3);
  }
}

TEST_CASE("the paper's cubic: the bound holds up to where its inverse all but folds") {
  const EyeModel eye = default_hmd().left;
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::cubic, {.max_error_px = 0.2});
  REQUIRE(mesh.ok());
  CHECK(mesh.max_error_px <= 0.2);
  CHECK(dense_error_px(eye, LensMode::cubic, mesh, 3) <= mesh.max_error_px);
  CHECK(folds(eye, mesh) == 0);
  CHECK(inner_outline(mesh).size() > 20);  // r - 0.1 r^3 folds at 1.826, which is drawn at 1.217: inside the corners
}

TEST_CASE("a fixed grid: its vertices, and an error that falls with the square of its cells") {
  const EyeModel eye = default_hmd().left;
  double last = 0.0;
  for (const int n : {8, 16, 32, 64}) {
    const PredistortionMesh mesh = grid_mesh(eye, LensMode::exact, n, n);
    REQUIRE(mesh.ok());
    CHECK(mesh.vertices.size() == static_cast<std::size_t>((n + 1) * (n + 1)));
    CHECK(mesh.triangle_count() == static_cast<std::size_t>(2 * n * n));
    CHECK(covered(mesh) == 1.0);
    CHECK(inner_outline(mesh).empty());
    const double measured = dense_error_px(eye, LensMode::exact, mesh, 40);
    CHECK(measured <= mesh.max_error_px);
    CHECK(measured > 0.9 * mesh.max_error_px);
    if (last > 0.0) CHECK(last / measured == doctest::Approx(4.0).epsilon(0.15));  // third derivatives fade away
    last = measured;
  }
  const PredistortionMesh cells = grid_mesh(eye, LensMode::exact, 7, 3);
  const PredistortionMesh other = grid_mesh(default_hmd().right, LensMode::exact, 7, 3);
  REQUIRE(cells.vertices.size() == 8 * 4);
  for (std::size_t i = 0; i < cells.vertices.size(); ++i) {
    CHECK(other.vertices[i].panel_x == 1.0f - cells.vertices[i].panel_x);
    CHECK(other.vertices[i].tangent[1][0] == -cells.vertices[i].tangent[1][0]);
  }
  // At equal vertices an adaptive mesh is the better one.
  const PredistortionMesh adaptive = adaptive_mesh(eye, LensMode::exact, {.max_error_px = 0.05});
  const int n = static_cast<int>(std::sqrt(static_cast<double>(adaptive.vertices.size())));
  CHECK(grid_mesh(eye, LensMode::exact, n, n).max_error_px > 1.3 * adaptive.max_error_px);
}

TEST_CASE("a lens of samples is drawn by its own triangles") {
  const Lens smooth(RadialLens{0.2});
  std::vector<PointMeshSample> samples;
  for (int y = -6; y <= 6; ++y) {
    for (int x = -6; x <= 6; ++x) {
      const Vector2 p(0.15 * x + 0.01 * (y % 3), 0.15 * y + 0.013 * (x % 2));  // larger than the panel
      samples.push_back({p, *smooth.distort(p)});
    }
  }
  const PointMeshResult result = make_point_mesh(samples);
  REQUIRE(result.ok());
  EyeModel eye;
  eye.resolution = {900, 700};
  eye.tangents = {-0.7, 0.6, -0.5, 0.55};
  eye.lens = Lens(PointMeshLens(result.mesh));
  const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  REQUIRE(mesh.ok());
  CHECK(inner_outline(mesh).empty());
  CHECK(covered(mesh) == 1.0);
  CHECK(mesh.vertices.size() < 250);
  CHECK(mesh.max_error_px < 0.001);
  CHECK(dense_error_px(eye, LensMode::exact, mesh, 50) <= mesh.max_error_px);
  // Cut by a field, too.
  const FieldTangents field{-0.5, 0.5, -0.45, 0.4};
  const PredistortionMesh part = adaptive_mesh(eye, LensMode::exact, {.field = field});
  REQUIRE(part.ok());
  CHECK(dense_error_px(eye, LensMode::exact, part, 50) <= part.max_error_px);
  for (const Edge& edge : inner_outline(part)) {
    const Vector2 t = (tangent(part.vertices[edge.first], 1) + tangent(part.vertices[edge.second], 1)) / 2.0;
    const double off =
        std::min({std::abs(t.x() + 0.5), std::abs(t.x() - 0.5), std::abs(t.y() + 0.45), std::abs(t.y() - 0.4)});
    CHECK(off < 2e-6);  // rounding to float and to the panel's lattice
  }
  // With red from other samples the triangles are not shared: bisection, which states what it reaches.
  for (PointMeshSample& s : samples) s.panel *= 0.98;
  const PointMeshResult red = make_point_mesh(samples);
  REQUIRE(red.ok());
  eye.lens_red = Lens(PointMeshLens(red.mesh));
  const PredistortionMesh colours = adaptive_mesh(eye, LensMode::exact, {.max_error_px = 0.5});
  REQUIRE(colours.ok());
  CHECK(colours.per_color);
  CHECK(dense_error_px(eye, LensMode::exact, colours, 10) <= colours.max_error_px);
}

TEST_CASE("bad input is named") {
  const EyeModel good = default_hmd().left;
  EyeModel eye = good;
  eye.resolution = {0, 720};
  CHECK(adaptive_mesh(eye, LensMode::exact).problem == MeshProblem::no_pixels);
  CHECK(grid_mesh(eye, LensMode::exact, 4, 4).problem == MeshProblem::no_pixels);
  eye = good;
  eye.tangents.left = eye.tangents.right;
  CHECK(adaptive_mesh(eye, LensMode::exact).problem == MeshProblem::impossible_field);
  eye.tangents.left = std::numeric_limits<double>::quiet_NaN();
  CHECK(adaptive_mesh(eye, LensMode::exact).problem == MeshProblem::impossible_field);
  CHECK(adaptive_mesh(good, LensMode::exact, {.field = FieldTangents{0, 0, -1, 1}}).problem ==
        MeshProblem::impossible_field);
  for (const double bound :
       {0.0, -1.0, 0.004, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK(adaptive_mesh(good, LensMode::exact, {.max_error_px = bound}).problem ==
          MeshProblem::error_bound_out_of_range);
  }
  CHECK(adaptive_mesh(good, LensMode::exact, {.border_error_px = 0.0}).problem ==
        MeshProblem::error_bound_out_of_range);
  CHECK(adaptive_mesh(good, LensMode::exact, {.max_vertices = 1000}).problem == MeshProblem::too_many_vertices);
  for (const int n : {0, -3, 5000}) CHECK(grid_mesh(good, LensMode::exact, n, 4).problem == MeshProblem::no_cells);
  CHECK(adaptive_mesh(good, LensMode::exact, {.field = FieldTangents{5, 6, 5, 6}}).problem ==
        MeshProblem::nothing_visible);
  eye = good;
  eye.lens = Lens(RadialLens{-0.3}, placed_at(0.01, Vector2(9.0, 9.0)));
  const PredistortionMesh nothing = adaptive_mesh(eye, LensMode::exact);
  CHECK(nothing.problem == MeshProblem::nothing_visible);
  CHECK(nothing.vertices.empty());
  CHECK(nothing.triangles.empty());
  for (int i = 0; i <= static_cast<int>(MeshProblem::too_many_vertices); ++i) {
    CHECK(describe(static_cast<MeshProblem>(i)) != "unknown problem");
  }
}

#include <doctest/doctest.h>

#include "warps.hpp"

using namespace pictures;
using namespace warps;

namespace {

/// What the eye sees of a picture drawn for its own field, without motion.
[[nodiscard]] io::Image seen_through(Studio& studio, const EyeModel& eye, LensMode mode, const Rigid& X_WE,
                                     const SceneStyle& style) {
  static_cast<void>(studio.draw(X_WE, style));
  RenderTarget seen(*studio.context, eye.resolution.width, eye.resolution.height);
  const WarpMesh mesh(*studio.context, seen_mesh(eye, mode));
  const LateWarpPass pass(*studio.context);
  pass.draw(RenderedPicture<RenderTarget*>(view_of(studio.eye, X_WE), &studio.target), mesh, {}, {}, seen);
  return seen.read_rgba();
}

}  // namespace

TEST_CASE("exact correction shows the eye the ideal picture; no correction shows discs where seen_centroid says") {
  const EyeModel eye = default_hmd().left;
  Studio studio(built_backends().front(), source_eye(eye));
  const Rigid X_WE = eye.X_HE;
  const io::Image ideal = studio.draw(X_WE, disc_measuring_style());
  const ImageDifference d = compare(seen_through(studio, eye, LensMode::exact, X_WE, disc_measuring_style()), ideal);
  INFO(describe(d));
  CHECK(d.max <= 1);  // the sampler's interpolation weights have 8 bits

  for (const LensMode mode : {LensMode::cubic, LensMode::uncorrected}) {
    const io::Image seen = seen_through(studio, eye, mode, X_WE, disc_measuring_style());
    int checked = 0;
    for (const Disc& disc : studio.scene.discs) {
      const auto e = project_disc(eye, X_WE, disc);
      if (!e || !e->is_inside(eye.resolution)) continue;
      const auto c = seen_centroid(eye, mode, *e);
      if (!c) continue;
      const PixelWindow window = window_around(*c, 1.6 * e->half_extent_px);
      if (!window.is_inside(look_at(seen))) continue;
      const auto found = picture_centroid(look_at(seen), window);
      REQUIRE(found);
      // A bilinear look-up of an exact picture: 0.02 px is what value 5 of evaluation.md allows.
      CHECK((found->centroid - *c).norm() < 0.02);
      ++checked;
    }
    CHECK(checked >= 5);
  }
}

TEST_CASE("the panel's picture, seen through the lens, is the ideal one") {
  // First warp: what the application sends to the panel. Second: what the lens does to it. Together: nothing but two
  // look-ups' blur.
  const EyeModel eye = default_hmd().left;
  const PixelSize size = eye.resolution;
  Studio studio(built_backends().front(), source_eye(eye));
  const Rigid X_WE = eye.X_HE;
  static_cast<void>(studio.draw(X_WE, disc_measuring_style()));
  RenderTarget panel(*studio.context, size.width, size.height), seen(*studio.context, size.width, size.height);
  const LateWarpPass pass(*studio.context);
  const RenderedView view = view_of(studio.eye, X_WE);
  const WarpMesh correct(*studio.context, adaptive_mesh(eye, LensMode::exact));
  pass.draw(RenderedPicture<RenderTarget*>(view, &studio.target), correct, {}, {}, panel);
  // The lens alone: what the eye sees of a panel whose picture nobody corrects.
  const WarpMesh lens(*studio.context, seen_mesh(eye, LensMode::uncorrected));
  pass.draw(RenderedPicture<RenderTarget*>(view, &panel), lens, {}, {}, seen);
  const auto errors = centroid_errors(seen.read_rgba(), eye, X_WE, studio.scene);
  REQUIRE(errors.size() >= 5);
  // Two bilinear look-ups, the first of which shrinks the picture and so skips pixels. A warp that were wrong by its own
  // size would be off by tens of pixels.
  CHECK(rms_px(errors) < 0.06);
}

TEST_CASE("colours bent differently meet on white; what any of them has not is black") {
  EyeModel eye = default_hmd({64, 36}).left;
  eye.lens_red = Lens();
  Studio studio(built_backends().front(), source_eye(eye));
  studio.target.clear({1, 1, 1, 1});
  RenderTarget seen(*studio.context, 64, 36);
  const SeenMesh mesh = seen_mesh(eye, LensMode::uncorrected);
  CHECK(mesh.per_colour);
  LateWarpPass(*studio.context)
      .draw(RenderedPicture<RenderTarget*>(view_of(studio.eye, Rigid()), &studio.target),
            WarpMesh(*studio.context, mesh), {}, {}, seen);
  CHECK(seen.read_rgba().at(32, 18) == io::Rgba{255, 255, 255, 255});
  CHECK(!seen_mesh(default_hmd().left, LensMode::exact).per_colour);
}

TEST_CASE("what the lens cannot show is left out, and only that: the mesh ends along the fold") {
  EyeModel eye = default_hmd({64, 36}).left;
  // Barrel: it folds over at a tangent of 0.4, seen at 2/3 of that, inside the picture's corners.
  eye.lens = Lens(RadialLens{-1.0 / (3.0 * 0.16)});
  const SeenMesh mesh = seen_mesh(eye, LensMode::exact);
  const double fold = 2.0 / 3.0 * 0.4;
  for (const SeenVertex& v : mesh.vertices) {
    const Vector2 t = tangent_of_pixel(eye, Vector2(v.seen_x * 64.0, v.seen_y * 36.0));
    CHECK(t.norm() <= fold + 1e-6);
  }
  // The area seen, in pixels: the part of the circle that lies in the picture, counted by points.
  double circle = 0.0, area = 0.0;
  constexpr int n = 20;  // points a pixel
  for (int y = 0; y < 36 * n; ++y) {
    for (int x = 0; x < 64 * n; ++x) {
      if (tangent_of_pixel(eye, Vector2((x + 0.5) / n, (y + 0.5) / n)).norm() <= fold) circle += 1.0 / (n * n);
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const SeenVertex &a = mesh.vertices[mesh.triangles[i]], &b = mesh.vertices[mesh.triangles[i + 1]],
                     &c = mesh.vertices[mesh.triangles[i + 2]];
    const double doubled =
        double(b.seen_x - a.seen_x) * (c.seen_y - a.seen_y) - double(c.seen_x - a.seen_x) * (b.seen_y - a.seen_y);
    CHECK(doubled > 0.0);
    area += 0.5 * 64.0 * 36.0 * doubled;
  }
  // Smallest cells are a quarter pixel wide, and the fold cuts half of each off, along an arc of about 100 pixels.
  CHECK(area <= circle + 0.1);
  CHECK(area >= circle - 0.25 * 100.0);
}

TEST_CASE("between the vertices the mesh keeps to its error") {
  const EyeModel eye = with_chromatic_lens(default_hmd({320, 180}).left);
  const SeenMeshSettings settings;
  for (const LensMode mode : {LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
    const SeenMesh mesh = seen_mesh(eye, mode);
    double worst_px = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
      Vector2 place = Vector2::Zero(), tangent = Vector2::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        const SeenVertex& v = mesh.vertices[mesh.triangles[i + k]];
        place += Vector2(v.seen_x, v.seen_y) / 3.0;
        tangent += Vector2(v.tangent[2][0], v.tangent[2][1]) / 3.0;
      }
      const Vector2 seen = tangent_of_pixel(eye, place.cwiseProduct(Vector2(320, 180)));
      const auto ideal = ideal_tangent(*eye.lens_blue, mode, seen);
      if (!ideal) continue;  // a smallest cell at the fold
      worst_px = std::max(worst_px, (tangent - *ideal).cwiseProduct(pixels_per_tangent(eye)).norm());
    }
    // Checked at edges' middles and the cell's; a triangle's middle bends by 8/9 of that, in both axes.
    CHECK(worst_px < 1.5 * settings.max_error_px);
  }
  CHECK(seen_mesh(eye, LensMode::none).triangles.size() == 3 * 2 * 20 * 12);  // nothing bends: largest cells do
}

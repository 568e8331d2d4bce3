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

TEST_CASE("cells that the lens cannot show are left out, and only those") {
  EyeModel eye = default_hmd({64, 36}).left;
  // Barrel: it folds over at a tangent of 0.4, seen at 2/3 of that, inside the picture's corners.
  eye.lens = Lens(RadialLens{-1.0 / (3.0 * 0.16)});
  const SeenMesh mesh = seen_mesh(eye, LensMode::exact, 32, 18);
  const double fold = 2.0 / 3.0 * 0.4;
  CHECK(mesh.triangles.size() < 2 * 3 * 32 * 18);
  CHECK(mesh.triangles.size() > 3 * 32 * 18 / 4);
  for (const SeenVertex& v : mesh.vertices) {
    const Vector2 t = tangent_of_pixel(eye, Vector2(v.seen_x * 64.0, v.seen_y * 36.0));
    CHECK(t.norm() <= fold + 1e-6);
  }
}

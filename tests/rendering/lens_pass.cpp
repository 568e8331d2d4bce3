#include <doctest/doctest.h>

#include "pictures.hpp"

using namespace pictures;

namespace {

io::Image through_lens(Studio& studio, LensMode mode, const Rigid& X_WE, const SceneStyle& style) {
  RenderTarget seen(*studio.context, studio.eye.resolution.width, studio.eye.resolution.height);
  const WarpPass pass(*studio.context);
  const WarpTable table = seen_picture_table(*studio.context, studio.eye, mode);
  static_cast<void>(studio.draw(X_WE, style));
  pass.draw(studio.target, table, seen);
  return seen.read_rgba();
}

}  // namespace

TEST_CASE("a table that names each pixel's own place changes nothing") {
  for (const Backend backend : built_backends()) {
    for (const int samples : {1, 4}) {
      Studio studio(backend, default_hmd().left, samples);
      const io::Image drawn = studio.draw(studio.eye.X_HE, virtual_style());
      const PixelSize size = studio.eye.resolution;
      const WarpTable table(*studio.context, size.width, size.height, false,
                            [](const Vector2& pixel, int) { return std::optional<Vector2>(pixel); });
      CHECK(table.missing() == 0.0);
      RenderTarget result(*studio.context, size.width, size.height);
      WarpPass(*studio.context).draw(studio.target, table, result);
      const ImageDifference d = compare(result.read_rgba(), drawn);
      INFO(describe(d));
      CHECK(d.max <= 1);  // the sampler's interpolation weights have a few bits
    }
  }
}

TEST_CASE("exact correction shows the eye the ideal picture; no correction shows discs where seen_centroid says") {
  Studio studio(built_backends().front());
  const Rigid X_WE = studio.eye.X_HE;
  const io::Image ideal = studio.draw(X_WE, disc_measuring_style());
  const ImageDifference d = compare(through_lens(studio, LensMode::exact, X_WE, disc_measuring_style()), ideal);
  INFO(describe(d));
  CHECK(d.max <= 1);

  for (const LensMode mode : {LensMode::cubic, LensMode::uncorrected}) {
    const io::Image seen = through_lens(studio, mode, X_WE, disc_measuring_style());
    int checked = 0;
    for (const Disc& disc : studio.scene.discs) {
      const auto e = project_disc(studio.eye, X_WE, disc);
      if (!e || !e->is_inside(studio.eye.resolution)) continue;
      const auto c = seen_centroid(studio.eye, mode, *e);
      if (!c) continue;
      const PixelWindow window = window_around(*c, 1.6 * e->half_extent_px);
      if (!window.is_inside(look_at(seen))) continue;
      const auto found = picture_centroid(look_at(seen), window);
      REQUIRE(found);
      // Bilinear look-up of an exact picture: 0.02 px is what value 5 of evaluation.md allows.
      CHECK((found->centroid - *c).norm() < 0.02);
      ++checked;
    }
    CHECK(checked >= 5);
  }
}

TEST_CASE("the panel's picture, seen through the lens, is the ideal one") {
  // First warp: what the application sends to the panel. Second: what the lens does to it. Together: nothing but two
  // look-ups' blur.
  Studio studio(built_backends().front());
  const PixelSize size = studio.eye.resolution;
  const Rigid X_WE = studio.eye.X_HE;
  static_cast<void>(studio.draw(X_WE, disc_measuring_style()));
  RenderTarget panel(*studio.context, size.width, size.height), seen(*studio.context, size.width, size.height);
  const WarpPass pass(*studio.context);
  pass.draw(studio.target, panel_picture_table(*studio.context, studio.eye, LensMode::exact), panel);
  const WarpTable lens(*studio.context, size.width, size.height, false, [&](const Vector2& pixel, int) {
    // The eye sees at `pixel` the panel point whose distorted image is there: the uncorrected mode's ideal pixel is the
    // panel's.
    return ideal_pixel(studio.eye, LensMode::uncorrected, pixel);
  });
  pass.draw(panel, lens, seen);
  const auto errors = centroid_errors(seen.read_rgba(), studio.eye, X_WE, studio.scene);
  REQUIRE(errors.size() >= 5);
  // Two bilinear look-ups, the first of which shrinks the picture and so skips pixels: measured 0.033 px. A warp that
  // were wrong by its own size would be off by tens of pixels.
  CHECK(rms_px(errors) < 0.06);
}

TEST_CASE("colours bent differently get a table each; what has no source is black and counted") {
  EyeModel eye = default_hmd({64, 36}).left;
  eye.lens_red = NoLens{};
  Studio studio(built_backends().front(), eye);
  const WarpTable table = seen_picture_table(*studio.context, eye, LensMode::uncorrected);
  CHECK(table.layers() == 3);
  studio.target.clear({1, 1, 1, 1});
  RenderTarget seen(*studio.context, 64, 36);
  WarpPass(*studio.context).draw(studio.target, table, seen);
  CHECK(seen.read_rgba().at(32, 18) == io::Rgba{255, 255, 255, 255});

  const WarpTable half(*studio.context, 64, 36, false, [](const Vector2& pixel, int) {
    return pixel.x() < 32.0 ? std::optional<Vector2>(pixel) : std::nullopt;
  });
  CHECK(half.missing() == doctest::Approx(0.5));
  WarpPass(*studio.context).draw(studio.target, half, seen);
  CHECK(seen.read_rgba().at(10, 10) == io::Rgba{255, 255, 255, 255});
  CHECK(seen.read_rgba().at(50, 10) == io::Rgba{0, 0, 0, 255});
}

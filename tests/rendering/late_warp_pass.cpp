#include <limits>
#include <map>
#include <numbers>

#include <doctest/doctest.h>

#include "warps.hpp"

using namespace pictures;
using namespace warps;

namespace {

constexpr DisplayTiming global_display{};

[[nodiscard]] DisplayTiming rolling(ScanDirection direction) {
  return {.scan_out = ScanOut::rolling, .scan_duration = std::chrono::microseconds(11100), .scan_direction = direction};
}

[[nodiscard]] Rigid turned(const Rigid& X_WE, const Vector3& degrees_xyz) {
  const Vector3 turn = degrees_xyz * (std::numbers::pi / 180.0);
  return X_WE * Rigid::rotation(so3::exp<double>(turn));
}

/// Draws at X_WS, warps to the late poses, and gives the panel's (or the seen) picture.
struct Warper {
  Warper(Backend backend, const EyeModel& eye_model, LensMode lens_mode, double wider = 1.0)
      : eye(eye_model),
        mode(lens_mode),
        studio(backend, source_eye(eye_model, wider)),
        pass(*studio.context),
        panel(*studio.context, adaptive_mesh(eye, mode, {})),
        result(*studio.context, eye.resolution.width, eye.resolution.height) {}

  [[nodiscard]] io::Image warp(const WarpMesh& mesh, const Rigid& X_WS, const ScanHomography& H_SE,
                               const DisplayTiming& timing, const SceneStyle& style) {
    source = studio.draw(X_WS, style);
    pass.draw(RenderedPicture<RenderTarget*>(view_of(studio.eye, X_WS), &studio.target), mesh, H_SE, timing, result);
    return result.read_rgba();
  }
  [[nodiscard]] ComposedWarp composed(const Rigid& X_WS, const ScanHomography& H_SE,
                                      const DisplayTiming& timing) const {
    return ComposedWarp(eye, mode, timing, view_of(studio.eye, X_WS), H_SE);
  }

  EyeModel eye;
  LensMode mode;
  Studio studio;
  LateWarpPass pass;
  WarpMesh panel;
  RenderTarget result;
  io::Image source;
};

[[nodiscard]] ScanHomography late(const RenderedView& view, const LatePoses& poses,
                                  const DeflectionSettings& settings = {}) {
  const DeflectionResult result = deflect(settings, view, poses);
  REQUIRE(result.ok());
  return result.H_SE;
}

}  // namespace

TEST_CASE("without lens and motion the picture stays as it is, all of it covered") {
  for (const Backend backend : built_backends()) {
    Warper warper(backend, default_hmd({640, 360}).left, LensMode::none);
    const Rigid X_WE = warper.eye.X_HE;
    const io::Image shown = warper.warp(warper.panel, X_WE, {}, global_display, virtual_style());
    const ImageDifference d = compare(shown, warper.source);
    INFO(describe(d));
    CHECK(d.max <= 1);  // the sampler's interpolation weights have 8 bits
    CHECK(count_coverage_mask(shown).covered_pct == 100.0);
  }
}

TEST_CASE("the panel's picture is the one that the composed warp defines: lens, colours, scan direction, mounting") {
  struct Case {
    LensMode mode;
    bool chromatic;
    DisplayTiming timing;
    bool upside_down;
  };
  const Case cases[] = {{LensMode::none, false, global_display, false},
                        {LensMode::none, false, rolling(ScanDirection::top_to_bottom), false},
                        {LensMode::exact, false, rolling(ScanDirection::top_to_bottom), false},
                        {LensMode::exact, true, rolling(ScanDirection::bottom_to_top), false},
                        {LensMode::cubic, false, rolling(ScanDirection::left_to_right), true},
                        {LensMode::exact, true, rolling(ScanDirection::right_to_left), true},
                        {LensMode::uncorrected, true, global_display, false}};
  for (const Backend backend : built_backends()) {
    for (const Case& c : cases) {
      CAPTURE(backend_name(backend));
      CAPTURE(static_cast<int>(c.mode));
      CAPTURE(c.chromatic);
      CAPTURE(name_of(c.timing.scan_direction));
      EyeModel eye = default_hmd({640, 360}).left;
      if (c.chromatic) eye = with_chromatic_lens(eye);
      eye.upside_down = c.upside_down;
      Warper warper(backend, eye, c.mode);
      const Rigid X_WS = eye.X_HE;
      // 2 degrees late, and 2.2 degrees during the scan: 200 deg/s over 11.1 ms.
      const LatePoses poses{turned(X_WS, {0.5, 2.0, 0.3}), turned(X_WS, {1.0, 4.0, 0.5})};
      const ScanHomography H_SE = late(view_of(warper.studio.eye, X_WS), poses);
      const io::Image shown = warper.warp(warper.panel, X_WS, H_SE, c.timing, virtual_style());
      const ComposedWarp composed = warper.composed(X_WS, H_SE, c.timing);
      const auto place = [&](const Vector2& pixel, Color color) { return composed.source_pixel(pixel, color); };
      const Disagreement d = disagreement(shown, warper.source, place);
      INFO("RMS " << d.rms << " of 255, mask differs in " << d.mask_pct << " %");
      CHECK(d.rms <= 1.0);
      // Pixels whose centre the edge passes within the mesh's error; and the mesh ends just before the cubic's fold.
      const double mask_pct = c.mode == LensMode::cubic ? 0.5 : 0.1;
      CHECK(d.mask_pct < mask_pct);
      CHECK(std::abs(count_coverage_mask(shown).covered_pct - d.covered_pct) < mask_pct);

      const io::Image discs = warper.warp(warper.panel, X_WS, H_SE, c.timing, disc_measuring_style());
      const auto to_panel = [&](const Vector2& pixel) { return composed.panel_pixel(pixel); };
      const io::Image on_cpu = warped_on_cpu(composed, warper.source, false);
      const CentroidRms centroids = centroid_rms(discs, on_cpu, warper.studio.eye, X_WS, warper.studio.scene, to_panel);
      const Likeness likeness = compare_covered(discs, on_cpu);
      INFO("against the CPU warp: RMS " << likeness.rms << " of 255, mask differs in " << likeness.mask_pct << " %");
      CHECK(likeness.rms <= 1.0);
      CHECK(likeness.mask_pct < mask_pct);
      INFO(centroids.discs << " discs, centroid RMS " << centroids.px << " px");
      CHECK(centroids.discs >= 4);
      CHECK(centroids.px <= 0.02);
    }
  }
}

TEST_CASE("what the eye sees is the composed warp through the true lens, black beyond the panel's edge") {
  for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
    for (const bool chromatic : {false, true}) {
      CAPTURE(static_cast<int>(mode));
      CAPTURE(chromatic);
      EyeModel eye = default_hmd({640, 360}).left;
      // Barrel distortion shows the panel's edge inside the ideal picture.
      if (mode == LensMode::uncorrected) eye.lens = Lens(RadialLens{-0.05}, eye.lens.placement());
      if (chromatic) eye = with_chromatic_lens(eye);
      Warper warper(built_backends().front(), eye, mode);
      const WarpMesh seen(*warper.studio.context, seen_mesh(eye, mode));
      const Rigid X_WS = eye.X_HE;
      const DisplayTiming timing = rolling(ScanDirection::top_to_bottom);
      const LatePoses poses{turned(X_WS, {0.5, 2.0, 0.3}), turned(X_WS, {1.0, 4.0, 0.5})};
      const ScanHomography H_SE = late(view_of(warper.studio.eye, X_WS), poses);
      const io::Image shown = warper.warp(seen, X_WS, H_SE, timing, virtual_style());
      const ComposedWarp composed = warper.composed(X_WS, H_SE, timing);
      const auto place = [&](const Vector2& pixel, Color color) -> std::optional<Vector2> {
        const auto panel = composed.panel_pixel_seen(pixel, color);
        return panel && is_inside(eye, *panel) ? composed.source_pixel_seen(pixel, color) : std::nullopt;
      };
      const Disagreement d = disagreement(shown, warper.source, place);
      INFO("RMS " << d.rms << " of 255, mask differs in " << d.mask_pct << " %");
      CHECK(d.rms <= 1.0);
      // The cubic folds over inside the picture. There it bends without bound, and a cell that it crosses is left out.
      const bool folds = mode == LensMode::cubic;
      CHECK(d.mask_pct < (folds ? 0.5 : 0.1));
      const io::Image discs = warper.warp(seen, X_WS, H_SE, timing, disc_measuring_style());
      const auto to_seen = [&](const Vector2& pixel) { return composed.seen_pixel(pixel); };
      const io::Image on_cpu = warped_on_cpu(composed, warper.source, true);
      const CentroidRms centroids = centroid_rms(discs, on_cpu, warper.studio.eye, X_WS, warper.studio.scene, to_seen);
      INFO(centroids.discs << " discs, centroid RMS " << centroids.px << " px");
      CHECK(centroids.discs >= 4);
      CHECK(centroids.px <= (folds ? 0.05 : 0.02));
    }
  }
}

TEST_CASE("with a perfect late pose and turning alone, things are seen where they are: at most 0.05 px RMS") {
  EyeModel eye = default_hmd().left;
  for (const LensMode mode : {LensMode::none, LensMode::exact}) {
    Warper warper(built_backends().front(), eye, mode, 1.3);
    const WarpMesh seen(*warper.studio.context, seen_mesh(eye, mode));
    double squares = 0.0;
    int discs = 0;
    for (const Rigid& X_WE : wandering_eyes(6, eye.X_HE)) {
      const Rigid X_WS = turned(X_WE, {1.5, -3.0, 2.0});
      const ScanHomography H_SE = late(view_of(warper.studio.eye, X_WS), LatePoses::at_once(X_WE));
      const io::Image shown = warper.warp(seen, X_WS, H_SE, global_display, disc_measuring_style());
      for (const CentroidError& e : centroid_errors(shown, eye, X_WE, warper.studio.scene)) {
        squares += e.px.squaredNorm();
        ++discs;
      }
    }
    REQUIRE(discs >= 20);
    INFO(discs << " discs, RMS " << std::sqrt(squares / discs) << " px");
    CHECK(std::sqrt(squares / discs) <= 0.05);
  }
}

TEST_CASE("a plane's homography is exact for points of the plane when the eye moves too") {
  EyeModel eye = default_hmd().left;
  RegistrationScene scene = default_registration_scene();
  // All discs onto the plane 2 m ahead of the source eye, facing it.
  for (Disc& disc : scene.discs) {
    if (disc.around) disc.radius_m = 1e-6;
    disc.centre_W *= 2.0 / -disc.centre_W.z();
    disc.normal_W = Vector3::UnitZ();
    disc.radius_m = 0.032;
  }
  std::erase_if(scene.discs, [](const Disc& disc) { return disc.around; });
  Warper warper(built_backends().front(), eye, LensMode::exact, 1.3);
  warper.studio.painter = RegistrationScenePainter(*warper.studio.context, scene);
  const WarpMesh seen(*warper.studio.context, seen_mesh(eye, LensMode::exact));
  const Rigid X_WS;
  const Rigid X_WE(so3::exp<double>(Vector3(0.02, -0.05, 0.03)), Vector3(0.03, -0.02, -0.05));
  const ScanHomography H_SE = late(view_of(warper.studio.eye, X_WS), LatePoses::at_once(X_WE),
                                   {.kind = DeflectionKind::plane, .plane_distance_m = 2.0});
  const io::Image shown = warper.warp(seen, X_WS, H_SE, global_display, disc_measuring_style());
  const auto errors = centroid_errors(shown, eye, X_WE, scene);
  REQUIRE(errors.size() >= 6);
  INFO(errors.size() << " discs, RMS " << rms_px(errors) << " px");
  CHECK(rms_px(errors) <= 0.05);
}

TEST_CASE("scan lines of their own keep an upright edge upright; one pose for all tilts it by 66.6 arcmin") {
  EyeModel eye = default_hmd().left;
  eye.X_HE = Rigid();
  RegistrationScene scene = default_registration_scene();
  scene.edge.bottom_W = Vector3(0.0, -1.5, -2.0);
  scene.edge.top_W = Vector3(0.0, 1.5, -2.0);
  SceneStyle style = disc_measuring_style();
  style.discs = false;
  style.edge = true;
  const DisplayTiming timing = rolling(ScanDirection::top_to_bottom);
  const double half_turn_deg = 0.5 * 100.0 * 0.0111;  // 100 deg/s during 11.1 ms: +-0.555 deg round the middle
  const LatePoses poses{turned(Rigid(), {0, -half_turn_deg, 0}), turned(Rigid(), {0, half_turn_deg, 0})};
  Warper warper(built_backends().front(), eye, LensMode::exact, 1.2);
  warper.studio.painter = RegistrationScenePainter(*warper.studio.context, scene);
  const WarpMesh seen(*warper.studio.context, seen_mesh(eye, LensMode::exact));
  // The eye turns to the left, so the world slides to the right; what was drawn once and is lit line by line does so in
  // the eye's own frame only if the warp moves it. Each line is compared with the edge at that line's own pose.
  for (const bool per_scanline : {true, false}) {
    const ScanHomography H_SE = late(view_of(warper.studio.eye, Rigid()), poses, {.per_scanline = per_scanline});
    const io::Image shown = warper.warp(seen, Rigid(), H_SE, timing, style);
    const ComposedWarp composed = warper.composed(Rigid(), H_SE, timing);
    const auto error_arcmin = [&](int row) {
      // A short piece: over the whole height the edge bends, as the lens spreads the panel's lines unevenly.
      const auto line = picture_edge(look_at(shown), {600, row - 10, 680, row + 10});
      REQUIRE(line);
      const Vector2 seen_at(line->x_at(row), row);
      const double s = composed.line_fraction(*composed.panel_pixel_seen(seen_at));
      const Rigid X_WE = interpolate(poses.X_WE_begin, poses.X_WE_end, s);
      const Vector3 ray_W = X_WE.q() * direction_of_tangents(tangent_of_pixel(eye, seen_at));
      return radians(std::atan2(ray_W.x(), -ray_W.z())).arcmin();
    };
    const double tilt = error_arcmin(700) - error_arcmin(20);
    INFO("per scan line " << per_scanline << ": tilt " << tilt << " arcmin");
    // Without, rows 20 to 700 are apart in time by less than the whole scan, as the lens spreads the panel's rows.
    if (per_scanline) CHECK(std::abs(tilt) < 0.15);  // 0.05 px of 2.8 arcmin
    if (!per_scanline) CHECK(std::abs(tilt) > 40.0);
  }
}

TEST_CASE("the mask tells what was not rendered") {
  Warper warper(built_backends().front(), default_hmd({640, 360}).left, LensMode::none);
  const Rigid X_WS = warper.eye.X_HE;
  // Turned to the left by 3 degrees: the left edge shows what lies beyond the picture's left edge.
  const ScanHomography H_SE = late(view_of(warper.studio.eye, X_WS), LatePoses::at_once(turned(X_WS, {0, 3.0, 0})));
  warper.studio.target.clear({1, 1, 1, 1});
  warper.pass.draw(RenderedPicture<RenderTarget*>(view_of(warper.studio.eye, X_WS), &warper.studio.target),
                   warper.panel, H_SE, global_display, warper.result);
  const io::Image shown = warper.result.read_rgba();
  CHECK(shown.at(2, 180) == io::Rgba{0, 0, 0, 0});
  CHECK(shown.at(320, 180) == io::Rgba{255, 255, 255, 255});
  // On the middle row the left edge, 30 degrees out, has moved in to 27 degrees: tan 27 / tan 30 of half the width.
  const double border = 320.0 * (1.0 - std::tan(27.0 * std::numbers::pi / 180.0) / std::tan(std::numbers::pi / 6.0));
  int column = 0;
  while (shown.at(column, 180)[3] == 0) ++column;
  CHECK(std::abs(column - border) <= 1.0);
  CHECK(count_coverage_mask(shown).missing_pct > 5.0);
}

TEST_CASE("halving long edges keeps the surface and opens no gaps") {
  const EyeModel eye = default_hmd({64, 36}).left;
  PredistortionMesh mesh = grid_mesh(eye, LensMode::exact, 1, 3);
  holdfast::rendering::detail::split_long_edges(mesh.vertices, mesh.triangles, 0.1f);
  double area = 0.0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const std::uint32_t t[] = {mesh.triangles[i], mesh.triangles[i + 1], mesh.triangles[i + 2]};
    const auto at = [&](int k) { return Vector2(mesh.vertices[t[k]].panel_x, mesh.vertices[t[k]].panel_y); };
    const Vector2 u = at(1) - at(0), v = at(2) - at(0);
    CHECK(u.cwiseAbs().maxCoeff() <= 0.1f);
    CHECK(v.cwiseAbs().maxCoeff() <= 0.1f);
    const double twice = u.x() * v.y() - u.y() * v.x();
    CHECK(twice > 0.0);  // still counter-clockwise
    area += 0.5 * twice;
    for (int k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
  }
  CHECK(area == doctest::Approx(1.0).epsilon(1e-6));
  // Every edge that belongs to one triangle alone lies on the picture's border: nowhere does a vertex stand on another
  // triangle's edge.
  for (const auto& [edge, uses] : edges) {
    CHECK(uses <= 2);
    if (uses == 2) continue;
    const PredistortionVertex &a = mesh.vertices[edge.first], &b = mesh.vertices[edge.second];
    const auto on_border = [](float p, float q) { return p == q && (p == 0.0f || p == 1.0f); };
    CHECK((on_border(a.panel_x, b.panel_x) || on_border(a.panel_y, b.panel_y)));
  }
}

TEST_CASE("empty meshes, foreign vertices and pictures of another size are refused in words") {
  const auto context = make_context();
  const EyeModel eye = default_hmd({64, 36}).left;
  CHECK_THROWS_AS(WarpMesh(*context, PredistortionMesh{}), RenderingError);
  CHECK_THROWS_WITH_AS(WarpMesh(*context, SeenMesh{}), "a warp mesh without triangles", RenderingError);
  PredistortionMesh wrong = grid_mesh(eye, LensMode::none, 2, 2);
  wrong.triangles[4] = 99;
  CHECK_THROWS_WITH_AS(WarpMesh(*context, wrong), "a warp mesh names vertex 99 of 9", RenderingError);
  for (const float value : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), 7.0f}) {
    wrong = grid_mesh(eye, LensMode::none, 2, 2);
    wrong.vertices[3].panel_x = value;
    CHECK_THROWS_WITH_AS(WarpMesh(*context, wrong), "vertex 3 of a warp mesh is not finite, or not on the panel",
                         RenderingError);
  }

  const LateWarpPass pass(*context);
  const WarpMesh mesh(*context, grid_mesh(eye, LensMode::none, 2, 2));
  RenderTarget source(*context, 64, 36), other(*context, 32, 36), result(*context, 64, 36);
  const RenderedView view = view_of(source_eye(eye), Rigid());
  CHECK_THROWS_WITH_AS(pass.draw(RenderedPicture<RenderTarget*>(view, &other), mesh, {}, global_display, result),
                       "a picture of 32 x 36 pixels where its view says 64 x 36", RenderingError);
  CHECK_THROWS_WITH_AS(pass.draw(RenderedPicture<RenderTarget*>(view, &source), mesh, {}, global_display, other),
                       "a picture of 32 x 36 pixels where the mesh says 64 x 36", RenderingError);
  CHECK_THROWS_WITH_AS(pass.draw(RenderedPicture<RenderTarget*>(view, &source), mesh, {}, global_display, source),
                       "a picture cannot be warped onto itself", RenderingError);
}

#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/deflection/depth_mesh.hpp>
#include <holdfast/deflection/depth_raster.hpp>
#include <holdfast/rendering/depth_mesh_pass.hpp>

#include "warps.hpp"

using namespace pictures;
using namespace warps;

namespace {

constexpr ClipPlanes clip{0.02, 200.0};
constexpr DisplayTiming global_display{};

[[nodiscard]] DisplayTiming rolling(ScanDirection direction) {
  return {.scan_out = ScanOut::rolling, .scan_duration = std::chrono::microseconds(11100), .scan_direction = direction};
}

/// Draws at X_WS with its depth, and gives the picture at the late poses.
struct DepthWarper {
  DepthWarper(Backend backend, const EyeModel& eye_model, LensMode lens_mode, double wider = 1.0, int samples = 1)
      : eye(eye_model),
        mode(lens_mode),
        studio(backend, source_eye(eye_model, wider), samples),
        texture(*studio.context, studio.eye.resolution),
        pass(*studio.context),
        result(*studio.context, eye.resolution.width, eye.resolution.height) {}

  void draw(const Rigid& X_WS, const SceneStyle& style) {
    source = studio.draw(X_WS, style);
    view = view_of(studio.eye, X_WS);
    texture.update(picture(), clip);
    depth.size = studio.eye.resolution;
    const std::vector<float> buffer = studio.target.read_depth();
    depth.distance_m.resize(buffer.size());
    distances_of_depth_buffer(buffer, projection_matrix(studio.view(X_WS)), DepthRange::minus_one_to_one,
                              depth.distance_m);
    REQUIRE(surface.update(view, depth) == DepthProblem::none);
  }
  [[nodiscard]] RenderedPicture<RenderTarget*> picture() {
    return RenderedPicture<RenderTarget*>(view, &studio.target);
  }
  [[nodiscard]] io::Image warp(const WarpMesh& mesh, const ScanPose& X_SE, const DisplayTiming& timing) {
    pass.draw(picture(), texture, mesh, X_SE, timing, result);
    return result.read_rgba();
  }

  EyeModel eye;
  LensMode mode;
  Studio studio;
  DepthSurfaceTexture texture;
  DepthWarpPass pass;
  RenderTarget result;
  RenderedView view;
  DepthImage depth;
  DepthSurface surface;
  io::Image source;
};

/// Part of the pixels (percent) whose state the mask and the definition (of green) tell differently, and RMS of the
/// colours where both are covered or both filled. sample(pixel, channel) is the definition.
struct StateDisagreement {
  double state_pct = 0.0;
  double rms = 0.0;
  double disoccluded_pct = 0.0;  ///< by the definition
};

template <typename Sample>
[[nodiscard]] StateDisagreement state_disagreement(const io::Image& warped, const io::Image& source,
                                                   const Sample& sample) {
  StateDisagreement d;
  double squares = 0.0, channels = 0.0;
  for (int y = 0; y < warped.height; ++y) {
    for (int x = 0; x < warped.width; ++x) {
      const SourceSample expected = sample(Vector2(x + 0.5, y + 0.5), std::size_t{1});
      const MaskValue value = expected.state == SourceState::covered       ? MaskValue::covered
                              : expected.state == SourceState::disoccluded ? MaskValue::disoccluded
                                                                           : MaskValue::missing;
      const io::Rgba shown = warped.at(x, y);
      d.disoccluded_pct += value == MaskValue::disoccluded ? 1.0 : 0.0;
      if (mask_value(shown[3]) != value) {
        d.state_pct += 1.0;
        continue;
      }
      if (value == MaskValue::missing) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const SourceSample from = sample(Vector2(x + 0.5, y + 0.5), c);
        if (from.state != expected.state) continue;
        squares += std::pow(shown[c] - look_up(source, from.pixel, static_cast<int>(c)), 2);
        channels += 1.0;
      }
    }
  }
  d.rms = std::sqrt(squares / std::max(1.0, channels));
  const double percent = 100.0 / (double(warped.width) * warped.height);
  d.state_pct *= percent;
  d.disoccluded_pct *= percent;
  return d;
}

[[nodiscard]] Rigid moved_pose(const Rigid& X, const Vector3& turn, const Vector3& shift) {
  return X * Rigid(so3::exp<double>(turn), shift);
}

}  // namespace

TEST_CASE("without motion the picture by depth is the one that was drawn") {
  for (const Backend backend : built_backends()) {
    for (const int samples : {1, 4}) {
      DepthWarper warper(backend, default_hmd({320, 180}).left, LensMode::none, 1.0, samples);
      warper.draw(warper.eye.X_HE, virtual_style());
      const WarpMesh panel(*warper.studio.context, adaptive_mesh(warper.eye, LensMode::none));
      const io::Image shown = warper.warp(panel, ScanPose(), global_display);
      const ImageDifference d = compare(shown, warper.source);
      INFO(describe(d));
      CHECK(d.max <= 1);  // the sampler's interpolation weights have 8 bits
      CHECK(count_coverage_mask(shown).covered_pct == 100.0);
    }
  }
}

TEST_CASE("the picture by depth is the one that the composed warp defines: states, colours, lens, scan direction") {
  for (const Backend backend : built_backends()) {
    for (const ScanDirection direction : {ScanDirection::top_to_bottom, ScanDirection::left_to_right}) {
      for (const bool seen : {false, true}) {
        CAPTURE(backend_name(backend));
        CAPTURE(name_of(direction));
        CAPTURE(seen);
        const EyeModel eye = default_hmd({320, 180}).left;
        DepthWarper warper(backend, eye, LensMode::exact);
        const Rigid X_WS = eye.X_HE;
        warper.draw(X_WS, virtual_style());
        const LatePoses late{moved_pose(X_WS, {0.01, 0.02, 0.01}, {0.03, 0.01, -0.02}),
                             moved_pose(X_WS, {0.01, 0.04, 0.02}, {0.04, 0.01, -0.03}),
                             moved_pose(X_WS, {0.01, 0.032, 0.016}, {0.036, 0.011, -0.026})};  // it slows down
        const DeflectionResult deflected = deflect({.kind = DeflectionKind::depth}, warper.view, late);
        REQUIRE(deflected.ok());
        const DisplayTiming timing = rolling(direction);
        Context& context = *warper.studio.context;
        const WarpMesh mesh = seen ? WarpMesh(context, seen_mesh(eye, LensMode::exact))
                                   : WarpMesh(context, adaptive_mesh(eye, LensMode::exact));
        const io::Image shown = warper.warp(mesh, deflected.X_SE, timing);
        const DepthSearch search(warper.surface, deflected.X_SE);
        const ComposedWarp composed(eye, LensMode::exact, timing, warper.view, search);
        const StateDisagreement d = state_disagreement(shown, warper.source, [&](const Vector2& pixel, std::size_t) {
          return seen ? composed.sample_seen(pixel) : composed.sample(pixel);
        });
        INFO("states differ in " << d.state_pct << " %, RMS " << d.rms << " of 255, disoccluded " << d.disoccluded_pct
                                 << " %");
        CHECK(d.disoccluded_pct > 0.5);
        // Rays that pass an edge within the mesh's error, or single precision's, of a pixel's border.
        CHECK(d.state_pct < 0.3);
        CHECK(d.rms <= 1.0);
        CHECK(std::abs(count_coverage_mask(shown).disoccluded_pct - d.disoccluded_pct) < 0.2);
      }
    }
  }
}

TEST_CASE("with a perfect late pose things at any depth are seen where they are: at most 0.1 px") {
  const EyeModel eye = default_hmd().left;
  for (const LensMode mode : {LensMode::none, LensMode::exact}) {
    DepthWarper warper(built_backends().front(), eye, mode, 1.3);
    const WarpMesh seen(*warper.studio.context, seen_mesh(eye, mode));
    double squares = 0.0, worst = 0.0;
    int discs = 0;
    for (const Rigid& X_WE : wandering_eyes(3, eye.X_HE)) {
      // 20 ms at 0.5 m/s and 100 deg/s
      const Rigid X_WS = moved_pose(X_WE, {0.01, -0.035, 0.02}, {0.01, 0.003, -0.005});
      warper.draw(X_WS, disc_measuring_style());
      const DeflectionResult late = deflect({.kind = DeflectionKind::depth}, warper.view, LatePoses::at_once(X_WE));
      REQUIRE(late.ok());
      const io::Image shown = warper.warp(seen, late.X_SE, global_display);
      for (const CentroidError& e : centroid_errors(shown, eye, X_WE, warper.studio.scene)) {
        squares += e.px.squaredNorm();
        worst = std::max(worst, e.px.norm());
        ++discs;
      }
    }
    REQUIRE(discs >= 10);
    INFO(discs << " discs, RMS " << std::sqrt(squares / discs) << " px, worst " << worst);
    CHECK(std::sqrt(squares / discs) <= 0.1);
    CHECK(worst <= 0.15);
  }
}

TEST_CASE("forward and backward: lens and colours composed, the forward mesh drawn as on the CPU") {
  for (const Backend backend : built_backends()) {
    for (const bool chromatic : {false, true}) {
      CAPTURE(backend_name(backend));
      CAPTURE(chromatic);
      EyeModel eye = default_hmd({320, 180}).left;
      if (chromatic) eye = with_chromatic_lens(eye);
      DepthWarper warper(backend, eye, LensMode::exact);
      const Rigid X_WS = eye.X_HE;
      warper.draw(X_WS, virtual_style());
      const LatePoses late{moved_pose(X_WS, {0.01, 0.02, 0.01}, {0.03, 0.01, -0.02}),
                           moved_pose(X_WS, {0.01, 0.04, 0.02}, {0.04, 0.01, -0.03}),
                           moved_pose(X_WS, {0.01, 0.032, 0.016}, {0.036, 0.011, -0.026})};  // it slows down
      const DeflectionResult deflected = deflect({.kind = DeflectionKind::depth}, warper.view, late);
      REQUIRE(deflected.ok());
      const DisplayTiming timing = rolling(ScanDirection::top_to_bottom);
      Context& context = *warper.studio.context;

      const DepthMeshPass forward(context, warper.studio.eye.resolution);
      const PlaceTable places(context, eye, LensMode::exact);
      forward.draw(warper.picture(), warper.texture, places, deflected.X_SE, timing, warper.result);
      const io::Image shown = warper.result.read_rgba();

      const DepthSearch search(warper.surface, deflected.X_SE);
      const ComposedWarp composed(eye, LensMode::exact, timing, warper.view, search);
      std::vector<SourceSample> samples[3];
      std::vector<float> nearness(320 * 180);
      DepthMesh mesh;
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        auto& of_color = samples[static_cast<std::size_t>(color)];
        of_color.resize(nearness.size());
        mesh.update(composed, color);
        static_cast<void>(rasterize(mesh, eye.resolution, warper.studio.eye.resolution, of_color, nearness));
      }
      const auto at = [&](const Vector2& pixel, std::size_t c) {
        return samples[c][static_cast<std::size_t>(pixel.y()) * 320 + static_cast<std::size_t>(pixel.x())];
      };
      const StateDisagreement d =
          state_disagreement(shown, warper.source, [&](const Vector2& pixel, std::size_t c) { return at(pixel, c); });
      INFO("states differ in " << d.state_pct << " %, RMS " << d.rms << " of 255, disoccluded " << d.disoccluded_pct
                               << " %");
      CHECK(d.disoccluded_pct > 0.5);
      // Pixels that a triangle's edge passes within single precision's error.
      CHECK(d.state_pct < 0.3);
      CHECK(d.rms <= 1.0);

      // Where both ways have the thing they show the same.
      const WarpMesh panel(context, adaptive_mesh(eye, LensMode::exact));
      const io::Image backward = warper.warp(panel, deflected.X_SE, timing);
      double squares = 0.0;
      int both = 0;
      for (std::size_t i = 0; i < shown.rgba.size(); i += 4) {
        if (shown.rgba[i + 3] != 255 || backward.rgba[i + 3] != 255) continue;
        ++both;
        for (std::size_t c = 0; c < 3; ++c) squares += std::pow(shown.rgba[i + c] - backward.rgba[i + c], 2);
      }
      INFO("both cover " << both << " pixels, RMS " << std::sqrt(squares / (3.0 * both)));
      CHECK(both > 30000);  // of 57600; the rest the lens and the motion leave without source, or hide
      // They cut edges half a pixel apart, where single pixels differ by the whole contrast.
      CHECK(std::sqrt(squares / (3.0 * both)) < 6.0);
    }
  }
}

TEST_CASE("the forward mesh shows things at any depth where they are: at most 0.1 px") {
  const EyeModel eye = default_hmd().left;
  DepthWarper warper(built_backends().front(), eye, LensMode::exact, 1.3);
  const DepthMeshPass forward(*warper.studio.context, warper.studio.eye.resolution);
  const PlaceTable seen(*warper.studio.context, eye, LensMode::exact, DrawnPicture::seen);
  const Rigid X_WE = wandering_eyes(1, eye.X_HE)[0];
  warper.draw(moved_pose(X_WE, {0.01, -0.035, 0.02}, {0.01, 0.003, -0.005}), disc_measuring_style());
  const DeflectionResult late = deflect({.kind = DeflectionKind::depth}, warper.view, LatePoses::at_once(X_WE));
  REQUIRE(late.ok());
  forward.draw(warper.picture(), warper.texture, seen, late.X_SE, global_display, warper.result);
  io::Image shown = warper.result.read_rgba();
  // Where it was hidden, the disc's rim is stretched over the gap that opens: not counted.
  for (std::size_t i = 0; i < shown.rgba.size(); i += 4) {
    if (mask_value(shown.rgba[i + 3]) != MaskValue::covered) shown.rgba[i] = shown.rgba[i + 1] = shown.rgba[i + 2] = 0;
  }
  const auto errors = centroid_errors(shown, eye, X_WE, warper.studio.scene);
  REQUIRE(errors.size() >= 5);
  INFO(errors.size() << " discs, RMS " << rms_px(errors) << " px");
  CHECK(rms_px(errors) <= 0.1);
}

TEST_CASE("distances in memory serve as well as the depth buffer") {
  const EyeModel eye = default_hmd({160, 90}).left;
  DepthWarper warper(built_backends().front(), eye, LensMode::none);
  warper.draw(eye.X_HE, virtual_style());
  const WarpMesh panel(*warper.studio.context, adaptive_mesh(eye, LensMode::none));
  const ScanPose X_SE(eye.X_HE, LatePoses::at_once(moved_pose(eye.X_HE, {0, 0.02, 0}, {0.03, 0.0, 0.01})));
  const io::Image from_buffer = warper.warp(panel, X_SE, global_display);
  warper.texture.update(RenderedPicture<DepthImage>(warper.view, warper.depth));
  const io::Image from_memory = warper.warp(panel, X_SE, global_display);
  const ImageDifference d = compare(from_buffer, from_memory);
  INFO(describe(d));
  CHECK(d.differing_pixels <= 4);  // rays at an edge, by rounding
}

TEST_CASE("a depth buffer's three conventions give one surface") {
  const EyeModel eye = default_hmd({64, 36}).left;
  const auto context = make_context();
  const RenderedView view = view_of(source_eye(eye), Rigid());
  const WarpMesh panel(*context, adaptive_mesh(eye, LensMode::none));
  const DepthWarpPass pass(*context);
  RenderTarget target(*context, 64, 36), result(*context, 64, 36);
  const GlFunctions& gl = context->gl();
  std::vector<io::Image> shown;
  for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one, DepthRange::one_to_zero}) {
    // A near square, 0.5 m away, before nothing; its depth is what the projection says.
    target.clear({0, 0, 0, 1}, range == DepthRange::one_to_zero ? 0.0f : 1.0f);
    const Matrix4 P = projection_matrix(view.tangents, clip, range);
    const Vector4 p = P * Vector4(0.0, 0.0, -0.5, 1.0);
    const double z = p.z() / p.w();
    const auto depth = static_cast<float>(range == DepthRange::minus_one_to_one ? 0.5 * (z + 1.0) : z);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(20, 10, 20, 15);
    const float white[] = {1, 1, 1, 1};
    gl.ClearNamedFramebufferfv(target.draw_framebuffer(), GL_COLOR, 0, white);
    gl.ClearNamedFramebufferfv(target.draw_framebuffer(), GL_DEPTH, 0, &depth);
    gl.Disable(GL_SCISSOR_TEST);
    DepthSurfaceTexture surface(*context, {64, 36});
    const RenderedPicture<RenderTarget*> picture(view, &target);
    surface.update(picture, clip, range);
    // 2 cm to the right: what is 0.5 m away moves left by 0.04 of tangent.
    pass.draw(picture, surface, panel, ScanPose(Rigid(), LatePoses::at_once(Rigid::translation({0.02, 0, 0}))),
              global_display, result);
    shown.push_back(result.read_rgba());
  }
  const double moved = 0.04 * pixels_per_tangent(eye).x();  // 2.2 px
  CHECK(shown[0].at(static_cast<int>(20 - moved + 1.0), 15)[0] > 200);
  CHECK(shown[0].at(static_cast<int>(40 - moved + 1.0), 15)[0] < 50);
  CHECK(compare(shown[1], shown[0]).max <= 1);
  CHECK(compare(shown[2], shown[0]).max <= 1);
}

TEST_CASE("a depth of another picture, or of another size, is refused in words") {
  const auto context = make_context();
  const EyeModel eye = default_hmd({64, 36}).left;
  const RenderedView view = view_of(source_eye(eye), Rigid());
  RenderTarget target(*context, 64, 36), small(*context, 32, 18), result(*context, 64, 36);
  target.clear();
  DepthSurfaceTexture surface(*context, {64, 36});
  RenderedView small_view = view;
  small_view.size = {32, 18};
  CHECK_THROWS_WITH_AS(surface.update(RenderedPicture<RenderTarget*>(small_view, &small), clip),
                       "a depth of 32 x 18 pixels for a surface of 64 x 36", RenderingError);
  CHECK_THROWS_AS(surface.update(RenderedPicture<DepthImage>(view, {})), RenderingError);
  surface.update(RenderedPicture<RenderTarget*>(view, &target), clip);
  RenderedView other = view;
  other.X_WS = Rigid::translation({0.1, 0, 0});
  const WarpMesh panel(*context, grid_mesh(eye, LensMode::none, 2, 2));
  const PlaceTable places(*context, eye, LensMode::none);
  const RenderedPicture<RenderTarget*> picture(other, &target);
  CHECK_THROWS_WITH_AS(DepthWarpPass(*context).draw(picture, surface, panel, ScanPose(), global_display, result),
                       "the depth was drawn with another view than the picture", RenderingError);
  CHECK_THROWS_WITH_AS(
      DepthMeshPass(*context, {64, 36}).draw(picture, surface, places, ScanPose(), global_display, result),
      "the depth was drawn with another view than the picture", RenderingError);
  CHECK_THROWS_AS(DepthMeshPass(*context, {64, 1}), RenderingError);
}

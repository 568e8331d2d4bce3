#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/deflection/coverage.hpp>
#include <holdfast/rendering/depth_warp_pass.hpp>

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

/// Part of the pixels (percent) whose state the mask and the definition tell differently, and RMS of the colours where
/// both are covered or both filled.
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
      const SourceSample expected = sample(Vector2(x + 0.5, y + 0.5));
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
      for (std::size_t c = 0; c < 3; ++c, channels += 1.0)
        squares += std::pow(shown[c] - look_up(source, expected.pixel, static_cast<int>(c)), 2);
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
                             moved_pose(X_WS, {0.01, 0.04, 0.02}, {0.04, 0.01, -0.03})};
        const DeflectionResult deflected = deflect({.kind = DeflectionKind::depth}, warper.view, late);
        REQUIRE(deflected.ok());
        const DisplayTiming timing = rolling(direction);
        Context& context = *warper.studio.context;
        const WarpMesh mesh = seen ? WarpMesh(context, seen_mesh(eye, LensMode::exact))
                                   : WarpMesh(context, adaptive_mesh(eye, LensMode::exact));
        const io::Image shown = warper.warp(mesh, deflected.X_SE, timing);
        const DepthSearch search(warper.surface, deflected.X_SE);
        const ComposedWarp composed(eye, LensMode::exact, timing, warper.view, search);
        const StateDisagreement d = state_disagreement(shown, warper.source, [&](const Vector2& pixel) {
          return seen ? composed.sample_seen(pixel) : composed.sample(pixel);
        });
        INFO("states differ in " << d.state_pct << " %, RMS " << d.rms << " of 255, disoccluded "
                                    << d.disoccluded_pct << " %");
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

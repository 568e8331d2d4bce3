#include "studio.hpp"

#include <cstdio>

#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/shown_point.hpp>
#include <holdfast/rendering/rolling.hpp>
#include <holdfast/scene/load_model.hpp>

#include "stopwatch.hpp"

namespace swimlab {

using namespace holdfast;
using namespace holdfast::rendering;

namespace {

class TimeAdder {
 public:
  explicit TimeAdder(double& sum_ms) : sum_ms_(sum_ms) {}
  TimeAdder(const TimeAdder&) = delete;
  TimeAdder& operator=(const TimeAdder&) = delete;
  ~TimeAdder() { sum_ms_ += stopwatch_.milliseconds(); }

 private:
  double& sum_ms_;
  Stopwatch stopwatch_;
};

/// The i-th of n parts of a band, cut across its lines.
PixelRectangle tile_of(PixelRectangle band, ScanDirection direction, int n, int i) {
  int& low = is_sideways(direction) ? band.bottom : band.left;
  int& high = is_sideways(direction) ? band.top : band.right;
  const int first = low, length = high - low;
  low = first + length * i / n;
  high = first + length * (i + 1) / n;
  return band;
}

}  // namespace

Studio::Studio(std::optional<Backend> backend, const RegistrationScene& scene, const std::filesystem::path& model)
    : context_(backend ? make_context(*backend) : make_context()),
      scene_(*context_, scene),
      late_warp_(*context_),
      depth_warp_(*context_) {
  if (model.empty()) return;
  const scene::Model loaded = scene::load_model(model);
  for (const std::string& warning : loaded.warnings) {
    std::fprintf(stderr, "%s: %s\n", model.string().c_str(), warning.c_str());
  }
  model_name_ = loaded.name;
  T_WM_ = scene::default_place(loaded);
  model_.emplace(*context_, loaded);
}

RenderTarget& Studio::target_of(PixelSize size, int samples, bool is_result) {
  auto& target = targets_[{size.width, size.height, samples, is_result}];
  if (target) return *target;
  const TimeAdder adder(setup_ms_);
  target = std::make_unique<RenderTarget>(*context_, size.width, size.height, samples);
  return *target;
}

void Studio::paint(const View& view, const SceneStyle& style) {
  scene_.draw_solid(view, style);
  if (model_ && style.corner) model_->draw(view, T_WM_, style.model_toning);
  scene_.draw_flat(view, style);
}

WarpMesh& Studio::mesh_of(const EyeModel& eye, LensMode lens) {
  const FieldTangents& t = eye.tangents;
  const EyeKey key(eye.side, lens, eye.resolution.width, eye.resolution.height,
                   std::array{t.left, t.right, t.down, t.up});
  const auto known = meshes_.find(key);
  if (known != meshes_.end()) return known->second;
  const TimeAdder adder(setup_ms_);
  return meshes_.try_emplace(key, *context_, seen_mesh(eye, lens)).first->second;
}

DepthSurfaceTexture& Studio::surface_of(PixelSize size) {
  const std::pair key(size.width, size.height);
  const auto known = surfaces_.find(key);
  if (known != surfaces_.end()) return known->second;
  const TimeAdder adder(setup_ms_);
  return surfaces_.try_emplace(key, *context_, size).first->second;
}

void Studio::draw_virtual(const ShownPicture& picture, const EyeModel& eye, LensMode lens, const DisplayTiming& timing,
                          const SceneStyle& style, Smooth smooth, io::Image& result) {
  RenderTarget& target = target_of(picture.view.size, smooth == Smooth::yes ? std::min(4, info().max_samples) : 1);
  if (picture.is_deflected() || lens != LensMode::none) {
    draw_warped(picture, eye, lens, timing, style, target, result);
    return;
  }
  const TimeAdder stopwatch(draw_readback_ms_);
  ++pictures_;
  target.clear(style.background);
  paint({.eye = &eye, .X_WE = picture.view.X_WS}, style);
  target.read_rgba(result);
}

void Studio::draw_warped(const ShownPicture& picture, const EyeModel& eye, LensMode lens, const DisplayTiming& timing,
                         const SceneStyle& style, RenderTarget& source, io::Image& result) {
  const WarpMesh& mesh = mesh_of(eye, lens);
  RenderTarget& seen = target_of(eye.resolution, 1, true);
  const bool by_depth = picture.is_deflected() && picture.how.kind == DeflectionKind::depth;
  DepthSurfaceTexture* const surface = by_depth ? &surface_of(picture.view.size) : nullptr;
  const EyeModel drawing = drawing_eye(eye, picture.view);
  const TimeAdder stopwatch(draw_readback_ms_);
  ++pictures_;
  source.clear(style.background);
  const View view{.eye = &drawing, .X_WE = picture.view.X_WS};
  paint(view, style);
  const RenderedPicture<RenderTarget*> drawn(picture.view, &source);
  if (by_depth) {
    surface->update(drawn, view.clip);
    depth_warp_.draw(drawn, *surface, mesh, picture.deflection.X_SE, timing, seen);
  } else {
    late_warp_.draw(drawn, mesh, picture.deflection.H_SE, timing, seen);
  }
  seen.read_rgba(result);
}

void Studio::draw_real(const EyeModel& eye, LensMode lens, const DisplayTiming& timing,
                       const std::function<Rigid(double)>& X_WE_at, const SceneStyle& style, Smooth smooth,
                       io::Image& result, int bands) {
  RenderTarget& target = target_of(eye.resolution, smooth == Smooth::yes ? std::min(4, info().max_samples) : 1);
  const TimeAdder stopwatch(draw_readback_ms_);
  ++pictures_;
  target.clear(style.background);
  if (timing.scan_out == ScanOut::global) {
    paint({.eye = &eye, .X_WE = X_WE_at(0.0)}, style);
  } else {
    // A lens bends the panel's lines: the time changes along a row too. (A model is drawn whole each time: not so often.)
    const int tiles = lens == LensMode::none || model_ ? 1 : 8;
    draw_rolling(target, timing.scan_direction, bands, [&](const Band& band) {
      for (int i = 0; i < tiles; ++i) {
        const PixelRectangle part = tile_of(band.part, timing.scan_direction, tiles, i);
        const Vector2 middle = 0.5 * Vector2(part.left + part.right, part.bottom + part.top);
        context_->gl().Scissor(part.left, part.bottom, part.right - part.left, part.top - part.bottom);
        paint({.eye = &eye, .X_WE = X_WE_at(light_seconds(eye, timing, lens, middle)), .part = part}, style);
      }
    });
  }
  target.read_rgba(result);
}

}  // namespace swimlab

#include "row_runner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <holdfast/io/input_error.hpp>
#include <holdfast/registration/picture_centroid.hpp>
#include <holdfast/registration/shown_point.hpp>
#include <holdfast/rendering/coverage_mask.hpp>

#include "stopwatch.hpp"

namespace swimlab {

using namespace holdfast;

namespace {

/// `n` of `count` frames, evenly spaced, first and last among them.
std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t n) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < std::min(n, count); ++i) {
    indices.push_back(n < 2 || count <= n ? i : i * (count - 1) / (n - 1));
  }
  return indices;
}

/// The green channel alone: it stands for the geometry where a lens bends each colour differently.
std::vector<std::uint8_t> green_of(const io::Image& image) {
  std::vector<std::uint8_t> green(image.rgba.size() / 4);
  for (std::size_t i = 0; i < green.size(); ++i) green[i] = image.rgba[4 * i + 1];
  return green;
}

/// The box round a disc in a picture, px.
struct Box {
  Vector2 low, high;
};
using Boxes = std::vector<std::optional<Box>>;

/// Round a disc, where eight points of its outline are seen by `seen(p_W)`. An uncorrected lens magnifies towards the
/// edge, and may push discs together or out of the picture. Nothing where part of the disc is not seen.
template <typename Seen>
std::optional<Box> seen_box(const Disc& disc, const Seen& seen) {
  const std::array<Vector3, 2> across_W = holdfast::detail::basis_across(disc.normal_W);
  std::optional<Box> box;
  for (int i = 0; i < 8; ++i) {
    const double angle = std::numbers::pi * i / 4.0;
    const Vector3 offset_W = std::cos(angle) * across_W[0] + std::sin(angle) * across_W[1];
    const std::optional<Vector2> point = seen(Vector3(disc.centre_W + disc.radius_m * offset_W));
    if (!point) return std::nullopt;
    if (!box) box = Box{*point, *point};
    box->low = box->low.cwiseMin(*point);
    box->high = box->high.cwiseMax(*point);
  }
  return box;
}

/// Whole in the picture, and no other disc's box reaches into its own with the margin.
bool is_alone(const Boxes& boxes, std::size_t disc, double margin_px, PixelSize size) {
  if (!boxes[disc]) return false;
  const Box own = *boxes[disc];
  if (own.low.minCoeff() < 0.0 || own.high.x() > size.width || own.high.y() > size.height) return false;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (i == disc || !boxes[i]) continue;
    const Vector2 apart = (boxes[i]->low - own.high).cwiseMax(own.low - boxes[i]->high);
    if (apart.maxCoeff() < margin_px) return false;
  }
  return true;
}

template <typename Seen>
Boxes all_boxes(const RegistrationScene& scene, const Seen& seen) {
  Boxes boxes;
  for (const Disc& disc : scene.discs) boxes.push_back(seen_box(disc, seen));
  return boxes;
}

/// Sets alpha to opaque; the part of the picture whose mask was 0, and that between.
void take_mask(io::Image& image, double& missing_pct, double& guessed_pct) {
  const rendering::CoverageMaskCount count = rendering::count_coverage_mask(image);
  missing_pct = count.missing_pct;
  guessed_pct = count.disoccluded_pct;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
}

/// Where the nearest disc of those is seen that stand whole in the real picture; of equals the one farthest from the
/// middle, whose lines light longest before or after it.
std::optional<Vector2> place_of_detail(const EyeModel& eye, const RegistrationScene& scene, const Rigid& X_WE) {
  const Vector2 middle(0.5 * eye.resolution.width, 0.5 * eye.resolution.height);
  std::optional<Vector2> place;
  std::pair<double, double> best;
  for (const Disc& disc : scene.discs) {
    const auto ellipse = project_disc(eye, X_WE, disc);
    if (!ellipse || !ellipse->front || !ellipse->is_inside(eye.resolution)) continue;
    const std::pair rank(disc.nominal_distance_m, -(ellipse->centroid - middle).norm());
    if (place && rank >= best) continue;
    best = rank;
    place = ellipse->centroid;
  }
  return place;
}

/// The part of `image` from pixel (x, y) on that is as large as `like`.
io::Image cut_out(const io::Image& image, int x, int y, const io::Image& like) {
  io::Image part(like.width, like.height);
  for (int row = 0; row < part.height; ++row) {
    for (int column = 0; column < part.width; ++column) part.set(column, row, image.at(x + column, y + row));
  }
  return part;
}

}  // namespace

std::optional<double> CentroidErrors::rms() const {
  return count == 0 ? std::nullopt : std::optional<double>(std::sqrt(sum / static_cast<double>(count)));
}

io::Image smaller(const io::Image& image, int factor) {
  if (factor <= 1) return image;
  io::Image result(image.width / factor, image.height / factor);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        int sum = 0;
        for (int dy = 0; dy < factor; ++dy) {
          for (int dx = 0; dx < factor; ++dx) sum += image.rgba[image.offset(x * factor + dx, y * factor + dy) + c];
        }
        result.rgba[result.offset(x, y) + c] = static_cast<std::uint8_t>(sum / (factor * factor));
      }
    }
  }
  return result;
}

void RealPictures::select(const Motion& motion, const ExperimentSettings& settings) {
  const Key of(&motion, settings.eye, settings.lens, settings.hmd.timing.scan_out);
  if (of == of_) return;
  of_ = of;
  pictures_.clear();
}

void compare_centroids(const EyeModel& eye, LensMode lens, const DisplayTiming& timing, const RegistrationScene& scene,
                       const FrameRecord& frame, const io::Image& real, const io::Image& drawn,
                       CentroidErrors& errors) {
  // A rolling display shears discs, and a lens bends them: a wide margin keeps neighbours out of the window.
  constexpr double margin_px = 4.0, keep_apart_px = 12.0;
  const Rigid X_EW = frame.X_WE_true.inverse();
  const ShownOn on{eye, eye, lens, timing};
  const Boxes real_boxes = all_boxes(scene, [&](const Vector3& p_W) { return project(eye, X_EW * p_W); });
  const Boxes drawn_boxes = all_boxes(scene, [&](const Vector3& p_W) { return place_in_view(frame.shown, on, p_W); });
  const std::vector<std::uint8_t> green = eye.lens_red || eye.lens_blue ? green_of(drawn) : std::vector<std::uint8_t>();
  const PictureView real_view{real.rgba, real.width, real.height, 4};
  const PictureView drawn_view = green.empty() ? PictureView{drawn.rgba, drawn.width, drawn.height, 4}
                                               : PictureView{green, drawn.width, drawn.height, 1};
  const auto measure = [&](const PictureView& view, const Vector2& expected, const Vector2& half_extent) {
    const auto found = picture_centroid(view, window_around(expected, half_extent, margin_px));
    if (found) errors.add((found->centroid - expected).norm());
  };
  for (const FiducialRecord& f : frame.fiducials) {
    if (!f.visible || !is_alone(real_boxes, f.disc, keep_apart_px, eye.resolution) ||
        !is_alone(drawn_boxes, f.disc, keep_apart_px, eye.resolution)) {
      continue;
    }
    const Box& real_box = *real_boxes[f.disc];
    const Box& drawn_box = *drawn_boxes[f.disc];
    measure(real_view, f.c_real, 0.5 * (real_box.high - real_box.low));
    measure(drawn_view, f.c_virtual, (drawn_box.high - f.c_virtual).cwiseMax(f.c_virtual - drawn_box.low));
  }
}

void RowRunner::measure(const Motion& motion, const ExperimentSettings& settings, const FrameRecord& frame,
                        CentroidErrors& errors) {
  const EyeModel& eye = settings.hmd.eye(settings.eye);
  const DisplayTiming& timing = settings.hmd.timing;
  const auto X_WE_at = [&](double s) { return motion.at(frame.t_display + from_seconds(s)).X_WB * eye.X_HE; };
  const rendering::SceneStyle style = rendering::disc_measuring_style();
  const io::Image& real = real_.at(frame.t_display, Smooth::no, [&](io::Image& picture) {
    studio_.draw_real(eye, settings.lens, timing, X_WE_at, style, Smooth::no, picture);
  });
  studio_.draw_virtual(frame.shown, eye, settings.lens, timing, style, Smooth::no, drawn_);
  compare_centroids(eye, settings.lens, timing, scene_, frame, real, drawn_, errors);
}

PictureFrame RowRunner::picture(const Motion& motion, const ExperimentSettings& settings, const FrameRecord& frame,
                                int factor) {
  const EyeModel& eye = settings.hmd.eye(settings.eye);
  const DisplayTiming& timing = settings.hmd.timing;
  const auto X_WE_at = [&](double s) { return motion.at(frame.t_display + from_seconds(s)).X_WB * eye.X_HE; };
  const io::Image& real = real_.at(frame.t_display, Smooth::yes, [&](io::Image& picture) {
    studio_.draw_real(eye, settings.lens, timing, X_WE_at, rendering::real_style(), Smooth::yes, picture);
  });
  studio_.draw_virtual(frame.shown, eye, settings.lens, timing, rendering::virtual_style(), Smooth::yes, drawn_);
  const Stopwatch keeping;
  PictureFrame result;
  result.t_s = to_seconds(frame.t_display - motion.begin());
  result.rms_px = frame.rms_px.value_or(0.0);
  take_mask(drawn_, result.missing_pct, result.guessed_pct);
  result.whole = {smaller(real, factor), smaller(drawn_, factor), {}};
  const auto add_arrows = [&](Shot& shot, const Vector2& corner, double scale) {
    const int height = shot.real.height;
    for (const FiducialRecord& f : frame.fiducials) {
      if (!f.visible) continue;
      const Vector2 from = scale * (f.c_real - corner), tip = scale * (f.c_virtual - corner);
      if (from.minCoeff() < 0.0 || from.x() > shot.real.width || from.y() > height) continue;
      shot.arrows.push_back({from.x(), height - from.y(), tip.x(), height - tip.y()});
    }
  };
  add_arrows(result.whole, Vector2::Zero(), 1.0 / factor);
  const std::optional<Vector2> middle = factor > 1 ? place_of_detail(eye, scene_, frame.X_WE_true) : std::nullopt;
  if (middle) {
    const io::Image& like = result.whole.real;
    const auto corner_of = [](double centre, int size, int all) {
      return std::clamp(static_cast<int>(std::lround(centre)) - size / 2, 0, all - size);
    };
    const int x = corner_of(middle->x(), like.width, real.width), y = corner_of(middle->y(), like.height, real.height);
    result.detail = Shot{cut_out(real, x, y, like), cut_out(drawn_, x, y, like), {}};
    result.detail_middle = {middle->x() - x, like.height - (middle->y() - y)};
    add_arrows(*result.detail, Vector2(x, y), 1.0);
  }
  const double ms = keeping.milliseconds();
  timing_.encode_ms += ms;
  timing_.frame_loop_ms -= ms;  // the caller counts the whole loop
  return result;
}

RowResult RowRunner::run(const Motion& motion, const ExperimentSettings& settings, const PicturePlan& plan) {
  real_.select(motion, settings);
  const std::vector<std::size_t> measured = evenly_spaced(frames_of(motion, settings), plan.measured);
  RowResult result;
  std::vector<FrameRecord> kept;
  std::optional<FrameRecord> worst;
  const auto observe = [&](const FrameRecord& frame) {
    result.samples.push_back(
        {to_seconds(frame.t_display - motion.begin()), frame.rms_px, frame.rms_arcmin, frame.swim_rms_deg_s});
    if (kept.size() < measured.size() && frame.index == measured[kept.size()]) kept.push_back(frame);
    if (frame.rms_px && (!worst || *frame.rms_px > 1.02 * *worst->rms_px)) worst = frame;
  };
  const Stopwatch measuring;
  ExperimentResult experiment = run_experiment(motion, settings, scene_, observe);
  if (experiment.status != ExperimentStatus::ok) {
    throw io::InputError({.key = "motion " + settings.motion_name, .problem = experiment.problem});
  }
  const double metrics_ms = measuring.milliseconds();
  timing_.metrics_ms += metrics_ms;
  result.row = std::move(experiment.row);

  const Stopwatch begin;
  std::size_t drawn_frames = kept.size() + (worst && plan.contact > 0 ? 1 : 0);
  drawn_frames = std::min(drawn_frames, result.row.frames);
  timing_.frame_loop_ms += metrics_ms * static_cast<double>(drawn_frames) / static_cast<double>(result.row.frames);

  CentroidErrors errors;
  const std::vector<std::size_t> contact = evenly_spaced(kept.size(), plan.contact);
  const int factor =
      std::max(1, static_cast<int>(std::lround(settings.hmd.eye(settings.eye).resolution.width / 420.0)));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    measure(motion, settings, kept[i], errors);
    if (std::binary_search(contact.begin(), contact.end(), i)) {
      result.contact.push_back(picture(motion, settings, kept[i], factor));
    }
  }
  if (worst && plan.contact > 0) result.worst = picture(motion, settings, *worst, 1);
  result.row.picture_vs_theory_px = errors.rms();
  timing_.frame_loop_ms += begin.milliseconds();
  return result;
}

}  // namespace swimlab

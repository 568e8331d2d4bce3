#include "row_runner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <holdfast/io/input_error.hpp>
#include <holdfast/registration/picture_centroid.hpp>

namespace swimlab {

using namespace holdfast;

namespace {

using Clock = std::chrono::steady_clock;
double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

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

/// Round a disc as it is seen through the lens: an uncorrected one magnifies towards the edge, and may push discs
/// together or out of the picture. Nothing where part of the disc is not seen.
std::optional<Box> seen_box(const EyeModel& eye, LensMode lens, const ProjectedEllipse& disc) {
  Box box{disc.centroid, disc.centroid};
  bool first = true;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const auto seen = seen_pixel(eye, lens, disc.centroid + Vector2(x, y).cwiseProduct(disc.half_extent_px));
      if (!seen) return std::nullopt;
      box.low = first ? *seen : Vector2(box.low.cwiseMin(*seen));
      box.high = first ? *seen : Vector2(box.high.cwiseMax(*seen));
      first = false;
    }
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

Boxes all_boxes(const EyeModel& eye, LensMode lens, const RegistrationScene& scene, const Rigid& X_WE) {
  Boxes boxes;
  for (const Disc& disc : scene.discs) {
    const auto projected = project_disc(eye, X_WE, disc);
    boxes.push_back(projected ? seen_box(eye, lens, *projected) : std::nullopt);
  }
  return boxes;
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

void compare_centroids(const EyeModel& eye, LensMode lens, const RegistrationScene& scene, const FrameRecord& frame,
                       const io::Image& real, const io::Image& drawn, CentroidErrors& errors) {
  // A rolling display shears discs, and a lens bends them: a wide margin keeps neighbours out of the window.
  constexpr double margin_px = 4.0, keep_apart_px = 12.0;
  const Boxes real_boxes = all_boxes(eye, LensMode::none, scene, frame.X_WE_true);
  const Boxes drawn_boxes = all_boxes(eye, lens, scene, frame.X_WE_displayed);
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
  const auto X_WE_at = [&](double s) { return motion.at(frame.t_display + from_seconds(s)).X_WB * eye.X_HE; };
  const rendering::SceneStyle style = rendering::disc_measuring_style();
  studio_.draw_real(eye, settings.lens, settings.hmd.timing, X_WE_at, style, Smooth::no, real_);
  studio_.draw_virtual(eye, settings.lens, frame.X_WE_displayed, style, Smooth::no, drawn_);
  compare_centroids(eye, settings.lens, scene_, frame, real_, drawn_, errors);
}

PictureFrame RowRunner::picture(const Motion& motion, const ExperimentSettings& settings, const FrameRecord& frame,
                                int factor) {
  const EyeModel& eye = settings.hmd.eye(settings.eye);
  const auto X_WE_at = [&](double s) { return motion.at(frame.t_display + from_seconds(s)).X_WB * eye.X_HE; };
  studio_.draw_real(eye, settings.lens, settings.hmd.timing, X_WE_at, rendering::real_style(), Smooth::yes, real_);
  studio_.draw_virtual(eye, settings.lens, frame.X_WE_displayed, rendering::virtual_style(), Smooth::yes, drawn_);
  const auto keeping = Clock::now();
  PictureFrame result;
  result.t_s = to_seconds(frame.t_display - motion.begin());
  result.rms_px = frame.rms_px.value_or(0.0);
  result.real = smaller(real_, factor);
  result.drawn = smaller(drawn_, factor);
  const auto onto_page = [&](const Vector2& p) { return Vector2(p.x() / factor, (real_.height - p.y()) / factor); };
  for (const FiducialRecord& f : frame.fiducials) {
    if (!f.visible) continue;
    const Vector2 from = onto_page(f.c_real), tip = onto_page(f.c_virtual);
    result.arrows.push_back({from.x(), from.y(), tip.x(), tip.y()});
  }
  const double ms = ms_since(keeping);
  timing_.encode_ms += ms;
  timing_.frame_loop_ms -= ms;  // the caller counts the whole loop
  return result;
}

RowResult RowRunner::run(const Motion& motion, const ExperimentSettings& settings, const PicturePlan& plan) {
  const auto begin = Clock::now();
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
  ExperimentResult experiment = run_experiment(motion, settings, scene_, observe);
  if (experiment.status != ExperimentStatus::ok) {
    throw io::InputError({.key = "motion " + settings.motion_name, .problem = experiment.problem});
  }
  result.row = std::move(experiment.row);

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
  timing_.frame_loop_ms += ms_since(begin);
  return result;
}

}  // namespace swimlab

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

/// A window that shows nothing but one disc: no other disc's box, in either picture, reaches into it.
bool is_alone(const std::vector<std::optional<ProjectedEllipse>>& discs, std::size_t disc, double margin_px) {
  const Vector2 centre = discs[disc]->centroid;
  const Vector2 reach = discs[disc]->half_extent_px + Vector2::Constant(margin_px);
  for (std::size_t i = 0; i < discs.size(); ++i) {
    if (i == disc || !discs[i]) continue;
    const Vector2 apart = (discs[i]->centroid - centre).cwiseAbs() - discs[i]->half_extent_px - reach;
    if (apart.maxCoeff() < 0.0) return false;
  }
  return true;
}

std::vector<std::optional<ProjectedEllipse>> all_discs(const EyeModel& eye, const RegistrationScene& scene,
                                                       const Rigid& X_WE) {
  std::vector<std::optional<ProjectedEllipse>> discs;
  for (const Disc& disc : scene.discs) discs.push_back(project_disc(eye, X_WE, disc));
  return discs;
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

void compare_centroids(const EyeModel& eye, const RegistrationScene& scene, const FrameRecord& frame,
                       const io::Image& real, const io::Image& drawn, CentroidErrors& errors) {
  // Lenses move discs by more than they bend them: a wide margin keeps neighbours out of the window.
  constexpr double margin_px = 4.0, keep_apart_px = 12.0;
  const auto real_discs = all_discs(eye, scene, frame.X_WE_true);
  const auto drawn_discs = all_discs(eye, scene, frame.X_WE_displayed);
  const std::vector<std::uint8_t> green = eye.lens_red || eye.lens_blue ? green_of(drawn) : std::vector<std::uint8_t>();
  const PictureView real_view{real.rgba, real.width, real.height, 4};
  const PictureView drawn_view = green.empty() ? PictureView{drawn.rgba, drawn.width, drawn.height, 4}
                                               : PictureView{green, drawn.width, drawn.height, 1};
  const auto measure = [&](const PictureView& view, const Vector2& expected, const Vector2& half_extent) {
    const auto found = picture_centroid(view, window_around(expected, half_extent, margin_px));
    if (found) errors.add((found->centroid - expected).norm());
  };
  for (const FiducialRecord& f : frame.fiducials) {
    if (!f.visible || !is_alone(real_discs, f.disc, keep_apart_px) || !is_alone(drawn_discs, f.disc, keep_apart_px)) {
      continue;
    }
    measure(real_view, f.c_real, real_discs[f.disc]->half_extent_px);
    measure(drawn_view, f.c_virtual, 1.15 * drawn_discs[f.disc]->half_extent_px);
  }
}

void RowRunner::measure(const Motion& motion, const ExperimentSettings& settings, const FrameRecord& frame,
                        CentroidErrors& errors) {
  const EyeModel& eye = settings.hmd.eye(settings.eye);
  const auto X_WE_at = [&](double s) { return motion.at(frame.t_display + from_seconds(s)).X_WB * eye.X_HE; };
  const rendering::SceneStyle style = rendering::disc_measuring_style();
  studio_.draw_real(eye, settings.lens, settings.hmd.timing, X_WE_at, style, Smooth::no, real_);
  studio_.draw_virtual(eye, settings.lens, frame.X_WE_displayed, style, Smooth::no, drawn_);
  compare_centroids(eye, scene_, frame, real_, drawn_, errors);
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

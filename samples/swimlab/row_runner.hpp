/// Runs one row: the experiment on all frames, then pictures of some of them, compared with what was computed.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <holdfast/io/image.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/registration/experiment.hpp>

#include "studio.hpp"

namespace swimlab {

/// From the real to the virtual disc: x0, y0, x1, y1, px with y downward, as pictures on a page are counted.
using Arrow = std::array<double, 4>;

/// Real and virtual as the eye would see them alone, and from where to where the discs err.
struct Shot {
  holdfast::io::Image real, drawn;
  std::vector<Arrow> arrows;
};

/// A frame as pictures.
struct PictureFrame {
  double t_s = 0.0;
  double rms_px = 0.0;
  double missing_pct = 0.0, guessed_pct = 0.0;  ///< of the virtual picture: without a pixel; revealed by a depth warp
  Shot whole;
  /// Round one disc, the same for all pipelines, each pixel as the display has it; as large as `whole`.
  std::optional<Shot> detail;
  std::array<double, 2> detail_middle{};  ///< the disc's place in it, counted as Arrow's
};

struct FrameSample {
  double t_s = 0.0;
  std::optional<double> rms_px, rms_arcmin, swim_deg_s;
};

struct RowResult {
  holdfast::ExperimentRow row;
  std::vector<FrameSample> samples;   ///< every frame
  std::vector<PictureFrame> contact;  ///< small pictures, evenly spaced in time
  std::optional<PictureFrame> worst;  ///< full size: the frame of the largest error
  bool is_repeated = false;           ///< the row of another pipeline that does the same here: numbers alone
};

struct PicturePlan {
  std::size_t measured = 13;  ///< evenly spaced frames whose pictures are measured
  std::size_t contact = 5;    ///< of these, so many are kept; 0 or at least 2
};

struct RunTiming {
  double frame_loop_ms = 0.0;  ///< everything done for the frames that are drawn, but what is kept, encoded and written
  double encode_ms = 0.0;
  double metrics_ms = 0.0;  ///< numbers of all frames; the drawn frames' share of it is in frame_loop_ms too
};

/// The box-filtered picture, `factor` times smaller.
[[nodiscard]] holdfast::io::Image smaller(const holdfast::io::Image& image, int factor);

/// Squares of the differences between centroids in a picture and the ellipses that theory projects.
struct CentroidErrors {
  double sum = 0.0;
  std::size_t count = 0;

  void add(double error_px) {
    sum += error_px * error_px;
    ++count;
  }
  [[nodiscard]] std::optional<double> rms() const;
};

/// Measures both pictures' discs of a frame (drawn in disc_measuring_style) against the record.
void compare_centroids(const holdfast::EyeModel& eye, holdfast::LensMode lens, const holdfast::DisplayTiming& timing,
                       const holdfast::RegistrationScene& scene, const holdfast::FrameRecord& frame,
                       const holdfast::io::Image& real, const holdfast::io::Image& drawn, CentroidErrors& errors);

/// Pictures of the real world, which do not depend on the pipeline: rows that share motion, eye and display draw them
/// once.
class RealPictures {
 public:
  /// Forgets what belongs to another motion, eye, display or lens.
  void select(const holdfast::Motion& motion, const holdfast::ExperimentSettings& settings);
  /// The picture of the frame, drawn by `draw(image)` when it is not known yet.
  template <typename Draw>
  const holdfast::io::Image& at(holdfast::HostTime t_display, Smooth smooth, const Draw& draw) {
    const auto [entry, is_new] = pictures_.try_emplace({t_display, smooth});
    if (is_new) draw(entry->second);
    return entry->second;
  }

 private:
  using Key = std::tuple<const holdfast::Motion*, holdfast::EyeSide, holdfast::LensMode, holdfast::ScanOut>;
  Key of_{};
  std::map<std::pair<holdfast::HostTime, Smooth>, holdfast::io::Image> pictures_;
};

class RowRunner {
 public:
  RowRunner(Studio& studio, const holdfast::RegistrationScene& scene) : studio_(studio), scene_(scene) {}

  /// Throws io::InputError when the motion is too short for the latency.
  [[nodiscard]] RowResult run(const holdfast::Motion& motion, const holdfast::ExperimentSettings& settings,
                              const PicturePlan& plan);
  [[nodiscard]] const RunTiming& timing() const { return timing_; }

 private:
  [[nodiscard]] PictureFrame picture(const holdfast::Motion& motion, const holdfast::ExperimentSettings& settings,
                                     const holdfast::FrameRecord& frame, int factor);
  void measure(const holdfast::Motion& motion, const holdfast::ExperimentSettings& settings,
               const holdfast::FrameRecord& frame, CentroidErrors& errors);

  Studio& studio_;
  const holdfast::RegistrationScene& scene_;
  RunTiming timing_;
  RealPictures real_;
  holdfast::io::Image drawn_;
};

}  // namespace swimlab

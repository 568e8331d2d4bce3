/// Runs one row: the experiment on all frames, then pictures of some of them, compared with what was computed.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <holdfast/io/image.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/registration/experiment.hpp>

#include "studio.hpp"

namespace swimlab {

/// From the real to the virtual disc: x0, y0, x1, y1, px with y downward, as pictures on a page are counted.
using Arrow = std::array<double, 4>;

/// A frame as pictures. Real and virtual are as the eye would see them alone.
struct PictureFrame {
  double t_s = 0.0;
  double rms_px = 0.0;
  holdfast::io::Image real, drawn;
  std::vector<Arrow> arrows;
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
};

struct PicturePlan {
  std::size_t measured = 13;  ///< evenly spaced frames whose pictures are measured
  std::size_t contact = 5;    ///< of these, so many are kept; 0 or at least 2
};

struct RunTiming {
  double frame_loop_ms = 0.0;  ///< everything but what is kept, encoded and written
  double encode_ms = 0.0;
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
void compare_centroids(const holdfast::EyeModel& eye, holdfast::LensMode lens, const holdfast::RegistrationScene& scene,
                       const holdfast::FrameRecord& frame, const holdfast::io::Image& real,
                       const holdfast::io::Image& drawn, CentroidErrors& errors);

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
  holdfast::io::Image real_, drawn_;
};

}  // namespace swimlab

/// What `swimlab lens` says about one lens of an eye.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/optics/eye.hpp>

namespace swimlab {

/// Where the lens ends inside the panel: beyond, it folds over or has no samples.
struct LensEnd {
  double radius_px = 0.0;         ///< from the lens's centre on the panel
  holdfast::Vector2 panel_px;     ///< there
  holdfast::Angle seen_off_axis;  ///< of the last direction seen, against the eye's axis
};

/// What became of the samples that describe a lens (optics/point_mesh.hpp).
struct SampleFacts {
  std::size_t samples = 0, triangles = 0;  ///< all that the samples make
  std::size_t folded = 0;                  ///< left out: mirrored or flat on the seen side
  std::size_t cut_off = 0;                 ///< left out: cut off by folds, or lying over others there
};

struct LensFacts {
  std::string color;  ///< all, or red, green, blue
  std::string model;
  double valid_radius_px = 0.0;  ///< infinite: everywhere one-to-one
  double residual_rms_px = 0.0;  ///< distort(undistort(v)) - v, over what the panel shows
  double residual_max_px = 0.0;
  std::size_t unanswered = 0;        ///< points that the panel shows and the inverse does not answer
  double dark_pct = 0.0;             ///< of the panel, where the lens answers nothing
  std::optional<LensEnd> first_end;  ///< the one nearest to the centre
  std::optional<LensEnd> last_end;   ///< the farthest
  std::optional<SampleFacts> samples;
};

/// One entry for all colours when they are bent alike, else three.
[[nodiscard]] std::vector<LensFacts> facts_of(const holdfast::EyeModel& eye);

}  // namespace swimlab

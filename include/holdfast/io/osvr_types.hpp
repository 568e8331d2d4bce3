/// What an OSVR display descriptor says besides the headset itself, and what it leaves open.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

/// How the two eyes' pictures lie in the frame that is sent to the display.
enum class OsvrDisplayMode { side_by_side, one_above_the_other, full_screen };

/// What a descriptor does not give and a headset needs.
struct OsvrAssumptions {
  double ipd_m = 0.063;                 ///< OSVR's own default
  double refresh_hz = 90.0;             ///< of a global display
  PixelSize eye_resolution{960, 1080};  ///< for files that hold only a distortion mesh, without resolutions
};

struct OsvrHmd {
  HmdModel hmd;
  OsvrDisplayMode display_mode = OsvrDisplayMode::side_by_side;
  bool swap_eyes = false;          ///< the left eye's picture goes where the right one's would be
  std::vector<std::string> notes;  ///< what was assumed, or is of no effect
};

/// A file and where it came from, for messages.
struct NamedText {
  std::string text;
  std::string file;
};

/// Answers a file that lies beside the descriptor, by its plain name; throws InputError when there is none.
using BesideReader = std::function<NamedText(std::string_view name)>;

}  // namespace holdfast::io

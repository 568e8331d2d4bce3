/// The motions of a run: the default ones by name, or recordings brought into the scene.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <holdfast/motion/motion.hpp>
#include <holdfast/motion/timed_pose.hpp>

#include "options.hpp"

namespace swimlab {

struct ChosenMotion {
  std::string id;     ///< as rows name it: "M1", or a recording's file name
  std::string title;  ///< "M1, yaw 2 Hz +-3 deg"
  std::string about;  ///< a sentence or two for the report
  std::unique_ptr<holdfast::Motion> motion;
  bool recorded = false;
};

/// Poses of a recording as head poses in the scene: its mean pose becomes the scene's first viewpoint. The body's axes
/// are taken for the head's (X right, Y up, -Z forward).
[[nodiscard]] std::vector<holdfast::TimedPose> brought_into_scene(std::vector<holdfast::TimedPose> samples);

/// Throws io::InputError: an unknown name, or a file that cannot be read.
[[nodiscard]] std::vector<ChosenMotion> load_motions(const RunOptions& options);

/// Largest angular speed of the head, deg/s, looked at every 5 ms.
[[nodiscard]] double peak_head_speed_deg_s(const holdfast::Motion& motion);

}  // namespace swimlab

#include "track_motion.hpp"

#include <chrono>
#include <memory>
#include <vector>

#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/head_motions.hpp>
#include <holdfast/simulation/ceiling_motion.hpp>

namespace swimlab {

using namespace holdfast;

TrueMotion generated_walk(std::uint64_t seed, double seconds) {
  const std::unique_ptr<Motion> walk = make_walk_around(seed, from_seconds(seconds));
  return {"walk-around", hiball_truth(place_under_ceiling(sample(*walk, std::chrono::milliseconds(10))))};
}

TrueMotion recorded_motion(const RecordedMotion& recorded, double seconds) {
  CeilingPlacement placement;
  placement.up_R = recorded.up_R;
  std::vector<TimedPose> samples =
      io::read_trajectory(recorded.file, recorded.lenient ? io::ReadMode::lenient : io::ReadMode::strict).samples;
  const HostTime end = samples.front().t + from_seconds(seconds);
  std::erase_if(samples, [&](const TimedPose& pose) { return pose.t > end; });
  if (samples.size() < 2 || samples.back().t - samples.front().t < std::chrono::seconds(2)) {
    throw io::InputError({.file = recorded.file.string(),
                          .problem = "too short to judge a tracker",
                          .expected = "two seconds of motion or more"});
  }
  return {recorded.file.filename().string(), hiball_truth(place_under_ceiling(samples, placement))};
}

Vector3 up_axis(const std::string& word) {
  if (word != "x" && word != "y" && word != "z") {
    throw io::InputError({.key = "--up",
                          .problem = "unknown axis",
                          .value = word,
                          .expected = "the recording's axis that points up: x, y or z"});
  }
  return Vector3::Unit(word[0] - 'x');
}

}  // namespace swimlab

#include "motions.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <sstream>
#include <utility>

#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/low_pass.hpp>
#include <holdfast/motion/spline_trajectory.hpp>

namespace swimlab {

using namespace holdfast;

namespace {

std::string about_default(std::string_view id) {
  if (id == "M0") return "The head keeps still: whatever error is left is not latency's.";
  if (id == "M1") return "The head shakes left and right twice a second, by 3 degrees each way.";
  if (id == "M2") return "The head turns left and right once a second, by 15 degrees each way.";
  if (id == "M3")
    return "The head turns at a steady 100 degrees a second and stops at once: no prediction lags, every predictor "
           "overshoots after the stop.";
  if (id == "M4") return "A person walks around the scene and looks at it.";
  if (id == "M5") return "The head turns: yaw, pitch and circling.";
  if (id == "M6") return "The head swings from side to side while it turns.";
  if (id == "M7")
    return "The head moves sideways at 0.5 metres a second without turning: near things slide more than far ones.";
  return "The head shakes ever faster, from 0.2 to 10 times a second, by 2 degrees each way.";
}

std::string known_names() {
  std::string names;
  for (const MotionName& name : motion_names()) names += (names.empty() ? "" : ", ") + std::string(name.id);
  return names;
}

ChosenMotion recorded_motion(const std::string& file, const RunOptions& options) {
  io::TrajectoryFile recording =
      io::read_trajectory(file, options.lenient ? io::ReadMode::lenient : io::ReadMode::strict);
  std::fprintf(stderr, "%s: %s", file.c_str(), io::describe(recording.report).c_str());
  ChosenMotion chosen;
  chosen.id = std::filesystem::path(file).filename().string();
  chosen.title = chosen.id + ", a recording";
  std::ostringstream about;
  about.precision(3);
  about << "A recording of " << to_seconds(recording.report.duration) << " s at " << recording.report.rate_hz()
        << " Hz, brought into the scene by its mean pose. Velocity is the difference of two poses 16.7 ms apart.";
  if (recording.report.gaps > 0) about << " Its gaps are bridged by straight motion at a constant rate.";
  std::vector<TimedPose> samples = brought_into_scene(std::move(recording.samples));
  if (options.low_pass_hz > 0.0) {
    samples = zero_phase_low_pass(samples, options.low_pass_hz);
    about << " What is faster than " << options.low_pass_hz << " Hz is taken for the recording's noise and left out.";
  }
  chosen.about = about.str();
  chosen.motion = std::make_unique<SplineTrajectory>(samples);
  chosen.recorded = true;
  return chosen;
}

ChosenMotion chosen_motion(const std::string& word, const RunOptions& options) {
  for (const MotionName& name : motion_names()) {
    if (word != name.id) continue;
    ChosenMotion chosen;
    chosen.id = word;
    chosen.title = word + ", " + std::string(name.title);
    chosen.about = about_default(word);
    chosen.motion = make_motion(word, options.seed);
    return chosen;
  }
  std::error_code ignored;
  if (!std::filesystem::exists(word, ignored)) {
    throw io::InputError({.key = "--motion",
                          .problem = "neither a known motion nor a file that exists",
                          .value = word,
                          .expected = "one of " + known_names() + ", or a recording (TUM, EuRoC, CSV with a header)"});
  }
  return recorded_motion(word, options);
}

}  // namespace

std::vector<TimedPose> brought_into_scene(std::vector<TimedPose> samples) {
  const Quaternion first = samples.front().X_WB.q();
  Vector4 q_sum = Vector4::Zero();
  Vector3 p_sum = Vector3::Zero();
  for (const TimedPose& sample : samples) {
    const Quaternion& q = sample.X_WB.q();
    const double sign = q.dot(first) < 0.0 ? -1.0 : 1.0;  // q and -q are one orientation
    q_sum += sign * Vector4(q.x(), q.y(), q.z(), q.w());
    p_sum += sample.X_WB.p();
  }
  const bool spread = q_sum.norm() < 0.1 * static_cast<double>(samples.size());  // turned all ways round
  const Quaternion q_mean = spread ? first : Quaternion(q_sum.w(), q_sum.x(), q_sum.y(), q_sum.z());
  const Rigid X_SW = Rigid(q_mean, p_sum / static_cast<double>(samples.size())).inverse();
  for (TimedPose& sample : samples) sample.X_WB = X_SW * sample.X_WB;
  return samples;
}

std::vector<ChosenMotion> load_motions(const RunOptions& options) {
  std::vector<ChosenMotion> motions;
  for (const std::string& word : options.motions) {
    ChosenMotion chosen = chosen_motion(word, options);
    const auto same = std::count_if(motions.begin(), motions.end(), [&](const auto& m) { return m.id == chosen.id; });
    if (same > 0 && !chosen.recorded) continue;  // named twice
    if (same > 0) chosen.id += " (" + std::to_string(same + 1) + ")";
    motions.push_back(std::move(chosen));
  }
  return motions;
}

double peak_head_speed_deg_s(const Motion& motion) {
  double peak = 0.0;
  for (HostTime t = motion.begin(); t <= motion.end(); t += std::chrono::milliseconds(5)) {
    peak = std::max(peak, motion.at(t).w_WB_B.norm());
  }
  return peak * (180.0 / std::numbers::pi);
}

}  // namespace swimlab

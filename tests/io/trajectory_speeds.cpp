// How people move in the recordings: where HeadDynamics' defaults and docs/prediction.md have their numbers.
#include <cmath>
#include <filesystem>

#include <doctest/doctest.h>

#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/differentiation.hpp>
#include <holdfast/motion/low_pass.hpp>
#include <holdfast/tracking/head_dynamics.hpp>

using namespace holdfast;

TEST_CASE("the usual speeds and accelerations lie between those of the recordings") {
  const std::filesystem::path recordings = HOLDFAST_RECORDINGS;
  if (!std::filesystem::is_directory(recordings)) {
    MESSAGE("skipped: no recordings at " << recordings.string());
    return;
  }
  const auto measured = [&](const char* file) {
    // Low-passed as 001 does with its truth: differences of raw poses would measure their noise.
    const auto poses = zero_phase_low_pass(io::read_trajectory(recordings / file).samples, 10.0);
    double v = 0, w = 0, a = 0, alpha = 0;
    for (const MotionState& s : differentiate(poses)) {
      v += s.v_WB.squaredNorm(), w += s.w_WB_B.squaredNorm();
      a += s.a_WB.squaredNorm(), alpha += s.alpha_WB_B.squaredNorm();
    }
    const double axes = 3.0 * static_cast<double>(poses.size());
    const HeadDynamics rms{std::sqrt(v / axes), std::sqrt(w / axes), std::sqrt(a / axes), std::sqrt(alpha / axes)};
    MESSAGE(std::string(file) << ": root mean square per axis " << rms.speed_m_s << " m/s, " << rms.angular_speed_rad_s
                              << " rad/s, " << rms.acceleration_m_s2 << " m/s^2, " << rms.angular_acceleration_rad_s2
                              << " rad/s^2");
    return rms;
  };
  const HeadDynamics head = measured("head/optitrack_head_120hz.tum"), carried = measured("handheld/table_01.txt"),
                     usual;
  CHECK(usual.speed_m_s > head.speed_m_s);
  CHECK(usual.speed_m_s < carried.speed_m_s);
  CHECK(usual.acceleration_m_s2 > head.acceleration_m_s2);
  CHECK(usual.acceleration_m_s2 < carried.acceleration_m_s2);
  CHECK(usual.angular_acceleration_rad_s2 > head.angular_acceleration_rad_s2);
  CHECK(usual.angular_acceleration_rad_s2 < carried.angular_acceleration_rad_s2);
  CHECK(usual.angular_speed_rad_s == doctest::Approx(head.angular_speed_rad_s).epsilon(0.1));
}

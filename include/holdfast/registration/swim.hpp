/// Swim: how fast virtual things slide against the real ones, d/dt (virtual - real).
///
/// Definition used here: for every fiducial visible in two successive frames, the difference of its two error vectors
/// over the time between the frames: s_n = (e_n - e_{n-1}) / (t_n - t_{n-1}), in px/s and, with the angular error of
/// metrics.hpp, in deg/s. It is the mean swim over one frame period, which is what a display that shows still pictures
/// can show; an abrupt stop of the head therefore counts once, with the step it makes. Against the continuous
/// derivative of a sinusoid of frequency f the difference quotient is smaller by sin(pi f T) / (pi f T) with the frame
/// period T: 0.08 % for 2 Hz at 90 Hz. A fiducial that leaves the view starts anew when it comes back. Source:
/// evaluation.md "Metrics" (swim velocity).
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <holdfast/registration/metrics.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// Rate of change of a fiducial's error between two frames.
struct SwimVelocity {
  Vector2 px_s = Vector2::Zero();
  Vector2 rad_s = Vector2::Zero();

  [[nodiscard]] double deg_s() const { return rad_s.norm() * degrees_per_rad; }
};

/// Differentiates the error of each fiducial from frame to frame.
class SwimMeter {
 public:
  explicit SwimMeter(std::size_t fiducials) : last_(fiducials) {}

  /// Times must increase. Nothing when the fiducial was not seen one frame before, or time stood still.
  std::optional<SwimVelocity> add(std::size_t fiducial, std::size_t frame, HostTime t, const Vector2& error_px,
                                  const Vector2& error_rad) {
    Seen& last = last_[fiducial];
    const Seen now{true, frame, t, error_px, error_rad};
    std::optional<SwimVelocity> swim;
    if (last.valid && last.frame + 1 == frame && t > last.t) {
      const double dt = to_seconds(t - last.t);
      swim = SwimVelocity{(error_px - last.error_px) / dt, (error_rad - last.error_rad) / dt};
    }
    last = now;
    return swim;
  }

 private:
  struct Seen {
    bool valid = false;
    std::size_t frame = 0;
    HostTime t;
    Vector2 error_px = Vector2::Zero();
    Vector2 error_rad = Vector2::Zero();
  };
  std::vector<Seen> last_;
};

}  // namespace holdfast

#include <doctest/doctest.h>

#include <holdfast/timing/timing.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

TEST_CASE("the samples of docs/timing.md do what they say") {
  const HostTime a = time_at(1.5), b = a + 20ms;
  CHECK(b - a == 20ms);
  const TimePoint<TrackerClock> stamp = time_at<TrackerClock>(7.0);
  const ClockOffset<TrackerClock, HostClock> offset(stamp, a, 46e-6);
  CHECK(offset.convert(stamp) == a);

  DisplayTiming display;
  display.refresh_hz = 90;
  display.scan_out = ScanOut::rolling;
  display.scan_duration = 11100us;
  const LightInterval light = light_of_pixel(display, next_vsync(display, b), {640.0, 700.0}, {1280.0, 720.0});
  CHECK(to_milliseconds(light.middle - next_vsync(display, b)) == doctest::Approx(11.1 * 20 / 720).epsilon(1e-5));

  FramePlanSettings settings;
  settings.display = display;
  settings.compute_time = 2ms;
  const auto plan = plan_frame(settings, a, b);
  REQUIRE(plan);
  CHECK(plan->prediction_distance_to_middle() == plan->prediction_distance() + 5550us);

  TrackerStages tracker;
  tracker.sensor_rate_hz = 100;
  tracker.estimate_rate_hz = 100;
  GraphicsStages graphics;
  graphics.render_time = 10ms;
  graphics.refresh_hz = 90;
  const auto budget =
      error_budget(degrees(100), arcmin(6), 5ms, motion_delay(tracker).mean, graphics_delay(graphics).mean);
  // 0.1 deg at rest, 5 ms of samples, 5 + 5 + 10 ms of tracker, 10 + 5.56 ms of graphics, at 0.1 deg per ms.
  CHECK(budget.total().degrees() == doctest::Approx(0.1 + 0.1 * (5 + 20 + 15.5556)).epsilon(1e-5));
}

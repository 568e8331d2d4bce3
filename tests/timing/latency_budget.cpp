#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/timing/latency_budget.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

TEST_CASE("the headline: 100 ms at 100 deg/s is 10 degrees, 5 inches at arm's length, 1.27 mm per ms") {
  const Angle error = dynamic_error(degrees(100), 100ms);
  CHECK(error.degrees() == doctest::Approx(10).epsilon(1e-15));
  constexpr double arm_m = 0.72;  // 28.3 inches
  const double moved = displacement(error, arm_m);
  CHECK(moved == doctest::Approx(5 * 0.0254).epsilon(1e-3));
  CHECK(moved * 1e3 / 100 == doctest::Approx(1.27).epsilon(1e-3));
}

TEST_CASE("eq. 5.2: half a metre per second over 20 ms is a centimetre") {
  CHECK(dynamic_error(0.5, 20ms) == doctest::Approx(0.01).epsilon(1e-15));
}

TEST_CASE("eq. 5.3 in closed form") {
  TrackerStages tracker;
  tracker.sensor_rate_hz = 100;       // 5 ms in the mean
  tracker.estimate_rate_hz = 50;      // 10 ms of waiting, 20 ms of work
  tracker.server_read_rate_hz = 250;  // 2 ms
  tracker.network_time = 1ms;
  tracker.client_read_rate_hz = 125;  // 4 ms
  CHECK(motion_delay(tracker).mean == 42ms);
  CHECK(motion_delay(tracker).most == 63ms);  // waiting takes whole periods
  tracker.estimate_time = 3ms;
  CHECK(motion_delay(tracker).mean == 25ms);
  const auto parts = motion_delay_parts(tracker);
  CHECK(parts[0].mean == 5ms);
  CHECK(parts[2].name == "estimation");
  CHECK(motion_delay(TrackerStages{}).mean == 0ns);  // stages that do not exist take no time
}

TEST_CASE("eq. 5.3 is the mean over random phases") {
  // Sensor at 125 Hz, estimator at 80 Hz (period 12.5 ms, all of it work), buffer read at 200 Hz; motion at a random
  // moment.
  TrackerStages tracker;
  tracker.sensor_rate_hz = 125;
  tracker.estimate_rate_hz = 80;
  tracker.server_read_rate_hz = 200;
  tracker.network_time = 1ms;
  std::mt19937_64 random(95);
  std::uniform_real_distribution<double> uniform;
  const auto wait_for = [&](double t, double hz) {  // from t to the next tick of a clock of random phase
    const double phase = uniform(random) / hz;
    return (std::ceil((t - phase) * hz) / hz + phase) - t;
  };
  double sum = 0.0;
  double longest = 0.0;
  constexpr int runs = 20'000;
  for (int i = 0; i < runs; ++i) {
    double t = uniform(random);
    const double start = t;
    t += wait_for(t, 125);
    t += wait_for(t, 80) + 1.0 / 80;
    t += wait_for(t, 200) + 0.001;
    sum += (t - start) / runs;
    longest = std::max(longest, t - start);
  }
  // The standard deviation of one run is 4.6 ms; over 20,000 runs 33 us. Four sigma.
  CHECK(std::abs(sum - to_seconds(motion_delay(tracker).mean)) < 130e-6);
  CHECK(longest <= to_seconds(motion_delay(tracker).most));
  CHECK(longest > 0.9 * to_seconds(motion_delay(tracker).most));
}

TEST_CASE("the graphics delay of section 5.1.2: waiting for the swap is half a frame in the mean") {
  GraphicsStages graphics;
  graphics.render_time = 10ms;
  graphics.refresh_hz = 100;
  graphics.display_time = 6ms;
  CHECK(graphics_delay(graphics).mean == 21ms);
  CHECK(graphics_delay(graphics).most == 26ms);
}

TEST_CASE("eq. 5.4 adds static, simultaneity and both delays") {
  const auto turn = error_budget(degrees(50), arcmin(6), 10ms, 40ms, 20ms);
  CHECK(turn.simultaneity.degrees() == doctest::Approx(0.5).epsilon(1e-15));
  CHECK(turn.tracker_delay.degrees() == doctest::Approx(2.0).epsilon(1e-15));
  CHECK(turn.graphics_delay.degrees() == doctest::Approx(1.0).epsilon(1e-15));
  CHECK(turn.total().degrees() == doctest::Approx(3.6).epsilon(1e-15));
  // The course's own example: 30 ms of samples at 3 cm/s move about a millimetre.
  const auto move = error_budget(0.03, 0.0, 30ms, 0ns, 0ns);
  CHECK(move.total() == doctest::Approx(0.9e-3).epsilon(1e-12));
}

TEST_CASE("table 5.1: intervals add up, disorder is found") {
  FrameEvents events;
  events.measured = time_at(1.000);
  events.reported = time_at(1.004);
  events.received = time_at(1.005);
  events.image_ready = time_at(1.015);
  events.swapped = time_at(1.020);
  events.scanned_out = time_at(1.030);
  CHECK(events.end_to_end() == 30ms);
  Duration sum{0};
  for (const Duration d : events.intervals()) sum += d;
  CHECK(sum == events.end_to_end());
  CHECK(events.intervals()[2] == 10ms);
  CHECK(frame_interval_names[2] == "rendering");
  CHECK_FALSE(first_event_out_of_order(events));
  events.image_ready = time_at(1.0049);
  REQUIRE(first_event_out_of_order(events));
  CHECK(frame_event_names[static_cast<std::size_t>(*first_event_out_of_order(events))] == "image ready");
}

TEST_CASE("unsound descriptions are named") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(find_problem(TrackerStages{}));
  CHECK_FALSE(find_problem(GraphicsStages{}));
  TrackerStages tracker;
  tracker.sensor_rate_hz = -1;
  CHECK(find_problem(tracker)->member == "sensor_rate_hz");
  tracker = {};
  tracker.estimate_rate_hz = nan;
  CHECK(find_problem(tracker)->member == "estimate_rate_hz");
  tracker = {};
  tracker.estimate_time = -1ms;
  CHECK(find_problem(tracker)->member == "estimate_time");
  tracker = {};
  tracker.server_read_rate_hz = std::numeric_limits<double>::infinity();
  CHECK(find_problem(tracker)->member == "server_read_rate_hz");
  tracker = {};
  tracker.network_time = -1ns;
  CHECK(find_problem(tracker)->member == "network_time");
  tracker = {};
  tracker.client_read_rate_hz = 1e-9;
  CHECK(find_problem(tracker)->member == "client_read_rate_hz");
  GraphicsStages graphics;
  graphics.render_time = -1ns;
  CHECK(find_problem(graphics)->member == "render_time");
  graphics = {};
  graphics.refresh_hz = nan;
  CHECK(find_problem(graphics)->member == "refresh_hz");
  graphics = {};
  graphics.display_time = -1ns;
  CHECK(find_problem(graphics)->member == "display_time");
}

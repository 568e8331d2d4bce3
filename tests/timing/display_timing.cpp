#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/timing/display_timing.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {
DisplayTiming rolling() {
  DisplayTiming timing;
  timing.refresh_hz = 90;
  timing.scan_out = ScanOut::rolling;
  timing.scan_duration = 11100us;
  timing.persistence = 2ms;
  timing.internal_delay = 3ms;
  timing.first_vsync = time_at(0.004);
  return timing;
}
}  // namespace

TEST_CASE("vsyncs come at the refresh and gather no rounding") {
  DisplayTiming timing = rolling();
  CHECK(vsync_at(timing, 0) == time_at(0.004));
  CHECK(vsync_at(timing, 90) - vsync_at(timing, 0) == 1s);
  CHECK(vsync_at(timing, -180) - vsync_at(timing, 0) == -2s);
  CHECK(vsync_at(timing, 90 * 86'400) - vsync_at(timing, 0) == 24h);  // a summed rounded period would be 0.9 ms off
  CHECK(frame_period(timing).count() == 11'111'111);
}

TEST_CASE("next_vsync is the first at or after") {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> any(-3'000'000'000'000, 3'000'000'000'000);
  for (const double hz : {24.0, 59.94, 60.0, 72.0, 90.0, 1000.0 / 7.0, 12'500.0}) {
    DisplayTiming timing = rolling();
    timing.refresh_hz = hz;
    for (int i = 0; i < 200; ++i) {
      const HostTime t(Duration(any(random)));
      const std::int64_t n = next_vsync_number(timing, t);
      CHECK(vsync_at(timing, n) >= t);
      CHECK(vsync_at(timing, n - 1) < t);
      // A vsync's own time is its own answer, one nanosecond later the next one's.
      CHECK(next_vsync_number(timing, vsync_at(timing, n)) == n);
      CHECK(next_vsync_number(timing, vsync_at(timing, n) + 1ns) == n + 1);
    }
  }
}

TEST_CASE("rows count from the bottom, lines from where the scan starts") {
  DisplayTiming timing = rolling();
  const Vector2 size(1280.0, 720.0);
  const auto line = [&](ScanDirection direction, double x, double y) {
    return line_fraction_of_pixel(direction, Vector2(x, y), size);
  };
  CHECK(line(ScanDirection::top_to_bottom, 33, 720) == 0.0);
  CHECK(line(ScanDirection::top_to_bottom, 700, 0) == 1.0);
  CHECK(line(ScanDirection::top_to_bottom, 33, 180) == 0.75);
  CHECK(line(ScanDirection::bottom_to_top, 33, 720) == 1.0);
  CHECK(line(ScanDirection::bottom_to_top, 33, 180) == 0.25);
  CHECK(line(ScanDirection::left_to_right, 0, 33) == 0.0);
  CHECK(line(ScanDirection::left_to_right, 320, 700) == 0.25);
  CHECK(line(ScanDirection::right_to_left, 0, 33) == 1.0);
  CHECK(line(ScanDirection::right_to_left, 320, 33) == 0.75);
  CHECK(is_sideways(ScanDirection::right_to_left));
  CHECK_FALSE(is_sideways(timing.scan_direction));
}

TEST_CASE("rolling: lines run from half the scan before the middle to half after") {
  const DisplayTiming timing = rolling();
  CHECK(line_time_from_middle(timing, 0.0) == -5550us);
  CHECK(line_time_from_middle(timing, 0.5) == 0ns);
  CHECK(line_time_from_middle(timing, 1.0) == 5550us);
  CHECK(line_seconds_from_middle(timing, 0.75) == doctest::Approx(2.775e-3).epsilon(1e-15));
}

TEST_CASE("global: every line has the middle's time, whatever the scan duration says") {
  DisplayTiming timing = rolling();
  timing.scan_out = ScanOut::global;
  for (const double line : {0.0, 0.3, 1.0}) CHECK(line_time_from_middle(timing, line) == 0ns);
  // Vsync, 3 ms of delay, half of 2 ms of light.
  CHECK(middle_of_scan_out(timing, time_at(1.0)) - time_at(1.0) == 4ms);
}

TEST_CASE("light of a line: delay, place in the scan, persistence") {
  const DisplayTiming timing = rolling();
  const HostTime vsync = vsync_at(timing, 5);
  const LightInterval top = light_of_pixel(timing, vsync, {10, 720}, {1280, 720});
  CHECK(top.begin - vsync == 3ms);  // the first line lights after the internal delay
  CHECK(top.end - top.begin == 2ms);
  CHECK(top.middle - top.begin == 1ms);
  const LightInterval bottom = light_of_pixel(timing, vsync, {10, 0}, {1280, 720});
  CHECK(bottom.begin - top.begin == 11100us);
  CHECK(middle_of_scan_out(timing, vsync) == light_of_line(timing, vsync, 0.5).middle);
  CHECK(middle_of_scan_out(timing, vsync) - vsync == 3ms + 5550us + 1ms);
  DisplayTiming upward = timing;
  upward.scan_direction = ScanDirection::bottom_to_top;
  CHECK(light_of_pixel(upward, vsync, {10, 0}, {1280, 720}).begin == top.begin);
}

TEST_CASE("evaluation.md value 9: 11.1 ms at 100 deg/s is 66.6 arcmin top to bottom") {
  const DisplayTiming timing = rolling();
  const double seconds = line_seconds_from_middle(timing, 1.0) - line_seconds_from_middle(timing, 0.0);
  CHECK((degrees(100) * seconds).arcmin() == doctest::Approx(66.6).epsilon(1e-12));
}

TEST_CASE("an unsound description is named") {
  CHECK_FALSE(find_problem(DisplayTiming{}));
  CHECK_FALSE(find_problem(rolling()));
  const auto member = [](auto&& spoil) {
    DisplayTiming timing = rolling();
    spoil(timing);
    const auto problem = find_problem(timing);
    return problem ? std::string(problem->member) : std::string();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double hz : {0.0, -90.0, nan, std::numeric_limits<double>::infinity(), 0.5, 2e6}) {
    CHECK(member([hz](DisplayTiming& t) { t.refresh_hz = hz; }) == "refresh_hz");
  }
  CHECK(member([](DisplayTiming& t) { t.scan_duration = 0ns; }) == "scan_duration");
  CHECK(member([](DisplayTiming& t) { t.scan_duration = -1ms; }) == "scan_duration");
  CHECK(member([](DisplayTiming& t) { t.scan_duration = 12ms; }) == "scan_duration");
  CHECK(member([](DisplayTiming& t) { t.scan_duration = 11200us; }).empty());  // 1 % of rounding is forgiven
  CHECK(member([](DisplayTiming& t) { t.persistence = -1ns; }) == "persistence");
  CHECK(member([](DisplayTiming& t) { t.persistence = 20ms; }) == "persistence");
  CHECK(member([](DisplayTiming& t) { t.internal_delay = 2s; }) == "internal_delay");
}

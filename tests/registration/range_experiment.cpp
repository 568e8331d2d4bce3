// Tracking by ranges: closed-form flights, and the recording with four variants side by side.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/io/range_files.hpp>
#include <holdfast/registration/range_experiment.hpp>

using namespace holdfast;

namespace {

constexpr RangeVariant neither{false, false}, gate_only{false, true}, bias_only{true, false}, both{true, true};

constexpr double take_off_s = 5.0;

/// A flight in closed form: at rest until take-off; then each coordinate is a (1 - cos w t)^2, and so is the heading.
struct Flight {
  struct Wave {
    double a, w;
    [[nodiscard]] double x(double t) const { return a * std::pow(1.0 - std::cos(phase(t)), 2); }
    [[nodiscard]] double v(double t) const { return 2.0 * a * w * (1.0 - std::cos(phase(t))) * std::sin(phase(t)); }
    [[nodiscard]] double acceleration(double t) const {
      const double c = std::cos(phase(t)), s = std::sin(phase(t));
      return 2.0 * a * w * w * (s * s + (1.0 - c) * c);
    }

   private:
    [[nodiscard]] double phase(double t) const { return w * std::max(0.0, t - take_off_s); }
  };
  Wave x{0.6, 0.9}, y{0.5, 0.6}, z{0.3, 0.7}, heading{0.2, 0.5};

  [[nodiscard]] Rigid X_WB(double t) const {
    return Rigid(so3::exp<double>(Vector3(0.0, 0.0, heading.x(t))), Vector3(x.x(t) - 1.0, y.x(t) - 0.8, 0.5 + z.x(t)));
  }
  [[nodiscard]] InertialReading inertial(double t) const {
    const Vector3 force_W(x.acceleration(t), y.acceleration(t), z.acceleration(t) + standard_gravity);
    return {time_at(t), Vector3(0.0, 0.0, heading.v(t)), Vector3(X_WB(t).R().transpose() * force_W)};
  }
};

const Vector3 antenna_B(0.05, -0.02, 0.1);

RangeSettings settings() {
  RangeSettings s;
  s.antenna_B = antenna_B;
  return s;
}

/// What is wrong with the ranges.
struct RangeFaults {
  double sigma_m = 0.0;
  double bias_m = 0.0;    ///< of anchor k: this times 1 + k / 8
  double late_share = 0;  ///< of ranges that come 0.5 m to 2.5 m late
};

/// Twenty seconds in a room of 8 x 8 x 3 m with an anchor in each corner: 200 inertial samples and 80 ranges a second.
RangeRecording flown(const RangeFaults& faults) {
  const Flight flight;
  RangeRecording recording;
  for (int k = 0; k < 8; ++k) {
    recording.anchors.push_back({10 + k, Vector3(k & 1 ? 4.0 : -4.0, k & 2 ? 4.1 : -3.9, k & 4 ? 3.0 : 0.1)});
  }
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i <= 4000; ++i) {
    const double t = 0.005 * i;
    recording.truth.push_back({time_at(t), flight.X_WB(t)});
    recording.inertial.push_back(flight.inertial(t));
  }
  for (int i = 0; i < 1600; ++i) {
    RangeReading reading;
    reading.t = time_at(0.0025 + 0.0125 * i);
    reading.anchor = static_cast<std::size_t>(3 * i) % 8;
    const Vector3 antenna_W = flight.X_WB(0.0025 + 0.0125 * i) * antenna_B;
    reading.range_m = (antenna_W - recording.anchors[reading.anchor].p_W).norm() + faults.sigma_m * normal(random) +
                      faults.bias_m * (1.0 + static_cast<double>(reading.anchor) / 8.0);
    if (uniform(random) < faults.late_share) reading.range_m += 0.5 + 2.0 * uniform(random);
    recording.ranges.push_back(reading);
  }
  return recording;
}

RangeRecording turned(const RangeRecording& recording, const Rigid& X_VW) {
  RangeRecording other = recording;
  for (RangeAnchor& anchor : other.anchors) anchor.p_W = X_VW * anchor.p_W;
  for (TimedPose& pose : other.truth) pose.X_WB = X_VW * pose.X_WB;
  return other;
}

double rms(const RangeRecording& recording, const RangeVariant& variant, const RangeSettings& s = settings()) {
  return track_ranges(recording, variant, s).position.rms();
}

const Rigid another_world(so3::exp<double>(Vector3(0.9, -1.3, 0.6)), Vector3(20.0, -7.0, 3.0));

std::optional<RangeRecording> uwb_recording() {
  const std::filesystem::path folder = std::filesystem::path(HOLDFAST_RECORDINGS) / "range";
  if (!std::filesystem::exists(folder)) {
    MESSAGE("skipped: no recording of ranges");
    return std::nullopt;
  }
  return io::read_range_recording({folder / "0607_twr_obs1_range.csv", folder / "anchor_0607_positions.csv",
                                   folder / "0607_twr_obs1_imu.csv", folder / "0607_twr_obs1_pose.csv"});
}

RangeSettings uwb_settings() {
  RangeSettings s;
  s.antenna_B = Vector3(-0.01245, 0.00127, 0.0908);
  return s;
}

}  // namespace

TEST_CASE("exact ranges: every variant follows the flight") {
  const RangeRecording recording = flown({});
  for (const RangeVariant& variant : range_variants) {
    const RangeRow row = track_ranges(recording, variant, settings());
    CHECK(row.ranges == 1600);
    CHECK(row.accepted == 1600);
    CHECK(row.gated == 0);
    CHECK(row.refused == 0);
    // Exact readings, and a model that takes what it does not know for white jerk: a lag of millimetres is left.
    CHECK(row.position.rms() < 0.01);
    CHECK(row.biases_m.size() == (variant.bias_states ? 8u : 0u));
    for (const double bias : row.biases_m) CHECK(std::abs(bias) < 0.02);
  }
}

TEST_CASE("the antenna's place counts") {
  const RangeRecording recording = flown({});
  RangeSettings at_origin = settings();
  at_origin.antenna_B.setZero();
  // The lever arm stands 0.1 m up in a body that stays level: unknown, it is the error of the height.
  CHECK(track_ranges(recording, neither, at_origin).height.rms() == doctest::Approx(0.1).epsilon(0.1));
}

TEST_CASE("biased ranges: states for biases take the error away, and find them") {
  const RangeRecording recording = flown({.sigma_m = 0.05, .bias_m = -0.3});
  const RangeRow known = track_ranges(recording, bias_only, settings());
  CHECK(known.position.rms() < 0.05);  // half of what one range errs by
  CHECK(rms(recording, neither) > 3.0 * known.position.rms());
  CHECK(rms(recording, both) < 0.05);
  for (std::size_t k = 0; k < 8; ++k) {
    const double bias_m = -0.3 * (1.0 + static_cast<double>(k) / 8.0);
    CHECK(known.biases_m[k] == doctest::Approx(bias_m).epsilon(0.2));  // 200 ranges with a moving body: 5 cm
  }
}

TEST_CASE("late ranges: the gate takes the error away") {
  const RangeRecording recording = flown({.sigma_m = 0.05, .late_share = 0.1});
  const RangeRow row = track_ranges(recording, both, settings());
  CHECK(row.position.rms() < 0.05);
  CHECK(row.gated >= 150);  // of about 160 late ones, all at least 4 standard deviations off
  CHECK(row.gated <
        500);  // a rejected anchor's next range is on probation, and a late one may come while biases are learnt
  CHECK(row.accepted + row.gated == row.ranges);
  CHECK(rms(recording, gate_only) < 0.05);
  CHECK(rms(recording, neither) > 2.0 * row.position.rms());
  CHECK(rms(recording, bias_only) > 2.0 * row.position.rms());
}

TEST_CASE("errors are the same in a world that is turned and shifted") {
  const RangeRecording recording = flown({.sigma_m = 0.05, .bias_m = -0.3, .late_share = 0.05});
  RangeSettings there = settings();
  there.up_W = another_world.R() * Vector3::UnitZ();
  for (const RangeVariant& variant : range_variants) {
    const RangeRow a = track_ranges(recording, variant, settings());
    const RangeRow b = track_ranges(turned(recording, another_world), variant, there);
    // Rounding of coordinates of 20 m, 1600 times.
    CHECK(b.position.rms() == doctest::Approx(a.position.rms()).epsilon(1e-7));
    CHECK(b.height.rms() == doctest::Approx(a.height.rms()).epsilon(1e-7));
    CHECK(b.angle.rms() == doctest::Approx(a.angle.rms()).epsilon(1e-7));
    CHECK(b.accepted == a.accepted);
  }
}

TEST_CASE("truth that covers a part judges that part; gaps and useless readings are survived and counted") {
  RangeRecording recording = flown({.sigma_m = 0.05});
  std::erase_if(recording.truth, [](const TimedPose& p) { return p.t < time_at(2.0) || p.t > time_at(18.0); });
  std::erase_if(recording.ranges, [](const RangeReading& r) { return r.t > time_at(8.0) && r.t < time_at(11.0); });
  std::erase_if(recording.inertial, [](const InertialReading& r) { return r.t > time_at(8.0) && r.t < time_at(8.2); });
  recording.inertial[1000].rate_B.x() = std::nan("");
  recording.ranges[300].range_m = -1.0;
  const RangeRow row = track_ranges(recording, both, settings());
  CHECK(row.ranges == 1040);  // 13 s of 80 a second
  CHECK(row.refused == 2);
  RmsAndPeak late;
  (void)track_ranges(recording, both, settings(), [&](const RangeMoment& m) {
    if (m.reading.t > time_at(14.0)) late.add((m.tracker.state().X_WB.p() - m.X_WB.p()).norm());
  });
  CHECK(late.count() == 320);
  CHECK(late.rms() < 0.1);  // as without the gap

  recording.truth.resize(1);
  CHECK(track_ranges(recording, both, settings()).ranges == 0);
  recording.ranges.clear();
  CHECK(track_ranges(recording, both, settings()).position.rms() == 0.0);
}

TEST_CASE("the UWB recording, range by range") {
  const std::optional<RangeRecording> recording = uwb_recording();
  if (!recording) return;
  std::map<std::string_view, RangeRow> rows;
  for (const RangeVariant& variant : range_variants) {
    const RangeRow& row = rows[name_of(variant)] = track_ranges(*recording, variant, uwb_settings());
    MESSAGE(name_of(variant), " ", row.position.rms(), " m, horizontal ", row.horizontal.rms(), ", height ",
            row.height.rms(), ", peak ", row.position.peak(), ", gated ", row.gated, " of ", row.ranges);
    CHECK(row.ranges == 5509);
    CHECK(row.refused == 0);
  }
  // Issue 4, "Must hold": at most 0.15 m with both (aim 0.11), at most 0.65 of any other.
  const double with_both = rows["bias_and_gate"].position.rms();
  CHECK(with_both < 0.11);
  for (const char* other : {"neither", "gate", "bias"}) CHECK(with_both < 0.65 * rows[other].position.rms());
  // README of the recordings: biases are about -0.20 to -0.34 m.
  for (const double bias : rows["bias_and_gate"].biases_m) {
    CHECK(bias < -0.15);
    CHECK(bias > -0.40);
  }

  RangeSettings there = uwb_settings();
  there.up_W = another_world.R() * Vector3::UnitZ();
  CHECK(rms(turned(*recording, another_world), both, there) == doctest::Approx(with_both).epsilon(1e-6));
}

TEST_CASE("on the UWB recording no setting stands on a knife's edge: half or twice those that matter still holds") {
  const std::optional<RangeRecording> recording = uwb_recording();
  if (!recording) return;
  using Change = std::function<void(RangeSettings&, double)>;
  const std::map<std::string, Change> changes{
      {"force sigma", [](RangeSettings& s, double f) { s.force_sigma *= f; }},
      {"accelerometer's bias", [](RangeSettings& s, double f) { s.force_bias_sigma *= f; }},
      {"bias sigma", [](RangeSettings& s, double f) { s.bias_sigma_m *= f; }},
      {"bias wander", [](RangeSettings& s, double f) { s.bias_wander_m2 *= f; }},
      {"start", [](RangeSettings& s, double f) { s.start_m *= f; }}};
  for (const auto& setting : changes) {
    for (const double factor : {0.5, 2.0}) {
      RangeSettings s = uwb_settings();
      setting.second(s, factor);
      const double error = rms(*recording, both, s);
      MESSAGE(setting.first, " times ", factor, ": ", error, " m");
      CHECK(error < 0.13);
    }
  }
}

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/calibration/inertial_calibration.hpp>
#include <holdfast/io/inertial_files.hpp>
#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/registration/inertial_recording.hpp>
#include <holdfast/simulation/inertial_faults.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/tracking/inertial_filter.hpp>

using namespace holdfast;

namespace {

constexpr double degree_per_rad = 180.0 / std::numbers::pi;
constexpr std::array methods{CalibrationMethod::differentiating, CalibrationMethod::integrating};

/// A unit that is tilted by 1.4 rad, off the body's origin, late by 37.3 ms, with biases and scales; no noise.
InertialUnit tilted_unit() {
  InertialUnit unit;
  unit.X_BS = Rigid(so3::exp<double>(Vector3(0.4, -1.1, 0.7)), Vector3(0.03, 0.05, -0.08));
  unit.gyro.bias = Vector3(0.01, -0.02, 0.015);
  unit.gyro.scale = Vector3(1.02, 0.98, 1.01);
  unit.accelerometer.bias = Vector3(0.2, -0.3, 0.1);
  unit.accelerometer.scale = Vector3(1.01, 0.99, 1.02);
  unit.lag = from_milliseconds(37.3);
  return unit;
}

/// The same with the white noise of the head recording's unit: 0.005 rad/s and 0.01 m/s^2 a reading at 500 Hz.
InertialUnit noisy_unit() {
  InertialUnit unit = tilted_unit();
  unit.gyro.noise_density = recorded_head_unit().gyro.noise_density;
  unit.accelerometer.noise_density = recorded_head_unit().accelerometer.noise_density;
  return unit;
}

std::vector<TimedPose> with_noise(std::vector<TimedPose> poses, double position_m, double turn_rad,
                                  std::uint64_t seed) {
  std::uint64_t number = 0;
  for (TimedPose& pose : poses) {
    KeyedNumbers numbers(seed, {static_cast<std::int64_t>(number++)});
    std::array<double, 6> normal{};
    for (std::size_t k = 0; k < 6; k += 2) {
      const Vector2 pair = numbers.normal_pair();
      normal[k] = pair[0], normal[k + 1] = pair[1];
    }
    const Vector3 turn(turn_rad * normal[0], turn_rad * normal[1], turn_rad * normal[2]);
    const Vector3 move(position_m * normal[3], position_m * normal[4], position_m * normal[5]);
    pose.X_WB = Rigid(pose.X_WB.q() * so3::exp<double>(turn), pose.X_WB.p() + move);
  }
  return poses;
}

std::vector<TimedPose> poses_of(const char* motion, std::uint64_t seed = 1) {
  return sample(*make_motion(motion, seed), from_milliseconds(8));
}

InertialCalibration calibrate(const std::vector<TimedPose>& poses, const std::vector<InertialReading>& readings,
                              CalibrationMethod method = CalibrationMethod::integrating) {
  InertialCalibrationSettings settings;
  settings.method = method;
  return calibrate_inertial(poses, readings, settings);
}

double degrees_off(const InertialCalibration& found, const InertialUnit& unit) {
  return degree_per_rad * so3::angle_between<double>(found.gyro.q_BS, unit.X_BS.q());
}
double offset_error_ms(const InertialCalibration& found, const InertialUnit& unit) {
  return std::abs(1e3 * found.gyro.time_offset_s - to_milliseconds(unit.lag));
}

bool says(const InertialCalibration& found, const std::string& words) {
  const auto has = [&](const std::string& line) { return line.find(words) != std::string::npos; };
  return has(found.problem) || has(found.accelerometer_problem) || std::ranges::any_of(found.notes, has);
}

/// J against central differences, at a few comparisons.
void check_jacobian(FitModel& model, const Eigen::VectorXd& x, double tolerance) {
  const auto size = static_cast<Eigen::Index>(model.parameters().size());
  for (std::size_t i = 0; i < model.windows().size(); i += model.windows().size() / 5) {
    Vector3 r, above, below;
    FitModel::Jacobian J(3, size), unused(3, size);
    model.prepare(x);
    model.compare(i, r, J);
    for (Eigen::Index j = 0; j < size; ++j) {
      const double h = 1e-5;
      Eigen::VectorXd moved = x;
      moved[j] = x[j] + h;
      model.prepare(moved);
      model.compare(i, above, unused);
      moved[j] = x[j] - h;
      model.prepare(moved);
      model.compare(i, below, unused);
      const Vector3 expected = (above - below) / (2.0 * h);
      CAPTURE(model.parameters()[static_cast<std::size_t>(j)].name);
      CHECK((J.col(j) - expected).norm() < tolerance * (1.0 + expected.norm()));
    }
  }
}

std::filesystem::path broad() {
  return std::filesystem::path(HOLDFAST_RECORDINGS) / "imu/broad_07_fast_rotation.csv";
}

}  // namespace

TEST_CASE("without noise both methods find all of the gyros' parameters, from far away") {
  const InertialUnit unit = tilted_unit();
  const std::vector<TimedPose> poses = poses_of("M6");
  const std::vector<InertialReading> readings = inertial_stream(*make_motion("M6"), unit);
  for (const CalibrationMethod method : methods) {
    CAPTURE(name_of(method));
    const InertialCalibration found = calibrate(poses, readings, method);
    REQUIRE(found.problem == "");
    // Integrating: what a cubic between readings 2 ms apart misses. Differentiating: what the sum of turns misses of their axis'
    // turning, w x w' interval^2 / 12, about 1e-5 rad/s.
    const double tolerance = method == CalibrationMethod::integrating ? 1e-6 : 3e-5;
    CHECK(so3::angle_between<double>(found.gyro.q_BS, unit.X_BS.q()) < tolerance);
    CHECK((found.gyro.bias - unit.gyro.bias).norm() < tolerance);
    CHECK((found.gyro.scale - unit.gyro.scale).norm() < tolerance);
    CHECK(std::abs(found.gyro.time_offset_s - 0.0373) < 1e-6);
    CHECK(found.gyro_fit.unobserved.empty());
    CHECK(found.notes.empty());
  }
}

TEST_CASE("without noise the accelerometers' parameters are found: a triad's, and the places of separate ones") {
  InertialUnit unit = tilted_unit();
  for (const bool separate : {false, true}) {
    CAPTURE(separate);
    if (separate) unit.accelerometers_S = {Vector3(0.0, 0.05, 0.0), Vector3(0.0, 0.0, 0.05), Vector3(0.05, 0.0, 0.0)};
    InertialCalibrationSettings settings;
    settings.accelerometer.separate = separate;
    const InertialCalibration found =
        calibrate_inertial(poses_of("M6"), inertial_stream(*make_motion("M6"), unit), settings);
    REQUIRE(found.accelerometer_problem == "");
    const AccelerometerParameters& sensors = found.accelerometer;
    // The midpoint rule over 2 ms; separate ones need w', which is a derivative of readings. Gravity pulls by its prior.
    const double tolerance = separate ? 1e-3 : 1e-4;
    CHECK(so3::angle_between<double>(sensors.q_BA, unit.X_BS.q()) < tolerance);
    CHECK((sensors.bias - unit.accelerometer.bias).norm() < tolerance);
    CHECK((sensors.scale - unit.accelerometer.scale).norm() < tolerance);
    CHECK((sensors.gravity_W - unit.gravity_W).norm() < 2.0 * tolerance);
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK((sensors.places_B[i] - unit.X_BS * unit.accelerometers_S[i]).norm() < tolerance);
    }
  }
}

TEST_CASE("the models' Jacobians are their derivatives") {
  const InertialUnit unit = tilted_unit();
  const std::vector<TimedPose> poses = poses_of("M6");
  const CheckedRecording checked = check_recording(poses, inertial_stream(*make_motion("M6"), unit));
  const std::vector<char> all(checked.readings.size(), 1);
  const SensorSignal gyro = *signal_of(checked, &InertialReading::rate_B, checked.gyro, all);
  const SensorSignal force = *signal_of(checked, &InertialReading::force_B, checked.accelerometer, all);
  const PoseArrays arrays(checked.poses, checked.poses.front().t);
  GyroStart start;
  start.gyro = {unit.X_BS.q(), unit.gyro.bias, unit.gyro.scale, to_seconds(unit.lag)};
  start.turning_axes_S.setIdentity();
  const Eigen::VectorXd x = detail::to_vector(start.gyro, Quaternion::Identity());
  // J takes the gyros' turning for the poses' (they are equal at the truth), and integrals of R by the midpoint rule.
  DifferentiatingModel differentiating(arrays, gyro, GyroPrior(), {true, true, true}, 0.05, start);
  check_jacobian(differentiating, x, 2e-4);
  IntegratingModel integrating(arrays, gyro, GyroPrior(), 0.1, start);
  check_jacobian(integrating, x, 2e-4);
  for (const bool separate : {false, true}) {
    AccelerometerPrior prior;
    prior.separate = separate;
    AccelerometerModel model(arrays, gyro, force, start.gyro, start.turning_axes_S, prior, unit.X_BS.q(),
                             unit.gravity_W, 0.1);
    Eigen::VectorXd at = model.to_vector({unit.X_BS.q(),
                                          unit.accelerometer.bias,
                                          unit.accelerometer.scale,
                                          {unit.X_BS.p(), unit.X_BS.p(), unit.X_BS.p()},
                                          unit.gravity_W});
    at[10] = 0.3, at[11] = -0.2;  // gravity tilted
    check_jacobian(model, at, 1e-7);
  }
}

TEST_CASE("a turned world turns gravity and nothing else; readings that come early have a negative offset") {
  InertialUnit unit = noisy_unit();
  unit.lag = from_milliseconds(-20.0);
  const std::vector<TimedPose> poses = with_noise(poses_of("M4"), 3e-4, 5e-4, 1);
  const std::vector<InertialReading> readings = inertial_stream(*make_motion("M4"), unit);
  const Rigid X_VW(so3::exp<double>(Vector3(1.0, -0.5, 2.0)), Vector3(3.0, 1.0, -2.0));
  std::vector<TimedPose> turned = poses;
  for (TimedPose& pose : turned) pose.X_WB = X_VW * pose.X_WB;
  const InertialCalibration found = calibrate(poses, readings), in_V = calibrate(turned, readings);
  CHECK(offset_error_ms(found, unit) < 1.0);
  CHECK(found.gyro.time_offset_s < 0.0);
  // Rounding, and the search's end within 1e-4 of a deviation.
  CHECK((in_V.gyro_fit.x - found.gyro_fit.x).norm() < 1e-6);
  CHECK(so3::angle_between<double>(in_V.accelerometer.q_BA, found.accelerometer.q_BA) < 1e-4);
  CHECK((in_V.accelerometer.gravity_W - X_VW.q() * found.accelerometer.gravity_W).norm() < 2e-3);
}

TEST_CASE(
    "with stated noise orientation is within 0.5 deg and time within 1 ms, and errors are as the covariance says") {
  const InertialUnit unit = noisy_unit();
  for (const CalibrationMethod method : methods) {
    CAPTURE(name_of(method));
    double nees = 0.0, runs = 0.0;
    for (const char* motion : {"M4", "M5", "M6"}) {
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const std::vector<InertialReading> readings = inertial_stream(*make_motion(motion, seed), unit, seed);
        const InertialCalibration found =
            calibrate(with_noise(poses_of(motion, seed), 5e-4, 1e-3, seed), readings, method);
        REQUIRE(found.problem == "");
        CHECK(degrees_off(found, unit) < 0.5);
        CHECK(offset_error_ms(found, unit) < 1.0);
        Eigen::VectorXd error(10);
        error << so3::log<double>(unit.X_BS.q().conjugate() * found.gyro.q_BS), found.gyro.bias - unit.gyro.bias,
            found.gyro.scale - unit.gyro.scale, found.gyro.time_offset_s - to_seconds(unit.lag);
        nees += error.dot(found.gyro_fit.covariance.llt().solve(error));
        runs += 1.0;
      }
    }
    // 120 degrees of freedom: chi^2 / 12 is 10 +- 1.3; deviations are enlarged a little by `excess`, which errs upwards.
    CHECK(nees / runs > 3.0);
    CHECK(nees / runs < 14.0);
  }
}

TEST_CASE("the head recording with simulated sensors: orientation within 0.5 deg, time within 1 ms") {
  const std::filesystem::path file = std::filesystem::path(HOLDFAST_RECORDINGS) / "head/optitrack_head_120hz.tum";
  if (!std::filesystem::exists(file)) {
    MESSAGE("skipped: no recording ", file.string());
    return;
  }
  std::vector<TimedPose> poses = io::read_trajectory(file).samples;
  poses.resize(std::min<std::size_t>(poses.size(), 4000));
  InertialUnit unit = recorded_head_unit();
  unit.X_BS = tilted_unit().X_BS;
  unit.lag = from_milliseconds(-8.6);
  const std::vector<InertialReading> readings = simulate_inertial(poses, unit);
  for (const CalibrationMethod method : methods) {
    CAPTURE(name_of(method));
    const InertialCalibration found = calibrate(with_noise(poses, 5e-4, 1e-3, 1), readings, method);
    REQUIRE(found.problem == "");
    CHECK(degrees_off(found, unit) < 0.5);
    CHECK(offset_error_ms(found, unit) < 1.0);
  }
}

TEST_CASE(
    "BROAD: both methods and the filter on line find the same time offset, and axes within 0.5 deg of the body's") {
  if (!std::filesystem::exists(broad())) {
    MESSAGE("skipped: no recording ", broad().string());
    return;
  }
  // From 30 s on, the first ten seconds of motion or so are enough.
  const auto later = [](auto all, HostTime from, HostTime to) {
    std::erase_if(all, [&](const auto& one) { return one.t < from || one.t > to; });
    return all;
  };
  const std::vector<InertialReading> readings = later(io::read_inertial(broad()), time_at(40.0), time_at(70.0));
  const std::vector<TimedPose> poses = later(io::read_trajectory(broad()).samples, time_at(40.0), time_at(70.0));
  InertialFilter filter;
  std::size_t next = 0;
  for (const TimedPose& pose : poses) {
    while (next < readings.size() && readings[next].t <= pose.t) (void)filter.update(readings[next++]);
    (void)filter.update(pose);
  }
  for (const CalibrationMethod method : methods) {
    CAPTURE(name_of(method));
    const InertialCalibration found = calibrate(poses, readings, method);
    REQUIRE(found.problem == "");
    CHECK(found.gyro.time_offset_s == doctest::Approx(0.004).epsilon(0.25));
    CHECK(std::abs(found.gyro.time_offset_s - filter.state().time_offset_s) < 1e-3);
    CHECK(degree_per_rad * so3::log<double>(found.gyro.q_BS).norm() < 0.5);
  }
}

TEST_CASE("calibrated readings suit the filter on line, which takes sensors for ones along the body's axes") {
  const InertialUnit unit = noisy_unit();
  const std::vector<TimedPose> poses = with_noise(poses_of("M6"), 3e-4, 5e-4, 1);
  const std::vector<InertialReading> readings = inertial_stream(*make_motion("M6"), unit);
  const InertialCalibration found = calibrate(poses, readings);
  InertialFilter filter;
  std::size_t next = 0;
  int rejected = 0;
  for (const TimedPose& pose : poses) {
    const auto fed = [&](const InertialReading& raw) { return calibrated(raw, found.gyro, found.accelerometer); };
    while (next < readings.size() && fed(readings[next]).t <= pose.t) (void)filter.update(fed(readings[next++]));
    rejected += filter.update(pose) == InertialPoseUpdate::rejected ? 1 : 0;
  }
  CHECK(rejected == 0);
  CHECK(std::abs(filter.state().time_offset_s) < 1e-3);  // it finds nothing left
  CHECK(filter.state().bias.rate_B.norm() < 2e-3);
  CHECK((filter.state().lever_B - unit.X_BS.p()).norm() < 0.01);
}

TEST_CASE("what a motion does not tell is named and stays nominal") {
  const InertialUnit unit = noisy_unit();
  SUBCASE("a still head") {
    for (const CalibrationMethod method : methods) {
      const InertialCalibration found =
          calibrate(with_noise(poses_of("M0"), 3e-4, 5e-4, 1), inertial_stream(*make_motion("M0"), unit), method);
      REQUIRE(found.problem == "");
      CHECK(says(found, "next to no rotation"));
      CHECK(found.gyro_fit.unobserved.size() == 7);  // all but the biases
      CHECK(found.gyro.time_offset_s == 0.0);
      CHECK(found.gyro_fit.deviation(9) == doctest::Approx(GyroPrior().time_offset_s));
      CHECK(so3::log<double>(found.gyro.q_BS).norm() < 1e-9);
      CHECK(found.gyro_fit.deviation(0) == doctest::Approx(1.0));
      CHECK((found.gyro.bias - unit.gyro.bias).norm() < 1e-3);
      CHECK(says(found, "without rotation gravity cannot be told"));
    }
  }
  SUBCASE("yaw alone: the turn about it") {
    const InertialCalibration found =
        calibrate(with_noise(poses_of("M2"), 3e-4, 5e-4, 1), inertial_stream(*make_motion("M2"), unit));
    REQUIRE(found.problem == "");
    CHECK(says(found, "rotation about one axis alone"));
    CHECK(found.gyro_fit.unobserved.size() == 3);  // the turn about it, and two of the scales
    // The axis itself is found: where it lies in S.
    const Vector3 expected = unit.X_BS.q().conjugate() * Vector3(Vector3::UnitY());
    const Vector3 said = found.gyro.q_BS.conjugate() * Vector3(Vector3::UnitY());
    CHECK(degree_per_rad * std::acos(std::min(1.0, expected.dot(said))) < 2.0);  // scales of 2 % bend it by 1 deg
    CHECK(offset_error_ms(found, unit) < 1.0);
  }
}

TEST_CASE("bad input is named") {
  const std::vector<TimedPose> poses = poses_of("M6");
  const InertialUnit unit = noisy_unit();
  std::vector<InertialReading> readings = inertial_stream(*make_motion("M6"), unit);
  const TimeSpan always{HostTime::min(), HostTime::max()};
  SUBCASE("nothing, too little, other times") {
    CHECK(says(calibrate({}, readings), "too few poses"));
    CHECK(says(calibrate(poses, {}), "too few readings"));
    CHECK(says(calibrate({poses.begin(), poses.begin() + 30}, readings), "too short"));
    for (InertialReading& reading : readings) reading.t += std::chrono::seconds(60);
    CHECK(says(calibrate(poses, readings), "times do not overlap"));
  }
  SUBCASE("another motion") {
    const std::vector<InertialReading> other = inertial_stream(*make_motion("M5", 3), unit);
    CHECK(says(calibrate(poses, other), "turning is not the poses'"));
  }
  SUBCASE("a dead gyro: differentiating does without") {
    make_dead(readings, always, std::array{1});
    const InertialCalibration refused = calibrate(poses, readings);
    CHECK(says(refused, "gyro y is dead"));
    CHECK(says(refused, "integrating needs all three gyros"));
    const InertialCalibration found = calibrate(poses, readings, CalibrationMethod::differentiating);
    REQUIRE(found.problem == "");
    CHECK(degrees_off(found, unit) < 0.5);
    CHECK(offset_error_ms(found, unit) < 1.0);
    CHECK(found.gyro_fit.unobserved.size() == 2);  // its bias and its scale
  }
  SUBCASE("a missing accelerometer, a stuck one") {
    lose(readings, always, std::array{5});
    CHECK(says(calibrate(poses, readings), "accelerometer z is missing"));
    make_stuck(readings, always, std::array{3});
    CHECK(says(calibrate(poses, readings), "accelerometer x is stuck"));
    CHECK(calibrate(poses, readings).problem == "");
  }
  SUBCASE("numbers missing, stuck and saturated for some time; not finite poses") {
    lose(readings, {time_at(2.0), time_at(2.5)}, std::array{0});
    make_stuck(readings, {time_at(4.0), time_at(5.0)}, std::array{1});
    saturate(readings, always, std::array{2}, 0.8 * std::abs(readings[1000].rate_B[2]) + 0.2);
    std::vector<TimedPose> gappy = poses;
    gappy[100].X_WB = Rigid(Quaternion::Identity(), Vector3(std::nan(""), 0.0, 0.0));
    const InertialCalibration found = calibrate(gappy, readings);
    CHECK(says(found, "gyro x is not a number in"));
    CHECK(says(found, "gyro y is stuck in"));
    CHECK(says(found, "gyro z is saturated"));
    CHECK(says(found, "1 poses are not finite"));
    REQUIRE(found.problem == "");
    CHECK(degrees_off(found, unit) < 0.5);
    CHECK(offset_error_ms(found, unit) < 1.0);
  }
  SUBCASE("a clock that jumps, either way") {
    for (const double ms : {60.0, -60.0}) {
      CAPTURE(ms);
      std::vector<InertialReading> jumped = readings;
      jump_clock(jumped, time_at(7.0), from_milliseconds(ms));
      const InertialCalibration found = calibrate(poses, jumped);
      CHECK(says(found, "the clocks jump"));
      CHECK(says(found, "readings' time goes back") == (ms < 0.0));
    }
  }
  SUBCASE("gyros in degrees") {
    for (InertialReading& reading : readings) reading.rate_B *= degree_per_rad;
    CHECK(says(calibrate(poses, readings), "times as much as the poses: another unit than rad/s?"));
  }
}

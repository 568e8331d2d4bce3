/// What gyros and accelerometers on a moving body would say, with the errors of real ones.
///
/// A unit has frame S, three gyros and three accelerometers (000 section 3.1.2). The sensor i of a kind feels what acts along
/// its sensitive axis u_i, and says
///   z_i = round(clamp(k_i (u_i . x_i) + b_i(t) + noise))
/// with the scale k_i, the bias b_i, which is a random walk, white noise, saturation and quantisation. x_i is in S
///   of a gyro           w_WB
///   of an accelerometer f = R_WB^T (a_WB - g) + alpha x l_i + w x (w x l_i),   l_i its place on the body:
/// a body at rest feels its support push up. All accelerometers at one place are a modern triad; 001's sat apart.
/// Motion: the body's (motion.hpp), whose a_WB, w_WB_B and alpha_WB_B must be its true derivatives: generators and splines
/// have them, bare samples do not.
/// Random numbers belong to (seed, number of the reading): the noise stays when other parameters change.
/// Units: rad/s and m/s^2. Preconditions: interval above zero, axes finite, deviations not negative (assert).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/angle.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/simulation/keyed_numbers.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

/// Three sensors of one kind; x stands for rad/s or m/s^2.
struct InertialTriad {
  Matrix3 axes = Matrix3::Identity();  ///< row i: u_i in S, of unit length; rows that are not square are misaligned
  Vector3 scale = Vector3::Ones();     ///< k
  Vector3 bias = Vector3::Zero();      ///< b at the first reading, x
  double bias_walk = 0.0;              ///< the bias gains this deviation in a second, x / sqrt(s)
  double noise_density = 0.0;          ///< x / sqrt(Hz); a reading's deviation is this times sqrt(readings a second)
  double range = std::numeric_limits<double>::infinity();  ///< more than +- this is said as this, x
  double resolution = 0.0;                                 ///< step of what is said, x; 0: none
};

struct InertialUnit {
  Rigid X_BS;  ///< where the unit sits on the body
  InertialTriad gyro, accelerometer;
  std::array<Vector3, 3> accelerometers_S{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};  ///< their places, m
  Vector3 gravity_W = -standard_gravity * Vector3::UnitY();  ///< where things fall, m/s^2
  Duration interval = std::chrono::milliseconds(2);          ///< between readings
  Duration lag{0};                                           ///< a reading stamped t tells of t - lag
};

/// Like those in today's headsets, of a triad: 0.01 deg/s and 100 ug in 1 Hz, +-2000 deg/s and +-16 g in 16 bits; biases of
/// half a degree a second and 30 mg, which drift by 0.02 deg/s and 0.3 mg in a minute. 500 Hz.
[[nodiscard]] inline InertialUnit mems_inertial_unit() {
  const double degree = degrees(1.0).radians();
  InertialUnit unit;
  unit.gyro.bias = 0.5 * degree * Vector3(0.8, -1.2, 1.0);
  unit.gyro.bias_walk = 0.02 * degree / std::sqrt(60.0);
  unit.gyro.noise_density = 0.01 * degree;
  unit.gyro.range = 2000.0 * degree;
  unit.gyro.resolution = 2.0 * unit.gyro.range / 65536.0;
  unit.accelerometer.bias = 0.03 * standard_gravity * Vector3(-1.0, 0.7, 1.1);
  unit.accelerometer.bias_walk = 3e-4 * standard_gravity / std::sqrt(60.0);
  unit.accelerometer.noise_density = 1e-4 * standard_gravity;
  unit.accelerometer.range = 16.0 * standard_gravity;
  unit.accelerometer.resolution = 2.0 * unit.accelerometer.range / 65536.0;
  return unit;
}

/// 001 section 3: gyros of +-300 deg/s and single accelerometers of +-2 g, apart, behind a 12-bit converter. Where they sat is
/// not printed: here each lies 5 cm out along the axis after its own. Of noise nothing is said either: here the converter's
/// steps, and white noise of one step. `interval` is ours.
[[nodiscard]] inline InertialUnit azuma_bishop_inertial_unit(Duration interval = std::chrono::milliseconds(10)) {
  InertialUnit unit;
  unit.interval = interval;
  unit.gyro.range = degrees(300.0).radians();
  unit.accelerometer.range = 2.0 * standard_gravity;
  for (InertialTriad* triad : {&unit.gyro, &unit.accelerometer}) {
    triad->resolution = 2.0 * triad->range / 4096.0;
    triad->noise_density = triad->resolution * std::sqrt(to_seconds(interval));
  }
  unit.accelerometers_S = {Vector3(0.0, 0.05, 0.0), Vector3(0.0, 0.0, 0.05), Vector3(0.05, 0.0, 0.0)};
  return unit;
}

namespace detail {

/// Specific force at a place l_B of the body.
[[nodiscard]] inline Vector3 specific_force(const MotionState& body, const Vector3& gravity_W, const Vector3& l_B) {
  const Vector3& w = body.w_WB_B;
  const Vector3 turning = w.cross(l_B);
  return body.X_WB.q().conjugate() * (body.a_WB - gravity_W) + body.alpha_WB_B.cross(l_B) + w.cross(turning);
}

/// What one sensor makes of k u . x + b + noise.
[[nodiscard]] inline double converted(const InertialTriad& triad, double value) {
  const double limited = std::clamp(value, -triad.range, triad.range);
  return triad.resolution > 0.0 ? triad.resolution * std::round(limited / triad.resolution) : limited;
}

}  // namespace detail

/// Sensors of these scales, axes and places, without bias, noise, saturation and steps. Stamped with the body's time.
[[nodiscard]] inline InertialReading ideal_inertial_reading(const MotionState& body, const InertialUnit& unit) {
  const Quaternion q_SB = unit.X_BS.q().conjugate();
  InertialReading reading;
  reading.t = body.t;
  const Vector3 rate_S = q_SB * body.w_WB_B;
  const Vector3 felt = unit.gyro.axes * rate_S;
  reading.rate_B = unit.gyro.scale.cwiseProduct(felt);
  for (int i = 0; i < 3; ++i) {
    const Vector3 place_B = unit.X_BS * unit.accelerometers_S[static_cast<std::size_t>(i)];
    const Vector3 force_S = q_SB * detail::specific_force(body, unit.gravity_W, place_B);
    reading.force_B[i] = unit.accelerometer.scale[i] * unit.accelerometer.axes.row(i).dot(force_S);
  }
  return reading;
}

/// Reading after reading, from the motion's begin on; the first is stamped begin + lag. The motion is not owned.
class InertialSimulator {
 public:
  explicit InertialSimulator(const Motion& motion, const InertialUnit& unit, std::uint64_t seed = 1)
      : motion_(&motion), unit_(unit), seed_(seed) {
    HOLDFAST_ASSERT(unit.interval > Duration(0), "readings need an interval");
    for (const InertialTriad* triad : {&unit.gyro, &unit.accelerometer}) {
      HOLDFAST_ASSERT(triad->axes.allFinite() && triad->scale.allFinite() && triad->bias.allFinite(), "not finite");
      HOLDFAST_ASSERT(triad->bias_walk >= 0.0 && triad->noise_density >= 0.0, "a deviation is negative");
      HOLDFAST_ASSERT(triad->range > 0.0 && triad->resolution >= 0.0, "a sensor needs a range");
    }
  }

  /// Whether the next reading would tell of a time after the motion's end.
  [[nodiscard]] bool is_done() const { return next_time() > motion_->end(); }

  [[nodiscard]] InertialReading next() {
    KeyedNumbers numbers(seed_, {count_});
    const double seconds = to_seconds(unit_.interval);
    const std::array<Vector3, 4> normal = twelve_normal(numbers);
    const double walked = count_ == 0 ? 0.0 : std::sqrt(seconds);
    unit_.gyro.bias += unit_.gyro.bias_walk * walked * normal[2];
    unit_.accelerometer.bias += unit_.accelerometer.bias_walk * walked * normal[3];

    InertialReading reading = ideal_inertial_reading(motion_->at(next_time()), unit_);
    reading.t = next_time() + unit_.lag;
    const double per_reading = 1.0 / std::sqrt(seconds);
    add_errors(reading.rate_B, unit_.gyro, per_reading * normal[0]);
    add_errors(reading.force_B, unit_.accelerometer, per_reading * normal[1]);
    ++count_;
    return reading;
  }

  /// The unit with the biases of the reading last made.
  [[nodiscard]] const InertialUnit& unit() const { return unit_; }

 private:
  [[nodiscard]] HostTime next_time() const { return motion_->begin() + count_ * unit_.interval; }

  [[nodiscard]] static std::array<Vector3, 4> twelve_normal(KeyedNumbers& numbers) {
    std::array<Vector3, 4> normal;
    for (int k = 0; k < 6; ++k) {
      const Vector2 pair = numbers.normal_pair();
      for (int j = 0; j < 2; ++j) normal[static_cast<std::size_t>((2 * k + j) / 3)][(2 * k + j) % 3] = pair[j];
    }
    return normal;
  }

  static void add_errors(Vector3& said, const InertialTriad& triad, const Vector3& noise) {
    for (int i = 0; i < 3; ++i) {
      said[i] = detail::converted(triad, said[i] + triad.bias[i] + triad.noise_density * noise[i]);
    }
  }

  const Motion* motion_;
  InertialUnit unit_;
  std::uint64_t seed_;
  std::int64_t count_ = 0;
};

/// All readings along a motion.
[[nodiscard]] inline std::vector<InertialReading> inertial_stream(const Motion& motion, const InertialUnit& unit,
                                                                  std::uint64_t seed = 1) {
  InertialSimulator simulator(motion, unit, seed);
  std::vector<InertialReading> readings;
  readings.reserve(static_cast<std::size_t>(motion.duration() / unit.interval) + 1);
  while (!simulator.is_done()) readings.push_back(simulator.next());
  return readings;
}

}  // namespace holdfast

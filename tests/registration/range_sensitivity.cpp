// What errors of ultrasonic ranges do to a position: 003's table 1, figures 7 to 9.
#include <array>

#include <doctest/doctest.h>

#include <holdfast/registration/range_sensitivity.hpp>

using namespace holdfast;

namespace {

/// Enough for a mean within some 5 %.
SensitivitySettings quick() {
  SensitivitySettings settings;
  settings.angles = 2;
  settings.trials = 40;
  settings.places_across = 2;
  return settings;
}

constexpr std::array heights_m{0.0, 0.5, 1.0, 1.5, 2.0, 2.5};

}  // namespace

TEST_CASE("range sensitivity: table 1 puts a receiver 2 to 5 mm off at every height, and improved compensation 2 mm") {
  double improved = 0.0;
  for (const double height_m : heights_m) {
    const SensitivityRow row = range_sensitivity(table_1_errors(), height_m, quick());
    const SensitivityRow better = range_sensitivity(improved_compensation_errors(), height_m, quick());
    MESSAGE(height_m, " m: ", row.error_mm, " mm, improved ", better.error_mm, " mm, resolution ", row.resolution_mm,
            " mm, GDOP ", row.gdop);
    CHECK(row.error_mm >= 2.0);
    CHECK(row.error_mm <= 5.0);
    CHECK(row.lost == 0);
    improved += better.error_mm / heights_m.size();
    // Figure 8: 0.7 to 1.5 mm in most of the volume, 2.5 mm near the floor.
    CHECK(row.resolution_mm > 0.5);
    CHECK(row.resolution_mm < 2.5);
  }
  CHECK(improved <= 2.0);
}

TEST_CASE("range sensitivity: transducer angles do most, and the parts add by their squares or less than in full") {
  const SensitivityRow all = range_sensitivity(table_1_errors(), 1.5, quick());
  double sum = 0.0, squares = 0.0, angles = 0.0;
  for (const UltrasonicErrorSource& source : each_alone(table_1_errors())) {
    const double error = range_sensitivity(source.errors, 1.5, quick()).error_mm;
    CHECK(error < all.error_mm);
    sum += error;
    squares += error * error;
    angles = error;  // the last one
  }
  CHECK(2.0 * angles * angles > squares);
  CHECK(all.error_mm < sum);
  CHECK(all.error_mm > 0.8 * std::sqrt(squares));  // means of lengths, not their squares
}

TEST_CASE("range sensitivity: no errors, errors in proportion, and a warmer room in closed form") {
  CHECK(range_sensitivity({}, 1.0, quick()).error_mm < 1e-6);
  // Half the errors put it half as far off, up to what is not linear in millimetres.
  UltrasonicErrors errors = table_1_errors(), half = errors;
  for (double UltrasonicErrors::*value : {&UltrasonicErrors::beacon_horizontal_m, &UltrasonicErrors::beacon_vertical_m,
                                          &UltrasonicErrors::temperature_celsius, &UltrasonicErrors::beacon_delay_m,
                                          &UltrasonicErrors::receiver_delay_m, &UltrasonicErrors::angle_m_per_rad}) {
    half.*value *= 0.5;
  }
  CHECK(range_sensitivity(half, 1.0, quick()).error_mm ==
        doctest::Approx(0.5 * range_sensitivity(errors, 1.0, quick()).error_mm).epsilon(0.01));

  // Straight below four beacons at one angle, ranges that are longer by a share s put the receiver down by s r / cos(angle).
  SensitivitySettings below;
  below.rig.beacons = beacon_grid(2, 2, 1.0, 2.0, 4);
  below.rig.receivers = {{Vector3::Zero(), Vector3::UnitY()}};
  below.first_x_m = below.last_x_m = 0.0;
  below.places_across = below.angles = below.trials = 1;
  UltrasonicErrors warmer;
  warmer.temperature_celsius = 2.0;
  const double range_m = std::sqrt(4.0 + 0.5);
  const double share = speed_of_sound(20.0) / speed_of_sound(22.0) - 1.0;
  CHECK(range_sensitivity(warmer, 0.0, below).error_mm ==
        doctest::Approx(1000.0 * std::abs(share) * range_m * range_m / 2.0).epsilon(0.01));  // second order in s
}

TEST_CASE("range sensitivity: angle errors at both transducers are not the paper's; too few beacons are counted") {
  SensitivitySettings both = quick();
  both.angle_at_beacon = true;
  CHECK(range_sensitivity(table_1_errors(), 2.5, both).error_mm > 5.0);

  SensitivitySettings two = quick();
  two.rig.beacons.resize(2);
  const SensitivityRow lost = range_sensitivity(table_1_errors(), 1.0, two);
  CHECK(lost.positions == 0);
  CHECK(lost.lost == two.trials * two.angles * two.places_across * two.places_across * 3);
  CHECK(lost.error_mm == 0.0);
}

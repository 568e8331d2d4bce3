// Acquisition under a large ceiling whose codes repeat: it finds the pose, or says that it does not.
#include <doctest/doctest.h>

#include <holdfast/registration/acquisition_experiment.hpp>

using namespace holdfast;

TEST_CASE("acquisition experiment: table 1's errors, sixteen codes, right or silent") {
  AcquisitionTrials trials;
  trials.trials = 20;
  trials.codes = 16;
  const AcquisitionRow row = acquire_at_random(trials);
  MESSAGE("acquired ", row.acquired, " of ", row.trials, ", ambiguous ", row.ambiguous, ", false ", row.false_poses,
          ", ", row.position_mm, " mm, ", row.angle_deg, " deg, tuples ", row.tuples);
  CHECK(row.trials == 20);
  CHECK(row.false_poses == 0);
  CHECK(row.acquired >= 18);
  CHECK(row.position_mm < 10.0);  // table 1 costs 2 to 3.5 mm with 50 beacons; here there are 16
  CHECK(row.tuples >= 1.0);
}

TEST_CASE("acquisition experiment: eight codes under 289 beacons, the hard case: no pose is false") {
  for (const double wrong : {0.0, 0.15}) {
    CAPTURE(wrong);
    AcquisitionTrials trials;
    trials.wrong = wrong;
    trials.trials = wrong == 0.0 ? 60 : 20;
    trials.seed = 7;
    const AcquisitionRow row = acquire_at_random(trials);
    MESSAGE("acquired ", row.acquired, " of ", row.trials, ", ambiguous ", row.ambiguous, ", false ", row.false_poses,
            ", ", row.position_mm, " mm, ", row.angle_deg, " deg, tuples ", row.tuples);
    CHECK(row.false_poses == 0);
    CHECK(row.acquired >= row.trials * 9 / 10);  // of 400 each, 398 and 394 were
    CHECK(row.position_mm < 10.0);
  }
}

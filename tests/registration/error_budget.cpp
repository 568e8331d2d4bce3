#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/registration/error_budget.hpp>

using namespace holdfast;

namespace {

BudgetSettings everything_wrong() {
  BudgetSettings settings;
  settings.experiment.motion_name = "M6";
  settings.experiment.lens = LensMode::cubic;
  settings.experiment.hmd.timing.scan_out = ScanOut::rolling;
  settings.experiment.hmd.timing.scan_duration = from_milliseconds(11.1);
  return settings;
}

}  // namespace

TEST_CASE("the budget lists each source alone, and all together is less than their sum") {
  const auto motion = make_motion("M6", 1);
  const RegistrationBudget budget = registration_budget(*motion, everything_wrong());
  REQUIRE(budget.parts.size() == 6);
  for (const BudgetPart& part : budget.parts) {
    CAPTURE(part.source);
    CHECK(part.rms_arcmin > 0.1);
    CHECK(part.rms_arcmin < budget.all.peak_arcmin);
  }
  CHECK(budget.all.rms_arcmin < budget.sum_arcmin());
  CHECK(budget.all.rms_arcmin > 0.5 * budget.root_of_squares_arcmin());
  // Twice the delay, about twice the error (000 eqs 5.1, 5.2); second order: a few percent.
  CHECK(budget.parts[2].rms_arcmin / budget.parts[1].rms_arcmin == doctest::Approx(2.0).epsilon(0.05));
  // 2 mm to the side are 2 mm at any depth.
  CHECK(budget.parts[0].rms_mm == doctest::Approx(2.0).epsilon(0.1));
  CHECK(budget.parts[5].rms_mm == doctest::Approx(1.0).epsilon(0.05));  // half of a wrong IPD for each eye
}

TEST_CASE("a budget without faults is empty") {
  BudgetSettings settings;
  settings.tracker_delay = settings.graphics_delay = Duration{0};
  settings.X_HT = Rigid();
  settings.ipd_error_m = 0.0;
  const auto motion = make_motion("M4", 1);
  const RegistrationBudget budget = registration_budget(*motion, settings);
  // Drawn through the same optics twice: rounding only.
  CHECK(budget.sum_arcmin() < 1e-9);
  CHECK(budget.all.peak_arcmin < 1e-9);
  CHECK(budget.orientation_bound.total().arcmin() == 0.0);
  CHECK(budget.position_bound_m.total() == 0.0);
}

TEST_CASE("a budget of a display that cannot be is empty, and comes to an end") {
  BudgetSettings settings;
  settings.experiment.hmd.timing.refresh_hz = 0.0;
  const RegistrationBudget budget = registration_budget(*make_motion("M4", 1), settings);
  CHECK(budget.parts.size() == 6);
  CHECK(budget.sum_arcmin() == 0.0);
}

TEST_CASE("eq. 5.4 bounds what the displayed pose errs") {
  BudgetSettings settings;
  settings.experiment.motion_name = "M4";
  const auto motion = make_motion("M4", 1);
  const RegistrationBudget budget = registration_budget(*motion, settings);
  ExperimentSettings late;
  late.motion_name = "M4";
  late.X_HT = settings.X_HT;
  late.latency = settings.tracker_delay + settings.graphics_delay;
  const PoseErrorSummary pose = run_experiment(*motion, late).row.pose;
  CHECK(pose.peak_orientation_arcmin <= budget.orientation_bound.total().arcmin());
  CHECK(pose.peak_position_mm <= 1e3 * budget.position_bound_m.total());
  CHECK(pose.peak_orientation_arcmin > 0.5 * budget.orientation_bound.total().arcmin());
}

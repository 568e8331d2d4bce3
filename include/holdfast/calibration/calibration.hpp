/// Everything of calibration that needs the core alone. filter_tuning.hpp needs NLopt, is the component
/// holdfast::calibration, and is included by itself.
#pragma once

#include <holdfast/calibration/inertial_calibration.hpp>
#include <holdfast/calibration/tuned_parameter.hpp>

/// Everything of the core: needs Eigen and the standard library alone.
///
/// The optional components have umbrellas of their own: holdfast/io/io.hpp, holdfast/rendering/rendering.hpp,
/// holdfast/scene/scene.hpp, holdfast/interop/glm.hpp, holdfast/calibration/filter_tuning.hpp.
#pragma once

#include <holdfast/assert.hpp>
#include <holdfast/calibration/calibration.hpp>
#include <holdfast/deflection/deflection.hpp>
#include <holdfast/frames/frames.hpp>
#include <holdfast/geometry/geometry.hpp>
#include <holdfast/motion/motions.hpp>
#include <holdfast/optics/optics.hpp>
#include <holdfast/pipeline/pipeline.hpp>
#include <holdfast/prediction/prediction.hpp>
#include <holdfast/registration/registration.hpp>
#include <holdfast/simulation/simulation.hpp>
#include <holdfast/timing/timing.hpp>
#include <holdfast/tracking/tracking.hpp>

/// Runs one registration experiment: a motion, a pipeline, an eye, a lens, a latency, a display.
#pragma once

#include <holdfast/motion/motion.hpp>
#include <holdfast/registration/experiment_types.hpp>

namespace holdfast {

/// Runs `settings` on `motion`, whose poses are X_WH in the scene's world W. `observe` (may be empty) is called once a
/// frame.
[[nodiscard]] ExperimentResult run_experiment(const Motion& motion, const ExperimentSettings& settings,
                                              const RegistrationScene& scene = default_registration_scene(),
                                              const FrameObserver& observe = {});

}  // namespace holdfast

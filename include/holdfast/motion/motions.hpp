/// Everything of motion/. (motion.hpp is the interface alone.)
#pragma once

#include <holdfast/motion/differentiation.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/head_curve.hpp>
#include <holdfast/motion/head_motions.hpp>
#include <holdfast/motion/jet.hpp>
#include <holdfast/motion/low_pass.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>
#include <holdfast/motion/spline_trajectory.hpp>
#include <holdfast/motion/test_signals.hpp>
#include <holdfast/motion/timed_pose.hpp>

/// Everything of tracking/.
#pragma once

#include <holdfast/tracking/backward_difference.hpp>
#include <holdfast/tracking/head_dynamics.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

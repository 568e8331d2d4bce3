/// Everything of tracking/.
#pragma once

#include <holdfast/tracking/acquisition.hpp>
#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/backward_difference.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/camera_view.hpp>
#include <holdfast/tracking/chain_step.hpp>
#include <holdfast/tracking/chi_square.hpp>
#include <holdfast/tracking/collinearity.hpp>
#include <holdfast/tracking/device_estimate.hpp>
#include <holdfast/tracking/device_table.hpp>
#include <holdfast/tracking/head_dynamics.hpp>
#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/innovation_gate.hpp>
#include <holdfast/tracking/mcaat_filter.hpp>
#include <holdfast/tracking/measurement.hpp>
#include <holdfast/tracking/observation_window.hpp>
#include <holdfast/tracking/pose_estimate.hpp>
#include <holdfast/tracking/process_model.hpp>
#include <holdfast/tracking/scaat_filter.hpp>
#include <holdfast/tracking/sighting_noise.hpp>
#include <holdfast/tracking/space_resection.hpp>
#include <holdfast/tracking/target_state.hpp>
#include <holdfast/tracking/three_point_resection.hpp>

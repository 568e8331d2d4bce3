/// Everything of registration/.
#pragma once

#include <holdfast/registration/experiment.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/registration/scene_fiducials.hpp>

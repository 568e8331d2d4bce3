/// Everything of registration/, but for the comparisons of trackers (track_experiment.hpp, range_experiment.hpp), which take long to
/// compile.
#pragma once

#include <holdfast/registration/effective_latency.hpp>
#include <holdfast/registration/error_budget.hpp>
#include <holdfast/registration/expected_values.hpp>
#include <holdfast/registration/experiment.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/inertial_recording.hpp>
#include <holdfast/registration/latency_types.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/outline_centroid.hpp>
#include <holdfast/registration/overshoot.hpp>
#include <holdfast/registration/picture_centroid.hpp>
#include <holdfast/registration/pipeline_pose.hpp>
#include <holdfast/registration/prediction_experiment.hpp>
#include <holdfast/registration/projected_ellipse.hpp>
#include <holdfast/registration/range_recording.hpp>
#include <holdfast/registration/scan_skew.hpp>
#include <holdfast/registration/scene_depth.hpp>
#include <holdfast/registration/scene_fiducials.hpp>
#include <holdfast/registration/shown_point.hpp>
#include <holdfast/registration/swim.hpp>
#include <holdfast/registration/theory.hpp>
#include <holdfast/registration/three_point_error.hpp>
#include <holdfast/registration/view_coverage.hpp>

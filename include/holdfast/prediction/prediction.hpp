/// Everything of prediction/.
#pragma once

#include <holdfast/prediction/azuma_bishop_prediction.hpp>
#include <holdfast/prediction/error_recorder.hpp>
#include <holdfast/prediction/error_spread.hpp>
#include <holdfast/prediction/error_statistics.hpp>
#include <holdfast/prediction/evaluation.hpp>
#include <holdfast/prediction/fading_least_squares.hpp>
#include <holdfast/prediction/guarded_pose_filter.hpp>
#include <holdfast/prediction/horizon_learner.hpp>
#include <holdfast/prediction/inertial_predictor.hpp>
#include <holdfast/prediction/jitter.hpp>
#include <holdfast/prediction/learnt_uncertainty.hpp>
#include <holdfast/prediction/motion_trend.hpp>
#include <holdfast/prediction/prediction_distance.hpp>
#include <holdfast/prediction/predictor.hpp>
#include <holdfast/prediction/predictor_theory.hpp>
#include <holdfast/prediction/recorded_truth.hpp>
#include <holdfast/prediction/state_prediction.hpp>

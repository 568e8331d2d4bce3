/// Everything of pipeline/.
#pragma once

#include <holdfast/pipeline/eye_view.hpp>
#include <holdfast/pipeline/field_outline.hpp>
#include <holdfast/pipeline/frame.hpp>
#include <holdfast/pipeline/frame_issues.hpp>
#include <holdfast/pipeline/frame_log.hpp>
#include <holdfast/pipeline/frame_loop.hpp>
#include <holdfast/pipeline/frame_loop_settings.hpp>
#include <holdfast/pipeline/latest_pose.hpp>
#include <holdfast/pipeline/pose_source.hpp>

/// Everything of pipeline/.
#pragma once

#include <holdfast/pipeline/frame_issues.hpp>
#include <holdfast/pipeline/frame_log.hpp>
#include <holdfast/pipeline/latest_pose.hpp>
#include <holdfast/pipeline/pose_source.hpp>

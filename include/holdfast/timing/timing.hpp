/// All of holdfast's timing: clocks and their offsets, displays, the frame plan, the latency budget.
#pragma once

#include <holdfast/timing/clock.hpp>
#include <holdfast/timing/clock_offset.hpp>
#include <holdfast/timing/clock_offset_estimator.hpp>
#include <holdfast/timing/display_timing.hpp>
#include <holdfast/timing/frame_plan.hpp>
#include <holdfast/timing/latency_budget.hpp>
#include <holdfast/timing/vsync_estimator.hpp>

/// Everything of simulation/, but for the trackers that are compared (hiball_trackers.hpp), which take long to compile.
#pragma once

#include <holdfast/simulation/ceiling_footprint.hpp>
#include <holdfast/simulation/ceiling_motion.hpp>
#include <holdfast/simulation/constellation_rig.hpp>
#include <holdfast/simulation/faults.hpp>
#include <holdfast/simulation/hiball_ceiling.hpp>
#include <holdfast/simulation/hiball_rig.hpp>
#include <holdfast/simulation/hiball_sightings.hpp>
#include <holdfast/simulation/hiball_tracker.hpp>
#include <holdfast/simulation/inertial_faults.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/simulation/keyed_numbers.hpp>
#include <holdfast/simulation/nearest_beacon.hpp>
#include <holdfast/simulation/sighting_stream.hpp>
#include <holdfast/simulation/time_span.hpp>
#include <holdfast/simulation/ultrasonic_range.hpp>
#include <holdfast/simulation/ultrasonic_ranging.hpp>

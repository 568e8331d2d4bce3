/// Everything of the io component: recordings of motion and ranges, headset descriptors, calibrated devices, meshes, results in JSON, pictures in PNG.
#pragma once

#include <holdfast/io/cardboard.hpp>
#include <holdfast/io/device_file.hpp>
#include <holdfast/io/hmd.hpp>
#include <holdfast/io/image.hpp>
#include <holdfast/io/inertial_files.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/mesh_writer.hpp>
#include <holdfast/io/osvr.hpp>
#include <holdfast/io/png.hpp>
#include <holdfast/io/range_files.hpp>
#include <holdfast/io/result_json.hpp>
#include <holdfast/io/results.hpp>
#include <holdfast/io/track_results.hpp>
#include <holdfast/io/trajectory.hpp>

/// Everything of optics: fields of view, projections, lenses, eyes and headsets.
#pragma once

#include <holdfast/optics/bivariate_lens.hpp>
#include <holdfast/optics/brown_conrady_lens.hpp>
#include <holdfast/optics/catmull_rom_lens.hpp>
#include <holdfast/optics/cubic_fit.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/optics/kannala_brandt_lens.hpp>
#include <holdfast/optics/lens.hpp>
#include <holdfast/optics/lens_mode.hpp>
#include <holdfast/optics/lens_model.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/lens_relief.hpp>
#include <holdfast/optics/overfill.hpp>
#include <holdfast/optics/planar_model.hpp>
#include <holdfast/optics/point_mesh.hpp>
#include <holdfast/optics/point_mesh_lens.hpp>
#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/power_series_lens.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>
#include <holdfast/optics/projection.hpp>
#include <holdfast/optics/radial_lens.hpp>
#include <holdfast/optics/radial_model.hpp>
#include <holdfast/optics/reversed_lens.hpp>
#include <holdfast/optics/tangents.hpp>
#include <holdfast/optics/vive_lens.hpp>

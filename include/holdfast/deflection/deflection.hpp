/// Everything of deflection: late correction of finished pictures, composed with lens and scan-out.
#pragma once

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/coverage.hpp>
#include <holdfast/deflection/cpu_warp.hpp>
#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/deflected_mesh.hpp>
#include <holdfast/deflection/depth_image.hpp>
#include <holdfast/deflection/depth_mesh.hpp>
#include <holdfast/deflection/depth_raster.hpp>
#include <holdfast/deflection/depth_search.hpp>
#include <holdfast/deflection/depth_surface.hpp>
#include <holdfast/deflection/lit_line.hpp>
#include <holdfast/deflection/picture_span.hpp>
#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/deflection/scan_homography.hpp>
#include <holdfast/deflection/scan_pose.hpp>
#include <holdfast/deflection/source_state.hpp>
#include <holdfast/deflection/warp_lattice.hpp>

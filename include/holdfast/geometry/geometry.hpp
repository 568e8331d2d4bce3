/// All of holdfast's geometry: transforms, angles, rays, planes, homographies, alignment, triangulation.
#pragma once

#include <holdfast/geometry/align.hpp>
#include <holdfast/geometry/align_poses.hpp>
#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/geometry/delaunay.hpp>
#include <holdfast/geometry/homography.hpp>
#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/geometry/predicates.hpp>
#include <holdfast/geometry/rays_planes.hpp>
#include <holdfast/geometry/rigid.hpp>
#include <holdfast/geometry/so3.hpp>
#include <holdfast/geometry/tangents_of_point.hpp>
#include <holdfast/geometry/triangle_grid.hpp>
#include <holdfast/geometry/triangle_overlap.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/geometry/vqs.hpp>

/// Everything of deflection: late correction of finished pictures, composed with lens and scan-out.
#pragma once

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/deflection/scan_homography.hpp>
#include <holdfast/deflection/scan_pose.hpp>

/// Everything of holdfast::rendering: contexts without a window, targets, the registration scene, late warps through the
/// lens, pictures of swim.
#pragma once

#include <holdfast/rendering/backend.hpp>
#include <holdfast/rendering/composition.hpp>
#include <holdfast/rendering/context.hpp>
#include <holdfast/rendering/coverage_mask.hpp>
#include <holdfast/rendering/depth_mesh_pass.hpp>
#include <holdfast/rendering/depth_surface_texture.hpp>
#include <holdfast/rendering/depth_warp_pass.hpp>
#include <holdfast/rendering/egl_context.hpp>
#include <holdfast/rendering/flat_shape.hpp>
#include <holdfast/rendering/frame_time.hpp>
#include <holdfast/rendering/gl_error.hpp>
#include <holdfast/rendering/gl_functions.hpp>
#include <holdfast/rendering/gl_object.hpp>
#include <holdfast/rendering/image_compare.hpp>
#include <holdfast/rendering/late_warp_pass.hpp>
#include <holdfast/rendering/lit_painter.hpp>
#include <holdfast/rendering/make_context.hpp>
#include <holdfast/rendering/mesh.hpp>
#include <holdfast/rendering/osmesa_context.hpp>
#include <holdfast/rendering/place_table.hpp>
#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/registration_scene.hpp>
#include <holdfast/rendering/render_target.hpp>
#include <holdfast/rendering/rolling.hpp>
#include <holdfast/rendering/seen_mesh.hpp>
#include <holdfast/rendering/shader_source.hpp>
#include <holdfast/rendering/texture.hpp>
#include <holdfast/rendering/triangle_buffers.hpp>
#include <holdfast/rendering/view.hpp>
#include <holdfast/rendering/warp_mesh.hpp>

/// The OpenGL functions of one context, and the platform headers in the only order in which they can be included: EGL,
/// then glad, then GL/osmesa.h.
///
/// The table is glad's (generated at configure time, see cmake/HoldfastRendering.cmake), with one function table per
/// context because several contexts live in one process: gl.ClearColor(...), gl.DrawArrays(...). All its functions are
/// inline and carry a holdfast_ prefix, so that including this from many translation units, or beside a glad of your
/// own in other translation units, links. Do not include <GL/gl.h> before this header.
#pragma once

// clang-format off
#if HOLDFAST_HAS_EGL
#ifndef EGL_NO_X11
#define EGL_NO_X11
#endif
#ifndef MESA_EGL_NO_X11_HEADERS
#define MESA_EGL_NO_X11_HEADERS
#endif
#include <EGL/egl.h>
#include <EGL/eglext.h>
#endif

#include <holdfast/rendering/glad_gl.hpp>

#if HOLDFAST_HAS_OSMESA
#include <GL/osmesa.h>
#endif
// clang-format on

namespace holdfast::rendering {

using GlFunctions = GladGLContext;

}  // namespace holdfast::rendering

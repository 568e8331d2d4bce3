# Finds what draws off screen: OSMesa and EGL, either or both. Used by the build tree and by the installed package alike, so that
# an installed holdfast::rendering works with the backends of the machine it is used on.
# Sets holdfast_gl_found; defines holdfast_gl::osmesa and holdfast_gl::egl (those found) and holdfast_gl::backends, which links
# them and tells the headers which they are (HOLDFAST_HAS_OSMESA, HOLDFAST_HAS_EGL).

set(holdfast_gl_found FALSE)
if(CMAKE_DISABLE_FIND_PACKAGE_OpenGL)
  return()
endif()

find_path(HOLDFAST_OSMESA_INCLUDE_DIR GL/osmesa.h)
find_library(HOLDFAST_OSMESA_LIBRARY OSMesa)
find_path(HOLDFAST_EGL_INCLUDE_DIR EGL/egl.h)
find_library(HOLDFAST_EGL_LIBRARY EGL)
mark_as_advanced(HOLDFAST_OSMESA_INCLUDE_DIR HOLDFAST_OSMESA_LIBRARY HOLDFAST_EGL_INCLUDE_DIR HOLDFAST_EGL_LIBRARY)

# Global, because a project that embeds Holdfast links these from outside this folder.
if(HOLDFAST_OSMESA_INCLUDE_DIR AND HOLDFAST_OSMESA_LIBRARY)
  set(holdfast_gl_found TRUE)
  if(NOT TARGET holdfast_gl::osmesa)
    add_library(holdfast_gl::osmesa INTERFACE IMPORTED GLOBAL)
    set_target_properties(holdfast_gl::osmesa PROPERTIES
      INTERFACE_INCLUDE_DIRECTORIES "${HOLDFAST_OSMESA_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES "${HOLDFAST_OSMESA_LIBRARY}"
      INTERFACE_COMPILE_DEFINITIONS HOLDFAST_HAS_OSMESA=1)
  endif()
endif()
if(HOLDFAST_EGL_INCLUDE_DIR AND HOLDFAST_EGL_LIBRARY)
  set(holdfast_gl_found TRUE)
  if(NOT TARGET holdfast_gl::egl)
    add_library(holdfast_gl::egl INTERFACE IMPORTED GLOBAL)
    set_target_properties(holdfast_gl::egl PROPERTIES
      INTERFACE_INCLUDE_DIRECTORIES "${HOLDFAST_EGL_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES "${HOLDFAST_EGL_LIBRARY}"
      INTERFACE_COMPILE_DEFINITIONS HOLDFAST_HAS_EGL=1)
  endif()
endif()
if(holdfast_gl_found AND NOT TARGET holdfast_gl::backends)
  add_library(holdfast_gl::backends INTERFACE IMPORTED GLOBAL)
  foreach(holdfast_backend IN ITEMS osmesa egl)
    if(TARGET holdfast_gl::${holdfast_backend})
      set_property(TARGET holdfast_gl::backends APPEND PROPERTY INTERFACE_LINK_LIBRARIES holdfast_gl::${holdfast_backend})
    endif()
  endforeach()
endif()

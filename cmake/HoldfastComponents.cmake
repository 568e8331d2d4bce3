# Defines one INTERFACE target per component: holdfast::core always, and of HOLDFAST_COMPONENTS those whose dependencies are
# found. A component's headers are the folders it owns, globbed, so that no hand-kept list can rot.

set(HOLDFAST_INCLUDE_DIR "${PROJECT_SOURCE_DIR}/include")
set(HOLDFAST_GENERATED_DIR "${PROJECT_BINARY_DIR}/generated/include")
set(HOLDFAST_DEFINED_COMPONENTS "")

# holdfast_add_component(NAME FOLDERS folder... [HEADERS pattern...] [GENERATED header...]): folders with all that is below them,
# and further headers of include/holdfast by pattern.
function(holdfast_add_component name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FOLDERS;HEADERS;GENERATED")
  set(headers "")
  foreach(folder IN LISTS arg_FOLDERS)
    file(GLOB_RECURSE found CONFIGURE_DEPENDS "${HOLDFAST_INCLUDE_DIR}/holdfast/${folder}/*.hpp")
    list(APPEND headers ${found})
  endforeach()
  foreach(pattern IN LISTS arg_HEADERS)
    file(GLOB found CONFIGURE_DEPENDS "${HOLDFAST_INCLUDE_DIR}/holdfast/${pattern}")
    list(APPEND headers ${found})
  endforeach()
  add_library(holdfast_${name} INTERFACE)
  add_library(holdfast::${name} ALIAS holdfast_${name})
  set_target_properties(holdfast_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(holdfast_${name} INTERFACE cxx_std_20)
  target_sources(holdfast_${name} INTERFACE FILE_SET HEADERS BASE_DIRS "${HOLDFAST_INCLUDE_DIR}" FILES ${headers})
  if(arg_GENERATED)
    target_sources(holdfast_${name} INTERFACE FILE_SET generated TYPE HEADERS BASE_DIRS "${HOLDFAST_GENERATED_DIR}"
      FILES ${arg_GENERATED})
  endif()
  set(HOLDFAST_DEFINED_COMPONENTS ${HOLDFAST_DEFINED_COMPONENTS} ${name} PARENT_SCOPE)
endfunction()

# core: Eigen only.
find_package(Eigen3 REQUIRED NO_MODULE)
if(Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "holdfast needs Eigen 3.4 or newer, found ${Eigen3_VERSION} (Debian: libeigen3-dev)")
endif()
# A version given to find_package would also cap it: Eigen 5's package file calls itself incompatible with 3.4.
holdfast_add_component(core HEADERS *.hpp FOLDERS geometry timing motion frames tracking prediction optics deflection simulation
  calibration registration pipeline)
target_link_libraries(holdfast_core INTERFACE Eigen3::Eigen)

if("io" IN_LIST HOLDFAST_COMPONENTS)
  find_package(nlohmann_json 3.10 QUIET)
  find_package(PNG QUIET)
  if(nlohmann_json_FOUND AND PNG_FOUND)
    holdfast_add_component(io FOLDERS io)
    target_link_libraries(holdfast_io INTERFACE holdfast_core nlohmann_json::nlohmann_json PNG::PNG)
  else()
    message(STATUS "holdfast::io left out: needs nlohmann-json and libpng (Debian: nlohmann-json3-dev libpng-dev)")
  endif()
endif()

if("rendering" IN_LIST HOLDFAST_COMPONENTS)
  include(HoldfastRendering)
endif()

if("scene" IN_LIST HOLDFAST_COMPONENTS AND TARGET holdfast_rendering)
  find_package(assimp QUIET)
  find_package(JPEG QUIET)
  if(assimp_FOUND AND JPEG_FOUND AND TARGET holdfast_io)
    holdfast_add_component(scene FOLDERS scene)
    target_link_libraries(holdfast_scene INTERFACE holdfast_rendering holdfast_io assimp::assimp JPEG::JPEG)
  else()
    message(STATUS "holdfast::scene left out: needs holdfast::io, assimp and libjpeg (Debian: libassimp-dev libjpeg-dev)")
  endif()
endif()

if("glm" IN_LIST HOLDFAST_COMPONENTS)
  find_package(glm QUIET)
  if(glm_FOUND)
    holdfast_add_component(glm HEADERS interop/glm.hpp)
    target_link_libraries(holdfast_glm INTERFACE holdfast_core glm::glm)
  else()
    message(STATUS "holdfast::glm left out: needs GLM (Debian: libglm-dev)")
  endif()
endif()

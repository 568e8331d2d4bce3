# Builds and runs a small project that uses Holdfast the way MODE says, in a scratch folder of the build.
set(scratch "${HOLDFAST_BUILD}/consumers/${MODE}")
file(REMOVE_RECURSE "${scratch}")
file(MAKE_DIRECTORY "${scratch}")

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(JOIN " " line ${ARGV})
    message(FATAL_ERROR "${line}\n${output}")
  endif()
  set(run_output "${output}" PARENT_SCOPE)
endfunction()

set(common -G Ninja -DCMAKE_CXX_COMPILER=${COMPILER} -DMODE=${MODE})
set(consumer "${HOLDFAST_SOURCE}/tests/packaging/consumer")

if(MODE STREQUAL "installed")
  run("${CMAKE_COMMAND}" --install "${HOLDFAST_BUILD}" --prefix "${scratch}/prefix")
  run("${CMAKE_COMMAND}" -S "${consumer}" -B "${scratch}/build" ${common} "-DCMAKE_PREFIX_PATH=${scratch}/prefix"
    "-DWANTED=core;${COMPONENTS}")
elseif(MODE STREQUAL "installed_core_alone")
  # Asking for core must look for Eigen alone.
  run("${CMAKE_COMMAND}" --install "${HOLDFAST_BUILD}" --prefix "${scratch}/prefix")
  run("${CMAKE_COMMAND}" -S "${consumer}" -B "${scratch}/build" ${common} "-DCMAKE_PREFIX_PATH=${scratch}/prefix"
    -DWANTED=core -DCMAKE_DISABLE_FIND_PACKAGE_PNG=ON -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON -DCMAKE_DISABLE_FIND_PACKAGE_glm=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_OpenXR=ON -DCMAKE_DISABLE_FIND_PACKAGE_NLopt=ON)
elseif(MODE STREQUAL "subdirectory")
  run("${CMAKE_COMMAND}" -S "${consumer}" -B "${scratch}/build" ${common} -DHOLDFAST_SOURCE=${HOLDFAST_SOURCE}
    "-DWANTED=core;${COMPONENTS}")
elseif(MODE STREQUAL "fetch_content")
  run("${CMAKE_COMMAND}" -S "${consumer}" -B "${scratch}/build" ${common}
    -DFETCHCONTENT_SOURCE_DIR_HOLDFAST=${HOLDFAST_SOURCE} "-DWANTED=core;${COMPONENTS}")
elseif(MODE STREQUAL "no_gl")
  # As on a machine without GL libraries and NLopt: what needs them is left out and said to be, the rest builds.
  run("${CMAKE_COMMAND}" -S "${consumer}" -B "${scratch}/build" ${common} -DHOLDFAST_SOURCE=${HOLDFAST_SOURCE}
    -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON -DCMAKE_DISABLE_FIND_PACKAGE_NLopt=ON "-DWANTED=core;io;glm")
  foreach(component rendering calibration)
    if(NOT run_output MATCHES "holdfast::${component} left out")
      message(FATAL_ERROR "configuring did not say that ${component} was left out:\n${run_output}")
    endif()
  endforeach()
endif()

run("${CMAKE_COMMAND}" --build "${scratch}/build")
run("${scratch}/build/consumer")

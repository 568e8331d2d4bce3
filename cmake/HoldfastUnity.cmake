# Compiles many test files as few: headers are read, and templates made, once for all of them, which takes a fraction of the time
# while a file's class templates stay below some 100,000 (g++ -fstats, type_specializations).
# Each file keeps its names to itself, in a namespace of its own; so that no header is read inside of that namespace, all headers
# that the files include come first, from a generated list.
option(HOLDFAST_UNITY "Compile the test files of a folder together: quickest for all of them, slower after a small change" OFF)
set(HOLDFAST_UNITY_FILES 8 CACHE STRING "How many files are compiled together at most: more take less time and more memory")
mark_as_advanced(HOLDFAST_UNITY_FILES)
set(HOLDFAST_COLLECT_INCLUDES "${CMAKE_CURRENT_LIST_DIR}/collect_includes.cmake")

# holdfast_compile_together(TARGET source...): TARGET's sources, but for those with SKIP_UNITY_BUILD_INCLUSION.
function(holdfast_compile_together target)
  set(sources "")
  foreach(source IN LISTS ARGN)
    get_source_file_property(alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
    if(NOT alone)
      list(APPEND sources "${source}")
    endif()
  endforeach()
  set(includes "${CMAKE_CURRENT_BINARY_DIR}/${target}_includes.hpp")
  add_custom_command(OUTPUT "${includes}"
    COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${includes}" "-DSOURCES=${sources}" -P "${HOLDFAST_COLLECT_INCLUDES}"
    DEPENDS ${sources} "${HOLDFAST_COLLECT_INCLUDES}" VERBATIM)
  target_sources(${target} PRIVATE "${includes}")
  set_target_properties(${target} PROPERTIES
    UNITY_BUILD ON
    UNITY_BUILD_BATCH_SIZE ${HOLDFAST_UNITY_FILES}
    UNITY_BUILD_UNIQUE_ID names_of_this_file
    UNITY_BUILD_CODE_BEFORE_INCLUDE "#include \"${includes}\"\nnamespace names_of_this_file {"
    UNITY_BUILD_CODE_AFTER_INCLUDE "}")
endfunction()

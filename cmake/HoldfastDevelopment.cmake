# Settings for our own executables only: nothing here reaches those who embed the library.

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()

add_library(holdfast_development INTERFACE)
target_compile_options(holdfast_development INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wnon-virtual-dtor -Woverloaded-virtual)
if(HOLDFAST_WARNINGS_AS_ERRORS)
  target_compile_options(holdfast_development INTERFACE -Werror)
endif()
if(HOLDFAST_SANITIZE_MEMORY)
  # Reads and writes through null, or beyond an object, AddressSanitizer finds by itself: to look for them twice is a quarter of
  # the time to compile.
  set(HOLDFAST_SANITIZERS -fsanitize=address,undefined -fno-sanitize=null,object-size -fno-sanitize-recover=all
    -fno-omit-frame-pointer)
elseif(HOLDFAST_SANITIZE_THREADS)
  set(HOLDFAST_SANITIZERS -fsanitize=thread)
endif()
target_compile_options(holdfast_development INTERFACE ${HOLDFAST_SANITIZERS})
target_link_options(holdfast_development INTERFACE ${HOLDFAST_SANITIZERS})

# Recordings that are not ours to ship; tests that want them say so when they are absent.
set(HOLDFAST_RECORDINGS "${PROJECT_SOURCE_DIR}/../shared/data" CACHE PATH "Folder of recorded motion and devices")

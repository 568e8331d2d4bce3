# Installs headers and a package whose components ask only for what was requested: one targets file per component.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(HOLDFAST_PACKAGE_DIR "${CMAKE_INSTALL_DATADIR}/cmake/holdfast")

foreach(component IN LISTS HOLDFAST_DEFINED_COMPONENTS)
  set(generated "")
  if(component STREQUAL "rendering")
    set(generated FILE_SET generated DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
  endif()
  install(TARGETS holdfast_${component} EXPORT holdfast_${component}
    FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" ${generated})
  install(EXPORT holdfast_${component} NAMESPACE holdfast:: FILE holdfast_${component}.cmake
    DESTINATION "${HOLDFAST_PACKAGE_DIR}")
endforeach()

configure_package_config_file(cmake/holdfastConfig.cmake.in "${PROJECT_BINARY_DIR}/holdfastConfig.cmake"
  INSTALL_DESTINATION "${HOLDFAST_PACKAGE_DIR}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/holdfastConfigVersion.cmake" COMPATIBILITY SameMinorVersion
  ARCH_INDEPENDENT)
install(FILES "${PROJECT_BINARY_DIR}/holdfastConfig.cmake" "${PROJECT_BINARY_DIR}/holdfastConfigVersion.cmake"
  cmake/HoldfastFindGl.cmake DESTINATION "${HOLDFAST_PACKAGE_DIR}")
install(DIRECTORY assets/ DESTINATION "${CMAKE_INSTALL_DATADIR}/holdfast")
install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}")

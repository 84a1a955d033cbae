# What is installed for C++: below the prefix, or in the wheel below the package. Nothing depends on the architecture.
include(CMakePackageConfigHelpers)
set(cmake_files ${STILLREACH_FOLDER}share/cmake/stillreach)

write_basic_package_version_file(
  ${CMAKE_CURRENT_BINARY_DIR}/stillreach-config-version.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
configure_file(cmake/stillreach.pc.in stillreach.pc @ONLY)

install(DIRECTORY include/stillreach DESTINATION ${STILLREACH_FOLDER}include)
install(TARGETS stillreach EXPORT stillreach)
install(EXPORT stillreach NAMESPACE stillreach:: FILE stillreach-targets.cmake DESTINATION ${cmake_files})
install(DIRECTORY dispatch/ DESTINATION ${cmake_files})
install(FILES cmake/stillreach-config.cmake cmake/stillreach-urdf.cmake ${CMAKE_CURRENT_BINARY_DIR}/stillreach-config-version.cmake
        DESTINATION ${cmake_files})
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stillreach.pc DESTINATION ${STILLREACH_FOLDER}share/pkgconfig)

# `cmake --install`: libraries, headers, CMake package, pkg-config file, program, man page, licence.
include(CMakePackageConfigHelpers)

install(TARGETS tulle_shared tulle_static EXPORT tulle_targets)
install(TARGETS tulle_program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/tulle DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
# `tulle bench` finds these from where the program lies, so an installed tree may be moved.
if(EXISTS ${PROJECT_SOURCE_DIR}/scenes/paper)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/scenes/paper DESTINATION ${CMAKE_INSTALL_DATADIR}/tulle/scenes FILES_MATCHING PATTERN "*.yaml")
endif()
foreach(name needles sphere spikes ribbon net boxes hammock)
    install(FILES ${PROJECT_SOURCE_DIR}/scenes/${name}.yaml DESTINATION ${CMAKE_INSTALL_DATADIR}/tulle/scenes)
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/docs/tulle.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/tulle)
install(EXPORT tulle_targets NAMESPACE tulle:: FILE tulleTargets.cmake DESTINATION ${package_directory})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/tulleConfig.cmake.in ${PROJECT_BINARY_DIR}/tulleConfig.cmake
    INSTALL_DESTINATION ${package_directory})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tulleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tulleConfig.cmake ${PROJECT_BINARY_DIR}/tulleConfigVersion.cmake
    DESTINATION ${package_directory})

# tulle.pc finds its prefix from where it lies, so an installed tree may be moved.
file(RELATIVE_PATH pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
list(TRANSFORM tulle_private_libraries PREPEND -l OUTPUT_VARIABLE pc_private_libraries)
list(JOIN pc_private_libraries " " pc_private_libraries)
configure_file(${PROJECT_SOURCE_DIR}/cmake/tulle.pc.in ${PROJECT_BINARY_DIR}/tulle.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/tulle.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

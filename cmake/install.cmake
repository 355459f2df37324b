# `cmake --install`: what is built of libraries, headers, CMake packages, pkg-config files, program, man page; licence.
include(CMakePackageConfigHelpers)

# tulle_install_library(NAME): targets, headers, CMake package and pkg-config file of tulle or tulle_io.
function(tulle_install_library name)
    install(TARGETS ${name}_shared ${name}_static EXPORT ${name}_targets)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/${name} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

    set(directory ${CMAKE_INSTALL_LIBDIR}/cmake/${name})
    install(EXPORT ${name}_targets NAMESPACE tulle:: FILE ${name}Targets.cmake DESTINATION ${directory})
    configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/${name}Config.cmake.in ${PROJECT_BINARY_DIR}/${name}Config.cmake
        INSTALL_DESTINATION ${directory})
    # Before 1.0 a minor version may change the interface.
    write_basic_package_version_file(${PROJECT_BINARY_DIR}/${name}ConfigVersion.cmake COMPATIBILITY SameMinorVersion)
    install(FILES ${PROJECT_BINARY_DIR}/${name}Config.cmake ${PROJECT_BINARY_DIR}/${name}ConfigVersion.cmake DESTINATION ${directory})

    # The file finds its prefix from where it lies, so an installed tree may be moved.
    file(RELATIVE_PATH pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
    string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
    list(TRANSFORM tulle_private_libraries PREPEND -l OUTPUT_VARIABLE pc_private_libraries)
    list(JOIN pc_private_libraries " " pc_private_libraries)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

tulle_install_library(tulle)
if(TULLE_IO)
    tulle_install_library(tulle_io)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

if(TULLE_PROGRAM)
    install(TARGETS tulle_program)
    install(FILES ${PROJECT_SOURCE_DIR}/docs/tulle.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
    # Scenes to begin with.
    if(EXISTS ${PROJECT_SOURCE_DIR}/scenes/paper)
        install(DIRECTORY ${PROJECT_SOURCE_DIR}/scenes/paper DESTINATION ${CMAKE_INSTALL_DATADIR}/tulle/scenes FILES_MATCHING PATTERN "*.yaml")
    endif()
    foreach(name needles sphere spikes ribbon net boxes hammock)
        install(FILES ${PROJECT_SOURCE_DIR}/scenes/${name}.yaml DESTINATION ${CMAKE_INSTALL_DATADIR}/tulle/scenes)
    endforeach()
endif()

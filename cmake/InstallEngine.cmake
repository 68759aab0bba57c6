# Installs the C libraries alone, for C or C++ programs without OpenMM: a CMake package and a pkg-config file, both called
# chaintree. With CHAINTREE_ENGINE_ONLY nothing else is installed; otherwise they are the component `engine`, which only
# `cmake --install BUILD --component engine` installs.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(engine_rule COMPONENT engine)
if(NOT CHAINTREE_ENGINE_ONLY)
    list(APPEND engine_rule EXCLUDE_FROM_ALL)
endif()

# chaintree_install_library(target header ...): one of these libraries, and its public headers.
function(chaintree_install_library target)
    install(TARGETS ${target} EXPORT chaintreeTargets
        ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" ${engine_rule}
        INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
    install(FILES ${ARGN} DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" ${engine_rule})
endfunction()

# ---- The CMake package ----

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/chaintree")
install(EXPORT chaintreeTargets FILE chaintreeConfig.cmake NAMESPACE chaintree::
    DESTINATION "${package_dir}" ${engine_rule})
# Before 1.0 another minor version may have other calls.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/chaintreeConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/chaintreeConfigVersion.cmake" DESTINATION "${package_dir}" ${engine_rule})

# ---- The file for pkg-config ----

# Paths start from that file, so that the whole folder can be moved.
set(pkgconfig_dir "/${CMAKE_INSTALL_LIBDIR}/pkgconfig")
file(RELATIVE_PATH to_libraries "${pkgconfig_dir}" "/${CMAKE_INSTALL_LIBDIR}")
file(RELATIVE_PATH to_headers "${pkgconfig_dir}" "/${CMAKE_INSTALL_INCLUDEDIR}")
set(math_library " -lm")
if(WIN32)
    set(math_library "")
endif()
configure_file("${CMAKE_CURRENT_LIST_DIR}/chaintree.pc.in" "${PROJECT_BINARY_DIR}/chaintree.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/chaintree.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" ${engine_rule})

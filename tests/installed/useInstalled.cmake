# Installs the libraries in C, moves the folder elsewhere, and builds programs on what is there: examples/engine by the
# CMake package, the same and headers.cpp by pkg-config.
#
# cmake -DBUILD_DIR=... -DSOURCE_DIR=... -DWORK_DIR=... -DVERSION=... -DC_COMPILER=... -DCXX_COMPILER=... -DEMULATOR=...
#     -DOPTIONS="-G...;-D..." -P useInstalled.cmake
# BUILD_DIR is the project's own build; EMULATOR runs programs where they are for another processor.

cmake_minimum_required(VERSION 3.22)

function(run output)
    execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE printed ERROR_VARIABLE complaint RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        string(REPLACE ";" " " command "${ARGN}")
        message(FATAL_ERROR "${command}\nends with ${result}: ${printed}${complaint}")
    endif()
    set(${output} "${printed}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE "${WORK_DIR}")
file(MAKE_DIRECTORY "${WORK_DIR}")
set(installed "${WORK_DIR}/moved")
run(ignored "${CMAKE_COMMAND}" --install "${BUILD_DIR}" --component engine --prefix "${WORK_DIR}/installed")
file(RENAME "${WORK_DIR}/installed" "${installed}")

# What is for OpenMM, or for nobody, is not there.
file(GLOB_RECURSE files RELATIVE "${installed}" "${installed}/*")
set(expected
    "include/chaintree\\.h" "include/ctclosure\\.h" "include/ctdensity\\.h" "include/ctenergy\\.h" "include/ctgrowth\\.h"
    "include/ctlocal\\.h" "include/ctvelocities\\.h"
    "lib[^;]*/(lib)?chaintree\\.(a|lib)" "lib[^;]*/(lib)?ctenergy\\.(a|lib)" "lib[^;]*/(lib)?ctmoves\\.(a|lib)"
    "lib[^;]*/cmake/chaintree/chaintreeConfig(-[a-z]+)?\\.cmake" "lib[^;]*/cmake/chaintree/chaintreeConfigVersion\\.cmake"
    "lib[^;]*/pkgconfig/chaintree\\.pc")
set(rest "${files}")
foreach(pattern IN LISTS expected)
    set(found "${rest}")
    list(FILTER found INCLUDE REGEX "^${pattern}$")
    if(NOT found)
        message(FATAL_ERROR "nothing like ${pattern} is installed, but ${files}")
    endif()
    list(REMOVE_ITEM rest ${found})
endforeach()
if(rest)
    message(FATAL_ERROR "more is installed than one expects: ${rest}")
endif()

# ---- The CMake package ----

set(build "${WORK_DIR}/example")
run(ignored "${CMAKE_COMMAND}" -S "${SOURCE_DIR}/examples/engine" -B "${build}" ${OPTIONS}
    "-DCMAKE_PREFIX_PATH=${installed}" "-DCMAKE_FIND_ROOT_PATH=${installed}" "-DCMAKE_C_COMPILER=${C_COMPILER}")
run(ignored "${CMAKE_COMMAND}" --build "${build}")
run(printed ${EMULATOR} "${build}/collapse")
message(STATUS "by the CMake package:\n${printed}")

string(REGEX MATCH "start: (-?[0-9.]+) kJ/mol, radius of gyration ([0-9.]+) nm" start "${printed}")
set(size_before "${CMAKE_MATCH_2}")
string(REGEX MATCH "end: (-?[0-9.]+) kJ/mol, radius of gyration ([0-9.]+) nm, no clash" end "${printed}")
set(energy_after "${CMAKE_MATCH_1}")
set(size_after "${CMAKE_MATCH_2}")
string(REGEX MATCH "accepted changes: (-?[0-9.]+) kJ/mol" held "${printed}")
set(energy_held "${CMAKE_MATCH_1}")
if(NOT start OR NOT end OR NOT energy_held STREQUAL energy_after OR NOT size_after LESS size_before)
    message(FATAL_ERROR "the chain has not collapsed, or its energy is wrong")
endif()

# ---- pkg-config ----

find_program(PKG_CONFIG NAMES pkg-config pkgconf)
if(NOT PKG_CONFIG OR EMULATOR)
    message(STATUS "pkg-config is not there, or finds another processor's libraries: not tried")
    return()
endif()
file(GLOB_RECURSE pc "${installed}/chaintree.pc")
get_filename_component(pc_dir "${pc}" DIRECTORY)
set(ENV{PKG_CONFIG_PATH} "${pc_dir}")
run(version "${PKG_CONFIG}" --modversion chaintree)
string(STRIP "${version}" version)
if(NOT version STREQUAL VERSION)
    message(FATAL_ERROR "pkg-config says version ${version} and not ${VERSION}")
endif()
run(flags "${PKG_CONFIG}" --cflags --libs chaintree)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(ignored "${C_COMPILER}" -std=c11 "${SOURCE_DIR}/examples/engine/collapse.c" ${flags} -o "${WORK_DIR}/collapse")
run(printed_again "${WORK_DIR}/collapse")
if(NOT printed_again STREQUAL printed)
    message(FATAL_ERROR "built by pkg-config it prints\n${printed_again}")
endif()
run(ignored "${CXX_COMPILER}" "${SOURCE_DIR}/tests/installed/headers.cpp" ${flags} -o "${WORK_DIR}/headers")
run(ignored "${WORK_DIR}/headers")

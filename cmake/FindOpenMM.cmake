#[[
FindOpenMM: the OpenMM to build on.

It is looked for in OPENMM_DIR (cache or environment) alone if that is set; else in the package `openmm` of
Python_EXECUTABLE, if there is one; else in the conda environment, in OpenMM's own default prefix and where CMake looks.

Makes the target OpenMM::OpenMM. Sets OpenMM_VERSION, OpenMM_INCLUDE_DIR, OpenMM_LIBRARY_DIR, and
OpenMM_PYTHON_PACKAGE_DIR (empty if Python has no openmm).
Stops with one sentence if there is no OpenMM, if it is too old, or if its C++ ABI is not that of the compiler.
]]

set(OPENMM_DIR "$ENV{OPENMM_DIR}" CACHE PATH "The folder that holds OpenMM's include and lib; empty: look for it")

# Importing openmm could fail here for reasons that are none of ours, so its version.py is run alone.
unset(OpenMM_PYTHON_PACKAGE_DIR)
unset(_openmm_python_prefix)
if(Python_EXECUTABLE)
    execute_process(
        COMMAND "${Python_EXECUTABLE}" -c "
import importlib.util, os.path, runpy
spec = importlib.util.find_spec('openmm')
if spec and spec.origin:
    package = os.path.dirname(spec.origin)
    version = runpy.run_path(os.path.join(package, 'version.py'))
    print(package, os.path.dirname(version['openmm_library_path']), sep=';', end='')
"
        WORKING_DIRECTORY "${CMAKE_CURRENT_LIST_DIR}"
        OUTPUT_VARIABLE _openmm_python)
    if(_openmm_python)
        list(GET _openmm_python 0 OpenMM_PYTHON_PACKAGE_DIR)
        list(GET _openmm_python 1 _openmm_python_prefix)
    endif()
endif()

if(OPENMM_DIR)
    set(_openmm_places PATHS "${OPENMM_DIR}" NO_DEFAULT_PATH)
else()
    set(_openmm_places HINTS "${_openmm_python_prefix}" "$ENV{CONDA_PREFIX}" PATHS /usr/local/openmm)
endif()

# Nothing found is cached: a changed OPENMM_DIR or environment must count.
unset(OpenMM_INCLUDE_DIR)
unset(OpenMM_LIBRARY)
find_path(OpenMM_INCLUDE_DIR OpenMM.h ${_openmm_places} PATH_SUFFIXES include NO_CACHE)
find_library(OpenMM_LIBRARY OpenMM ${_openmm_places} PATH_SUFFIXES lib NO_CACHE)
if(NOT OpenMM_INCLUDE_DIR OR NOT OpenMM_LIBRARY)
    if(OPENMM_DIR)
        message(FATAL_ERROR "OPENMM_DIR is ${OPENMM_DIR}, but that folder does not hold OpenMM's include and lib.")
    endif()
    message(FATAL_ERROR "OpenMM was not found: install it with `pip install openmm` or `conda install -c conda-forge "
        "openmm`, or set OPENMM_DIR to the folder that holds its include and lib.")
endif()
get_filename_component(OpenMM_LIBRARY_DIR "${OpenMM_LIBRARY}" DIRECTORY)

# One program tells both: it prints the version, and it links only where both sides use the same std::string.
function(_openmm_probe definitions built printed output)
    try_run(ran compiled "${CMAKE_BINARY_DIR}/CMakeFiles/OpenMMProbe" "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/OpenMMProbe.cpp"
        CMAKE_FLAGS
            "-DINCLUDE_DIRECTORIES=${OpenMM_INCLUDE_DIR}"
            "-DCMAKE_BUILD_RPATH=${OpenMM_LIBRARY_DIR}"
        COMPILE_DEFINITIONS ${definitions}
        LINK_LIBRARIES "${OpenMM_LIBRARY}"
        COMPILE_OUTPUT_VARIABLE compileOutput
        RUN_OUTPUT_VARIABLE runOutput)
    set(${built} ${compiled} PARENT_SCOPE)
    set(${printed} "${runOutput}" PARENT_SCOPE)
    set(${output} "${compileOutput}${runOutput}" PARENT_SCOPE)
    unset(ran CACHE)
    unset(compiled CACHE)
endfunction()

set(_openmm_log "${CMAKE_BINARY_DIR}/OpenMMProbe.log")
_openmm_probe("" _openmm_links _openmm_printed _openmm_output)
if(NOT _openmm_links)
    _openmm_probe(-D_GLIBCXX_USE_CXX11_ABI=0 _openmm_links _openmm_printed _openmm_other_output)
    if(_openmm_links)
        message(FATAL_ERROR "OpenMM ${_openmm_printed} in ${OpenMM_LIBRARY_DIR} uses the old C++ string ABI, as its "
            "wheels before 8.4 do: install openmm 8.4 or later.")
    endif()
    file(WRITE "${_openmm_log}" "${_openmm_output}")
    message(FATAL_ERROR "A program cannot be linked with OpenMM in ${OpenMM_LIBRARY_DIR} (see ${_openmm_log}): install "
        "another OpenMM or compiler.")
endif()
if(NOT _openmm_printed MATCHES "^[0-9]+\\.[0-9]+(\\.[0-9]+)?")
    file(WRITE "${_openmm_log}" "${_openmm_output}")
    # The loader's words follow the name of the program.
    string(REGEX REPLACE "^[^\n]*error while loading shared libraries: |\n.*$" "" _openmm_reason "${_openmm_printed}")
    if(_openmm_reason)
        string(APPEND _openmm_reason "; ")
    endif()
    message(FATAL_ERROR "A program linked with OpenMM in ${OpenMM_LIBRARY_DIR} does not run (${_openmm_reason}see "
        "${_openmm_log}): install the library that it lacks, or OpenMM again.")
endif()
set(OpenMM_VERSION "${CMAKE_MATCH_0}")
if(OpenMM_VERSION VERSION_LESS OpenMM_FIND_VERSION)
    message(FATAL_ERROR "OpenMM in ${OpenMM_LIBRARY_DIR} is version ${OpenMM_VERSION}: install openmm "
        "${OpenMM_FIND_VERSION} or later.")
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenMM
    REQUIRED_VARS OpenMM_LIBRARY OpenMM_INCLUDE_DIR
    VERSION_VAR OpenMM_VERSION)

if(OpenMM_FOUND AND NOT TARGET OpenMM::OpenMM)
    add_library(OpenMM::OpenMM SHARED IMPORTED)
    set_target_properties(OpenMM::OpenMM PROPERTIES
        IMPORTED_LOCATION "${OpenMM_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenMM_INCLUDE_DIR}")
endif()

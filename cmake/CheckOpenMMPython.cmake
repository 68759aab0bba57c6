# Stops a build whose Python module would import but then fail for users: OpenMM's module accepts its classes only if SWIG
# wrote both modules with the same runtime, for the same OpenMM.

if(NOT OpenMM_PYTHON_PACKAGE_DIR)
    message(FATAL_ERROR "${Python_EXECUTABLE} has no package openmm: install it (pip install openmm==${OpenMM_VERSION}), "
        "or build without Python by -DCHAINTREE_BUILD_PYTHON=OFF.")
endif()

file(STRINGS "${OpenMM_PYTHON_PACKAGE_DIR}/version.py" python_version REGEX "^short_version")
string(REGEX MATCH "[0-9.]+" python_version "${python_version}")
if(NOT python_version VERSION_EQUAL OpenMM_VERSION)
    message(FATAL_ERROR "OpenMM in ${OpenMM_LIBRARY_DIR} is version ${OpenMM_VERSION}, but the Python package in "
        "${OpenMM_PYTHON_PACKAGE_DIR} is ${python_version}: install the same version of both.")
endif()

file(GLOB openmm_module "${OpenMM_PYTHON_PACKAGE_DIR}/_openmm.*")
file(STRINGS "${openmm_module}" openmm_runtime REGEX "swig_runtime_data[0-9]+")
string(REGEX MATCH "swig_runtime_data([0-9]+)" openmm_runtime "${openmm_runtime}")
set(openmm_runtime "${CMAKE_MATCH_1}")

file(STRINGS "${SWIG_DIR}/swigrun.swg" swig_runtime REGEX "define SWIG_RUNTIME_VERSION")
string(REGEX MATCH "\"([0-9]+)\"" swig_runtime "${swig_runtime}")
set(swig_runtime "${CMAKE_MATCH_1}")

if(NOT openmm_runtime STREQUAL swig_runtime)
    if(openmm_runtime EQUAL 5)
        set(advice "pip install \"swig>=4.4\"")
    else()
        set(advice "install the SWIG that OpenMM's module was made with, or another OpenMM")
    endif()
    message(FATAL_ERROR "SWIG ${SWIG_VERSION} (${SWIG_EXECUTABLE}) writes modules of runtime ${swig_runtime}, but OpenMM "
        "${OpenMM_VERSION} uses runtime ${openmm_runtime}: ${advice}.")
endif()

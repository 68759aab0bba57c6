# A program, or a file of pytest, is one test. A program that returns 77 counts as skipped.

# Approximate seconds of the longest tests. They begin first, so that none runs alone at the end; ctest has no times of its
# own in its first run.
set(CHAINTREE_LONG_TESTS
    test_package=58 test_race=47 test_two_levels=45 test_sample_forcefield=41 test_native_energies=40 test_native_solvent=40
    test_real_structures=38 test_sample_command=38 test_resuming=36 TestTrajectories=35 test_sampling_statistics=33
    test_native_sampling=29 test_native_pairs=29 test_dynamics=28 test_solvent=28 test_random_programs=20 test_examples=21
    test_cluster=21 TestRandomPrograms_clearances=13 TestCrowds_sanitized=20 TestRandomPrograms_portable=13
    TestRandomPrograms_boxes=13 TestRandomPrograms_avx2=13 test_energies=19 test_accuracy=18 test_clashes=17
    TestRandomPrograms=12 test_moving=17 TestRandomPrograms_sanitized=16 test_moves=16
    test_clash_chunks=14 TestEnergyPrograms_sanitized=14 test_native_values=14
    test_clashes_command=13 TestThreads=13 TestCounts_sanitized=13 test_pictures=13 TestRandomLeaves_sanitized=12
    TestStandIn=12 test_outputs=12 test_hard_structures=12 TestScales_sanitized=11 test_damaged_files=11)

# chaintree_label_test(name label ...): labels a test, and limits its time to many times that of the slowest on two busy
# cores, so that only tests that hang exceed it.
function(chaintree_label_test name)
    set(seconds 900)
    if("sanitized" IN_LIST ARGN)
        set(seconds 2700)
    endif()
    if(CMAKE_CROSSCOMPILING)
        math(EXPR seconds "10 * ${seconds}") # an emulator runs them
    endif()
    set_tests_properties(${name} PROPERTIES LABELS "${ARGN}" TIMEOUT ${seconds})
    string(REGEX MATCH "(^|;)${name}=([0-9]+)" cost "${CHAINTREE_LONG_TESTS}")
    if(cost)
        set_tests_properties(${name} PROPERTIES COST ${CMAKE_MATCH_2})
    endif()
endfunction()

# chaintree_add_c_tests(SOURCES ... [WITH source ...] [LIBRARIES lib ...] [ARGUMENTS ...] [SANITIZED_LIBRARIES lib ...]
# [SANITIZED_ARGUMENTS ...] [LABELS ...]): programs on the engine alone, each with the sources after WITH. Each runs as
# it is, and, with the arguments and libraries that are given for that instead, a second time with sanitizers.
function(chaintree_add_c_tests)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" ""
        "SOURCES;WITH;LIBRARIES;ARGUMENTS;SANITIZED_LIBRARIES;SANITIZED_ARGUMENTS;LABELS")
    foreach(list LIBRARIES ARGUMENTS)
        if(NOT arg_SANITIZED_${list})
            set(arg_SANITIZED_${list} ${arg_${list}})
        endif()
    endforeach()
    foreach(source IN LISTS arg_SOURCES)
        get_filename_component(name "${source}" NAME_WE)
        add_executable(${name} ${source} ${arg_WITH})
        target_link_libraries(${name} PRIVATE chaintree ${arg_LIBRARIES})
        _chaintree_add_program_test(${name} ${arg_ARGUMENTS})
        chaintree_label_test(${name} engine ${arg_LABELS})
        if(TARGET chaintree_sanitized)
            add_executable(${name}_sanitized ${source} ${arg_WITH})
            target_compile_options(${name}_sanitized PRIVATE ${CHAINTREE_SANITIZED_LEVEL})
            target_link_libraries(${name}_sanitized PRIVATE chaintree_sanitized ${arg_SANITIZED_LIBRARIES})
            _chaintree_add_program_test(${name}_sanitized ${arg_SANITIZED_ARGUMENTS})
            chaintree_label_test(${name}_sanitized engine sanitized ${arg_LABELS})
        endif()
    endforeach()
endfunction()

# chaintree_add_cxx_tests(source ...): programs on the plugin's libraries.
function(chaintree_add_cxx_tests)
    foreach(source IN LISTS ARGN)
        chaintree_add_cxx_program("${source}")
        get_filename_component(name "${source}" NAME_WE)
        chaintree_add_cxx_test(${name} ${name})
    endforeach()
endfunction()

# chaintree_add_cxx_program(source): a program that is named after its source.
function(chaintree_add_cxx_program source)
    get_filename_component(name "${source}" NAME_WE)
    add_executable(${name} ${source})
    target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}/tests")
    target_link_libraries(${name} PRIVATE OpenMMChainTreeReference)
    # They are compiled more often than they run, and what takes time is in the libraries.
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    _chaintree_set_test_options(${name})
endfunction()

# chaintree_add_cxx_test(name program [argument ...]): a run of such a program.
function(chaintree_add_cxx_test name program)
    add_test(NAME ${name} COMMAND ${program} ${ARGN})
    chaintree_label_test(${name} api)
    # From that folder come the platforms that are plugins of OpenMM, CPU among them.
    set_tests_properties(${name} PROPERTIES
        SKIP_RETURN_CODE 77
        ENVIRONMENT "OPENMM_PLUGIN_DIR=${OpenMM_LIBRARY_DIR}/plugins")
endfunction()

# chaintree_add_python_tests(source ...): files of pytest, run on the package in the build tree.
function(chaintree_add_python_tests)
    foreach(source IN LISTS ARGN)
        get_filename_component(name "${source}" NAME_WE)
        add_test(NAME ${name}
            COMMAND "${Python_EXECUTABLE}" -m pytest -q -rs -p no:cacheprovider "${source}"
            WORKING_DIRECTORY "${PROJECT_BINARY_DIR}")
        chaintree_label_test(${name} python)
        set_tests_properties(${name} PROPERTIES
            SKIP_REGULAR_EXPRESSION "(^|\n)[0-9]+ skipped in "
            ENVIRONMENT "PYTHONPATH=${CHAINTREE_PACKAGE_PARENT_DIR};PYTHONDONTWRITEBYTECODE=1;CHAINTREE_ORACLE=$<TARGET_FILE:chaintree_oracle>")
    endforeach()
endfunction()

function(_chaintree_add_program_test name)
    _chaintree_set_test_options(${name})
    add_test(NAME ${name} COMMAND ${name} ${ARGN})
    set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77)
endfunction()

function(_chaintree_set_test_options name)
    # A test must be able to fail, so its assertions hold in every build.
    target_compile_options(${name} PRIVATE -UNDEBUG)
    if(WIN32)
        target_compile_options(${name} PRIVATE
            "$<$<COMPILE_LANGUAGE:C>:SHELL:-include \"${PROJECT_SOURCE_DIR}/tests/windowsEnvironment.h\">")
    endif()
    chaintree_set_warnings(${name})
endfunction()

# Builds the engine and trajectory.c without and with optimization, by every available compiler. Requires that all programs,
# and the project's own build (which counts as the optimized one in a Release), print the same on every instruction set and
# with each way of testing trials; and that this is the output of other machines (expected.txt), if the C library has the
# same sines and cosines.
#
# cmake -DPROGRAM=... -DSOURCE_DIR=... -DWORK_DIR=... -DCOMPILERS="..." -DOWN="..." -DAVX2=... -DAVX512=... -DEMULATOR=...
#     -P compareTrajectories.cmake
# PROGRAM is the project's own build by the compiler OWN, empty unless it is a Release; AVX2 and AVX512 are the compiler
# options for these instruction sets. EMULATOR runs programs for another processor.

set(engine_dir "${SOURCE_DIR}/platforms/reference/chaintree")
file(GLOB sources "${engine_dir}/src/*.c")
list(APPEND sources
    "${SOURCE_DIR}/tests/trajectory/trajectory.c"
    "${SOURCE_DIR}/tests/hardcases/sceneBuilder.c"
    "${SOURCE_DIR}/tests/oracle/randomScene.c"
    "${SOURCE_DIR}/tests/oracle/randomSource.c")
# These are compiled once for each instruction set.
file(GLOB wide_sources "${engine_dir}/src/wide/*.c")
set(sets PORTABLE)
if(AVX2)
    list(APPEND sets AVX2 AVX512)
endif()

function(run_program program set course output)
    execute_process(
        COMMAND "${CMAKE_COMMAND}" -E env "CHAINTREE_SIMD=${set}" "CHAINTREE_TRIALS=${course}" ${EMULATOR} "${program}"
        OUTPUT_VARIABLE printed RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${program} ends with ${result}: ${printed}")
    endif()
    set(${output} "${printed}" PARENT_SCOPE)
endfunction()

function(compare_program program)
    foreach(set avx512 avx2 portable)
        foreach(course cost tree boxes clearances)
            run_program("${program}" ${set} ${course} printed)
            if(NOT printed STREQUAL expected)
                message(FATAL_ERROR "${program}, ${set}, ${course}:\n${printed}and not\n${expected}")
            endif()
        endforeach()
    endforeach()
    message(STATUS "${program}: the same")
endfunction()

# The project's flags, but for the level.
function(compile_source compiler level source object)
    execute_process(
        COMMAND "${compiler}" -std=c11 -ffp-contract=off -DNDEBUG ${level} ${ARGN}
            "-I${engine_dir}/include" "-I${engine_dir}/../simd" "-I${SOURCE_DIR}/tests" -c "${source}" -o "${object}"
        RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${compiler} ${level} cannot compile ${source}")
    endif()
endfunction()

function(build_program compiler level program)
    get_filename_component(name "${program}" NAME)
    set(objects_dir "${WORK_DIR}/${name}-objects")
    file(MAKE_DIRECTORY "${objects_dir}")
    set(objects "")
    foreach(source IN LISTS sources)
        get_filename_component(stem "${source}" NAME_WE)
        compile_source("${compiler}" ${level} "${source}" "${objects_dir}/${stem}.o")
        list(APPEND objects "${objects_dir}/${stem}.o")
    endforeach()
    foreach(source IN LISTS wide_sources)
        get_filename_component(stem "${source}" NAME_WE)
        foreach(set IN LISTS sets)
            compile_source("${compiler}" ${level} "${source}" "${objects_dir}/${stem}${set}.o" -DCT_PATH_${set} ${${set}})
            list(APPEND objects "${objects_dir}/${stem}${set}.o")
        endforeach()
    endforeach()
    execute_process(COMMAND "${compiler}" ${objects} -lm -o "${program}" RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${compiler} cannot link ${program}")
    endif()
endfunction()

run_program("${PROGRAM}" portable tree expected)
message(STATUS "expected:\n${expected}")
file(READ "${SOURCE_DIR}/tests/trajectory/expected.txt" elsewhere)
string(REGEX MATCH "^[^\n]*" functions "${expected}")
string(REGEX MATCH "^[^\n]*" functions_elsewhere "${elsewhere}")
if(NOT functions STREQUAL functions_elsewhere)
    message(STATUS "this C library rounds sines or cosines in its own way, so the scenes are others")
elseif(NOT expected STREQUAL elsewhere)
    message(FATAL_ERROR "other machines print\n${elsewhere}(an intended change must rewrite expected.txt)")
endif()
compare_program("${PROGRAM}")
foreach(compiler IN LISTS COMPILERS)
    get_filename_component(name "${compiler}" NAME)
    set(levels -O0 -O3)
    if(compiler STREQUAL OWN)
        set(levels -O0)
    endif()
    foreach(level IN LISTS levels)
        set(program "${WORK_DIR}/trajectory-${name}${level}")
        build_program("${compiler}" ${level} "${program}")
        compare_program("${program}")
    endforeach()
endforeach()

# The test `format` and the target `tidy`, over all C and C++ of the project.

set(styled_dirs openmmapi serialization platforms python tests benchmarks examples cmake)
foreach(dir IN LISTS styled_dirs)
    file(GLOB_RECURSE files CONFIGURE_DEPENDS
        "${PROJECT_SOURCE_DIR}/${dir}/*.h" "${PROJECT_SOURCE_DIR}/${dir}/*.c" "${PROJECT_SOURCE_DIR}/${dir}/*.cpp")
    list(APPEND styled_files ${files})
endforeach()

# Every version of clang-format breaks lines in its own way, so only one can be the measure.
set(clang_format_version 14)
find_program(CLANG_FORMAT_EXECUTABLE NAMES clang-format-${clang_format_version} clang-format)
if(CLANG_FORMAT_EXECUTABLE)
    execute_process(COMMAND "${CLANG_FORMAT_EXECUTABLE}" --version OUTPUT_VARIABLE clang_format_output)
endif()
if(CLANG_FORMAT_EXECUTABLE AND clang_format_output MATCHES "version ${clang_format_version}\\.")
    add_custom_target(format COMMAND "${CLANG_FORMAT_EXECUTABLE}" -i ${styled_files} VERBATIM)
    if(CHAINTREE_BUILD_TESTS)
        add_test(NAME format COMMAND "${CLANG_FORMAT_EXECUTABLE}" --dry-run --Werror ${styled_files})
        chaintree_label_test(format style)
    endif()
else()
    message(STATUS "clang-format ${clang_format_version} was not found: the format is not checked")
endif()

find_program(CLANG_TIDY_EXECUTABLE NAMES clang-tidy)
if(CLANG_TIDY_EXECUTABLE)
    set(tidied_files ${styled_files})
    list(FILTER tidied_files INCLUDE REGEX "/src/(wide/)?[^/]*\\.(c|cpp)$")
    add_custom_target(tidy
        COMMAND "${CLANG_TIDY_EXECUTABLE}" --quiet -p "${PROJECT_BINARY_DIR}" ${tidied_files}
        VERBATIM)
endif()

# Compiler settings for each system: gcc, or clang with gcc's options.

if(MSVC AND NOT (CMAKE_C_COMPILER_FRONTEND_VARIANT STREQUAL "GNU" AND CMAKE_CXX_COMPILER_FRONTEND_VARIANT STREQUAL "GNU"))
    message(FATAL_ERROR "On Windows openmm-chaintree needs clang, for its vectors: add -DCMAKE_C_COMPILER=clang "
        "-DCMAKE_CXX_COMPILER=clang++ -G Ninja.")
endif()

# The same seed gives the same trajectory on every machine only if no compiler fuses multiplications and additions. No
# code reads errno after a square root.
add_compile_options(-ffp-contract=off -fno-math-errno)

# Libraries of C programs besides the C library, which includes libm on Windows.
set(CHAINTREE_C_LIBRARIES)
if(NOT WIN32)
    set(CHAINTREE_C_LIBRARIES m)
endif()

if(MSVC)
    # Microsoft's headers define M_PI on request, and warn of functions of standard C.
    add_compile_definitions(_USE_MATH_DEFINES _CRT_SECURE_NO_WARNINGS)
    # __builtin_cpu_supports needs clang's runtime library, which is not linked automatically there.
    execute_process(COMMAND "${CMAKE_C_COMPILER}" --rtlib=compiler-rt -print-libgcc-file-name
        OUTPUT_VARIABLE builtins OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(EXISTS "${builtins}")
        set(CHAINTREE_C_LIBRARIES "${builtins}")
    endif()
endif()

# What the project needs of a compiler on each system: gcc, or clang by its driver for gcc's options.

if(MSVC AND NOT (CMAKE_C_COMPILER_FRONTEND_VARIANT STREQUAL "GNU" AND CMAKE_CXX_COMPILER_FRONTEND_VARIANT STREQUAL "GNU"))
    message(FATAL_ERROR "On Windows openmm-chaintree needs clang, for its vectors: add -DCMAKE_C_COMPILER=clang "
        "-DCMAKE_CXX_COMPILER=clang++ -G Ninja.")
endif()

# The same seed gives the same trajectory on every machine only if no compiler fuses a product into a sum. And nobody
# asks errno whether a square root has gone well.
add_compile_options(-ffp-contract=off -fno-math-errno)

# What programs in C need beside the C library, which on Windows has the functions of libm, too.
set(CHAINTREE_C_LIBRARIES)
if(NOT WIN32)
    set(CHAINTREE_C_LIBRARIES m)
endif()

if(MSVC)
    # Microsoft's headers define M_PI on request, and warn of functions of standard C.
    add_compile_definitions(_USE_MATH_DEFINES _CRT_SECURE_NO_WARNINGS)
    # What __builtin_cpu_supports asks lies in a library of clang's own, which is not linked there by itself.
    execute_process(COMMAND "${CMAKE_C_COMPILER}" --rtlib=compiler-rt -print-libgcc-file-name
        OUTPUT_VARIABLE builtins OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(EXISTS "${builtins}")
        set(CHAINTREE_C_LIBRARIES "${builtins}")
    endif()
endif()

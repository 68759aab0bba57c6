# Cross-compiles with gcc for Linux on 64-bit Arm, and runs programs under qemu (Debian: apt install
# g++-aarch64-linux-gnu qemu-user):
#     cmake -S . -B build/aarch64 -DCMAKE_TOOLCHAIN_FILE=cmake/aarch64-linux-gnu.cmake -DCHAINTREE_ENGINE_ONLY=ON

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

# Where the C library of that system lies, if not at the root.
set(CHAINTREE_AARCH64_LIBRARIES /usr/aarch64-linux-gnu CACHE PATH "The folder that holds aarch64's lib/ld-linux-aarch64.so.1")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CHAINTREE_AARCH64_LIBRARIES)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L "${CHAINTREE_AARCH64_LIBRARIES}")

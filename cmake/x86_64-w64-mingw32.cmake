# Cross-compiles with MinGW-w64's gcc for Windows, and runs programs under wine (Debian: apt install
# g++-mingw-w64-x86-64-posix wine). Only for the engine: OpenMM for Windows uses Microsoft's C++.
#     cmake -S . -B build/windows -DCMAKE_TOOLCHAIN_FILE=cmake/x86_64-w64-mingw32.cmake -DCHAINTREE_ENGINE_ONLY=ON

set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)

set(CMAKE_CROSSCOMPILING_EMULATOR wine)

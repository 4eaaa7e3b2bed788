# Windows x86-64, with clang on the runtime of Debian's mingw-w64; programs run under wine. CROSS_ROOT contains the
# libraries (cross.sh). gcc for this target misaligns vectors that it spills to the stack (gcc bug 54412), so it cannot be used with AVX.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR AMD64)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CROSS_ROOT)

set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_C_COMPILER_TARGET x86_64-w64-mingw32)
set(CMAKE_CXX_COMPILER_TARGET x86_64-w64-mingw32)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
foreach(tool AR RANLIB NM OBJDUMP)
  string(TOLOWER x86_64-w64-mingw32-${tool} program)
  find_program(CMAKE_${tool} ${program} REQUIRED)
endforeach()
set(CMAKE_EXE_LINKER_FLAGS_INIT "-fuse-ld=lld-19 -static")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "-fuse-ld=lld-19 -static")
set(CMAKE_CXX_STANDARD_LIBRARIES -lwinpthread)  # needed by the standard library's threads
# Debian's `wine` prints a request to install 32-bit programs at each start.
find_program(WINE NAMES wine64 wine PATHS /usr/lib/wine REQUIRED)
set(CMAKE_CROSSCOMPILING_EMULATOR ${WINE})

# Search only in CROSS_ROOT: libraries of the build machine do not work on the target.
set(CMAKE_FIND_ROOT_PATH ${CROSS_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

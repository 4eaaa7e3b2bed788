# Windows x86-64, with clang on the runtime of Debian's mingw-w64; programs run under wine. CROSS_ROOT holds the libraries
# (cross.sh). gcc for this target misaligns vectors that it spills to the stack (its bug 54412), so it is none for AVX.
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
set(CMAKE_CXX_STANDARD_LIBRARIES -lwinpthread)  # the standard library's threads stand on it
# Debian's `wine` asks for 32-bit programs to be installed each time.
find_program(WINE NAMES wine64 wine PATHS /usr/lib/wine REQUIRED)
set(CMAKE_CROSSCOMPILING_EMULATOR ${WINE})

# Only what is there: a library of this machine is none of that one.
set(CMAKE_FIND_ROOT_PATH ${CROSS_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

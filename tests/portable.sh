#!/usr/bin/env bash
# Tests the libraries for games with another standard library and without exceptions and RTTI: checks every source with clang
# and libc++, then builds and runs a game in that way. First it runs the self-test of headers_test.py. Installs missing
# packages; everything else is under build/portable.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

deploy/install_packages.sh clang libc++-dev libc++abi-dev
launcher=()
[[ -z ${CCACHE_PROGRAM:-} ]] || launcher=("-DCMAKE_CXX_COMPILER_LAUNCHER=$CCACHE_PROGRAM")
# One instruction set is sufficient and compiles faster. Each source is compiled alone, so that a missing include is an error.
cmake -S tests/portable_consumer -B build/portable -G Ninja "${launcher[@]}" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_UNITY_BUILD=OFF \
  -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
  -DCMAKE_CXX_FLAGS='-stdlib=libc++ -O0 -DHWY_COMPILE_ONLY_STATIC' -DCMAKE_CXX_FLAGS_DEBUG=
tests/headers_test.py --self-test
tests/portable_sources_test.py build/portable
cmake --build build/portable -j "$(nproc)"
ctest --test-dir build/portable --output-on-failure

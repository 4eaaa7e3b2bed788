#!/usr/bin/env bash
# On Debian and Ubuntu, installs the missing packages of the build and the tests with apt. On other systems, lists the packages.
# Does nothing, and needs no rights, if nothing is missing. Arguments: additional packages. The option --programs before them
# leaves out packages that only tests need.
set -euo pipefail
case ${1:-} in
  -h | --help)
    sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "$0"
    exit 0
    ;;
esac

packages=(
  build-essential cmake ninja-build ccache pkg-config git ca-certificates
  libgrpc++-dev libssl-dev protobuf-compiler-grpc protobuf-compiler libprotobuf-dev libabsl-dev
  libhwy-dev libeigen3-dev libsqlite3-dev libcli11-dev libtomlplusplus-dev libspdlog-dev nlohmann-json3-dev libprotozero-dev
  libboost-dev libcurl4-openssl-dev libsystemd-dev libpq-dev prometheus-cpp-dev zlib1g-dev
)
tools=(c++ cmake ninja git protoc grpc_cpp_plugin npm)
# A Node.js that was not installed from a package works too.
command -v npm >/dev/null || packages+=(nodejs npm)
if [ "${1:-}" = --programs ]; then
  shift
else
  packages+=(python3 libgtest-dev libgmock-dev libbenchmark-dev clang-format)
  tools+=(python3 clang-format)
fi
packages+=("$@")

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  missing_tools=()
  for tool in "${tools[@]}"; do
    command -v "$tool" >/dev/null || missing_tools+=("$tool")
  done
  {
    echo "This system has no apt. Install these with its own package manager (Debian's names):"
    printf '  %s\n' "${packages[@]}"
    ((${#missing_tools[@]} == 0)) || echo "Programs not found: ${missing_tools[*]}"
  } >&2
  # The libraries cannot be checked here; CMake names a missing one.
  ((${#missing_tools[@]} == 0)) || exit 1
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
((${#missing[@]} == 0)) && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || {
    echo "Missing packages: ${missing[*]}. This user is not root, and there is no sudo: ask an administrator to run" >&2
    echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  }
  as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}" >&2
apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o Acquire::Retries=5 "$@" >&2; }
# While an archive is being updated, its lists may be inconsistent, or may name packages that do not exist yet.
for wait_s in 10 30 end; do
  apt update && apt install -y --no-install-recommends "${missing[@]}" && break
  [ "$wait_s" != end ] || exit 1
  echo "Trying again in $wait_s s." >&2
  sleep "$wait_s"
done

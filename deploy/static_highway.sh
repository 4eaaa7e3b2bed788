#!/usr/bin/env bash
# Builds Highway as the static library libhwy.a, which the archive and the plug-in of the C ABI contain. Debian and Ubuntu do not
# ship it. Does nothing if the library exists.
#
#   deploy/static_highway.sh                    build/highway/libhwy.a, where CMake looks, from the source of apt's package
#   deploy/static_highway.sh FOLDER [SOURCE]    FOLDER/libhwy.a, from the source of the installed version in folder SOURCE
#
# For another place, pass -DSWEEPSTAKE_STATIC_HIGHWAY=FOLDER/libhwy.a to CMake. The source stays in FOLDER/source.
set -euo pipefail
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=deploy/private_apt.sh
source "$repository/deploy/private_apt.sh"

if [[ ${1:-} == --help || $# -gt 2 ]]; then
  sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
  (($# <= 2)) && exit 0 || exit 2
fi
folder=${1:-$repository/build/highway}
[[ ! -f $folder/libhwy.a ]] || exit 0
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

download_source() {
  rm -rf "$folder/source" "$folder/apt" "$folder/download"
  mkdir -p "$folder/download"
  (cd "$folder/download" && start_private_apt "$folder/apt" deb-src &&
    private_apt "$folder/apt" source --download-only highway &&
    dpkg-source --no-copy -x highway_*.dsc "$folder/source") || return
  rm -rf "$folder/apt" "$folder/download"
}

build() {
  cmake -S "$1" -B "$folder/build" -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF -DBUILD_TESTING=OFF \
    -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_CXX_VISIBILITY_PRESET=hidden \
    -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_EXAMPLES=OFF &&
    cmake --build "$folder/build" --target hwy
}

log=$folder/log.txt
source=${2:-$folder/source}
{ [[ -n ${2:-} ]] || download_source; } >"$log" 2>&1 && build "$source" >>"$log" 2>&1 || {
  tail -n 20 "$log" >&2
  echo "Could not build a static Highway (full log: $log). Pass the folder of its source: $0 FOLDER SOURCE" >&2
  exit 1
}
mv "$folder/build/libhwy.a" "$folder/"
rm -rf "$folder/build"

#!/usr/bin/env bash
# Builds the native library of the Unity package for this machine, and installs it with the .meta that selects its platform.
#
#   unity_client/tools/build_plugin.sh          into Runtime/Plugins of the package in this checkout
#   unity_client/tools/build_plugin.sh FOLDER   into FOLDER/PLATFORM, for a project whose package is read-only: its Assets/Plugins
#
# Linux: Debian 12, Ubuntu 24.04 and newer; missing packages are installed with apt, as root or with sudo. On Windows, take a
# release; tests/cross.sh builds the library for Windows on Linux. Documentation~/native-library.md has the other platforms.
set -euo pipefail
[[ ${1:-} == --help || $# -gt 1 ]] && { sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit $(($# > 1 ? 2 : 0)); }
into=${1:+$(mkdir -p "$1" && cd "$1" && pwd)}
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
package=unity_client/com.sweepstake.broadphase

[[ $(uname -s) == Linux ]] || { echo "This builds the library on Linux only; native-library.md in $package/Documentation~ describes other systems." >&2; exit 1; }
deploy/install_packages.sh --programs
deploy/static_highway.sh
cmake --workflow --preset plugin
if [[ -z $into ]]; then
  cmake --install build/plugin --component plugin --strip --prefix "$package"
else
  staged=$(mktemp -d)
  trap 'rm -rf "$staged"' EXIT
  cmake --install build/plugin --component plugin --strip --prefix "$staged"
  cp -r "$staged"/Runtime/Plugins/. "$into"
fi

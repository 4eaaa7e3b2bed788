#!/usr/bin/env bash
# Builds the C# of the Unity package outside Unity and runs its tests, with the plug-in and the daemon of a build folder.
#
#   tests/unity_client/dotnet_test.sh build/dev                       all tests
#   tests/unity_client/dotnet_test.sh build/dev --filter Name~Reload  arguments after the folder go to `dotnet test`
#
# Exit status: 0 all is well, 1 something failed, 77 nothing could be run, and why: the .NET SDK is missing, or its packages.
set -euo pipefail
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
projects=$repository/unity_client/dotnet

if [[ ${1:-} == --help || $# -lt 1 ]]; then
  sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
  [[ ${1:-} == --help ]] && exit 0 || exit 2
fi
build=$(cd "$1" && pwd)
shift

left_out() {
  printf '\n******** LEFT OUT: %s ********\n\n' "$1"
  exit 77
}

command -v dotnet >/dev/null || left_out "the C# tests of the Unity package. The .NET SDK 10 is missing: install the package \
dotnet-sdk-10.0 of Microsoft's repository for this system, or unpack the SDK and put its folder into PATH"
[[ $(dotnet --version) =~ ^([0-9]+)\. && ${BASH_REMATCH[1]} -ge 10 ]] ||
  left_out "the C# tests of the Unity package. They need the .NET SDK 10, and this is $(dotnet --version)"

# The daemon takes each SWEEPSTAKE_… of the environment for a setting.
export UNITY_CLIENT_BUILD=$build LD_LIBRARY_PATH=$build/plugin${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
settings=(--configuration Release --nologo -p:BuildFolder="$build/dotnet/" -nodeReuse:false)

tests=(core_tests daemon_tests)
for project in "${tests[@]}"; do
  dotnet restore "$projects/$project" -p:BuildFolder="$build/dotnet/" -nodeReuse:false --verbosity quiet ||
    left_out "the C# tests of the Unity package ($project). NuGet could not restore the packages that unity_client/dotnet names; \
add a source that has them to your NuGet configuration"
done

python3 "$repository/unity_client/tools/make_protocol.py" "$repository" --check
for project in "${tests[@]}"; do dotnet build "$projects/$project" --no-restore --verbosity quiet "${settings[@]}"; done
for project in "${tests[@]}"; do dotnet test "$projects/$project" --no-build --no-restore --verbosity quiet "${settings[@]}" "$@"; done

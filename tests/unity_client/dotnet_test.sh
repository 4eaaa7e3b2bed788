#!/usr/bin/env bash
# Builds the C# of the Unity package outside Unity and runs its tests, with the plug-in and the daemon of a build folder.
#
#   tests/unity_client/dotnet_test.sh build/dev                       all tests
#   tests/unity_client/dotnet_test.sh build/dev --filter Name~Reload  arguments after the folder go to `dotnet test`
#
# Exit status: 0 all tests passed, 1 a test failed, 77 some or all tests were skipped; the last line says which and why.
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

# The name must not begin with SWEEPSTAKE_: the daemon reads such variables as settings.
export UNITY_CLIENT_BUILD=$build LD_LIBRARY_PATH=$build/plugin${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
settings=(--configuration Release --nologo -p:BuildFolder="$build/dotnet/" -nodeReuse:false)

restore() { dotnet restore "$projects/$1" -p:BuildFolder="$build/dotnet/" -nodeReuse:false --verbosity quiet; }
run() {
  dotnet build "$projects/$1" --no-restore --verbosity quiet "${settings[@]}"
  dotnet test "$projects/$1" --no-build --no-restore --verbosity quiet --logger "console;verbosity=minimal" "${settings[@]}" "${@:2}"
}
readonly advice="NuGet could not restore the packages that unity_client/dotnet needs; add a source with them to your NuGet configuration"

restore core_tests || left_out "the C# tests of the Unity package. $advice"
run core_tests "$@"
compile_as_unity() { python3 "$repository/tests/unity_client/compile_test.py" "$repository" "$build"; }

restore api_list
python3 "$repository/tests/unity_client/stubs_test.py" "$repository" "$build"

if ! restore daemon_tests || ! restore unity_tests || ! restore facts; then
  compile_as_unity
  left_out "the C# tests of the Unity package that need gRPC, including those of its components; the tests of its core have passed. $advice"
fi
python3 "$repository/unity_client/tools/make_protocol.py" "$repository" --check
native=$build/dotnet/native
if dotnet publish "$projects/headless" --configuration Release --nologo -r "linux-$(uname -m | sed s/x86_64/x64/\;s/aarch64/arm64/)" -p:Native=true \
  -p:BuildFolder="$native/" -nodeReuse:false --verbosity quiet --output "$native/program"; then
  export UNITY_CLIENT_NATIVE=$native/program/Sweepstake.Headless
else
  printf '\n******** LEFT OUT: %s ********\n\n' "the native headless game. It needs clang and the package Microsoft.DotNet.ILCompiler"
fi
run daemon_tests "$@"
run unity_tests "$@"
python3 "$repository/tests/unity_client/outside_names_test.py" "$repository"
compile_as_unity

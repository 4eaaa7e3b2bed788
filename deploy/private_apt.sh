# Sourced by scripts that download packages without changing the machine's package manager: apt-get with its own sources, lists
# and cache.

# Prints "URI SUITE COMPONENT" of the archive that provides Highway on this machine. If the package lists were deleted to save
# space, apt's configuration still names the archive.
archive_of_highway() {
  local found
  found=$(apt-cache policy libhwy-dev | awk '$1 ~ /^[0-9]+$/ && $2 ~ /:\// { sub("/", " ", $3); print $2, $3; exit }')
  [[ -n $found ]] || found=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    awk -v suite="$(. /etc/os-release && echo "${VERSION_CODENAME:-}")" '$2 == suite && $3 ~ /^(main|universe)/ { print; exit }')
  [[ -n $found ]] || {
    echo "apt has no archive of this release in its sources (/etc/apt): add one to download the libraries." >&2
    return 1
  }
  echo "$found"
}

# private_apt STATE APT_GET_ARGUMENTS...: apt-get for arm64 and for sources; STATE is its folder, absolute.
private_apt() {
  local state=$1
  shift
  apt-get -q -o Acquire::Retries=5 -o APT::Architectures=arm64 -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none \
    -o Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false -o Dir::Etc::SourceList="$state/sources.list" \
    -o Dir::Etc::SourceParts=/dev/null -o Dir::State="$state" -o Dir::State::Lists="$state/lists" \
    -o Dir::State::Status=/dev/null -o Dir::Cache="$state/cache" "$@"
}

# start_private_apt STATE KIND...: creates the folder and downloads the archive's lists of these kinds (deb, deb-src).
start_private_apt() {
  local state=$1 keys=/usr/share/keyrings/debian-archive-keyring.gpg archive
  shift
  local options=arch=arm64
  [[ ! -f $keys ]] || options+=" signed-by=$keys"
  archive=$(archive_of_highway) || return
  mkdir -p "$state/lists/partial" "$state/cache/archives/partial" &&
    printf "%s [$options] $archive\n" "$@" >"$state/sources.list" &&
    private_apt "$state" update
}

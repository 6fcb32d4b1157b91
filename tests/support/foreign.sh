# Sourced: Debian's packages of other suites and processors, checked by apt, without a change to this system's lists.

# get_package SUITE deb|deb-src FOLDER PACKAGE...: the packages' files, or those of their source, lie in FOLDER. NAME:arm64 is
# one for another processor; then all of them have to be.
get_package() {
  local suite=$1 kind=$2 folder=$3 options words architecture=
  shift 3
  case $1 in *:*) architecture=${1##*:} ;; esac
  mkdir -p "$folder/lists/partial"
  echo "$kind [${architecture:+arch=$architecture }signed-by=/usr/share/keyrings/debian-archive-keyring.gpg]" \
    "http://deb.debian.org/debian $suite main" >"$folder/sources.list"
  options=(-q -o Dir::Etc::sourcelist="$folder/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o Dir::State::lists="$folder/lists" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=
    ${architecture:+-o APT::Architectures::=$architecture})
  words=(download)
  [ "$kind" = deb ] || words=(source --download-only)
  (cd "$folder" && apt-get "${options[@]}" update && apt-get "${options[@]}" "${words[@]}" "$@") >"$folder/log" 2>&1 ||
    fail "apt-get could not get $* of $suite; all of its output is in $folder/log."
}

# Sourced: Debian's packages of other suites, checked by apt, without a change to this system's lists.

# get_package SUITE deb|deb-src PACKAGE FOLDER: the package's file, or those of its source, lie in FOLDER.
get_package() {
  local suite=$1 kind=$2 package=$3 folder=$4 options words
  mkdir -p "$folder/lists/partial"
  echo "$kind [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian $suite main" \
    >"$folder/sources.list"
  options=(-q -o Dir::Etc::sourcelist="$folder/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o Dir::State::lists="$folder/lists" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=)
  words=(download)
  [ "$kind" = deb ] || words=(source --download-only)
  (cd "$folder" && apt-get "${options[@]}" update && apt-get "${options[@]}" "${words[@]}" "$package") >"$folder/log" 2>&1 ||
    fail "apt-get could not get $package of $suite; all of its output is in $folder/log."
}

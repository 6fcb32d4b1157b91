# Sourced by fuzz.sh and sanitize.sh, after setup.sh: builds with Clang, whose sanitizers and libFuzzer Debian has beside it.

CLANG_PACKAGES=(clang libclang-rt-14-dev llvm)

# build_with_clang FOLDER FLAGS "TARGET..." OPTION...: RelWithDebInfo with these flags; ccache where there is one.
build_with_clang() {
  local folder=$1 flags=$2 targets=$3 log=$1/build.log launcher=() start=$SECONDS
  shift 3
  mkdir -p "$folder"
  ! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  echo "Building $targets in ${folder#"$root"/}"
  # shellcheck disable=SC2086 # several targets
  if ! { cmake -S "$root" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=$flags" \
    "-DCMAKE_C_FLAGS_RELWITHDEBINFO=$flags" \
    -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ "${launcher[@]}" "$@" &&
    cmake --build "$folder" --target $targets; } >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    fail "The build failed; all of its output is in $log."
  fi
  echo "built in $((SECONDS - start)) s"
}

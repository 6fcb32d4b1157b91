#!/usr/bin/env bash
# Tests under a sanitizer; nothing but what is found is new, and what is found fails.
#   bash tests/sanitize.sh address [filter]   AddressSanitizer and UndefinedBehaviorSanitizer: all tests, or those of a gtest filter
#   bash tests/sanitize.sh thread [filter]    ThreadSanitizer: by default the tests with threads of their own
#   bash tests/sanitize.sh valgrind [filter]  Memcheck: by default one way through the OpenGL path
#   bash tests/sanitize.sh python [files]     ThreadSanitizer in Blender's Python module: by default the add-on's tests with threads
# What Mesa does is left out by the files in tests/sanitizers, which say why.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/sanitizers/build.sh"

kind=${1:-} filter=${2:-}
folder=$root/build/sanitize-$kind lists=$root/tests/sanitizers
case $kind in
address)
  packages=("${CLANG_PACKAGES[@]}") flags="-O1 -gline-tables-only" option=-DPARADESC_SANITIZE=address
  export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1
  export LSAN_OPTIONS=suppressions=$lists/leaks.txt:print_suppressions=0
  ;;
thread)
  packages=("${CLANG_PACKAGES[@]}") flags="-O1 -gline-tables-only" option=-DPARADESC_SANITIZE=thread
  : "${filter:=*Threads*:*GlThread*:*cancel*:DriverFailures.meshes_are_made_while*}"
  export TSAN_OPTIONS=suppressions=$lists/threads.txt:ignore_noninstrumented_modules=1:second_deadlock_stack=1
  ;;
valgrind)
  packages=(clang valgrind) flags="-O1 -gdwarf-4" option=-DPARADESC_SANITIZE= # Valgrind 3.19 does not read the fifth version
  : "${filter:=Threads.calls_on_one_context_take_turns/software}"
  ;;
python) ;;
*) fail "usage: bash tests/sanitize.sh address|thread|valgrind|python [filter]" ;;
esac

# Built by GCC, whose runtime Python can start with (Clang 14's crashes when it is preloaded), beside a copy of the add-on and its tests,
# since the add-on opens no library but the one in its own folder.
if [ "$kind" = python ]; then
  python=${PARADESC_PYTHON:-$python}
  if [ "$python" = "$root/.venv/bin/python" ]; then
    install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}"
    make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}"
  fi
  mkdir -p "$folder/tests"
  { cmake -S "$root" -B "$folder" -G Ninja -DCMAKE_CXX_COMPILER=g++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1" -DPARADESC_SANITIZE=thread -DPARADESC_TESTS=OFF &&
    cmake --build "$folder" --target paradesc; } >"$folder/build.log" 2>&1 ||
    fail "The build failed; all of its output is in $folder/build.log."
  rm -rf "$folder/addon" "$folder/tests/addon"
  ln -sfn "$root/native" "$folder/native" # a test reads sources
  cp -r "$root/addon" "$folder/addon"
  cp -r "$root/tests/addon" "$folder/tests/addon"
  mkdir -p "$folder/addon/paradesc/lib"
  cp "$folder/libparadesc.so" "$folder/addon/paradesc/lib/"
  files=${filter:-threads_test.py contexts_test.py cancel_test.py}
  rm -f "$folder"/found.*
  # shellcheck disable=SC2086 # several files; numpy's own threads are not what is looked at
  cd "$folder/tests/addon" && PYTHONPATH=$folder/addon LD_PRELOAD=$(g++ -print-file-name=libtsan.so) OPENBLAS_NUM_THREADS=1 \
    TSAN_OPTIONS=suppressions=$lists/threads.txt:ignore_noninstrumented_modules=1:second_deadlock_stack=1:log_path=$folder/found \
    "$python" -m pytest -q -p no:cacheprovider --rootdir "$folder/tests" -c /dev/null -o "python_files=*_test.py" $files
  status=$?
  cat "$folder"/found.* 2>/dev/null && status=1
  [ $status -eq 0 ] && echo "Nothing found."
  exit $status
fi

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${packages[@]}"
build_with_clang "$folder" "$flags" paradesc_tests "$option"
command=("$folder/paradesc_tests" "--gtest_filter=${filter:-*}" --gtest_brief=1)
if [ "$kind" = valgrind ]; then
  # The code that llvmpipe compiles is not in a file; rasterizing in one thread is enough for one way.
  LP_NUM_THREADS=0 valgrind --quiet --error-exitcode=9 --smc-check=all-non-file --suppressions="$lists/valgrind.supp" \
    --leak-check=full --errors-for-leak-kinds=definite --num-callers=30 "${command[@]}"
else
  "${command[@]}"
fi
status=$?
[ $status -eq 0 ] && echo "Nothing found."
exit $status

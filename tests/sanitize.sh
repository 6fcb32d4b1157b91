#!/usr/bin/env bash
# The native tests under a sanitizer, built by Clang; nothing but what is found is new, and what is found fails.
#   bash tests/sanitize.sh address [filter]   AddressSanitizer and UndefinedBehaviorSanitizer: all tests, or those of a gtest filter
#   bash tests/sanitize.sh thread [filter]    ThreadSanitizer: by default the tests with threads of their own
#   bash tests/sanitize.sh valgrind [filter]  Memcheck: by default one way through the OpenGL path
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
  : "${filter:=*Threads*:*GlThread*:*cancel*}"
  export TSAN_OPTIONS=suppressions=$lists/threads.txt:ignore_noninstrumented_modules=1:second_deadlock_stack=1
  ;;
valgrind)
  packages=(clang valgrind) flags="-O1 -gdwarf-4" option=-DPARADESC_SANITIZE= # Valgrind 3.19 does not read the fifth version
  : "${filter:=Threads.calls_on_one_context_take_turns/software}"
  ;;
*) fail "usage: bash tests/sanitize.sh address|thread|valgrind [filter]" ;;
esac

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

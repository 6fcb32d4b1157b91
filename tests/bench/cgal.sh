#!/usr/bin/env bash
# Lays CGAL 6's headers into build/cgal, from Debian 13's package, with which run.py builds the program that it compares with.
#   bash tests/bench/cgal.sh
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../blend_samples/setup.sh"
source "$root/tests/support/foreign.sh"

folder=$root/build/cgal
install_packages libboost-dev libeigen3-dev
get_package trixie deb "$folder" libcgal-dev
dpkg -x "$folder"/libcgal-dev_*.deb "$folder"
echo "CGAL's headers lie in $folder/usr/include; now: cmake -S . -B build -DPARADESC_BENCHMARKS=ON"

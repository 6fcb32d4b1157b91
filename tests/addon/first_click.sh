#!/usr/bin/env bash
# Does what somebody does who has just installed the add-on, by the picture of the panel that the manual shows: one click, a grey mask.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
output=$(bash "$root/addon/manual/pictures/make.sh" "$root/build/pictures" panel 2>&1)
grep '^panel: ' <<<"$output" || { printf '%s\n' "$output" | tail -n 20; exit 1; }

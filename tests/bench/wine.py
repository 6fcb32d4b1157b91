"""Times the Windows library under Wine against the Linux one of the same release, in turns.

bash tests/release.sh && python tests/bench/wine.py [--turns 5] [--threads N] [--json FILE]

Each turn runs tests/packages/frame_times.c with both libraries in build/release: the fastest of a dozen frames, mean
curvature on a torus of 70,000 triangles. The ratio is that of the fastest turns.
"""

import argparse
import json
import os
import subprocess
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RELEASE = ROOT / "build" / "release"
LINUX, WINDOWS = RELEASE / "linux-x64", RELEASE / "windows-x64"
WINE = next((path for path in map(Path, ("/usr/lib/wine/wine64", "/usr/bin/wine64")) if path.is_file()), None)


def commands(threads: int) -> dict[str, list[str]]:
    """The words that print a library's milliseconds, by system."""
    windows_path = "Z:" + str(WINDOWS / "paradesc.dll").replace("/", "\\")
    return {
        "linux": [str(LINUX / "frame_times"), str(LINUX / "libparadesc.so"), str(threads)],
        "wine": [str(WINE), str(WINDOWS / "frame_times.exe"), windows_path, str(threads)],
    }


def milliseconds(words: list[str]) -> float:
    """The times that one run prints."""
    environment = {**os.environ, "WINEPREFIX": str(RELEASE / "wine"), "WINEDEBUG": "-all"}
    environment["WINEDLLOVERRIDES"] = "mscoree=;mshtml="
    return float(subprocess.run(words, env=environment, capture_output=True, text=True, check=True).stdout.split()[-1])


def main() -> int:
    """Prints every turn and the ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--threads", type=int, default=0, help="0: all cores")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    if WINE is None or not (WINDOWS / "frame_times.exe").is_file():
        parser.error("Wine or the release libraries are missing: bash tests/release.sh installs and builds them")
    words = commands(arguments.threads)
    taken: dict[str, list[float]] = {name: [] for name in words}
    for turn in range(arguments.turns):
        for name, command in words.items():
            taken[name].append(milliseconds(command))
        said = ", ".join(f"{name} {times[-1]:.1f} ms" for name, times in taken.items())
        sys.stdout.write(f"turn {turn + 1}: {said}\n")
    ratio = min(taken["wine"]) / min(taken["linux"])
    sys.stdout.write(f"Wine over Linux: {ratio:.2f}\n")
    if arguments.json:
        found = {"date": str(date.today()), "threads": arguments.threads, "milliseconds": taken}
        arguments.json.write_text(json.dumps(found | {"wine_over_linux": ratio}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())

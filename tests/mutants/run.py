"""Makes single mutations of the code, each a bug that a careless change would bring, and finds which tests notice.

Usage: run.py [--list] [--check] [--only NAMES] [--rest] [--jobs N] [--page]
Works in copies of the tree under build/mutants. Ends with 1 if a mutation survives, or cannot be applied or built.
"""

import argparse
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from queue import Queue

import tomllib

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "mutants"
RESULTS = BUILD / "results.json"
PAGE = ROOT / "tests" / "RELIABILITY.md"
BEGIN, END = "<!-- mutants: begin -->", "<!-- mutants: end -->"
ENDINGS = {".cpp", ".h", ".c", ".def", ".glsl", ".py"}
PATIENCE = 600  # seconds; a mutation that makes tests hang is noticed, too
NATIVE = re.compile(r"^\[\s+(OK|FAILED|SKIPPED|RUN)\s+\] (\S+\.[^\s,]+)", re.MULTILINE)
ADDON = re.compile(r"^(\S+::.+?) (PASSED|FAILED|ERROR|SKIPPED)", re.MULTILINE)
GOOD = ("noticed", "equivalent")


@dataclass(frozen=True)
class Mutant:
    """One mutation and the tests that should notice it."""

    name: str
    folder: str  # in which exactly one file contains the old text, once
    old: str
    new: str
    native: str = ""  # a filter of GoogleTest
    addon: str = ""  # words of pytest after tests/addon, files first
    equivalent: str = ""  # why no test can notice it

    @property
    def pattern(self) -> re.Pattern[str]:
        """The old text, however its lines are broken."""
        return re.compile(r"\s+".join(map(re.escape, self.old.split())))


@dataclass
class Outcome:
    """The outcome of one mutation."""

    name: str
    result: str  # noticed, survived, equivalent, does not apply, does not build, no test ran
    by: str = ""
    file: str = ""
    seconds: float = 0.0


def read_mutants() -> list[Mutant]:
    """The list."""
    found = []
    for path in sorted(Path(__file__).parent.glob("*.toml")):
        found += [Mutant(**row) for row in tomllib.loads(path.read_text())["mutant"]]
    names = [item.name for item in found]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise SystemExit(f"Two mutations have one name: {sorted(twice)}.")
    return found


def place(tree: Path, mutant: Mutant) -> tuple[Path | None, str]:
    """The one file with the old text, else None and the reason: also where a file of Python cannot be compiled then."""
    hits: list[tuple[Path, int]] = []
    base = tree / mutant.folder
    for path in [base] if base.is_file() else sorted(base.rglob("*")):
        if path.suffix in ENDINGS and path.is_file():
            count = len(mutant.pattern.findall(path.read_text()))
            hits += [(path, count)] * bool(count)
    total = sum(count for _, count in hits)
    if total != 1:
        where = ", ".join(str(path.relative_to(tree)) for path, _ in hits)
        return None, f"the old text is there {total} times{': ' if where else ''}{where}"
    path = hits[0][0]
    if path.suffix == ".py":
        try:
            compile(mutant.pattern.sub(lambda _: mutant.new, path.read_text()), path, "exec")
        except SyntaxError as error:
            return None, f"{path.relative_to(tree)}: {error.msg}"
    return path, ""


def source_files() -> list[Path]:
    """The files that git knows or would add, relative to the root."""
    words = ["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard", "-z"]
    listed = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    return [Path(name) for name in listed.split("\0") if name and (ROOT / name).is_file()]


class Tree:
    """A copy of the tree that is built and tested."""

    def __init__(self, number: int, python: str) -> None:
        self.path = BUILD / f"tree{number}"
        self.python = python
        self.failing: set[str] = set()  # tests that fail before any mutation
        self.synchronize()
        shared = ROOT.parent / "shared"
        if shared.is_dir() and not (BUILD / "shared").exists():
            (BUILD / "shared").symlink_to(shared)

    def synchronize(self) -> None:
        """Makes the copy like the tree; files that are the same stay untouched, and are not built again."""
        names = set(source_files())
        for name in names:
            target, content = self.path / name, (ROOT / name).read_bytes()
            if not target.is_file() or target.read_bytes() != content:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
                shutil.copymode(ROOT / name, target)
        for top in ("native", "shaders", "tests", "addon"):
            for path in (self.path / top).rglob("*"):
                name = path.relative_to(self.path)
                if path.suffix in ENDINGS and path.is_file() and name not in names:
                    path.unlink()

    def build(self, target: str) -> str:
        """Builds a target; gives the last lines of an error, or ""."""
        folder, kind = self.path / "build", ["-DCMAKE_BUILD_TYPE=Release"]
        if shutil.which("ccache"):
            kind.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
        if not (folder / "build.ninja").is_file():
            ended = run(["cmake", "-S", self.path, "-B", folder, "-G", "Ninja", *kind], self.path)
            if ended.returncode:
                return ended.stdout[-2000:]
        ended = run(["cmake", "--build", folder, "--target", target], self.path)
        return ended.stdout[-2000:] if ended.returncode else ""

    def test(self, native: str, addon: str, first_only: bool) -> tuple[set[str], int, str]:
        """Runs tests; gives those that failed, how many ran, and the end of what they printed."""
        return self.native(native, first_only) if native else self.addon(addon, first_only)

    def native(self, names: str, first_only: bool) -> tuple[set[str], int, str]:
        """Runs GoogleTest."""
        left_out = ":".join(name for name in sorted(self.failing) if "::" not in name)
        words = [self.path / "build" / "paradesc_tests", f"--gtest_filter={names}{'-' * bool(left_out)}{left_out}"]
        ended = run([*words, *["--gtest_fail_fast"] * first_only], self.path)
        told = NATIVE.findall(ended.stdout)
        failed = {name for word, name in told if word == "FAILED"}
        if ended.returncode and not failed:  # it crashed, or hung
            failed = {name for word, name in told[-1:]} or {"the program"}
        return failed, sum(word in ("OK", "FAILED") for word, _ in told), ended.stdout[-1500:]

    def addon(self, words: str, first_only: bool) -> tuple[set[str], int, str]:
        """Runs pytest."""
        given = [f"tests/addon/{word}" if ".py" in word else word for word in shlex.split(words)]
        left_out = [f"--deselect={name}" for name in sorted(self.failing) if "::" in name]
        command = [self.python, "-m", "pytest", "-v", "--tb=no", "-p", "no:cacheprovider", *["-x"] * first_only]
        ended = run([*command, *left_out, *given], self.path, {"PYTHONPATH": str(self.path / "addon")})
        told = ADDON.findall(ended.stdout)
        failed = {name for name, word in told if word in ("FAILED", "ERROR")}
        if ended.returncode not in (0, 5) and not failed:  # it crashed, hung, or could not be imported
            failed = {"the program"}
        return failed, sum(word != "SKIPPED" for _, word in told) + ("the program" in failed), ended.stdout[-1500:]


def run(words: list[object], folder: Path, more: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Runs a process and joins its outputs; one that hangs ends with 124."""
    try:
        return subprocess.run(
            list(map(str, words)),
            cwd=folder,
            env={**os.environ, **(more or {})},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            errors="replace",
            timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired as error:
        said = error.stdout if isinstance(error.stdout, bytes) else b""
        return subprocess.CompletedProcess(words, 124, said.decode(errors="replace"))


def build_all(tree: Tree) -> None:
    """Builds the copy without a mutation."""
    for target in ("paradesc", "paradesc_tests"):
        trouble = tree.build(target)
        if trouble:
            raise SystemExit(f"{target} does not build:\n{trouble}")


def baseline(tree: Tree, mutants: list[Mutant]) -> set[str]:
    """The tests of these suites that fail without a mutation, and so cannot notice anything."""
    failing: set[str] = set()
    native = sorted({item.native for item in mutants if item.native})
    if native:
        failing |= tree.native(":".join(native), False)[0]
    for words in sorted({item.addon for item in mutants if item.addon}):
        failing |= tree.addon(words, False)[0]
    return failing


def try_one(tree: Tree, mutant: Mutant) -> Outcome:
    """Applies a mutation, builds, runs its tests, takes it back."""
    start = time.perf_counter()
    if mutant.equivalent:
        return Outcome(mutant.name, "equivalent", mutant.equivalent)
    path, trouble = place(tree.path, mutant)
    if path is None:
        return Outcome(mutant.name, "does not apply", trouble)
    text, name = path.read_text(), str(path.relative_to(tree.path))
    try:
        path.write_text(mutant.pattern.sub(lambda _: mutant.new, text))
        trouble = tree.build("paradesc_tests" if mutant.native else "paradesc")
        if trouble:
            return Outcome(mutant.name, "does not build", trouble.strip().splitlines()[-1], name)
        failed, count, said = tree.test(mutant.native, mutant.addon, True)
    finally:
        path.write_text(text)
    seconds = round(time.perf_counter() - start, 1)
    if failed:
        return Outcome(mutant.name, "noticed", sorted(failed)[0], name, seconds)
    if not count:
        return Outcome(mutant.name, "no test ran", said.strip()[-200:], name, seconds)
    return Outcome(mutant.name, "survived", mutant.native or mutant.addon, name, seconds)


def kept_results() -> dict[str, Outcome]:
    """The results of earlier runs."""
    if not RESULTS.is_file():
        return {}
    return {row["name"]: Outcome(**row) for row in json.loads(RESULTS.read_text())}


def keep(results: dict[str, Outcome]) -> None:
    """Keeps the results for the page, and for --rest."""
    RESULTS.write_text(json.dumps([asdict(item) for item in results.values()], indent=1))


def try_all(mutants: list[Mutant], jobs: int, python: str) -> dict[str, Outcome]:
    """Tries all these mutations, with a copy of the tree for each job."""
    trees: Queue[Tree] = Queue()
    made = [Tree(number, python) for number in range(jobs)]
    for tree in made:
        build_all(tree)
    failing = baseline(made[0], mutants)
    if failing:
        sys.stdout.write(f"failing without a mutation, left out: {', '.join(sorted(failing))}\n")
    for tree in made:
        tree.failing = failing
        trees.put(tree)
    results = kept_results()

    def work(mutant: Mutant) -> None:
        tree = trees.get()
        try:
            outcome = try_one(tree, mutant)
        finally:
            trees.put(tree)
        results[mutant.name] = outcome
        keep(results)
        sys.stdout.write(f"{outcome.result:15s} {mutant.name:52s} {outcome.seconds:6.1f} s  {outcome.by}\n")
        sys.stdout.flush()

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(work, mutants))
    return results


def summary(mutants: list[Mutant], results: dict[str, Outcome]) -> str:
    """Sums up the results in one sentence."""
    done = [results[item.name] for item in mutants if item.name in results]
    counts = {kind: sum(item.result == kind for item in done) for kind in sorted({item.result for item in done})}
    tried = len(done) - counts.get("equivalent", 0)
    share = 100 * counts.get("noticed", 0) / tried if tried else 0.0
    listed = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    return f"{len(done)} mutations of {len(mutants)}: {listed}; noticed of those that change something: {share:.1f} %"


def write_page(mutants: list[Mutant], results: dict[str, Outcome]) -> None:
    """Writes the table in RELIABILITY.md, between its marks."""
    rows = ["| mutation | in | result | first noticed by |", "|---|---|---|---|"]
    for mutant in mutants:
        found = results.get(mutant.name)
        if found:
            test = found.by.removeprefix("tests/addon/").partition("[")[0]  # without its parameters
            by = f"`{test}`" if found.result == "noticed" else found.by
            rows.append(f"| {mutant.name} | `{found.file}` | {found.result} | {by} |")
    text = PAGE.read_text()
    before, rest = text.split(BEGIN)
    table = "\n".join(rows)
    PAGE.write_text(f"{before}{BEGIN}\n{summary(mutants, results)}.\n\n{table}\n{END}{rest.split(END)[1]}")


def check(mutants: list[Mutant]) -> int:
    """Checks whether every mutation applies to the tree as it is."""
    wrong = 0
    for mutant in mutants:
        path, trouble = (ROOT, "") if mutant.equivalent else place(ROOT, mutant)
        if path is None:
            wrong += 1
            sys.stdout.write(f"does not apply  {mutant.name}: {trouble}\n")
    sys.stdout.write(f"{len(mutants) - wrong} mutations of {len(mutants)} apply\n")
    return int(wrong > 0)


def main() -> int:
    """Runs what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", action="store_true", help="names and suites")
    parser.add_argument("--check", action="store_true", help="whether every mutation still applies; builds nothing")
    parser.add_argument("--only", default="", help="names, with commas between; a part of a name does")
    parser.add_argument("--rest", action="store_true", help="those without a good result yet")
    parser.add_argument("--jobs", type=int, default=1, help="copies of the tree at a time")
    parser.add_argument("--page", action="store_true", help="the table in tests/RELIABILITY.md, of the results kept")
    parser.add_argument("--python", default=os.environ.get("PARADESC_PYTHON", str(ROOT / ".venv" / "bin" / "python")))
    asked = parser.parse_args()
    every = read_mutants()
    wanted = [word.strip() for word in asked.only.split(",") if word.strip()]
    mutants = [item for item in every if not wanted or any(word in item.name for word in wanted)]
    if asked.list:
        sys.stdout.write("".join(f"{item.name:52s} {item.native or item.addon or 'equivalent'}\n" for item in mutants))
        return 0
    if asked.check:
        return check(mutants)
    BUILD.mkdir(parents=True, exist_ok=True)
    results = kept_results()
    if asked.rest:
        mutants = [item for item in mutants if item.name not in results or results[item.name].result not in GOOD]
    if not asked.page:
        results = try_all(mutants, asked.jobs, asked.python)
    else:
        write_page(every, results)
    sys.stdout.write(summary(mutants, results) + "\n")
    return int(any(results[item.name].result not in GOOD for item in mutants if item.name in results))


if __name__ == "__main__":
    sys.exit(main())

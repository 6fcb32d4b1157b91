"""Shader texts through compilers, and tests of devices on one OpenGL driver after the other; run by drivers.sh."""

import argparse
import datetime
import hashlib
import json
import os
import re
import select
import signal
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "support"))
import drivers_page

ROOT = Path(__file__).parents[1]
BINARY = ROOT / "build/paradesc_tests"
FOLDER = ROOT / "build/drivers"
TEXTS = FOLDER / "texts"
LONGEST_TEST = 900  # seconds of the processor until a test counts as one that does not end

NO_DEVICE = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/dev/null"}
SOFTWARE = {"LIBGL_ALWAYS_SOFTWARE": "1"}
# Tests of other engines need no driver, and these two tests are steps of their own here.
NOT_OF_DEVICES = ("*/reference*", "*/cpu*", "ShaderTexts.are_written_to_a_folder", "ShaderFolder.*")


@dataclass
class Driver:
    """An OpenGL driver: the variables that choose it, and whether it is Debian 13's."""

    name: str
    title: str
    environment: dict
    in_chroot: bool = True
    preloaded: str = ""


TESTED = [
    Driver("llvmpipe", "llvmpipe of this system", {}, in_chroot=False),
    Driver("llvmpipe-25", "llvmpipe of Debian 13", SOFTWARE),
    Driver("zink", "zink over lavapipe of Debian 13", SOFTWARE | {"MESA_LOADER_DRIVER_OVERRIDE": "zink"}),
]
# Only where it is asked for by its name.
CARD = Driver("card", "this machine's graphics card", {"PARADESC_TEST_GPU": "1"}, in_chroot=False)
AMD = [
    Driver(
        f"{chip} {option.removeprefix('use').upper()}",
        f"AMD {chip}, compiled by {option.removeprefix('use').upper()}",
        {"AMDGPU_GPU_ID": chip, "AMD_DEBUG": f"cs,vs,ps,stats,{option}"},
        preloaded="libamdgpu_noop_drm_shim.so",
    )
    for chip in ("polaris10", "vega10", "navi31")
    for option in ("useaco", "usellvm")
]


@dataclass
class Outcome:
    """How tests, texts or programs ended on one driver."""

    title: str
    unit: str
    passed: int = 0
    failed: dict = field(default_factory=dict)  # name: its last words
    skipped: dict = field(default_factory=dict)  # name: why
    seconds: float = 0
    device: str = ""
    date: str = ""
    registers: dict = field(default_factory=dict)  # rows by name, of a compiler that says what programs take

    def keep(self, name):
        """Keeps it beside the logs, so that drivers may be tried one at a time."""
        self.date = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
        (FOLDER / f"{name}.json").write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")
        say(rows_of([self]))
        return self


class Place:
    """A system that has drivers: this one, or a Debian 13 in a folder."""

    def __init__(self, chroot):
        """chroot: that folder, or None."""
        self.chroot = chroot

    def command(self, driver, names, variables=None):
        """The arguments with which subprocess runs these tests there: names or patterns."""
        variables = {"GTEST_FILTER": ":".join(names)} | driver.environment | (variables or {})
        if not driver.in_chroot:
            return {"args": [BINARY], "env": os.environ | variables}
        words = ["LD_LIBRARY_PATH=/root/lib"] + [f"LD_PRELOAD={driver.preloaded}"] * bool(driver.preloaded)
        fixed = {"HOME": "/root", "LANG": "C.UTF-8", "PATH": os.environ["PATH"]}
        return {"args": ["chroot", self.chroot, "env", *words, BINARY], "env": fixed | variables}


# ---- Tests


class Run:
    """One process of tests, line by line, until it ends or a test takes too long."""

    def __init__(self, command, log):
        """command: of Place.command. log: an open file that takes everything it says."""
        self.log = log
        self.process = subprocess.Popen(
            **command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
        )
        self.ended = {}  # name: (word, what was said meanwhile)
        self.current, self.said, self.began, self.computed = None, [], time.monotonic(), 0

    def processor_seconds(self):
        """Seconds of the processor that the process has had; other processes do not slow it down in these."""
        try:
            words = Path(f"/proc/{self.process.pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
        except OSError:
            return self.computed
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")

    def takes_too_long(self):
        """Returns whether the current test does."""
        waited = time.monotonic() - self.began
        return self.processor_seconds() - self.computed > LONGEST_TEST or waited > 10 * LONGEST_TEST

    def take(self, line):
        """Notes what a line says about a test."""
        self.log.write(line + "\n")
        self.log.flush()
        found = re.match(r"\[ *(RUN|OK|FAILED|SKIPPED) *\] ([\w./-]+)(?:, where .*)?(?: \(\d+ ms\))?$", line)
        if not found:
            self.said.append(line)
        elif found[1] == "RUN":
            self.current, self.said, self.began, self.computed = (
                found[2],
                [],
                time.monotonic(),
                self.processor_seconds(),
            )
        elif self.current == found[2]:
            self.ended[found[2]] = (found[1], self.said)
            self.current = None

    def wait(self):
        """Reads to the end; a test that takes too long, or that ends the process, has failed."""
        rest = b""
        descriptor = self.process.stdout.fileno()
        while True:
            ready, _, _ = select.select([descriptor], [], [], 5)
            if ready:
                part = os.read(descriptor, 1 << 16)
                if not part:
                    break
                *lines, rest = (rest + part).split(b"\n")
                for line in lines:
                    self.take(line.decode(errors="replace"))
            if self.current and self.takes_too_long():
                os.killpg(self.process.pid, signal.SIGKILL)
                self.ended[self.current] = ("FAILED", [f"it did not end in {LONGEST_TEST} s of the processor"])
                self.current = None
        status = self.process.wait()
        if self.current:
            self.ended[self.current] = ("FAILED", [*self.said[-5:], f"it ended the process with {status}"])
        return status


def why_skipped(said):
    """The reason that a test gave, in short: the line after the one that names the place."""
    for place, reason in pairwise(said):
        if place.endswith(": Skipped") and reason:
            return reason.split("; ")[0][:160]
    return "it gives no reason"


def run_tests(place, driver, names):
    """An Outcome of these tests; after a crash or a test without end the others go on."""
    outcome = Outcome(driver.title, "tests")
    start = time.monotonic()
    with (FOLDER / f"{driver.name}.log").open("w", encoding="utf-8") as log:
        left = list(names)
        while left:
            run = Run(place.command(driver, left), log)
            status = run.wait()
            for name, (word, said) in run.ended.items():
                if word == "OK":
                    outcome.passed += 1
                elif word == "SKIPPED":
                    outcome.skipped[name] = why_skipped(said)
                else:
                    outcome.failed[name] = " ".join(said)[-600:]
                outcome.device = outcome.device or next((line[8:] for line in said if line.startswith("device: ")), "")
            left = [name for name in left if name not in run.ended]
            if not run.ended:
                outcome.failed["the process"] = f"it ended with {status} before the first test"
                break
    if not outcome.device:
        outcome.failed["the device"] = "no test ran on it that says its name"
    outcome.seconds = time.monotonic() - start
    return outcome


def device_tests(place, driver):
    """Names of the tests that want a device: those that are skipped where EGL offers none. A card's have names of their
    own."""
    card = driver is CARD
    nowhere = Driver("nowhere", "no device", NO_DEVICE | (CARD.environment if card else {}), in_chroot=False)
    binary = hashlib.sha256(BINARY.read_bytes()).hexdigest()[:16]
    kept = FOLDER / f"device-tests-{'card-' if card else ''}{binary}.json"
    if kept.exists():
        return json.loads(kept.read_text(encoding="utf-8"))
    listed = place.command(nowhere, ["*"])
    listed["args"] = [*listed["args"], "--gtest_list_tests"]
    listing = subprocess.run(**listed, capture_output=True, text=True, check=True).stdout
    suite, names = "", []
    for line in listing.splitlines():
        word = line.split("#")[0].rstrip()
        if line.startswith("  "):
            names.append(suite + word.strip())
        elif word.endswith("."):
            suite = word
    patterns = [re.compile(pattern.replace(".", r"\.").replace("*", ".*") + "$") for pattern in NOT_OF_DEVICES]
    asked = [name for name in names if not any(pattern.match(name) for pattern in patterns)]
    found = run_tests(place, nowhere, asked)
    wanted = [name for name in asked if name in found.skipped]
    kept.write_text(json.dumps(wanted), encoding="utf-8")
    return wanted


# ---- Texts


def write_texts():
    """Below TEXTS, every text that the library can send to a driver: those that tests send, and other possible ones."""
    subprocess.run(["rm", "-rf", TEXTS], check=True)
    here = Place(None).command(
        TESTED[0], ["ShaderTexts.are_written_to_a_folder"], {"PARADESC_SHADER_TEXTS": str(TEXTS)}
    )
    said = subprocess.run(**here, capture_output=True, text=True)
    if said.returncode or not (TEXTS / "sent").is_dir():
        sys.exit(f"paradesc: the shader texts could not be written: {said.stdout[-2000:]}")


def validate(path):
    """The errors of Khronos' compiler and of its validator of SPIR-V for one text."""
    binary = path.with_suffix(path.suffix + ".spv")
    compiler = ["glslangValidator", "-G", "--aml", "--amb", "-o", binary, path]
    for command in (compiler, ["spirv-val", "--target-env", "opengl4.5", binary]):
        said = subprocess.run(command, capture_output=True, text=True)
        if said.returncode:
            return path.name, (said.stdout + said.stderr)[:600]
    binary.unlink()
    return path.name, ""


def check_texts():
    """An Outcome of all texts by Khronos' compiler and validator."""
    outcome = Outcome("glslangValidator, spirv-val", "texts")
    start = time.monotonic()
    paths = sorted(path for path in TEXTS.glob("*/*") if path.suffix in (".vert", ".frag", ".comp"))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, wrong in pool.map(validate, paths):
            if wrong:
                outcome.failed[name] = wrong
            else:
                outcome.passed += 1
    outcome.seconds = time.monotonic() - start
    return outcome


# ---- Programs


def compile_programs(place, driver, part):
    """An Outcome of the programs of one folder of TEXTS on a driver."""
    outcome = Outcome(driver.title, "programs")
    folder = TEXTS / part
    if driver.in_chroot:
        there = Path(f"{place.chroot}{folder}")
        subprocess.run(["rm", "-rf", there], check=True)
        there.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(["cp", "-r", folder, there], check=True)
    command = place.command(driver, ["ShaderFolder.*"], {"PARADESC_SHADER_TEXTS": str(folder)})
    start = time.monotonic()
    said = subprocess.run(**command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
    outcome.seconds = time.monotonic() - start
    text = said.decode(errors="replace")
    (FOLDER / f"{driver.name.replace(' ', '-')}-{part}.log").write_text(text, encoding="utf-8")
    outcome.device = next(iter(re.findall(r"^device: (.*)", text, re.MULTILINE)), "no device")
    made = re.findall(r"^(\d+) programs$", text, re.MULTILINE)
    refused = re.findall(r"The graphics driver did not \w+ (\S+),.*", text)
    outcome.failed = dict.fromkeys(refused, "refused")
    if not made:
        outcome.failed["the process"] = text[-600:]
    outcome.passed = int(made[0]) - len(refused) if made else 0
    if "AMD_DEBUG" in driver.environment and "AMD" not in outcome.device:
        outcome.failed["the device"] = f"it is {outcome.device}"
    outcome.registers = drivers_page.registers_of(text, folder)
    return outcome


# ---- The command


def rows_of(outcomes):
    """Lines of the table."""
    for outcome in outcomes:
        if outcome.device:
            yield f"{outcome.title}: {outcome.device}"
        yield (
            f"{outcome.title:34} {outcome.passed:6} {outcome.unit:8} passed {len(outcome.failed):4} failed "
            f"{len(outcome.skipped):4} skipped {outcome.seconds:7.0f} s"
        )
        for reason, count in Counter(outcome.skipped.values()).items():
            yield f"    skipped {count}: {reason}"
        for name, why in outcome.failed.items():
            yield f"    FAILED {name}: {why}"


def say(lines):
    """Prints them at once: a run takes long, and may be read while it does."""
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


def main():
    """Runs what was asked for; ends with 1 where anything failed."""
    usual = ["texts", *(driver.name for driver in TESTED), "amd"]
    names = [*usual, CARD.name]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drivers", nargs="*", metavar="DRIVER", help=" ".join(names))
    parser.add_argument("--chroot")
    parser.add_argument("--page", action="store_true")
    options = parser.parse_args()
    if unknown := set(options.drivers) - set(names):
        parser.error(f"there is no driver {', '.join(unknown)}; choose of {' '.join(names)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    place = Place(options.chroot)
    asked = options.drivers or usual
    outcomes = []
    if "texts" in asked or "amd" in asked:
        write_texts()
    if "texts" in asked:
        outcomes.append(check_texts().keep("texts"))
    tested = [driver for driver in [*TESTED, CARD] if driver.name in asked]
    chosen = [driver for driver in tested if place.chroot or not driver.in_chroot]
    outcomes += [run_tests(place, driver, device_tests(place, driver)).keep(driver.name) for driver in chosen]
    if "amd" in asked and place.chroot:
        outcomes += [compile_programs(place, driver, "sent").keep(driver.name) for driver in AMD]
    say(["", "==== Drivers", *rows_of(outcomes)])
    if options.page:
        kept = [FOLDER / f"{name}.json" for name in ("texts", *(driver.name for driver in TESTED + AMD))]
        found = [Outcome(**json.loads(path.read_text(encoding="utf-8"))) for path in kept if path.exists()]
        drivers_page.write(ROOT / "tests/DRIVERS.md", found)
    sys.exit(any(outcome.failed for outcome in outcomes))


if __name__ == "__main__":
    main()

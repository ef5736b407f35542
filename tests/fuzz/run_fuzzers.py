#!/usr/bin/env python3
"""Runs the fuzzers of the preset `fuzz`, one after the other, and adds a row for each to the ledger.

    cmake --preset fuzz && cmake --build --preset fuzz
    tests/fuzz/run_fuzzers.py --executions 1000000          # all of them
    tests/fuzz/run_fuzzers.py --executions 50000 history bvh

What a fuzzer learned is kept beside it (BUILD/corpus/TARGET) and is where its next run starts. A finding
is left in BUILD/findings/TARGET: mend the cause, and put the input, small, into tests/fuzz/findings/TARGET,
where every build's tests try it again. Ends with 1 where there was one.
"""

import argparse
import datetime
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[1]
# Libraries of the distribution, which leak a little where they refuse, do their reading.
LIBRARIES = {"bvh", "exr", "texture"}
LEDGER = HERE / "ledger.md"
SLOW_SECONDS = 10  # of one input, with the sanitizers


def seeds(build, folder):
    """Writes the seeds and dictionaries below `folder`; returns the size that each target's inputs may have."""
    sizes = {}
    for replay in ("fuzz_replay", "fuzz_replay_import"):
        told = subprocess.run([build / "tests/fuzz" / replay, "--seeds", folder], check=True,
                              stdout=subprocess.PIPE, text=True).stdout
        sizes.update((name, int(size)) for name, size in (line.split() for line in told.splitlines()))
    return sizes


def processor_seconds():
    """Of all programs that were run and have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(build, target, most_bytes, start, executions, seconds, seed):
    """One fuzzer until it has tried so many inputs or found something: how many it tried, what it found, and seconds of processor."""
    corpus, found = build / "corpus" / target, build / "findings" / target
    corpus.mkdir(parents=True, exist_ok=True)
    found.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    log = build / "findings" / f"{target}.log"
    words = start / f"{target}.dict"
    begun = processor_seconds()
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    fuzzer, leaks = build / "tests/fuzz" / f"{target}_fuzz", int(target not in LIBRARIES)
    with tempfile.TemporaryDirectory(prefix="backbend-fuzz-", dir=memory) as scratch, open(log, "w") as told:
        environment = {"PATH": os.environ["PATH"], "TMPDIR": scratch, "OPENIMAGEIO_THREADS": "1",
                       "ASAN_OPTIONS": "alloc_dealloc_mismatch=0:allocator_may_return_null=0:malloc_context_size=2:quarantine_size_mb=16:"
                                       f"detect_leaks={leaks}",
                       "UBSAN_OPTIONS": "print_stacktrace=1"}
        # A second, and half a gigabyte, are what a hostile file may cost; sanitizers take ten times that. Of each
        # allocation only two callers are kept, and freed memory is kept from use for 16 MB: deep stacks and a quarter
        # of a gigabyte cost parsers half their time, and a finding is replayed with everything.
        subprocess.run(
            [fuzzer, f"-runs={executions}", f"-max_total_time={seconds}", f"-max_len={most_bytes}", f"-seed={seed}",
             *([f"-dict={words}"] if words.stat().st_size else []), f"-artifact_prefix={found}/", "-timeout=20", "-rss_limit_mb=4096",
             f"-report_slow_units={SLOW_SECONDS}", "-malloc_limit_mb=1024", f"-detect_leaks={leaks}", "-print_final_stats=1",
             "-close_fd_mask=3" if target in LIBRARIES else "-close_fd_mask=1", "-reload=0", corpus, start / target],
            stdout=told, stderr=subprocess.STDOUT, cwd=scratch, check=False, env=environment)
        busy = processor_seconds() - begun
        # libFuzzer goes by the clock, which stands still for an input while other work has the machine: what is slow is
        # tried once more, by the processor's time.
        for unit in set(found.glob("slow-unit-*")) - before:
            at = processor_seconds()
            subprocess.run([fuzzer, unit], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=scratch, check=False,
                           env=environment)
            if processor_seconds() - at < SLOW_SECONDS:
                unit.unlink()
    tried = re.search(r"stat::number_of_executed_units: (\d+)", log.read_text(errors="replace"))
    return int(tried.group(1)) if tried else 0, sorted(set(found.iterdir()) - before), busy


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("target", nargs="*", help="all of them by default")
    parser.add_argument("--executions", type=int, default=1000000, help="of each [1000000]")
    parser.add_argument("--seconds", type=int, default=0, help="of each at most, however few it has tried; 0: no end")
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/fuzz")
    parser.add_argument("--seed", type=int, default=0, help="of the mutators; 0: another one each time")
    options = parser.parse_args()
    build = options.build.resolve()
    failed = False
    with tempfile.TemporaryDirectory(prefix="backbend-seeds-") as folder:
        start = pathlib.Path(folder)
        sizes = seeds(build, start)
        unknown = set(options.target) - set(sizes)
        if unknown:
            parser.error(f"no target {', '.join(sorted(unknown))}; there are {', '.join(sorted(sizes))}")
        for target in options.target or sorted(sizes):
            tried, found, busy = run(build, target, sizes[target], start, options.executions, options.seconds,
                               options.seed)
            day = datetime.datetime.now(datetime.timezone.utc).date()
            what = ", ".join(path.name for path in found) or "none"
            print(f"{target}: {tried} executions, {tried / max(busy, 0.01):.0f} per second of a processor, findings: {what}", flush=True)
            with open(LEDGER, "a") as ledger:
                ledger.write(f"| {target} | {day} | {tried} | {len(found) or 'none'} |\n")
            failed = failed or bool(found) or tried < options.executions
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

"""Every call that writes fails once: what has its final name is whole, the exit code tells, and the next
run heals it. BACKBEND_LONG tries every error at every call, else each call fails with one of them."""

import errno
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import harness
from harness import CANNOT_WRITE, RETRY, contents, human, run_backbend

HUMAN = human(1500)


class FaultTest:
    """Holds the shim that fails calls. `sanitizers` must come first in a process, so that it cannot
    be preloaded into theirs."""

    @classmethod
    def setUpClass(cls):
        if b"__asan_init" in pathlib.Path(harness.BACKBEND).read_bytes():
            raise unittest.SkipTest("the program holds a sanitizer, which must be loaded first")
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            raise unittest.SkipTest("no C compiler")
        holder = tempfile.TemporaryDirectory(prefix="backbend faults ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name).resolve()
        # The loader takes blanks in LD_PRELOAD for separators.
        place = tempfile.TemporaryDirectory(prefix="backbend-shim-")
        cls.addClassCleanup(place.cleanup)
        cls.shim = pathlib.Path(place.name) / "fail_calls.so"
        subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", cls.shim,
                        pathlib.Path(__file__).with_name("fail_calls.c"), "-ldl"], check=True)

    def failing(self, arguments, out, kind, number, at, program="", timeout_s=120):
        return run_backbend(arguments, self.folder, timeout_s=timeout_s, environment={
            "LD_PRELOAD": str(self.shim), "FAULT_FOLDER": str(out), "FAULT_KIND": kind,
            "FAULT_NUMBER": str(number), "FAULT_AT": str(at), "FAULT_PROGRAM": program,
            "FAULT_COUNT": str(self.folder / "count")})

    def count(self, arguments, out, kind, program=""):
        (self.folder / "count").unlink(missing_ok=True)
        done = self.failing(arguments, out, kind, 0, 0, program)
        self.assertEqual(done.returncode, 0, done.stderr)
        file = self.folder / "count"
        return int(file.read_text()) if file.exists() else 0


class FailingEachCallOnce(FaultTest, unittest.TestCase):
    """The smallest job that writes many files: a report again from its report.json."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        made = run_backbend(["check", HUMAN, "--quick", "-o", "run"], cls.folder)
        assert made.returncode in (0, 1, 5), made.stderr
        cls.report = cls.folder / "run/report.json"
        cls.out = cls.folder / "out"
        done = run_backbend(cls.command(), cls.folder)
        assert done.returncode == 0, done.stderr
        cls.expected = contents(cls.out)
        assert len(cls.expected) >= 6, cls.expected

    @classmethod
    def command(cls):
        return ["report", cls.report, "-o", cls.out]

    def assert_old_new_or_absent(self, told):
        for name, what in contents(self.out).items() if self.out.exists() else ():
            self.assertEqual(what, self.expected.get(name), f"{name}: {told}")

    def fail_each(self, kind, numbers):
        shutil.rmtree(self.out, ignore_errors=True)
        calls = self.count(self.command(), self.out, kind)
        self.assertGreater(calls, 0, f"no {kind} was seen: the shim does not work")
        refused = 0
        for turn, number in enumerate(numbers):
            healed = number in (0, errno.EINTR)  # what is not an error but an interruption
            for at in range(1, calls + 1):
                if "BACKBEND_LONG" not in os.environ and at % len(numbers) != turn:
                    continue
                with self.subTest(kind=kind, number=number, at=at):
                    shutil.rmtree(self.out, ignore_errors=True)
                    done = self.failing(self.command(), self.out, kind, number, at)
                    told = f"exit {done.returncode}: {done.stderr}"
                    self.assert_old_new_or_absent(told)
                    if done.returncode == 0:
                        self.assertEqual(contents(self.out), self.expected, told)
                    else:
                        refused += 1
                        self.assertFalse(healed, told)
                        self.assertEqual(done.returncode,
                                         CANNOT_WRITE if number in (errno.EACCES, errno.EROFS) else RETRY, told)
                        self.assertEqual(len(done.stderr.splitlines()), 1, told)
        self.assertGreater(refused, 0, f"no failing {kind} was noticed")
        # The last failure is healed by running again.
        self.assertEqual(run_backbend(self.command(), self.folder).returncode, 0)
        self.assertEqual(contents(self.out), self.expected)

    def test_writing(self):
        self.fail_each("write", (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EINTR, 0))

    def test_flushing(self):
        self.fail_each("fsync", (errno.ENOSPC, errno.EIO, errno.EINTR))

    def test_naming(self):
        self.fail_each("rename", (errno.ENOSPC, errno.EIO, errno.EROFS))

    def test_closing(self):
        self.fail_each("close", (errno.EIO, errno.ENOSPC))

    def test_making_folders(self):
        self.fail_each("mkdir", (errno.ENOSPC, errno.EACCES))

    def test_creating(self):
        self.fail_each("open", (errno.ENOSPC, errno.EACCES, errno.EINTR))


class FailingTheEncoder(FaultTest, unittest.TestCase):
    """ffmpeg's own writes fail, whatever it says of them."""

    def test_no_video_gets_its_name_that_is_not_whole(self):
        if not shutil.which("ffmpeg"):
            self.skipTest("ffmpeg is not installed")
        out = self.folder / "turn"
        command = ["turntable", HUMAN, "--views", "3", "--res", "64x48", "--spp", "1", "-o", out]
        calls = self.count(command, out, "write", "ffmpeg")
        if calls == 0:
            self.skipTest("this ffmpeg writes past the C library")
        (video,) = out.rglob("*.mp4")
        name, whole = video.relative_to(out), video.read_bytes()
        for number in (errno.ENOSPC, errno.EIO):
            for at in range(1, calls + 1):
                with self.subTest(number=number, at=at):
                    shutil.rmtree(out)
                    done = self.failing(command, out, "write", number, at, "ffmpeg")
                    if (out / name).exists():
                        self.assertEqual((out / name).read_bytes(), whole, done.stderr)
                    else:
                        self.assertEqual(done.returncode, RETRY, done.stderr)
                    self.assertEqual([p for p in out.rglob("*") if ".tmp-" in p.name], [], done.stderr)
                    self.assertFalse(done.returncode == 0 and not (out / name).exists(), "a success without its video")

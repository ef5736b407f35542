"""check --watch: judges again when an input changes, and says what a cold run says."""

import contextlib
import json
import os
import pty
import re
import select
import signal
import subprocess
import time

import harness
from harness import BAD_INPUT, USAGE, CommandTest, contents, human

PICTURES = ["--res", "64x48", "--spp", "1"]
RIG = '[rig]\nsystem = "curve"\nbones = {}\n'


class Watcher:
    """Runs check --watch in the folder of a test."""

    def setUp(self):
        super().setUp()
        self.one, self.two = (human(vertices).read_bytes() for vertices in (2000, 2600))
        self.hero = self.write("work/hero.glb", self.one)

    @contextlib.contextmanager
    def watching(self, *arguments, terminal=None):
        command = [str(word) for word in [harness.BACKBEND, "check", self.hero, "--watch", *arguments]]
        self.log = self.folder / "log"
        with open(self.log, "wb") as log, open(self.folder / "errors", "wb") as errors, \
                subprocess.Popen(command, cwd=self.folder, env=harness.bare_environment(self.folder, TERM="xterm"),
                                 stdin=subprocess.DEVNULL, stdout=terminal or log, stderr=terminal or errors) as run:
            self.run_now = run
            try:
                yield run
            finally:
                run.kill()

    def wait_for(self, pattern, times=1, where="log"):
        """Until the pattern stands in what was said so often; returns the text."""
        for _ in range(int(harness.PATIENCE_S * 10)):
            text = (self.folder / where).read_text()
            if len(re.findall(pattern, text)) >= times:
                return text
            self.assertIsNone(self.run_now.poll(), text + (self.folder / "errors").read_text())
            time.sleep(0.1)
        self.fail(f"no {pattern}: {text}")

    def check_cold(self, *arguments):
        result = self.backbend("check", self.hero, *arguments, "-o", "cold")
        self.assertIn(result.returncode, (0, 1), result.stderr)

    def wait_for_files(self):
        """Until the run folder holds the report of what is there now."""
        self.check_cold("--quick")
        for _ in range(int(harness.PATIENCE_S * 10)):
            if contents(self.folder / "out") == contents(self.folder / "cold"):
                return
            time.sleep(0.1)
        self.assertEqual(contents(self.folder / "out"), contents(self.folder / "cold"))

    def stop(self, run, number=signal.SIGINT, code=130):
        run.send_signal(number)
        self.assertEqual(run.wait(timeout=60), code)


class Saving(Watcher, CommandTest):
    def test_every_way_of_saving_gives_what_a_cold_run_gives(self):
        with self.watching("--quick", "-o", "out") as run:
            self.wait_for(r"save 1;")
            self.wait_for_files()
            self.hero.write_bytes(self.two)                     # over itself
            self.assertIn("hero.glb", self.wait_for(r"save 2: hero.glb"))
            self.wait_for_files()
            self.write("work/new", self.one).rename(self.hero)  # renamed into place
            self.wait_for(r"save 3: hero.glb")
            self.wait_for_files()
            self.hero.rename(self.folder / "work/hero~")        # away, then anew, in two steps
            with open(self.hero, "wb") as out:
                out.write(self.two[:1000])
                out.flush()
                time.sleep(0.1)
                out.write(self.two[1000:])
            text = self.wait_for(r"save 4: hero.glb")
            self.wait_for_files()
            self.assertEqual((self.folder / "errors").read_text(), "")
            self.assertRegex(text, r"since the save before: ")
            self.stop(run)

    def test_bad_input_is_told_and_the_next_save_waited_for(self):
        with self.watching("--quick", "-o", "out") as run:
            self.wait_for(r"save 1;")
            self.hero.write_bytes(self.two[:1000])
            self.wait_for(r"hero.glb: truncated", where="errors")
            self.hero.unlink()
            self.wait_for(r"hero.glb: No such file", where="errors")
            self.hero.write_bytes(self.two)
            self.wait_for(r"save 2: hero.glb")
            self.wait_for_files()
            self.stop(run, signal.SIGTERM, 143)

    def test_sidecar_rig_and_project_count(self):
        rig = self.write("rigs/spine.toml", RIG.format(10))
        with self.watching("--quick", "-o", "out", "--rig", rig) as run:
            self.wait_for(r"save 1;")
            self.write("rigs/spine.toml", RIG.format(12))
            self.wait_for(r"save 2: spine.toml")
            self.write("work/hero.backbend.toml", "nonsense = 1\n")
            self.wait_for(r"hero.backbend.toml", where="errors")
            (self.folder / "work/hero.backbend.toml").unlink()
            self.wait_for(r"save 3: hero.backbend.toml \(gone\)")
            self.write("work/backbend.toml", 'mapping = "spread"\n')
            self.wait_for(r"save 4: backbend.toml")
            self.check_cold("--quick", "--rig", rig)
            self.assertEqual(json.loads((self.folder / "cold/report.json").read_text())["rigs"][0]["mapping"], "spread")
            self.assertEqual(contents(self.folder / "out"), contents(self.folder / "cold"))
            self.stop(run)

    def test_looking_twice_a_second_says_so_and_finds_the_same(self):
        with self.watching("--quick", "-o", "out", "--poll") as run:
            self.assertIn("looking at 3 files twice a second (requested)", self.wait_for(r"Ctrl-C ends"))
            self.hero.write_bytes(self.two)
            self.wait_for(r"save 2: hero.glb")
            self.wait_for_files()
            self.stop(run)


class Showing(Watcher, CommandTest):
    def test_json_is_one_report_a_line(self):
        with self.watching("--quick", "-o", "out", "--json") as run:
            self.wait_for(r"\n")
            self.hero.write_bytes(self.two)
            lines = self.wait_for(r"\n", times=2).splitlines()
            self.stop(run)
        for line in lines:
            self.assertEqual(json.loads(line)["schema"], "backbend.report/1")

    def test_a_terminal_shows_one_screen(self):
        main, other = pty.openpty()
        shown = b""
        with self.watching("--quick", "-o", "out", terminal=other) as run:
            os.close(other)

            def read_until(pattern):
                nonlocal shown
                end = time.monotonic() + harness.PATIENCE_S
                while not re.search(pattern, shown) and time.monotonic() < end:
                    if select.select([main], [], [], 0.1)[0]:
                        shown += os.read(main, 65536)
                self.assertRegex(shown, pattern)

            read_until(rb"Ctrl-C ends")
            self.hero.write_bytes(self.two)
            read_until(rb"save 2: hero.glb")
            self.assertEqual(shown.count(b"\x1b[H\x1b[2J"), 2)
            self.stop(run)
        os.close(main)

    def test_what_cannot_be_watched_is_refused(self):
        for words, code in ((["--dry-run"], USAGE), (["--history", "h.jsonl"], USAGE)):
            self.assert_refused("check", self.hero, "--watch", "--quick", *words, code=code, names=["--watch"])
        self.assert_refused("check", self.hero, "--quick", "--poll", code=USAGE, names=["--watch"])
        self.assert_refused("check", "nobody.glb", "--watch", "--quick", "-o", "out", code=BAD_INPUT,
                            names=["nobody.glb"])


class Picturing(Watcher, CommandTest):
    def test_pictures_follow_and_are_those_of_a_cold_run(self):
        with self.watching(*PICTURES, "-o", "out") as run:
            self.wait_for(r"pictures of save 1")
            self.hero.write_bytes(self.two)
            self.wait_for(r"pictures of save 2")
            self.stop(run)
        self.check_cold(*PICTURES)
        self.assertEqual(contents(self.folder / "out"), contents(self.folder / "cold"))

    def test_a_save_while_pictures_are_made_ends_them(self):
        with self.watching("--res", "640x480", "--spp", "4096", "-o", "out") as run:
            self.wait_for(r"save 1;")
            time.sleep(0.5)
            self.hero.write_bytes(self.two)
            self.assertNotIn("pictures of save 1", self.wait_for(r"save 2: hero.glb"))
            self.stop(run)

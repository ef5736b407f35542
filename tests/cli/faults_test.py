"""Full disks and hostile folders: what has its final name is whole, and the exit code tells."""

import os
import subprocess

from harness import CANNOT_WRITE, CommandTest, RETRY, contents, human

HUMAN = human(1500)


class FillingTheDisk(CommandTest):
    """A real file system of every size from nothing to enough."""

    def test_a_report_is_whole_or_the_run_says_so(self):
        if os.geteuid() != 0:
            self.skipTest("needs root")
        made = self.backbend("check", HUMAN, "--quick", "-o", "run")
        self.assertIn(made.returncode, (0, 1, 5), made.stderr)
        self.assert_runs("report", "run/report.json", "-o", "whole")
        expected = contents(self.folder / "whole")
        pages = sum(-(-path.stat().st_size // 4096) + 1 for path in (self.folder / "whole").iterdir())
        disk = self.folder / "disk"
        disk.mkdir()
        codes = set()
        for size in [*range(1, pages + 12, max(1, pages // 20)), *range(pages - 3, pages + 12)]:
            mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size * 4096}", "tmpfs", disk],
                                     capture_output=True, text=True)
            if mounted.returncode != 0:
                self.skipTest("cannot mount: " + mounted.stderr.strip())
            try:
                done = self.backbend("report", "run/report.json", "-o", disk / "out")
                codes.add(done.returncode)
                found = contents(disk / "out") if (disk / "out").exists() else {}
                for name, what in found.items():
                    self.assertEqual(what, expected.get(name), f"{size} pages: {name}: {done.stderr}")
                if done.returncode == 0:
                    self.assertEqual(found, expected)
            finally:
                subprocess.run(["umount", disk], check=True)
        self.assertEqual(codes, {0, RETRY})


class FillingTheDiskWithPictures(CommandTest):
    def test_frames_are_whole_or_not_there_and_the_run_says_so(self):
        if os.geteuid() != 0:
            self.skipTest("needs root")
        disk = self.folder / "disk"
        disk.mkdir()
        for command in (["render"], ["turntable", "--views", "3"], ["render", "--sweep", "extension"]):
            with self.subTest(command):
                words = [command[0], HUMAN, *command[1:], "--rig", "curve", "--res", "160x120", "--spp", "1"]
                if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", disk]).returncode != 0:
                    self.skipTest("cannot mount")
                try:
                    (disk / "filler").write_bytes(bytes(300 << 10))
                    done = self.backbend(*words, "-o", disk / "out")
                    self.assertEqual(done.returncode, RETRY, done.stderr)
                    self.assertIn("cannot write", done.stderr)
                    # A folder in which nothing came to be whole is not left, either.
                    left = sorted((disk / "out").iterdir()) if (disk / "out").exists() else []
                finally:
                    subprocess.run(["umount", disk], check=True)
                self.assertEqual([path.name for path in left if not path.name.endswith(".exr")], [])


class HostileFolders(CommandTest):
    def setUp(self):
        super().setUp()
        self.still = ["render", HUMAN, "--res", "32x32", "--spp", "1", "-o", "out"]

    def test_links_planted_at_the_outputs_names_are_replaced_not_followed(self):
        self.assert_runs(*self.still)
        before = {name: what for name, what in contents(self.folder / "out").items() if what != "folder"}
        self.assertTrue(before)
        victim = self.write("victim.txt", "precious")
        for name in before:
            (self.folder / "out" / name).unlink()
            (self.folder / "out" / name).symlink_to(victim)
        self.assert_runs(*self.still)
        self.assertEqual(victim.read_text(), "precious")
        after = {name: what for name, what in contents(self.folder / "out").items() if what != "folder"}
        self.assertEqual(after, before)

    def test_a_link_in_the_place_of_a_runs_own_folder_is_refused(self):
        (self.folder / "elsewhere").mkdir()
        (self.folder / "out").mkdir()
        (self.folder / "out/farm").symlink_to(self.folder / "elsewhere")
        done = self.backbend("farm", "parallel", "-o", "out")
        self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
        self.assertIn("out/farm: is a link", done.stderr)
        self.assertEqual(list((self.folder / "elsewhere").iterdir()), [])

    def test_a_folder_that_may_not_be_written_is_said_at_once(self):
        out = self.folder / "out"
        out.mkdir()
        if os.geteuid() == 0:
            # Root may write anywhere but on a medium that is read-only.
            if subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", out], capture_output=True).returncode != 0:
                self.skipTest("cannot mount")
            self.addCleanup(subprocess.run, ["umount", out])
        else:
            out.chmod(0o555)
            self.addCleanup(out.chmod, 0o755)
        done = self.backbend(*self.still)
        self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
        self.assertEqual(list(out.iterdir()), [])
        done = self.backbend("nightly", "--quick", "-o", "out")
        self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
        self.assertNotIn("poses", done.stderr, "hours of work before the folder was tried")

"""--dry-run: the plan and about how long it takes, nothing written; and what is refused leaves no trace."""

import json
import os

import glb
from harness import USAGE, CommandTest, contents


class DryRun(CommandTest):
    def plan(self, *words):
        before = contents(self.folder)
        told = json.loads(self.assert_runs(*words, "--dry-run", "--json", "--quiet").stdout)
        self.assertEqual(contents(self.folder), before, words)
        self.assertGreater(told["minutes"], -1e-9)
        return told

    def test_pictures_say_how_many_they_are_and_how_large(self):
        self.write("hero.glb", glb.tube())
        small = ("hero.glb", "--res", "64x32", "--spp", "4", "-o", "out/deep")
        told = self.plan("render", *small)
        self.assertEqual((told["frames"], told["sequence"], told["samples"]), (1, 1, 64 * 32 * 4))
        told = self.plan("turntable", *small, "--views", "10", "--light-views", "6", "--shard", "1/4")
        self.assertEqual((told["frames"], told["sequence"]), (4, 16))
        told = self.plan("render", *small, "--sweep", "extension", "--frames", "1001-1010x2")
        self.assertEqual((told["frames"], told["sequence"], told["samples"]), (5, 61, 5 * 64 * 32 * 4))
        told = self.plan("render", *small, "--extreme", "--sweeps", "standard")
        self.assertGreater(told["poses"], 61)
        text = self.assert_runs("render", *small, "--preset", "final", "--noise", "0.1", "--dry-run").stdout
        self.assertIn("up to 4 samples a pixel", text)

    def test_runs_say_how_many_poses_they_measure(self):
        self.write("hero.glb", glb.tube())
        told = self.plan("check", "hero.glb", "--quick")
        self.assertEqual((told["characters"], told["rigs"], told["canaries"], told["small_pictures"]), (1, 1, 1, 0))
        self.assertGreater(told["poses"], 61)
        self.assertEqual(self.plan("compare", "even", "curve", "--character", "hero.glb", "--quick")["rigs"], 2)
        self.assert_refused("check", "--baked", "hero.glb", "--dry-run", code=USAGE, names=["--dry-run"])

    def test_what_the_job_would_refuse_is_refused(self):
        self.write("hero.glb", glb.tube())
        self.assert_refused("render", "hero.glb", "--pose", "extension=much", "--dry-run", code=USAGE, names=["much"])
        self.assert_refused("turntable", "none.glb", "--dry-run", names=["none.glb"])

    def test_a_frame_beyond_the_machines_memory_leaves_no_folder(self):
        if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE") > 100 << 30:
            self.skipTest("this machine has memory for the largest picture")
        self.write("hero.glb", glb.tube())
        for command in ("render", "turntable"):
            self.assert_refused(command, "hero.glb", "--res", "16384x16384", "--aovs", "all", "--quiet", "-o",
                                "out/deep", names=["GB"])

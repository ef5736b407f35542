"""The Debian package, and what the program says of its own options to shells and to man."""

import os
import re
import shutil
import subprocess

import harness
from harness import CommandTest

BUILD = os.environ.get("BACKBEND_BUILD")


class DescribingItself(CommandTest):
    def commands(self):
        told = self.assert_runs("--help").stdout
        return re.findall(r"^  ([a-z]+) {2,}", told[told.index("Subcommands:"):], re.MULTILINE)

    def test_every_command_and_option_is_in_every_form(self):
        commands = self.commands()
        self.assertGreater(len(commands), 10)
        options = set()
        for command in commands:
            options |= set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", self.assert_runs(command, "--help").stdout))
        for form in ("bash", "zsh", "fish", "man"):
            text = self.assert_runs("completions", form).stdout.replace("\\-", "-")
            for command in commands:
                self.assertRegex(text, rf"\b{command}\b", form)
            for option in options:
                self.assertIn(option[2:] if form == "fish" else option, text, form)

    def test_the_shells_take_them(self):
        for shell in ("bash", "zsh", "fish"):
            if not shutil.which(shell):
                continue
            script = self.write(f"completion.{shell}", self.assert_runs("completions", shell).stdout)
            done = subprocess.run([shell, "-n", script], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), shell)

    def test_bash_completes_commands_options_and_choices(self):
        script = self.write("completion.bash", self.assert_runs("completions", "bash").stdout)

        def completed(*words):
            line = " ".join(f"'{word}'" for word in words)
            done = subprocess.run(
                ["bash", "-c", f"source '{script}'; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; "
                               "_backbend; printf '%s\\n' \"${COMPREPLY[@]}\""],
                capture_output=True, text=True, cwd=self.folder)
            self.assertEqual(done.stderr, "")
            return done.stdout.split()

        self.assertEqual(completed("backbend", "night"), ["nightly"])
        self.assertEqual(completed("backbend", "nightly", "--sha"), ["--shard"])
        self.assertEqual(set(completed("backbend", "check", "--mapping", "")), {"chest", "spread"})
        self.assertLessEqual({"beauty", "clay", "heat"}, set(completed("backbend", "render", "--mode", "")))
        self.assertNotIn("0", completed("backbend", "calibrate", "--tubes", ""))  # 3 to 64 are taken as well
        self.assertIn("--threads", completed("backbend", "check", "--th"))

    def test_man_reads_the_page_without_a_complaint(self):
        if not shutil.which("groff"):
            self.skipTest("groff is not installed")
        page = self.write("backbend.1", self.assert_runs("completions", "man").stdout)
        done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", page], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("nightly", done.stdout)


class Packaging(CommandTest):
    def test_the_package_depends_on_what_it_runs_with_and_holds_what_it_needs(self):
        if not BUILD or not all(map(shutil.which, ("cpack", "dpkg-shlibdeps", "file"))):
            self.skipTest("needs a build folder, cpack, dpkg-dev and file")
        out = self.folder / "out"
        done = subprocess.run(["cpack", "--config", f"{BUILD}/CPackConfig.cmake", "-B", out], capture_output=True,
                              text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        (package,) = out.glob("backbend_*.deb")
        for module in out.glob("python3-backbend_*.deb"):  # where the Python module is built
            fields = subprocess.run(["dpkg-deb", "--field", module], check=True, capture_output=True, text=True).stdout
            self.assertRegex(fields, r"(?m)^Depends:.*backbend \(= .*python3-numpy")
            contents = subprocess.run(["dpkg-deb", "--contents", module], check=True, capture_output=True, text=True).stdout
            for name in ("__init__.py", "__init__.pyi", "py.typed", "_core."):
                self.assertIn("/usr/lib/python3/dist-packages/backbend/" + name, contents)
            self.assertNotIn("/usr/bin", contents)
            subprocess.run(["dpkg-deb", "--extract", module, self.folder / "root"], check=True)
        facts = subprocess.run(["dpkg-deb", "--field", package], check=True, capture_output=True, text=True).stdout
        depends = re.search(r"^Depends: (.*)$", facts, re.MULTILINE)[1]
        for library in ("libc6", "libembree", "libopenexr", "libopenimageio", "libtbb", "libassimp", "ffmpeg", "fonts-dejavu-core"):
            self.assertIn(library, depends)
        listing = subprocess.run(["dpkg-deb", "--contents", package], check=True, capture_output=True, text=True).stdout
        for path in ("/usr/bin/backbend", "/usr/libexec/backbend/backbend-import", "/usr/libexec/backbend/backbend-pictures.so", "/usr/share/backbend/scenes/nightly.toml", "/usr/share/backbend/report.schema.json", "/usr/share/man/man1/backbend.1",
                     "/usr/share/bash-completion/completions/backbend", "/usr/share/doc/backbend/copyright"):
            self.assertIn("." + path, listing)
        # It runs from where it was unpacked, and is the program that was built.
        subprocess.run(["dpkg-deb", "--extract", package, self.folder / "root"], check=True)
        done = subprocess.run([self.folder / "root/usr/bin/backbend", "list", "checks"], capture_output=True, text=True)
        self.assertEqual(done.stdout, harness.run_backbend(["list", "checks"], self.folder).stdout)
        packages = self.folder / "root/usr/lib/python3/dist-packages"
        if packages.is_dir():
            # The module finds the program's files: the scenes, and what reads FBX.
            done = subprocess.run(["/usr/bin/python3", "-c", "import backbend; print(len(backbend.compare('even', 'even', sweeps='standard').rigs))"],
                                  env=harness.bare_environment(self.folder, PYTHONPATH=str(packages)), cwd=self.folder,
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
        # Pictures need the module beside it.
        done = subprocess.run([self.folder / "root/usr/bin/backbend", "render", harness.human(), "--res", "32x32", "--spp", "1",
                               "-o", self.folder / "pictures"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(list((self.folder / "pictures").rglob("*.png")))

"""The launcher, tried on a project of one file: with the real build tools, and with stand-ins for
the package tools, so that no test ever installs anything."""

import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from harness import SOURCE

# Whoever runs these tests may have set it for the real tree.
os.environ.pop("BACKBEND_PACKAGES", None)

CMAKE_LISTS = """\
cmake_minimum_required(VERSION 3.25)
project(tiny LANGUAGES C)
option(BACKBEND_TESTS "" ON)
add_subdirectory(cli)
if(BACKBEND_TESTS)
  enable_testing()
  add_test(NAME echo COMMAND backbend hello)
endif()
"""
CLI_LISTS = "add_executable(backbend main.c)\n"
PRESETS = """\
{"version": 6, "configurePresets": [{"name": "release", "generator": "Ninja",
 "binaryDir": "${sourceDir}/build/release"}]}
"""
# Prints its version, folder and arguments; `exit N` ends with N, `cat` repeats stdin.
PROGRAM = """\
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
int main(int argc, char** argv) {
  if (argc == 3 && !strcmp(argv[1], "exit")) return atoi(argv[2]);
  if (argc == 2 && !strcmp(argv[1], "cat")) {
    for (int c; (c = getchar()) != EOF;) putchar(c);
    return 0;
  }
  char folder[4096];
  printf("one %s", getcwd(folder, sizeof folder));
  for (int i = 1; i < argc; ++i) printf(" [%s]", argv[i]);
  printf("\\n");
  return 0;
}
"""
PACKAGES = """\
# a comment
[tool]    # to build
lib-one
lib-two   # with a reason
[tests]
lib-test
viewer viewer
[ci]
never-asked
"""

# The stand-ins keep what they were asked in $SHIMS/calls and what is installed in $SHIMS/installed.
SHIMS = {
    "dpkg-query": """\
while read -r name; do
  case " $* " in *" $name "*) echo "installed $name" ;; esac
done <"$SHIMS/installed"
""",
    "apt-get": """\
echo "apt-get $* [$DEBIAN_FRONTEND] $(umask)" >>"$SHIMS/calls"
echo "apt says this on stdout"
case " $* " in
  *" update "*) : >"$SHIMS/lists" ;;
  *" install "*)
    [ -e "$SHIMS/lists" ] || { echo 'E: Unable to locate package lib-one' >&2; exit 100; }
    for word; do case $word in lib-*|viewer) echo "$word" >>"$SHIMS/installed" ;; esac; done ;;
esac
""",
    "dpkg": "exit 0\n",
    "id": 'echo "${FAKE_UID:-0}"\n',
    # A build that takes no time.
    "cmake": """\
echo "cmake $*" >>"$SHIMS/calls"
case $1 in
  --preset) mkdir -p "$4/build/release/cli"
    printf 'CMAKE_HOME_DIRECTORY:INTERNAL=%s\\nBACKBEND_TESTS:BOOL=%s\\n' "$4" "${5#*=}" \\
      >"$4/build/release/CMakeCache.txt"
    : >"$4/build/release/build.ninja" ;;
esac
""",
    "ninja": """\
printf '#!/bin/sh\\necho "ran $*"\\n' >"$2/cli/backbend"
chmod +x "$2/cli/backbend"
""",
    "ctest": 'echo "ctest $*"\n',
}
SUDO = """\
[ "$1" != -n ] || shift
[ "${SUDO_PASSWORD:-}" = "" ] || exit 1
echo "sudo $*" >>"$SHIMS/calls"
exec "$@"
"""


class Tree:
    """A project of one file under the launcher, in a folder with an awkward name."""

    def __init__(self, test):
        holder = tempfile.TemporaryDirectory(prefix="launcher ")
        test.addCleanup(holder.cleanup)
        self.top = pathlib.Path(holder.name)
        self.root = self.top / "a [clöne] of hers"
        self.shims = self.top / "shims"
        for folder in (self.root / "cli", self.shims):
            folder.mkdir(parents=True)
        shutil.copy(SOURCE / "backbend", self.root)
        self.write("CMakeLists.txt", CMAKE_LISTS)
        self.write("CMakePresets.json", PRESETS)
        self.write("packages.txt", "[tool]\n[tests]\n")
        self.write("cli/CMakeLists.txt", CLI_LISTS)
        self.write("cli/main.c", PROGRAM)
        self.environment = dict(os.environ, SHIMS=str(self.shims))
        self.environment.pop("DEBIAN_FRONTEND", None)

    def write(self, name, text):
        (self.root / name).write_text(text)

    def shim(self, name, body):
        path = self.shims / name
        path.write_text("#!/bin/sh\n" + body)
        path.chmod(0o755)

    def use_shims(self):
        """Nothing but the stand-ins and the everyday commands: the real package tools and sudo
        cannot be reached."""
        everyday = self.top / "everyday"
        everyday.mkdir()
        hidden = {*SHIMS, "sudo"}
        for folder in ("/usr/bin", "/bin"):
            for path in pathlib.Path(folder).iterdir():
                if path.name not in hidden and not (everyday / path.name).is_symlink():
                    (everyday / path.name).symlink_to(path)
        for name, body in SHIMS.items():
            self.shim(name, body)
        (self.shims / "installed").touch()
        self.write("packages.txt", PACKAGES)
        self.environment["PATH"] = f"{self.shims}:{everyday}"

    def calls(self, word=""):
        path = self.shims / "calls"
        return [line for line in path.read_text().splitlines() if word in line] if path.exists() else []

    def run(self, *arguments, program=None, **options):
        environment = dict(self.environment, **options.pop("environment", {}))
        options.setdefault("stdin", subprocess.DEVNULL)
        if "input" in options:
            del options["stdin"]
        return subprocess.run([str(program or self.root / "backbend"), *arguments], text=True,
                              capture_output=True, timeout=300, env=environment, **options)


class LauncherBuilds(unittest.TestCase):
    """With the real build tools."""

    @classmethod
    def setUpClass(cls):
        cls.cleanups = unittest.TestCase()
        cls.tree = Tree(cls.cleanups)
        cls.first = cls.tree.run("nightly", "an argument", "*")

    @classmethod
    def tearDownClass(cls):
        cls.cleanups.doCleanups()

    def setUp(self):
        self.tree.write("cli/main.c", PROGRAM)
        self.tree.write("cli/CMakeLists.txt", CLI_LISTS)

    def test_the_first_run_builds_and_leaves_stdout_to_the_tool(self):
        self.assertEqual(self.first.returncode, 0, self.first.stderr)
        self.assertEqual(self.first.stdout, f"one {os.getcwd()} [nightly] [an argument] [*]\n")
        self.assertIn("backbend: built in", self.first.stderr)

    def test_a_run_with_nothing_changed_is_quick_and_says_nothing(self):
        self.tree.run()
        started = time.monotonic()
        for _ in range(5):
            again = self.tree.run()
            self.assertEqual((again.returncode, again.stderr), (0, ""))
        # 6 ms of the launcher's own when measured; the limit leaves room for a loaded machine, and
        # a configure alone takes longer.
        self.assertLess((time.monotonic() - started) / 5, 0.3)

    def test_exit_code_stdin_and_working_directory_are_the_tools_own(self):
        self.assertEqual(self.tree.run("exit", "43").returncode, 43)
        self.assertEqual(self.tree.run("cat", input="from\nstdin").stdout, "from\nstdin")
        self.assertEqual(self.tree.run(cwd="/").stdout, "one /\n")

    def test_it_runs_through_a_symlink_from_anywhere(self):
        link = self.tree.top / "link"
        link.symlink_to(self.tree.root / "backbend")
        second = self.tree.top / "second"
        second.symlink_to("link")
        result = self.tree.run("x", program=second, cwd="/tmp")
        self.assertEqual((result.returncode, result.stdout), (0, "one /tmp [x]\n"))

    def test_a_change_is_built_even_when_it_looks_old(self):
        self.tree.write("cli/main.c", PROGRAM.replace('"one ', '"two '))
        self.assertTrue(self.tree.run().stdout.startswith("two "))
        # A copy that keeps its time: changed now, but older than everything built.
        word = self.tree.root / "cli/word.h"
        self.tree.write("cli/main.c", '#include "word.h"\n' + PROGRAM.replace('"one ', 'WORD "'))
        for content in ("three ", "four "):
            word.write_text(f'#define WORD "{content}"\n')
            os.utime(word, (1e9, 1e9))
            self.assertTrue(self.tree.run().stdout.startswith(content), content)

    def test_a_program_that_does_not_compile_is_70_with_the_reason(self):
        self.tree.write("cli/main.c", "int main(void) { return nonsense; }\n")
        broken = self.tree.run()
        self.assertEqual((broken.returncode, broken.stdout), (70, ""))
        self.assertIn("nonsense", broken.stderr)
        self.assertIn("the build failed", broken.stderr.splitlines()[-1])
        self.assertEqual(self.tree.run().returncode, 70)  # and again: nothing old is run instead
        self.tree.write("cli/main.c", PROGRAM)
        self.assertEqual(self.tree.run().returncode, 0)

    def test_a_project_that_does_not_configure_is_70_with_the_reason(self):
        self.tree.write("cli/CMakeLists.txt", CLI_LISTS + 'message(FATAL_ERROR "no such luck")\n')
        shutil.rmtree(self.tree.root / "build")
        broken = self.tree.run()
        self.tree.write("cli/CMakeLists.txt", CLI_LISTS)
        self.assertEqual((broken.returncode, broken.stdout), (70, ""))
        self.assertIn("no such luck", broken.stderr)
        self.assertEqual(self.tree.run().returncode, 0)

    def test_odd_locale_umask_terminal_and_closed_streams_change_nothing(self):
        for setting in ("umask 077", "export LC_ALL=de_DE.UTF-8 LANGUAGE=tr", "export TERM=nonsense",
                        "export CDPATH=/", "unset HOME", "exec 0<&-", "exec 2>&-", "export TZ=Asia/Kolkata"):
            (self.tree.root / "cli/main.c").touch()  # so that there is something to build
            command = f'{setting}; exec "$0" same'
            result = subprocess.run(["sh", "-c", command, str(self.tree.root / "backbend")], text=True,
                                    capture_output=True, env=self.tree.environment, cwd="/")
            self.assertEqual((result.returncode, result.stdout), (0, "one / [same]\n"), f"{setting}: {result.stderr}")

    def test_closed_stdout_does_not_break_the_build(self):
        (self.tree.root / "cli/main.c").touch()
        result = subprocess.run(["sh", "-c", 'exec 1>&-; exec "$0" exit 9', str(self.tree.root / "backbend")],
                                stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 9, result.stderr)

    def test_a_tree_that_was_moved_is_built_anew(self):
        moved = self.tree.top / "moved"
        shutil.copytree(self.tree.root, moved)
        result = self.tree.run("x", program=moved / "backbend", cwd="/")
        self.assertEqual((result.returncode, result.stdout), (0, "one / [x]\n"), result.stderr)
        self.assertTrue((moved / "build/release/cli/backbend").exists())

    @unittest.skipUnless(os.geteuid() == 0, "only root can become somebody else")
    def test_a_build_that_belongs_to_another_user_runs_and_is_not_touched(self):
        self.assertEqual(self.tree.run().returncode, 0)
        self.tree.top.chmod(0o755)
        nobody = ["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups"]

        def run():
            return subprocess.run([*nobody, self.tree.root / "backbend", "exit", "7"], text=True, cwd="/",
                                  capture_output=True)

        self.assertEqual((run().returncode, run().stderr), (7, ""))
        (self.tree.root / "cli/main.c").touch()
        refused = run()
        self.assertEqual((refused.returncode, refused.stdout), (73, ""))
        self.assertEqual(len(refused.stderr.splitlines()), 1, refused.stderr)

    def test_runs_at_the_same_time_build_once_and_all_succeed(self):
        shutil.rmtree(self.tree.root / "build")
        runs = [subprocess.Popen([self.tree.root / "backbend", str(i)], stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True, cwd="/") for i in range(4)]
        told = [run.communicate(timeout=120) for run in runs]
        self.assertEqual([run.returncode for run in runs], [0] * 4, told)
        self.assertEqual([out for out, _ in told], [f"one / [{i}]\n" for i in range(4)])
        self.assertEqual(sum("built in" in err for _, err in told), 1, told)

    def test_a_signal_ends_the_build_and_frees_the_tree(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            # A compiler that never comes back.
            self.tree.write("cli/CMakeLists.txt", CLI_LISTS +
                            "add_custom_command(TARGET backbend PRE_LINK COMMAND sleep 30)\n")
            run = subprocess.Popen([self.tree.root / "backbend"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, cwd="/")
            time.sleep(2)
            self.assertIsNone(run.poll())
            run.send_signal(number)
            _, told = run.communicate(timeout=10)  # ends only when every child let go of the pipes
            self.assertEqual(run.returncode, -number, told)
            self.tree.write("cli/CMakeLists.txt", CLI_LISTS)
            self.assertEqual(self.tree.run("exit", "0").returncode, 0)

    def test_test_runs_ctest_and_ends_with_its_summary(self):
        result = self.tree.run("test", cwd="/")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("100% tests passed, 0 tests failed out of 1", result.stdout)
        self.assertIn("Total Test time", result.stdout.splitlines()[-1])
        self.assertNotEqual(self.tree.run("test", "-R", "no such test").returncode, 0)
        # The tool afterwards is still built for the tests, and has nothing to do.
        self.assertEqual(self.tree.run("x", cwd="/").stderr, "")


class LauncherInstalls(unittest.TestCase):
    """With stand-ins for the package tools and the build."""

    def setUp(self):
        self.tree = Tree(self)
        self.tree.use_shims()

    def test_root_installs_what_is_missing_without_a_question(self):
        (self.tree.shims / "installed").write_text("lib-one\n")
        (self.tree.shims / "lists").touch()
        result = self.tree.run("nightly", preexec_fn=lambda: os.umask(0o077))
        self.assertEqual((result.returncode, result.stdout), (0, "ran nightly\n"), result.stderr)
        (call,) = self.tree.calls("apt-get")
        self.assertTrue(call.endswith(" install --no-install-recommends lib-two [noninteractive] 0022"), call)
        self.assertIn(" -y ", call)
        self.assertNotIn("apt says", result.stdout + result.stderr)

    def test_lists_are_brought_up_to_date_only_when_the_first_try_fails(self):
        self.assertEqual(self.tree.run("nightly").returncode, 0)
        self.assertEqual([call.split(" [")[0].split()[-1] for call in self.tree.calls("apt-get")],
                         ["lib-two", "update", "lib-two"])

    def test_nothing_is_asked_of_the_package_tools_when_nothing_is_missing(self):
        (self.tree.shims / "installed").write_text("lib-one\nlib-two\n")
        self.assertEqual(self.tree.run("nightly").returncode, 0)
        self.assertEqual(self.tree.calls("apt-get"), [])

    def test_the_tests_packages_are_for_test_only_and_a_command_may_stand_in_for_one(self):
        (self.tree.shims / "installed").write_text("lib-one\nlib-two\n")
        self.tree.shim("viewer", "exit 0\n")
        self.tree.run("nightly")
        self.assertEqual(self.tree.calls("apt-get"), [])
        self.assertIn("-DBACKBEND_TESTS=OFF", self.tree.calls("--preset")[-1])
        (self.tree.shims / "lists").touch()
        result = self.tree.run("test", "-R", "one")
        self.assertIn("--no-install-recommends lib-test [", self.tree.calls("apt-get")[-1])
        self.assertIn("-DBACKBEND_TESTS=ON", self.tree.calls("--preset")[-1])
        self.assertRegex(result.stdout, r"^ctest --test-dir .* -R one\n$")

    def test_the_pages_npm_packages_are_installed_once_and_only_for_test(self):
        (self.tree.shims / "installed").write_text("lib-one\nlib-two\nlib-test\nviewer\n")
        web = self.tree.root / "tests/web"
        web.mkdir(parents=True)
        (web / "package-lock.json").write_text("{}")
        self.tree.shim("npm", "echo 'npm error no registry' >&2; exit 1\n")
        failing = self.tree.run("test")
        self.assertEqual(failing.returncode, 0)  # the page's tests skip themselves
        self.assertIn("no registry", failing.stderr)
        self.assertIn("will be skipped", failing.stderr)
        self.tree.shim("npm", 'echo "npm $*" >>"$SHIMS/calls"\n'
                       'mkdir -p "$3/node_modules"; : >"$3/node_modules/.package-lock.json"\n')
        for command in ("nightly", "test", "test", "nightly"):
            self.assertEqual(self.tree.run(command).returncode, 0)
        self.assertEqual(len(self.tree.calls("npm ci")), 1)

    def test_a_user_installs_through_sudo(self):
        self.tree.shim("sudo", SUDO)
        (self.tree.shims / "lists").touch()
        result = self.tree.run("nightly", environment={"FAKE_UID": "1000"})
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue(self.tree.calls("sudo env"), self.tree.calls())

    def test_without_sudo_one_line_names_the_packages(self):
        result = self.tree.run("nightly", environment={"FAKE_UID": "1000"})
        self.assert_one_line(result, "lib-one lib-two", "no sudo")

    def test_sudo_that_wants_a_password_is_not_waited_for_without_a_terminal(self):
        self.tree.shim("sudo", SUDO)
        result = self.tree.run("nightly", environment={"FAKE_UID": "1000", "SUDO_PASSWORD": "yes"})
        self.assert_one_line(result, "lib-one lib-two", "password")

    def test_without_a_network_the_reason_and_the_packages_are_told(self):
        self.tree.shim("apt-get", "echo 'E: Could not resolve the archive' >&2; exit 100\n")
        result = self.tree.run("nightly")
        self.assertEqual((result.returncode, result.stdout), (75, ""), result.stderr)
        self.assertIn("E: Could not resolve the archive", result.stderr)
        self.assertIn("lib-one lib-two", result.stderr.splitlines()[-1])

    def assert_one_line(self, result, *words):
        self.assertEqual((result.returncode, result.stdout), (75, ""), result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertFalse((self.tree.root / "build/release/CMakeCache.txt").exists())

"""A night in shards: the same bytes as on one machine, whatever was cut, killed or damaged."""

import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import harness
import night
from night import NightTest

INCOMPLETE = 4


def parent_of(pid):
    """The parent's id, of a process that may have ended meanwhile."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1]
    except OSError:
        return ""


def name_of(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


class CuttingANight(NightTest):
    def test_a_run_of_one_process_leaves_no_parts(self):
        self.assertIn("report.json", self.expected)
        self.assertFalse((self.folder / "whole/parts").exists())

    def test_shards_in_one_folder_merge_into_the_same_bytes_twice(self):
        for share in ("2/3", "3/3", "1/3"):
            self.shard("shared", share)
        self.assertFalse((self.folder / "shared/report.json").exists())
        told = self.merge("shared")
        # Only the folder differs in what is printed.
        self.assertEqual(told.stdout.replace("/shared/", "/whole/"), self.whole.stdout)
        self.assert_whole("shared")
        self.merge("shared")
        self.assert_whole("shared")

    def test_shards_of_machines_that_share_nothing_merge_in_any_grouping(self):
        for i in (1, 2, 3):
            self.shard(f"apart {i}", f"{i}/3")
        missing = self.merge("apart 3", "apart 1", code=INCOMPLETE, output="two")
        self.assertIn("missing: picture ", missing.stderr)
        self.assertFalse((self.folder / "two/report.json").exists())
        self.merge("two", "apart 2", output="left first")
        self.assert_whole("left first")
        self.merge("apart 1", "apart 2", "apart 3", output="at once")
        self.assert_whole("at once")

    def test_a_merge_from_elsewhere_finds_baseline_and_history_and_tells_the_night_once(self):
        approved = self.backbend("approve", "--run", self.folder / "whole", "--baseline", "baseline.json",
                                 "--author", "a lead", "--reason", "show start")
        self.assertEqual(approved.returncode, 0, approved.stderr)
        told = ("--quick", "--baseline", "baseline.json", "--label", "v1", "--history")
        done = self.nightly("approved", *told, "one.jsonl")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for share in ("1/2", "2/2"):
            self.shard("approved in shards", share, *told, "shards.jsonl")
        for _ in range(2):
            done = harness.run_backbend(["merge", self.folder / "approved in shards"], self.folder, cwd="/")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(night.results(self.folder / "approved in shards"), night.results(self.folder / "approved"))
            self.assertEqual((self.folder / "shards.jsonl").read_bytes(), (self.folder / "one.jsonl").read_bytes())

    def test_a_missing_shard_is_named_and_no_report_pretends(self):
        self.shard("lost", "1/2")
        told = self.merge("lost", code=INCOMPLETE)
        self.assertIn("missing", told.stderr.splitlines()[-1])
        self.assertFalse((self.folder / "lost/index.html").exists())
        self.assertFalse((self.folder / "lost/report.json").exists())

    def test_shards_of_different_jobs_are_refused(self):
        self.shard("mixed a", "1/2", "--quick")
        self.shard("mixed b", "2/2", "--quick", "--spp", "3")
        told = self.merge("mixed a", "mixed b", code=harness.BAD_INPUT, output="mixed")
        self.assertIn("another job", told.stderr)
        refused = self.nightly("mixed a", "--shard", "2/2", "--quick", "--spp", "3")
        self.assertEqual(refused.returncode, harness.BAD_INPUT, refused.stderr)

    def test_a_character_that_changed_since_is_refused(self):
        suite = night.prepare(self.folder / "changing")
        for i in (1, 2):
            done = self.backbend("nightly", suite, "--quick", "-o", "changed", "--shard", f"{i}/2")
            self.assertEqual(done.returncode, 0, done.stderr)
        with (suite.parent / "human.glb").open("ab") as character:
            character.write(b"\0\0\0\0")
        self.assertIn("changed", self.merge("changed", code=harness.BAD_INPUT).stderr)

    def test_a_share_that_is_none_is_a_usage_error(self):
        for share in ("0/3", "4/3", "1", "1/0", "a/b", "auto", "1/3x"):
            done = self.nightly("none", "--shard", share)
            self.assertEqual(done.returncode, harness.USAGE, share)
            self.assertIn("--shard", done.stderr)
        self.assertFalse((self.folder / "none").exists())

    def test_a_dry_run_says_what_there_is_to_do_and_writes_nothing(self):
        done = self.nightly("dry", "--dry-run", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        plan = json.loads(done.stdout)
        self.assertEqual((plan["characters"], plan["rigs"], plan["canaries"]), (1, 2, 1))
        self.assertEqual(plan["poses"], 2 * 21)
        self.assertEqual(plan["searched"], 2 * 11)  # half of them
        self.assertEqual(plan["pictures"], 2 * 21 + 3)
        self.assertGreater(plan["minutes"], 0)
        self.assertFalse((self.folder / "dry").exists())


class TakingUpANight(NightTest):
    def test_what_was_killed_anywhere_resumes_to_the_same_bytes(self):
        draw = random.Random(8)
        command = [str(harness.BACKBEND), "nightly", str(self.suite), "-o", "killed", "--resume"]
        for _ in range(4):
            with subprocess.Popen(command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, env=harness.bare_environment(self.folder)) as run:
                until = time.monotonic() + draw.uniform(0.2, 6.0)
                while run.poll() is None and time.monotonic() < until:
                    time.sleep(0.005)
                run.kill()
            for part in (self.folder / "killed").rglob("*.part"):
                self.assertTrue(part.read_bytes().startswith(b"backbend part 1\n"))
        done = self.nightly("killed", "--resume")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assert_whole("killed")

    def test_what_is_damaged_is_made_again_and_what_is_whole_is_kept(self):
        self.assertEqual(self.nightly("damaged", "--resume").returncode, 1)
        run = self.folder / "damaged"
        parts = sorted((run / "parts").glob("*.part"))
        frames = sorted(run.rglob("review/*/*.png"))
        self.assertGreater(len(parts), 10)
        parts[0].write_bytes(parts[0].read_bytes()[:-1])            # cut
        flipped = bytearray(parts[1].read_bytes())
        flipped[-1] ^= 1
        parts[1].write_bytes(flipped)                               # one bit
        parts[2].unlink()                                           # lost
        frames[0].write_bytes(frames[1].read_bytes())               # another frame's bytes
        frames[2].write_bytes(b"")
        kept = frames[3].stat().st_mtime_ns
        self.assertEqual(self.nightly("damaged", "--resume").returncode, 1)
        self.assert_whole("damaged")
        self.assertEqual(frames[3].stat().st_mtime_ns, kept, "a whole frame was rendered again")

    def test_a_second_run_on_the_folder_is_sent_away_and_harms_nothing(self):
        command = [str(harness.BACKBEND), "nightly", str(self.suite), "-o", "busy"]
        with subprocess.Popen(command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, env=harness.bare_environment(self.folder)) as first:
            deadline = time.monotonic() + 120
            while not (self.folder / "busy/parts").exists() and time.monotonic() < deadline:
                time.sleep(0.01)
            first.send_signal(signal.SIGSTOP)
            second = self.nightly("busy")
            first.send_signal(signal.SIGCONT)
            self.assertEqual(second.returncode, harness.RETRY, second.stderr)
            self.assertEqual(first.wait(timeout=2 * harness.PATIENCE_S), 1)
        self.assert_whole("busy")


    def test_eight_runs_that_start_at_once_on_a_folder_do_each_other_no_harm(self):
        # Whoever is sent away must not take the folder along that another has just made.
        command = [str(harness.BACKBEND), "nightly", str(self.suite), "--quick", "--quiet", "-o", "at once"]
        self.assertEqual(self.nightly("alone", "--quick").returncode, 1)
        alone = night.results(self.folder / "alone")
        for number in range(3):
            with self.subTest(number=number):
                shutil.rmtree(self.folder / "at once", ignore_errors=True)
                runs = [subprocess.Popen(command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                         stderr=subprocess.PIPE, text=True, env=harness.bare_environment(self.folder))
                        for _ in range(8)]
                told = [run.communicate(timeout=harness.PATIENCE_S)[1] for run in runs]
                codes = [run.returncode for run in runs]
                self.assertLessEqual(set(codes), {1, harness.RETRY}, told)
                self.assertIn(1, codes)
                self.assertEqual(night.results(self.folder / "at once"), alone)


class WritingFarmScripts(NightTest):
    def farm(self, engine, run, *more):
        done = self.backbend("farm", engine, self.suite, "-o", run, "--shards", "3", *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return pathlib.Path(done.stdout.strip())

    def test_gnu_parallel_runs_the_night(self):
        if not shutil.which("parallel"):
            self.skipTest("GNU parallel is not installed")
        start = self.farm("parallel", "a 'quoted' $run %d")
        done = subprocess.run([start, "--jobs", "2"], cwd="/", capture_output=True, text=True,
                              env=harness.bare_environment(self.folder))
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assert_whole("a 'quoted' $run %d")

    def test_the_open_job_template_follows_its_rules(self):
        template = json.loads(self.farm("openjd", "open").read_text())
        self.assertEqual(template["specificationVersion"], "jobtemplate-2023-09")
        shards, merge = template["steps"]
        self.assertEqual(template["extensions"], ["TASK_CHUNKING"])
        (parameter,) = shards["parameterSpace"]["taskParameterDefinitions"]
        self.assertEqual((parameter["name"], parameter["type"], parameter["range"]), ("Shard", "CHUNK[INT]", "1-3"))
        self.assertEqual(parameter["chunks"],
                         {"defaultTaskCount": 1, "targetRuntimeSeconds": 300, "rangeConstraint": "CONTIGUOUS"})
        self.assertEqual(merge["dependencies"], [{"dependsOn": shards["name"]}])
        # The same as a worker would do: each task's command with its parameter put in.
        for step, values in ((shards, ("1-2", "3-3")), (merge, (None,))):
            run = step["script"]["actions"]["onRun"]
            for value in values:
                words = [word.replace("{{Task.Param.Shard}}", str(value)) for word in run["args"]]
                done = subprocess.run([run["command"], *words], capture_output=True, text=True, cwd="/")
                self.assertEqual(done.returncode, 0 if step is shards else 1, done.stderr)
        self.assert_whole("open")

    def test_every_script_is_sound(self):
        if not shutil.which("shellcheck"):
            self.skipTest("shellcheck is not installed")
        for engine in ("slurm", "parallel", "openjd"):
            scripts = sorted(self.farm(engine, f"{engine} scripts").parent.glob("*.sh"))
            self.assertGreaterEqual(len(scripts), 2)
            done = subprocess.run(["shellcheck", *scripts], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout)


class RunningOnSlurm(NightTest):
    """A real Slurm of two virtual nodes on this machine, with a munge of its own."""

    PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"  # daemons lie where only root's own leads

    @classmethod
    def setUpClass(cls):
        for program in ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "sinfo"):
            if not shutil.which(program, path=cls.PATH):
                raise unittest.SkipTest(f"{program} is not installed")
        if os.geteuid() != 0:
            raise unittest.SkipTest("needs root")
        super().setUpClass()
        state = tempfile.TemporaryDirectory(prefix="backbend-slurm-", dir="/tmp", ignore_cleanup_errors=True)
        cls.addClassCleanup(state.cleanup)
        cls.state = pathlib.Path(state.name)
        cls.state.chmod(0o711)
        cls.processes = {}
        cls.addClassCleanup(cls.stop_all)
        cls.start_munge()
        cls.start_slurm()

    @classmethod
    def start(cls, name, *command):
        log = (cls.state / f"{name}.out").open("wb")
        with log:
            cls.processes[name] = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                                   env=cls.environment(), start_new_session=True)

    @classmethod
    def environment(cls):
        return harness.bare_environment(cls.folder, PATH=cls.PATH, SLURM_CONF=str(cls.state / "slurm.conf"))

    @classmethod
    def start_munge(cls):
        munge = cls.state / "munge"
        munge.mkdir(mode=0o711)
        key = munge / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        cls.socket = munge / "munge.socket.2"
        cls.start("munged", "munged", "--foreground", "--force", f"--key-file={key}", f"--socket={cls.socket}",
                  f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed")
        cls.wait_for(lambda: cls.socket.exists(), 20, "munge does not start here")

    @classmethod
    def start_slurm(cls):
        host = os.uname().nodename.split(".")[0]
        base = 20000 + os.getpid() % 20000
        for name in ("ctld", "n1", "n2"):
            (cls.state / name).mkdir()
        (cls.state / "slurm.conf").write_text(f"""
ClusterName=backbend
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort={base}
AuthType=auth/munge
AuthInfo=socket={cls.socket}
CredType=cred/munge
StateSaveLocation={cls.state}/ctld
SlurmdSpoolDir={cls.state}/%n
SlurmctldPidFile={cls.state}/ctld.pid
SlurmdPidFile={cls.state}/%n.pid
SlurmctldLogFile={cls.state}/ctld.log
SlurmdLogFile={cls.state}/%n.log
SlurmdParameters=config_overrides
SlurmdTimeout=10
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SchedulerType=sched/backfill
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={base + 1} CPUs=1 RealMemory=2000 State=UNKNOWN
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={base + 2} CPUs=1 RealMemory=2000 State=UNKNOWN
PartitionName=render Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
""")
        cls.start("slurmctld", "slurmctld", "-D", "-i")
        for node in ("n1", "n2"):
            cls.start(node, "slurmd", "-D", "-N", node)
        cls.wait_for(lambda: cls.say("sinfo", "-h", "-o", "%D %t") == "2 idle", 60, "Slurm does not start here")

    @classmethod
    def wait_for(cls, ready, seconds, why):
        deadline = time.monotonic() + seconds
        while not ready():
            if time.monotonic() > deadline:
                logs = "".join(path.read_text(errors="replace")[-600:] for path in sorted(cls.state.glob("*.log")))
                raise unittest.SkipTest(f"{why}: {logs}")
            time.sleep(0.2)

    @classmethod
    def say(cls, *command):
        return subprocess.run(command, env=cls.environment(), capture_output=True, text=True).stdout.strip()

    @classmethod
    def stop_all(cls):
        for process in reversed(list(cls.processes.values())):
            with contextlib.suppress(ProcessLookupError):
                process.terminate()
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def submit(self, run, shards):
        done = self.backbend("farm", "slurm", self.suite, "-o", run, "--shards", shards, "--submit",
                             environment=self.environment())
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split()[-1]

    def wait_for_end(self, run, seconds):
        """Until no job is left; a report shows that the merge ran."""
        deadline = time.monotonic() + seconds
        while self.say("squeue", "-h"):
            if time.monotonic() > deadline:
                logs = "".join(p.read_text(errors="replace") for p in (self.folder / run / "farm").glob("*.log"))
                self.fail("the jobs do not end: " + self.say("squeue", "-l") + "\n" + logs)
            time.sleep(0.5)

    def test_an_array_of_shards_and_its_merge_give_the_same_bytes(self):
        self.submit("array", 3)
        self.wait_for_end("array", 600)
        self.assert_whole("array")

    def test_a_node_that_dies_in_mid_run_is_made_up_for(self):
        if os.environ.get("BACKBEND_LONG") != "1":
            self.skipTest("takes minutes: BACKBEND_LONG=1 runs it")
        self.submit("dying", 4)
        self.wait_for(lambda: self.say("squeue", "-h", "-w", "n2", "-t", "R"), 60, "nothing runs on n2")
        time.sleep(0.5)
        # The daemon, then the keeper of the step (which would still tell), then the step itself.
        steps = [pid for pid in os.listdir("/proc") if pid.isdigit() and self.belongs_to(pid, "n2")]
        keepers = {parent for parent in map(parent_of, steps) if name_of(parent) == "slurmstepd"}
        self.assertTrue(keepers, "no step found on n2")
        self.processes["n2"].kill()
        for pid in [*keepers, *steps]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(int(pid), signal.SIGKILL)
        self.wait_for_end("dying", 800)
        self.assertIn("down", self.say("sinfo", "-h", "-N", "-n", "n2", "-o", "%t"))
        self.assert_whole("dying")

    def belongs_to(self, pid, node):
        """Whether a process is a step of our jobs on that node, by its environment."""
        try:
            settings = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
        except OSError:
            return False
        return (f"SLURM_CONF={self.state}/slurm.conf".encode() in settings and
                f"SLURMD_NODENAME={node}".encode() in settings)

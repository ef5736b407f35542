"""How the module lives with its interpreter: Ctrl-C, threads, forks, an exit while it works."""

import pathlib
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from module import PATIENCE_S, ModuleTest  # noqa: E402

LONG = "backbend.compare('curve', 'isner', character=HUMAN, pictures=True)"


class Interrupting(ModuleTest):
    def interrupted(self, script):
        process = self.start(script)
        self.assertEqual(process.stdout.readline(), "begins\n")
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual((process.returncode, out), (0, "stopped\n"), err)

    def test_ctrl_c_ends_a_judgement_and_the_next_one_works(self):
        self.interrupted(f"""
print("begins", flush=True)
try:
    while True:
        {LONG}
except KeyboardInterrupt:
    print("stopped", flush=True)
assert backbend.judge(HUMAN, "even").findings is not None
""")

    def test_ctrl_c_ends_a_large_solve(self):
        self.interrupted("""
rig = backbend.Rig("even", np.array([[0, 0, 0], [0, 1, 0], [0, 2, 0]], float))
controls = np.zeros((1 << 17, len(rig.channels)))
print("begins", flush=True)
try:
    while True:
        rig.solve(controls, measures=True)
except KeyboardInterrupt:
    print("stopped", flush=True)
""")

    def test_a_signal_handler_of_the_callers_own_decides(self):
        self.interrupted(f"""
import signal
class Enough(Exception): pass
def handler(*_): raise Enough
signal.signal(signal.SIGINT, handler)
print("begins", flush=True)
try:
    while True:
        {LONG}
except Enough:
    print("stopped", flush=True)
""")


class ManyThreads(ModuleTest):
    def test_threads_of_python_get_the_same_results_at_once(self):
        self.run_script("""
import threading
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
controls = np.random.default_rng(1).uniform(-60, 60, (20, len(rig.channels)))
expected = body.pose(rig, controls).positions
report = backbend.judge(body, "even").text
wrong = []
def work(number):
    for _ in range(5):
        if not (body.pose(rig, controls).positions == expected).all(): wrong.append("pose")
        if not np.isfinite(rig.solve(controls).positions).all(): wrong.append("solve")
    if number < 2 and backbend.judge(body, "even").text != report: wrong.append("judge")
threads = [threading.Thread(target=work, args=(n,)) for n in range(6)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert not wrong, wrong
""")

    def test_other_threads_run_while_it_works(self):
        self.run_script("""
import threading
counted, over = [0], threading.Event()
def count():
    while not over.is_set():
        counted[0] += 1
        over.wait(0.001)
thread = threading.Thread(target=count)
thread.start()
before = counted[0]
backbend.judge(HUMAN, "isner")
during = counted[0] - before
over.set(); thread.join()
assert during > 5, during
""")

    def test_arrays_that_another_thread_writes_never_crash_it(self):
        self.run_script("""
import threading
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
controls, over = np.zeros((200, len(rig.channels))), threading.Event()
def scribble():
    rng = np.random.default_rng(1)
    while not over.is_set(): controls[:] = rng.uniform(-1e3, 1e3, controls.shape)
thread = threading.Thread(target=scribble)
thread.start()
for _ in range(20): body.pose(rig, controls)
over.set(); thread.join()
""")


class Forking(ModuleTest):
    def test_a_copy_of_a_process_that_has_worked_refuses_and_ends(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
body.pose(rig, rig.rest_controls)
child = os.fork()
if child == 0:
    for call in (lambda: body.pose(rig, rig.rest_controls), lambda: backbend.judge(HUMAN), lambda: body.measure(rig)):
        try:
            call()
            os._exit(1)
        except RuntimeError as error:
            if "spawn" not in str(error): os._exit(2)
    rig.solve(np.zeros((10, len(rig.channels))))  # needs no threads
    sys.exit(0)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
body.pose(rig, rig.rest_controls)
""")

    def test_a_copy_made_before_the_first_use_works(self):
        self.run_script("""
child = os.fork()
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
assert len(body.pose(rig, rig.rest_controls).positions) == 1
if child == 0: sys.exit(0)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
""")

    def test_a_fork_in_the_middle_of_work_in_another_thread_is_refused_there(self):
        self.run_script("""
import threading, time
thread = threading.Thread(target=lambda: backbend.judge(HUMAN, "isner"))
thread.start()
time.sleep(0.2)
child = os.fork()
if child == 0:
    try:
        backbend.judge(HUMAN)
    except RuntimeError:
        os._exit(0)
    os._exit(1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
thread.join()
""")


class Exiting(ModuleTest):
    def test_an_exit_while_a_thread_works_ends_cleanly(self):
        for work in (LONG, "[rig.solve(many, measures=True) for _ in range(1000)]"):
            self.run_script(f"""
import threading, time
rig = backbend.Rig("even", np.array([[0, 0, 0], [0, 1, 0], [0, 2, 0]], float))
many = np.zeros((1 << 16, len(rig.channels)))
def work():
    try:
        {work}
    except BaseException:
        pass
threading.Thread(target=work, daemon=True).start()
time.sleep(0.4)
""")

    def test_an_exit_while_a_rig_in_python_is_asked_ends_cleanly(self):
        self.run_script("""
import threading, time
body = backbend.load(HUMAN)
class Slow(backbend.PythonRig):
    def __init__(self): super().__init__(["extension", "side", "twist"], body.joints, body.parents, body.rest_matrices)
    def pose(self, values):
        time.sleep(0.05)
        return np.tile(body.rest_matrices, (len(values), 1, 1, 1))
def work():
    try:
        backbend.judge(body, Slow())
    except BaseException:
        pass
threading.Thread(target=work, daemon=True).start()
time.sleep(0.4)
""")

    def test_objects_and_arrays_that_are_left_at_the_end_do_not_matter(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
poses = body.pose(rig, np.tile(rig.rest_controls, (3, 1)))
class Kept(backbend.PythonRig):
    def pose(self, values): return np.tile(body.rest_matrices, (len(values), 1, 1, 1))
own = backbend.Rig(Kept(["extension"], body.joints, body.parents, body.rest_matrices), body)
sys.kept = [body, rig, poses, own]
sys.modules["kept"] = sys.kept
""")

    def test_work_at_the_exit_is_refused(self):
        out = self.run_script("""
import atexit
rig = backbend.Rig("even", np.array([[0, 0, 0], [0, 1, 0], [0, 2, 0]], float))
class AtTheEnd:
    def __del__(self):
        try:
            rig.solve(rig.rest_controls)
        except RuntimeError as error:
            print("exits" in str(error))
sys.at_the_end = AtTheEnd()
""")
        self.assertIn(out, ("True\n", ""))

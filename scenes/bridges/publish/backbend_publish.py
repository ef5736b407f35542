"""Refuses a publish on new or worse findings of `backbend check`: for Pyblish, for AYON, and for hooks.

    PYBLISHPLUGINPATH=.../scenes/bridges/publish           # Pyblish finds the plugins below
    python3 backbend_publish.py hero.glb                   # a hook: 0 go on, 1 refused, 2 usage

One file, Python 3.7 or newer, nothing but backbend beside it; docs/publish.md says how it is set up. A fault of ours
(backbend is missing, too slow, broken, or did not measure something) never blocks a publish: it is a warning that
says so.
"""

import argparse
import collections
import getpass
import html
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

CHARACTERS = (".glb", ".gltf", ".fbx", ".dae")
# What the exit codes of backbend mean for a publish; all others are faults of ours.
PASS, FINDINGS, BAD_INPUT, NOT_MEASURED = 0, 1, 3, 5
FAULTS = {2: "was called with options that it does not know", 4: "did not finish", 6: "found no baseline",
          70: "had an internal error", 73: "could not write", 75: "ran out of room or was not ready",
          130: "was interrupted", 143: "was ended"}
MOST_LINES = 20

# kind: "pass", "refused" or "not_judged". lines: one a finding, with what to do. page, picture: paths or "".
Outcome = collections.namedtuple("Outcome", "kind headline lines page pictures")


def setting(name, default=""):
    """BACKBEND_PUBLISH_NAME of the environment."""
    return os.environ.get("BACKBEND_PUBLISH_" + name, "") or default


# ---- Running backbend


def run(words, seconds):
    """(exit code or None where it took too long, what it wrote, its last line on standard error)."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("BACKBEND_PUBLISH_")}
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as complained:
        child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=said, stderr=complained, env=environment,
                                 start_new_session=True)
        try:
            code = child.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            if child.poll() is None:
                end(child)
        said.seek(0)
        complained.seek(0)
        lines = [line for line in complained.read().decode("utf-8", "replace").splitlines() if line.strip()]
        return code, said.read().decode("utf-8", "replace"), lines[-1].strip() if lines else ""


def end(child):
    """Ends a program and what it started: asked first, then made to."""
    for how, seconds in ((signal.SIGTERM, 5), (signal.SIGKILL, 5)):
        try:
            os.killpg(child.pid, how)
        except (AttributeError, OSError):  # no groups on this system, or it is gone
            child.terminate()
        try:
            child.wait(timeout=seconds)
            return
        except subprocess.TimeoutExpired:
            continue


def not_judged(why):
    return Outcome("not_judged", why + ". The rig was not judged; that does not hold up the publish", [], "", [])


def judge(job):
    """Judges the character of `job` and says whether to refuse it. Never raises for what backbend does.

    Keys of `job`: `character` (a file), and if wanted `rig`, `map`, `baked`, `baseline`, `options` (further words of
    `backbend check`), `output` (a folder for runs), `time_limit` (seconds), `program`, `unreadable` ("refuse", "warn").
    """
    name = pathlib.Path(job["character"]).name
    program = shutil.which(job.get("program") or setting("PROGRAM", "backbend"))
    if program is None:
        return not_judged("%s: backbend is not installed on this machine, or not on the PATH" % name)
    rig = job.get("rig") or ""
    if rig.startswith("blender:") and shutil.which("blender") is None:
        return not_judged("%s: its rig needs Blender, which is not on the PATH of this machine" % name)
    baseline = job.get("baseline") or setting("BASELINE")
    if baseline and not os.path.isfile(baseline):
        return not_judged("%s: %s: no such baseline; backbend approve makes one" % (name, baseline))
    try:
        folder = run_folder(job.get("output") or setting("OUTPUT"), name)
        words = [program, "check", job["character"], "-o", str(folder), "--quiet"]
        for option, value in (("--rig", rig), ("--map", job.get("map")), ("--baked", job.get("baked"))):
            if value:
                words += [option, str(value)]
        if baseline:
            words += ["--baseline", str(baseline_for(baseline, name, folder))]
        words += [str(word) for word in job.get("options") or shlex.split(setting("OPTIONS"))]
        seconds = float(job.get("time_limit") or setting("TIME_LIMIT", "600"))
        code, _, complaint = run(words, seconds)
        return outcome_of(job, program, folder, code, complaint, seconds)
    except Exception as error:  # whatever is wrong here is not the artist's
        return not_judged("%s: the gate failed (%s: %s)" % (name, type(error).__name__, error))


def run_folder(wanted, name):
    """A new folder for a run, below the one that is wanted or the machine's temporary one."""
    parent = pathlib.Path(wanted or os.path.join(tempfile.gettempdir(), "backbend_publish_" + user()))
    parent.mkdir(parents=True, exist_ok=True)
    return pathlib.Path(tempfile.mkdtemp(prefix=re.sub(r"[^\w.-]", "_", pathlib.Path(name).stem) + "_", dir=str(parent)))


def user():
    try:
        return getpass.getuser()
    except (KeyError, OSError, ImportError):
        return "user"


def without_version(stem):
    return re.sub(r"[._-]?v\d+$", "", stem, flags=re.IGNORECASE)


def baseline_for(path, name, folder):
    """Approvals are kept by the character's name: those of hero_v012 hold for hero_v013, too."""
    with open(path, encoding="utf-8") as file:
        baseline = json.load(file)
    stem, changed = pathlib.Path(name).stem, False
    for approval in baseline.get("approvals", []):
        if approval["character"] != stem and without_version(approval["character"]) == without_version(stem):
            approval["character"], changed = stem, True
    if not changed:
        return path
    own = folder.with_name(folder.name + "_baseline.json")
    own.write_text(json.dumps(baseline), encoding="utf-8")
    return own


# ---- Reading what it found


def outcome_of(job, program, folder, code, complaint, seconds):
    name = pathlib.Path(job["character"]).name
    said = ("; its last line: " + complaint) if complaint else ""
    if code is None:
        return not_judged("%s: backbend did not finish within %g s and was ended" % (name, seconds))
    if code == BAD_INPUT:
        why = complaint or name + ": backbend cannot read it, and does not say why"
        if (job.get("unreadable") or setting("UNREADABLE", "refuse")) == "warn":
            return not_judged(why)
        return Outcome("refused", why, [], "", [])
    if code not in (PASS, FINDINGS, NOT_MEASURED):
        what = FAULTS.get(code, "was ended by signal %d" % -code if code < 0 else "ended with exit code %d" % code)
        return not_judged("%s: backbend %s%s" % (name, what, said))
    try:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        if report["schema"] != "backbend.report/1" or report["exit_code"] != code:
            raise ValueError("its report is of another kind, or says otherwise than its exit code %d" % code)
        return read_report(job, program, folder, report)
    except (OSError, ValueError, KeyError, TypeError) as error:
        return not_judged("%s: backbend left no report that can be read (%s)%s" % (name, error, said))


def read_report(job, program, folder, report):
    name = pathlib.Path(job["character"]).name
    page = folder / "index.html"
    page = str(page) if page.is_file() else ""
    names = {check["code"]: check["name"] for check in report["checks"]}
    failed = [finding for finding in report["findings"] if finding["verdict"] == "fail"]
    if report["exit_code"] == NOT_MEASURED:
        outcome = not_judged("%s: something was not measured (%s)" % (name, "; ".join(report["reasons"]) or report["headline"]))
        return outcome._replace(page=page)
    if report["exit_code"] == PASS:
        return Outcome("pass", "%s: nothing over a limit in %s" % (name, report["headline"]), [], page, [])
    if not failed:
        raise ValueError("it failed without a finding")
    lines, pictures, remedies = [], [], {}
    for finding in failed[:MOST_LINES]:
        code = finding["code"]
        if code not in remedies:
            remedies[code] = remedy_of(program, code)
        lines.append(line_of(finding, names.get(code, ""), remedies[code]))
        picture = next((finding["pictures"][kind] for kind in ("after", "before", "heat", "other")
                        if finding["pictures"].get(kind)), "")
        pictures.append(str(folder / picture) if picture else "")
    if len(failed) > MOST_LINES:
        lines.append("and %d more, on the page" % (len(failed) - MOST_LINES))
        pictures.append("")
    count = "%d finding%s" % (len(failed), "" if len(failed) == 1 else "s")
    kind = "new or worse than approved" if job.get("baseline") or setting("BASELINE") else "over a limit"
    return Outcome("refused", "%s: %s %s" % (name, count, kind), lines, page, pictures)


def remedy_of(program, code):
    """What `explain` says to try; without an answer, where it would be."""
    try:
        status, said, _ = run([program, "explain", code, "--json"], 30)
        if status == 0:
            return json.loads(said)["try"]
    except (OSError, ValueError, KeyError):
        pass
    return "backbend explain " + code


def line_of(finding, name, remedy):
    """`BB030 cross-section collapse, twist 60: 0.71 (limit 0.75), chest, left. WEIGHTS: what to do`."""
    unit = "" if finding["unit"] in ("ratio", "count") else " " + finding["unit"]
    measured = ""
    if finding["value"] is not None:
        measured = ": %.4g%s" % (finding["value"], unit)
        if finding["limit"] is not None:
            measured += " (limit %.4g)" % finding["limit"]
    place = finding["place"]
    where = [" - ".join(place["between"]) if "between" in place else place.get("joint", ""), place.get("side", ""),
             place.get("mesh_part", "")]
    cures = finding.get("cures")
    do = "run " + cures[0]["command"] if cures else remedy
    text = "%s %s, %s%s%s. %s: %s" % (finding["code"], name, finding["pose"] or finding["sweep"] or "at rest", measured,
                                      "".join(", " + each for each in where if each), finding["owner"], do)
    return " ".join(text.split())  # one line, whatever names hold


def text_of(outcome):
    """For a log: the headline, a line and a picture for each finding, the page."""
    out = [outcome.headline]
    for k, line in enumerate(outcome.lines):
        out.append("  " + line)
        if k < len(outcome.pictures) and outcome.pictures[k]:
            out.append("    picture: " + outcome.pictures[k])
    if outcome.page:
        out.append("page: " + outcome.page)
    return "\n".join(out)


def markdown_of(outcome):
    """The same for AYON's publisher, which shows Markdown."""
    def link(text, path):
        return "[%s](<%s>)" % (text, pathlib.Path(path).absolute().as_uri())

    out = ["**%s**" % html.escape(outcome.headline), ""]
    for k, line in enumerate(outcome.lines):
        picture = outcome.pictures[k] if k < len(outcome.pictures) else ""
        out.append("- " + html.escape(line) + (" " + link("picture", picture) if picture else ""))
    if outcome.page:
        out += ["", link("Page with all findings", outcome.page)]
    return "\n".join(out)


# ---- What is to be judged, from a publish's own data


def job_of_files(folder, files):
    """The one character among an instance's files, or None."""
    files = [files] if isinstance(files, str) else list(files or [])
    found = [os.path.join(folder or "", name) for name in files if os.path.splitext(str(name))[1].lower() in CHARACTERS]
    return {"character": found[0]} if len(found) == 1 else None


def job_of_scene(scene):
    """A scene that is a character, or a Blender scene with its export beside it: then the rig is judged live."""
    stem, ending = os.path.splitext(str(scene))
    if ending.lower() in CHARACTERS:
        return {"character": str(scene)}
    if ending.lower() == ".blend" and os.path.isfile(stem + ".glb"):
        job = {"character": stem + ".glb", "rig": "blender:" + str(scene)}
        if os.path.isfile(stem + ".map.json"):
            job["map"] = stem + ".map.json"
        return job
    return None


def job_of_data(data):
    """`data["backbend"]` (a job or a character's path), else the instance's files or representations."""
    wanted = data.get("backbend")
    if wanted:
        return dict(wanted) if isinstance(wanted, dict) else {"character": str(wanted)}
    job = job_of_files(data.get("stagingDir"), data.get("files"))
    for representation in data.get("representations") or []:
        job = job or job_of_files(representation.get("stagingDir") or data.get("stagingDir"), representation.get("files"))
    return job


# ---- Pyblish and AYON

try:
    import pyblish.api as pyblish_api
except ImportError:  # as a command, and where a test reads this file
    pyblish_api = None

try:
    from ayon_core.pipeline.publish import OptionalPyblishPluginMixin, PublishValidationError
except ImportError:
    OptionalPyblishPluginMixin, PublishValidationError = object, None


def refuse(outcome):
    """Ends an instance's publish with what was found: with AYON's own exception inside AYON, else with any."""
    if PublishValidationError is not None:
        raise PublishValidationError(text_of(outcome), title="The rig breaks", description=markdown_of(outcome))
    raise ValueError(text_of(outcome))


def gate(plugin, instance, job):
    """Judges once, keeps what was found in the instance's data, and refuses or warns."""
    for name in ("program", "time_limit", "baseline", "output", "unreadable"):
        if getattr(plugin, name, None):  # AYON's settings are put on the class
            job.setdefault(name, getattr(plugin, name))
    outcome = judge(job)
    instance.data["backbend_outcome"] = dict(outcome._asdict())
    if outcome.kind == "refused":
        instance.data["publish"] = False  # after extraction Pyblish goes on in spite of an error, but not with this instance
        refuse(outcome)
    if outcome.kind == "not_judged":
        plugin.log.warning("backbend: " + text_of(outcome))
    else:
        plugin.log.info("backbend: " + text_of(outcome))


if pyblish_api is not None:

    class CollectBackbendCharacter(pyblish_api.ContextPlugin):
        """Finds what to judge: rig instances with a character's file, else the scene that is open."""

        label = "Collect characters for backbend"
        order = pyblish_api.CollectorOrder + 0.4  # after those that make the instances
        rig_families = ["rig", "character", "skeletalMesh"]

        def process(self, context):
            found = 0
            for instance in context:
                families = [instance.data.get(key) for key in ("family", "productType", "productBaseType")]
                families += instance.data.get("families") or []
                if not instance.data.get("backbend") and not set(families) & set(self.rig_families):
                    continue
                job = job_of_data(instance.data)
                if job is None and context.data.get("currentFile"):
                    job = job_of_scene(context.data["currentFile"])
                # Without a file yet, the second validator looks at what the extractors write.
                instance.data["families"] = list(instance.data.get("families") or []) + ["backbend"]
                if job is not None:
                    instance.data["backbend"] = job
                found += 1
            job = job_of_scene(context.data.get("currentFile") or "")
            if not found and not len(context) and job is not None:
                instance = context.create_instance("backbend " + pathlib.Path(job["character"]).stem, family="backbend")
                instance.data["backbend"] = job
                found += 1
            self.log.debug("backbend judges %d instance(s)" % found)

    class ValidateBackbendCharacter(pyblish_api.InstancePlugin, OptionalPyblishPluginMixin):
        """Refuses the publish of a character or a rig with new or worse findings."""

        label = "Spine rig and weights (backbend)"
        order = pyblish_api.ValidatorOrder + 0.3  # where AYON's mesh validators are
        families = ["backbend"]
        # Defaults of a job's keys; AYON puts a project's settings here.
        program = baseline = output = unreadable = ""
        time_limit = 0

        def job(self, instance):
            return instance.data.get("backbend")

        def process(self, instance):
            if PublishValidationError is not None and not self.is_active(instance.data):
                return
            if "backbend_outcome" in instance.data:  # judged before extraction
                return
            job = self.job(instance)
            if job:
                gate(self, instance, dict(job))
            else:
                self.nothing()

        def nothing(self):
            self.log.info("backbend: no file to judge before extraction")

    class ValidateBackbendExtracted(ValidateBackbendCharacter):
        """The same for characters that only the extractors write, before anything is integrated."""

        label = "Spine rig and weights as extracted (backbend)"
        order = pyblish_api.ExtractorOrder + 0.49

        def job(self, instance):
            return job_of_data(instance.data)

        def nothing(self):
            self.log.warning("backbend: no %s among the extracted files: the rig was not judged" % ", ".join(CHARACTERS))


# ---- A command, for hooks


def main(arguments):
    parser = argparse.ArgumentParser(prog="backbend_publish.py", description="Judges characters before they are committed "
                                     "or published. Exit code 0: go on (warnings on standard error say what was not "
                                     "judged); 1: refused; 2: usage.")
    parser.add_argument("characters", nargs="+", metavar="FILE", help="%s; others are passed over" % ", ".join(CHARACTERS))
    parser.add_argument("--rig", help="as backbend check takes it; of one character")
    parser.add_argument("--map", help="as backbend check takes it")
    parser.add_argument("--baseline", help="approved failures (backbend approve): only new or worse ones refuse")
    parser.add_argument("--output", help="folder for runs [the machine's temporary folder]")
    parser.add_argument("--time-limit", type=float, help="seconds for each character [600]")
    parser.add_argument("--quick", action="store_true", help="no pictures")
    parser.add_argument("--strict", action="store_true", help="exit code 1 also where something could not be judged")
    options = parser.parse_args(arguments)
    worst = 0
    for character in options.characters:
        if os.path.splitext(character)[1].lower() not in CHARACTERS:
            continue
        outcome = judge({"character": character, "rig": options.rig, "map": options.map, "baseline": options.baseline,
                         "output": options.output, "time_limit": options.time_limit,
                         "options": ["--quick"] if options.quick else None})
        text = text_of(outcome)
        if outcome.kind == "pass":
            print(text)
        else:
            print(("refused: " if outcome.kind == "refused" else "warning: ") + text, file=sys.stderr)
        if outcome.kind == "refused" or (options.strict and outcome.kind == "not_judged"):
            worst = 1
    return worst


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""backbend in Blender: judges the rig of the open file, shows each finding on it, repairs its weights.

Install it as an add-on (Edit > Preferences > Add-ons > Install), or run it in the text editor. The panel is in the
3D view's sidebar, tab `backbend`; docs/blender_addon.md shows it. Needs `backbend` on this machine, and nothing else:
Blender 3.4 or newer, with a window or headless. The operators of bpy.ops.backbend wait for their result when they are
called by a script, and let Blender go on when they are started from the panel.

What is judged is a copy of the file: saved to a folder of its own, taken to rest, exported, and asked live.
"""

import array
import json
import math
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import webbrowser

import bpy
import mathutils
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

bl_info = {
    "name": "backbend",
    "description": "Judges the spine of the open rig, shows findings on it, repairs its weights",
    "author": "backbend",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > backbend",
    "category": "Rigging",
}

HEAT = "backbend heat"
ROTATIONS = {"rx": 0, "ry": 1, "rz": 2}
LOCATIONS = {"x": 0, "y": 1, "z": 2}
OPPOSITE = {"extension": "flexion", "flexion": "extension"}
READABLE = (0, 1, 5)  # exit codes of `check` that leave a report to read
PROGRESS = re.compile(r"^(.*?) \d+/\d+ \((\d+) %\)")


class Trouble(Exception):
    """What went wrong, in one line for the artist."""


# ---- Work beside Blender: programs in a thread, so that the window goes on


class Work:
    """Runs `job(work)` in a thread. Nothing in there may touch bpy."""

    def __init__(self, job):
        self.status, self.fraction, self.error, self.result = "starting", 0.0, "", None
        self.child, self.cancelled, self.environment = None, False, environment()
        self.thread = threading.Thread(target=self.call, args=(job,), daemon=True)
        self.thread.start()

    def call(self, job):
        try:
            self.result = job(self)
        except Trouble as trouble:
            self.error = str(trouble)
        except Exception as error:  # said to the artist; a thread that only ends would leave the panel waiting
            self.error = f"the add-on failed: {type(error).__name__}: {error}"

    @property
    def done(self):
        return not self.thread.is_alive()

    def run(self, words, doing, ends=(0,)):
        """Its standard output. Trouble with the program's own last line where it ends with another code."""
        if self.cancelled:
            raise Trouble("cancelled")
        self.status, self.fraction = doing, 0.0
        name, said = pathlib.Path(words[0]).name, []
        with tempfile.TemporaryFile() as out:
            try:
                self.child = subprocess.Popen([str(word) for word in words], stdin=subprocess.DEVNULL, stdout=out,
                                              stderr=subprocess.PIPE, env=self.environment, start_new_session=True)
            except OSError as error:
                raise Trouble(f"{words[0]}: cannot be started: {error.strerror}; install backbend, or set its path in "
                              "the add-on's preferences") from None
            for line in self.child.stderr:
                line = line.decode("utf-8", "replace").strip()
                progress = PROGRESS.match(line)
                if progress:
                    self.status, self.fraction = progress.group(1), int(progress.group(2)) / 100
                elif line:
                    said = (said + [line])[-20:]
            code = self.child.wait()
            self.child = None
            out.seek(0)
            text = out.read().decode("utf-8", "replace")
        if self.cancelled:
            raise Trouble("cancelled")
        if code not in ends:
            last = said[-1] if said else f"{name} ended with exit code {code} and said nothing"
            raise Trouble(last if said and code in (2, 3) else f"{doing}: {last} (exit code {code})")
        return text

    def run_json(self, words, doing, ends=(0,)):
        text = self.run(words, doing, ends)
        try:
            return json.loads(text)
        except ValueError:
            raise Trouble(f"{doing}: {words[0]} answers with something else than JSON: is it backbend?") from None

    def cancel(self):
        self.cancelled = True
        child = self.child
        if child is not None and child.poll() is None:
            try:
                os.killpg(child.pid, signal.SIGTERM)  # backbend ends the Blender that it has started
            except (AttributeError, OSError):
                child.terminate()


def environment():
    """With this Blender first, so that the rig is asked by the release that the artist works in."""
    path = os.path.dirname(bpy.app.binary_path) + os.pathsep + os.environ.get("PATH", "")
    return {**os.environ, "PATH": path}


class Session:
    """What the panel knows. Results are of this session; none is written into the artist's file."""

    def __init__(self):
        self.work = None
        self.clear()
        self.program = {}  # path, exports

    def clear(self):
        self.report, self.folder, self.mapping, self.rests = None, None, None, {}
        self.armature, self.character, self.advice, self.error, self.said = "", None, {}, "", ""

    @property
    def findings(self):
        """Ours, worst first; those of self-tests and of comparison rigs are none."""
        if self.report is None:
            return []
        ours = {rig["rig"] for rig in self.report["rigs"] if rig["role"] == "proposed"}
        return [finding for finding in self.report["findings"]
                if finding["verdict"] in ("fail", "stress", "waived", "not_measured")
                and (finding["rig"] in ours or not finding["rig"])]


SESSION = Session()


# ---- Programs and folders


def preferences():
    addon = bpy.context.preferences.addons.get(__name__)
    return addon.preferences if addon else None


def program():
    """The path of backbend. Trouble where it is not on this machine."""
    chosen = preferences()
    wanted = (chosen.program if chosen else "") or os.environ.get("BACKBEND_PROGRAM", "") or "backbend"
    found = shutil.which(bpy.path.abspath(wanted) if wanted.startswith("//") else os.path.expanduser(wanted))
    if found is None:
        raise Trouble(f"{wanted}: no such program; install backbend, or set its path in the add-on's preferences")
    return found


def probe(work, path):
    """Whether this backbend has `export even`, which not every release has; asked once."""
    if SESSION.program.get("path") != path:
        try:
            work.run([path, "export", "even", "--help"], "asking backbend what it can do")
            exports = True
        except Trouble:
            if work.cancelled:
                raise
            exports = False
        SESSION.program = {"path": path, "exports": exports}
    return SESSION.program["exports"]


def new_folder(name):
    chosen = preferences()
    parent = bpy.path.abspath(chosen.folder) if chosen and chosen.folder else bpy.app.tempdir
    os.makedirs(parent, exist_ok=True)
    return pathlib.Path(tempfile.mkdtemp(prefix=f"backbend_{name}_", dir=parent))


def stem():
    """What the character is called in the report."""
    name = pathlib.Path(bpy.data.filepath).stem or "untitled"
    return re.sub(r"[^\w.-]", "_", name)


# ---- The rig of the open file


def deforms(armature, thing):
    return (thing.parent == armature and thing.parent_type == "ARMATURE") or any(
        modifier.type == "ARMATURE" and modifier.object == armature and modifier.show_viewport
        for modifier in thing.modifiers)


def bodies_of(armature):
    return sorted((thing for thing in bpy.context.view_layer.objects
                   if thing.type == "MESH" and not thing.hide_render and deforms(armature, thing)),
                  key=lambda thing: thing.name)


def armature_of(context):
    """The one that is chosen in the panel, is active, or deforms the active mesh; else the only one with a body."""
    chosen = context.scene.backbend.armature
    if chosen is not None and chosen.type == "ARMATURE":
        return chosen
    active = context.view_layer.objects.active
    if active is not None and active.type == "ARMATURE":
        return active
    every = [thing for thing in context.view_layer.objects if thing.type == "ARMATURE"]
    if active is not None and active.type == "MESH":
        owners = [thing for thing in every if deforms(thing, active)]
        if len(owners) == 1:
            return owners[0]
    found = [thing for thing in every if bodies_of(thing)]
    if len(found) != 1:
        raise Trouble(f"{len(found)} armatures deform a mesh: choose one in the panel")
    return found[0]


def bone_of(armature, control):
    """`bone` of the armature, or `armature:bone` of another one."""
    if control in armature.pose.bones:
        return armature.pose.bones[control]
    owner, _, name = control.partition(":")
    other = bpy.data.objects.get(owner)
    if other is not None and other.type == "ARMATURE" and name in other.pose.bones:
        return other.pose.bones[name]
    raise Trouble(f"the rig has no control '{control}'")


def parse_pose(text):
    """`extension 114.3, side 10` as degrees by channel."""
    pose = {}
    for part in text.split(","):
        if part.strip() in ("rest", ""):
            continue
        name, _, degrees = part.strip().rpartition(" ")
        try:
            pose[name] = float(degrees)
        except ValueError:
            raise Trouble(f"'{text}' is not a pose of the controls") from None
    return pose


def targets_of(channels, name):
    """(control, channel, per degree) of a body channel, as backbend takes a mapping: opposites serve each other."""
    sign = 1.0
    if name not in channels:
        name, sign = OPPOSITE.get(name), -1.0
    return [(target["control"], target["channel"], sign * target.get("per_degree", 1.0)) for target in channels.get(name, [])]


def control_values(channels, pose):
    """(control, channel) -> what is added to its rest: every control that the mapping names, most of them 0."""
    values = {(target["control"], target["channel"]): 0.0 for targets in channels.values() for target in targets}
    for name, degrees in pose.items():
        targets = targets_of(channels, name)
        if degrees and not targets:
            raise Trouble(f"no control stands for {name}")
        for control, channel, factor in targets:
            values[control, channel] += degrees * factor
    return values


def set_controls(armature, values, rests):
    """Sets what control_values() gives. A control keeps its rotation mode, and turns about nothing else."""
    turns = {}
    for (control, channel), value in values.items():
        bone = bone_of(armature, control)
        if channel in ROTATIONS:
            turns.setdefault(control, [0.0, 0.0, 0.0])[ROTATIONS[channel]] = math.radians(value)
        elif channel in LOCATIONS:
            bone.location[LOCATIONS[channel]] = value
        elif channel in bone.keys():
            wanted = rests.get((control, channel), bone[channel]) + value
            bone[channel] = round(wanted) if isinstance(bone[channel], int) else wanted
        else:
            raise Trouble(f"'{control}' has no channel '{channel}'")
    for control, angles in turns.items():
        bone = bone_of(armature, control)
        if bone.rotation_mode == "QUATERNION":
            bone.rotation_quaternion = mathutils.Euler(angles, "XYZ").to_quaternion()
        elif bone.rotation_mode == "AXIS_ANGLE":
            axis, angle = mathutils.Euler(angles, "XYZ").to_quaternion().to_axis_angle()
            bone.rotation_axis_angle = (angle, *axis)
        else:
            bone.rotation_euler = angles
    for owner in {bone_of(armature, control).id_data for control, _ in values}:
        owner.update_tag()


def scalar_rests(armature, mapping):
    """What the properties that a mapping names hold now: the copy is judged with that as rest."""
    out = {}
    for targets in (mapping or {}).get("channels", {}).values():
        for target in targets:
            control, channel = target["control"], target["channel"]
            if channel not in ROTATIONS and channel not in LOCATIONS:
                bone = bone_of(armature, control)
                if channel not in bone.keys():
                    raise Trouble(f"'{control}' has no channel '{channel}'")
                out[control, channel] = bone[channel]
    return out


# ---- The copy that is judged: made here, taken to rest and exported by a Blender in the background


def save_copy(folder, armature):
    """Saves the open file to `folder`; the words that export it there, and the character's path."""
    copy = folder / (stem() + ".blend")
    bpy.ops.wm.save_as_mainfile(filepath=str(copy), copy=True, check_existing=False, compress=False)
    character = copy.with_suffix(".glb")
    words = [bpy.app.binary_path, "--background", "--factory-startup", "--enable-autoexec", copy, "--python-exit-code", "3",
             "--python", os.path.abspath(__file__), "--", "--export", character, armature.name]
    return words, copy, character


def take_to_rest(armature):
    """Every control to where it is without a pose: actions are the animator's, not the rig's."""
    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for thing in bpy.data.objects:
        if thing.type != "ARMATURE" or thing.pose is None:
            continue
        if thing.animation_data is not None:
            thing.animation_data.action = None
            for track in thing.animation_data.nla_tracks:
                track.mute = True
        for bone in thing.pose.bones:
            bone.matrix_basis = mathutils.Matrix()
    bpy.context.view_layer.update()


def export(path, name):
    """Writes the armature and its meshes at rest as glTF, and saves the file as it is then."""
    armature = bpy.data.objects[name]
    take_to_rest(armature)
    bpy.ops.wm.save_mainfile()
    bodies = bodies_of(armature)
    if not bodies:
        raise Trouble(f"'{name}' deforms no mesh that is rendered: there is nothing to judge")
    import numpy
    for old in ("bool", "float", "int", "object"):  # Debian 12's exporter asks for what numpy has dropped
        if old not in vars(numpy):
            setattr(numpy, old, getattr(__import__("builtins"), old))
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    bpy.ops.object.select_all(action="DESELECT")
    for thing in [armature, *bodies]:
        thing.hide_set(False)
        thing.select_set(True)
    bpy.context.view_layer.objects.active = armature
    for body in bodies:
        if body.parent != armature:  # the exporter skins children of the armature
            world = body.matrix_world.copy()
            body.parent = armature
            body.matrix_world = world
        for modifier in body.modifiers:
            if modifier.type in ("SUBSURF", "MULTIRES"):
                modifier.show_viewport = modifier.show_render = False  # the cage is what is weighted
    made = any(modifier.show_viewport and modifier.type not in ("ARMATURE", "SUBSURF", "MULTIRES")
               for body in bodies for modifier in body.modifiers)
    wanted = {"filepath": path, "export_format": "GLB", "use_selection": True, "export_apply": made,
              "export_animations": False, "export_morph": False, "export_skins": True,
              "export_def_bones": any(not bone.use_deform for bone in armature.data.bones),
              "export_rest_position_armature": True, "export_draco_mesh_compression_enable": False}
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    bpy.ops.export_scene.gltf(**{key: value for key, value in wanted.items() if key in known})


def export_main(arguments):
    """What runs in the background: `-- --export OUT.glb ARMATURE`."""
    try:
        export(arguments[1], arguments[2])
    except (Trouble, RuntimeError, KeyError) as error:
        print(f"backbend: the character cannot be exported: {' '.join(str(error).split())}", file=sys.stderr)
        sys.exit(3)


def side_file(name):
    """NAME beside the open file, where it is there: `.map.json`, `.backbend.toml`."""
    if not bpy.data.filepath:
        return None
    path = pathlib.Path(bpy.data.filepath).with_suffix("")
    path = path.with_name(path.name + name)
    return path if path.is_file() else None


def chosen_mapping(settings):
    """The mapping that the panel names, or that is beside the file; None: found by turning every control."""
    path = pathlib.Path(bpy.path.abspath(settings.mapping)) if settings.mapping else side_file(".map.json")
    if path is None:
        return None
    try:
        mapping = json.loads(path.read_text(encoding="utf-8"))
        if not mapping["channels"]:
            raise ValueError("it names no channels")
        return mapping
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Trouble(f"{path}: is not a mapping: {error}") from None


def judge_work(context):
    """Saves the copy and starts the judgement; what finish_judge() is given."""
    settings, backbend, armature = context.scene.backbend, program(), armature_of(context)
    mapping = chosen_mapping(settings)
    if mapping is None and SESSION.armature == armature.name:
        mapping = SESSION.mapping  # found before
    rests = scalar_rests(armature, mapping)
    folder = new_folder(stem())
    words, copy, character = save_copy(folder, armature)
    sidecar = side_file(".backbend.toml")
    if sidecar is not None:
        shutil.copy(sidecar, character.with_suffix(".backbend.toml"))
    own, name = bpy.path.abspath(settings.character) if settings.character else "", armature.name
    options = ["--quick"] if settings.quick else []
    if settings.envelope != "auto":
        options += ["--envelope", settings.envelope]

    def job(work):
        work.run(words, "exporting the character")
        judged = pathlib.Path(own) if own else character
        rig = f"blender:{copy}"
        found = mapping
        if found is None:
            found = work.run_json([backbend, "inspect", judged, "--rig", rig, "--json"],
                                  "finding the controls that bend the spine")
        (folder / "mapping.json").write_text(json.dumps({"armature": name, **found}))
        work.run([backbend, "check", judged, "--rig", rig, "--map", folder / "mapping.json", "-o", folder / "run", *options],
                 "measuring the rig", ends=READABLE)
        report = json.loads((folder / "run/report.json").read_text(encoding="utf-8"))
        advice = {}
        for code in sorted({finding["code"] for finding in report["findings"] if finding["verdict"] == "fail"}):
            advice[code] = work.run_json([backbend, "explain", code, "--json"], "reading what to try")["try"]
        probe(work, backbend)
        return {"report": report, "folder": folder / "run", "mapping": found, "rests": rests, "armature": name,
                "character": judged, "advice": advice}

    return job


# ---- Heat


def read_glb(path):
    data = pathlib.Path(path).read_bytes()
    magic, _, _, length, _ = struct.unpack_from("<4sIIII", data)
    if magic != b"glTF":
        raise Trouble(f"{path}: is not a binary glTF file")
    return json.loads(data[20:20 + length]), data[28 + length:]


def accessor(document, binary, number):
    """Rows of floats of a float32 or of normalized values, as the two files at hand have them."""
    of = document["accessors"][number]
    view = document["bufferViews"][of["bufferView"]]
    width, kind = {"VEC2": 2, "VEC3": 3, "VEC4": 4}[of["type"]], {5126: "f", 5121: "B", 5123: "H"}[of["componentType"]]
    start = view.get("byteOffset", 0) + of.get("byteOffset", 0)
    row = struct.Struct(f"<{width}{kind}")
    stride = view.get("byteStride") or row.size
    return [row.unpack_from(binary, start + k * stride) for k in range(of["count"])]


def primitives(document):
    """In the order in which backbend numbers vertices: nodes as the file lists them, then their primitives."""
    return [primitive for node in document["nodes"] if "mesh" in node
            for primitive in document["meshes"][node["mesh"]]["primitives"]]


def rest_colours(character, posed):
    """(place at rest, colour) of each vertex of a finding's pose.glb."""
    rest, rest_bytes = read_glb(character)
    document, binary = read_glb(posed)
    of_rest, of_pose = primitives(rest), primitives(document)
    places = [accessor(rest, rest_bytes, each["attributes"]["POSITION"]) for each in of_rest]
    colours = [accessor(document, binary, each["attributes"]["COLOR_0"]) for each in of_pose]
    if [len(each) for each in places] != [len(each) for each in colours]:
        raise Trouble("the mesh of this finding is not the exported one: its heat is on the page")
    return [((x, -z, y), colour) for of_places, of_colours in zip(places, colours)  # glTF has Y up, Blender Z
            for (x, y, z), colour in zip(of_places, of_colours)]


def rows_of_vertices(armature, body, rows):
    """For each vertex of a mesh the number of the row at its place at rest, or None.

    Releases of the exporter write skinned vertices in the world's or the armature's space: the one that fits counts.
    """
    tree, best = mathutils.kdtree.KDTree(len(rows)), []
    for number, (place, _) in enumerate(rows):
        tree.insert(place, number)
    tree.balance()
    reach = 1e-4 * max((max(row[0][k] for row in rows) - min(row[0][k] for row in rows) for k in range(3)), default=0.0)
    for space in (mathutils.Matrix(), armature.matrix_world.inverted_safe()):
        matrix, found = space @ body.matrix_world, []
        for vertex in body.data.vertices:
            _, number, far = tree.find(matrix @ vertex.co)
            found.append(number if number is not None and far <= reach else None)
        if not best or found.count(None) < best.count(None):
            best = found
    return best


def paint(armature, rows):
    """Colours the vertices of the armature's meshes as the rows say; how many of how many have a colour."""
    painted, total = 0, 0
    for body in bodies_of(armature):
        mesh, values = body.data, array.array("f")
        for number in rows_of_vertices(armature, body, rows):
            values.extend((0.5, 0.5, 0.5, 1.0) if number is None else rows[number][1])
            painted += number is not None
            total += 1
        layer = mesh.color_attributes.get(HEAT)
        if layer is not None and (layer.domain, layer.data_type) != ("POINT", "FLOAT_COLOR"):
            mesh.color_attributes.remove(layer)
            layer = None
        layer = layer or mesh.color_attributes.new(name=HEAT, type="FLOAT_COLOR", domain="POINT")
        layer.data.foreach_set("color", values)
        mesh.color_attributes.active_color = layer
        mesh.update()
    return painted, total


def show_colours(context):
    for area in context.screen.areas if context.screen else []:
        if area.type == "VIEW_3D":
            shading = area.spaces.active.shading
            if shading.type in ("WIREFRAME", "SOLID"):
                shading.type, shading.color_type = "SOLID", "VERTEX"


def heat_file(finding):
    """pose.glb of a finding, or None: the worst few of a run have one."""
    for kind in ("before", "after", "heat", "other"):
        picture = finding["pictures"].get(kind)
        if picture:
            path = (SESSION.folder / picture).parent / "pose.glb"
            if path.is_file():
                return path
    return None


# ---- Weights


def set_weights(armature, weights):
    """Sets `backbend.weights/1` as vertex groups, by place at rest; how many vertices were set.

    Only vertices that changed are touched. Trouble, before anything is, where a group is locked or a place has no
    vertex.
    """
    plans = []
    for entry in weights["objDDic"]:
        changed = entry["changed"]
        if not changed:
            continue
        rows = [((x, -z, y), number) for number, (x, y, z) in enumerate(entry["positions"])]
        joints = {}
        for joint, of_joint in entry["weights"].items():
            for number, weight in of_joint.items():
                joints.setdefault(int(number), []).append((joint, weight))
        bodies = [body for body in bodies_of(armature) if entry["objName"] in (body.data.name, body.name)]
        if not bodies:
            raise Trouble(f"no mesh of the rig is called '{entry['objName']}'")
        plans += [(body, plan_weights(armature, body, rows, set(changed), joints)) for body in bodies]
    for body, plan in plans:
        numbers = list(plan)
        for group in body.vertex_groups:
            if group.name in armature.data.bones:  # a group of anything else is not a weight
                group.remove(numbers)
        for number, influences in plan.items():
            for joint, weight in influences:
                group = body.vertex_groups.get(joint) or body.vertex_groups.new(name=joint)
                group.add([number], weight, "REPLACE")
        body.data.update()
    return sum(len(plan) for _, plan in plans)


def plan_weights(armature, body, rows, changed, joints):
    """Vertex of the body -> its new influences."""
    plan, placed = {}, set()
    for vertex, number in enumerate(rows_of_vertices(armature, body, rows)):
        if number in changed:
            plan[vertex] = joints.get(number, [])
            placed.add(tuple(rows[number][0]))
    lost = {tuple(rows[number][0]) for number in changed} - placed
    if lost:
        raise Trouble(f"'{body.name}': {len(lost)} of the repaired places have no vertex here: a modifier made them, or "
                      "the mesh has changed since; nothing was set")
    for group in body.vertex_groups:
        if group.lock_weight and group.name in armature.data.bones:
            raise Trouble(f"'{body.name}': the vertex group '{group.name}' is locked; unlock it to repair its weights")
    return plan


# ---- Operators


class Waits:
    """An operator that works in the background from the panel, and waits where a script calls it."""

    def execute(self, context):
        if not self.begin(context):
            return {"CANCELLED"}
        while not SESSION.work.done:
            time.sleep(0.05)
        return self.end(context)

    def invoke(self, context, _):
        if context.window is None:
            return self.execute(context)
        if not self.begin(context):
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if SESSION.work is None:  # stopped from elsewhere
            context.window_manager.event_timer_remove(self.timer)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.backbend.progress = SESSION.work.fraction
        redraw(context)
        if not SESSION.work.done:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        return self.end(context)

    def cancel(self, context):  # Blender ends, or another file is opened
        stop()

    def begin(self, context):
        if SESSION.work is not None:
            self.report({"ERROR"}, "backbend is at work already")
            return False
        SESSION.error = SESSION.said = ""
        try:
            SESSION.work = Work(self.prepare(context))
        except (Trouble, OSError, RuntimeError) as trouble:
            return self.fail(" ".join(str(trouble).split()))
        return True

    def end(self, context):
        work, SESSION.work = SESSION.work, None
        redraw(context)
        if work.error:
            self.fail(work.error, "INFO" if work.cancelled else "ERROR")
            return {"CANCELLED"}
        try:
            SESSION.said = self.finish(context, work.result)
        except (Trouble, OSError, ValueError, KeyError) as trouble:
            self.fail(str(trouble))
            return {"CANCELLED"}
        self.report({"INFO"}, SESSION.said)
        return {"FINISHED"}

    def fail(self, line, level="ERROR"):
        SESSION.error = line
        self.report({level}, line)
        return False


class BACKBEND_OT_judge(Waits, bpy.types.Operator):
    """Judge the rig of this file live, on a copy: which poses break it, where, and who must act"""
    bl_idname, bl_label = "backbend.judge", "Judge this rig"

    def prepare(self, context):
        job = judge_work(context)
        remember(context)
        return job

    def finish(self, context, found):
        SESSION.clear()
        for name, value in found.items():
            setattr(SESSION, name, value)
        fill_lists(context)
        return verdict_text(SESSION.report)


class BACKBEND_OT_cancel(bpy.types.Operator):
    """Stop the work that is going on; nothing is changed"""
    bl_idname, bl_label = "backbend.cancel", "Cancel"

    def execute(self, context):
        if SESSION.work is not None:
            SESSION.work.cancel()
        return {"FINISHED"}


class BACKBEND_OT_show_finding(bpy.types.Operator):
    """Take the rig's own controls to the pose of this finding, and show where it is"""
    bl_idname, bl_label, bl_options = "backbend.show_finding", "Show", {"UNDO", "INTERNAL"}
    index: IntProperty(min=0)
    heat: BoolProperty(name="Heat", default=True)

    def execute(self, context):
        try:
            finding = SESSION.findings[self.index]
            armature = judged_armature(context)
            set_controls(armature, control_values(SESSION.mapping["channels"], parse_pose(finding["pose"])), SESSION.rests)
            context.window_manager.backbend.active = self.index
            if self.heat and heat_file(finding) is not None:
                bpy.ops.backbend.show_heat(index=self.index)
        except IndexError:
            self.report({"ERROR"}, "there is no such finding")
            return {"CANCELLED"}
        except Trouble as trouble:
            self.report({"ERROR"}, str(trouble))
            return {"CANCELLED"}
        known = mapped_controls() | driven_bones(armature)
        others = [bone.name for bone in armature.pose.bones if off_rest(bone) and bone.name not in known]
        if others:
            self.report({"WARNING"}, f"{len(others)} other controls are not at rest ({others[0]}): the pose is not that of the finding")
        return {"FINISHED"}


class BACKBEND_OT_show_heat(bpy.types.Operator):
    """Show the heat of this finding as a colour attribute of the mesh"""
    bl_idname, bl_label, bl_options = "backbend.show_heat", "Heat", {"UNDO", "INTERNAL"}
    index: IntProperty(min=0)

    def execute(self, context):
        try:
            path = heat_file(SESSION.findings[self.index])
            if path is None:
                raise Trouble("this finding has no heat: the worst few of a run with pictures have one")
            painted, total = paint(judged_armature(context), rest_colours(SESSION.character, path))
        except (Trouble, IndexError, OSError, ValueError, KeyError) as trouble:
            self.report({"ERROR"}, str(trouble))
            return {"CANCELLED"}
        show_colours(context)
        self.report({"INFO"}, f"heat on {painted} of {total} vertices")
        return {"FINISHED"}


class BACKBEND_OT_rest(bpy.types.Operator):
    """Take the controls of the spine back to rest, and take the heat off the mesh"""
    bl_idname, bl_label, bl_options = "backbend.rest", "Rest", {"UNDO", "INTERNAL"}

    def execute(self, context):
        try:
            armature = judged_armature(context)
            set_controls(armature, control_values(SESSION.mapping["channels"], {}), SESSION.rests)
        except Trouble as trouble:
            self.report({"ERROR"}, str(trouble))
            return {"CANCELLED"}
        for body in bodies_of(armature):
            layer = body.data.color_attributes.get(HEAT)
            if layer is not None:
                body.data.color_attributes.remove(layer)
        return {"FINISHED"}


class BACKBEND_OT_open_page(bpy.types.Operator):
    """Open the page with pictures, plots and all findings"""
    bl_idname, bl_label = "backbend.open_page", "Open the page"

    def execute(self, context):
        page = SESSION.folder / "index.html" if SESSION.folder else None
        if page is None or not page.is_file():
            self.report({"ERROR"}, "there is no page: judge the rig first")
            return {"CANCELLED"}
        webbrowser.open(page.as_uri())
        return {"FINISHED"}


class BACKBEND_OT_repair(Waits, bpy.types.Operator):
    """Repair the weights that are at fault, measure again, and set them as vertex groups (undo takes them back)"""
    bl_idname, bl_label, bl_options = "backbend.repair", "Repair weights", {"UNDO"}

    def prepare(self, context):
        backbend, armature = program(), armature_of(context)
        words, _, character = save_copy(new_folder(stem()), armature)
        sidecar = side_file(".backbend.toml")
        if sidecar is not None:
            shutil.copy(sidecar, character.with_suffix(".backbend.toml"))
        out, name = character.with_name("weights.json"), armature.name

        def job(work):
            work.run(words, "exporting the character")
            told = work.run_json([backbend, "repair", character, "--weights", out, "--json"], "repairing the weights", ends=(0, 1))
            weights = json.loads(out.read_text(encoding="utf-8")) if out.is_file() else None
            return told, weights, name

        return job

    def finish(self, context, found):
        told, weights, name = found
        if weights is None:
            return "nothing to repair: no failure that weights alone can cure" if not told["checks"] else \
                "no change of the weights that was tried helps: they are as they were"
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        if name not in bpy.data.objects:
            raise Trouble(f"the armature '{name}' is gone")
        count = set_weights(bpy.data.objects[name], weights)
        left = sum(check["failures_after"] for check in told["checks"])
        return f"weights of {count} vertices repaired; failures left: {left}"


class BACKBEND_OT_export_even(Waits, bpy.types.Operator):
    """Add backbend's own spine rig `even` to this file (undo takes it back)"""
    bl_idname, bl_label, bl_options = "backbend.export_even", "Export even", {"UNDO"}

    def prepare(self, context):
        backbend, armature = program(), armature_of(context)
        folder = new_folder(stem())
        words, _, character = save_copy(folder, armature)
        sidecar = side_file(".backbend.toml")
        if sidecar is not None:
            shutil.copy(sidecar, character.with_suffix(".backbend.toml"))
        name = armature.name

        def job(work):
            if not probe(work, backbend):
                raise Trouble(f"{backbend} has no `export even`; a newer backbend has")
            work.run(words, "exporting the character")
            work.run([backbend, "export", "even", "--to", "blender", "--for", character, "-o", folder / "even.py"],
                     "building the rig")
            return folder / "even.py", name

        return job

    def finish(self, context, found):
        script, name = found
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        armature = bpy.data.objects.get(name)
        if armature is None:
            raise Trouble(f"the armature '{name}' is gone")
        context.view_layer.objects.active = armature
        # Without a window the script would save the file under another name; only its function is called then.
        names = {"__name__": "backbend_even" if bpy.app.background else "__main__", "__file__": str(script)}
        words, sys.argv = sys.argv, [str(script), "--", "--armature", name]
        try:
            exec(compile(script.read_text(encoding="utf-8"), str(script), "exec"), names)
            if bpy.app.background:
                names["build"](armature)
        except (Exception, SystemExit) as error:  # FINISHED, so that undo takes back what it has done so far
            kind = type(error).__name__
            SESSION.error = str(error) if kind == "EvenError" else f"the exported script failed: {kind}: {error}"
            self.report({"ERROR"}, SESSION.error)
            return "undo takes back what the script did before it failed"
        finally:
            sys.argv = words
        return "the rig `even` is in this file"


def judged_armature(context):
    if SESSION.report is None:
        raise Trouble("there is no result: judge the rig first")
    armature = bpy.data.objects.get(SESSION.armature)
    if armature is None or armature.type != "ARMATURE":
        raise Trouble(f"the armature '{SESSION.armature}' is gone: judge the rig again")
    return armature


def mapped_controls():
    return {target["control"] for targets in SESSION.mapping["channels"].values() for target in targets}


def driven_bones(armature):
    """Those that drivers turn: they follow the controls."""
    drivers = armature.animation_data.drivers if armature.animation_data else []
    return {part.group(1) for part in (re.match(r'pose\.bones\["(.*?)"\]', curve.data_path) for curve in drivers) if part}


def off_rest(bone):
    return any(abs(bone.matrix_basis[row][column] - (row == column)) > 1e-4 for row in range(4) for column in range(4))


def redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


# ---- What the panel shows


def fill_lists(context):
    lists = context.window_manager.backbend
    lists.findings.clear()
    lists.headroom.clear()
    lists.active = 0
    for number, finding in enumerate(SESSION.findings):
        names = {check["code"]: check["name"] for check in SESSION.report["checks"]}
        row = lists.findings.add()
        row.name = f"{finding['code']} {names.get(finding['code'], '')}"
        row.pose, row.owner, row.verdict, row.number = finding["pose"], finding["owner"], finding["verdict"], number
    ours = next((rig for rig in SESSION.report["rigs"] if rig["role"] == "proposed"), None)
    for channel in ours["headroom"] if ours else []:
        row = lists.headroom.add()
        row.name = channel["channel"]
        row.share, row.text = headroom_text(channel)


def verdict_text(report):
    failed = sum(finding["verdict"] == "fail" for finding in report["findings"])
    verdict = {0: "Passes", 1: f"{failed} finding" + ("" if failed == 1 else "s"), 5: "Not all measured"}[report["exit_code"]]
    return f"{verdict}: {report['headline']}"


def headroom_text(channel):
    """(share of the required range that is clean, the same in words)."""
    clean, needs, tested = channel["clean_to_deg"], channel["needs_deg"], channel["tested_to_deg"]
    if not channel["measured"] or clean is None:
        return 0.0, f"{channel['channel']}: not measured"
    to = f"{clean:.0f}" + ("+" if tested is not None and clean >= tested else "")
    if not needs:
        return 1.0, f"{channel['channel']}: clean to {to}"
    return min(1.0, clean / needs), f"{channel['channel']}: clean to {to}, required {needs:.0f}"


def bar(layout, owner, key, text):
    if hasattr(layout, "progress"):  # Blender 4.0
        layout.progress(factor=getattr(owner, key), text=text)
    else:
        layout.prop(owner, key, slider=True, text=text)


def wrapped(layout, text, icon="NONE", width=44):
    for number, line in enumerate(textwrap.wrap(text, width) or [""]):
        layout.label(text=line, icon=icon if number == 0 else "BLANK1")


class BACKBEND_UL_findings(bpy.types.UIList):
    ICONS = {"fail": "CANCEL", "stress": "DOT", "waived": "CHECKMARK", "not_measured": "QUESTION"}

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.78)
        operator = split.operator("backbend.show_finding", text=f"{item.name}  {item.pose}", emboss=False,
                                  icon=self.ICONS.get(item.verdict, "DOT"))
        operator.index = item.number
        split.label(text=item.owner)


class BACKBEND_PT_panel(bpy.types.Panel):
    bl_label, bl_space_type, bl_region_type, bl_category = "backbend", "VIEW_3D", "UI", "backbend"

    def draw(self, context):
        layout, settings, lists = self.layout, context.scene.backbend, context.window_manager.backbend
        layout.prop(settings, "armature")
        column = layout.column(align=True)
        column.prop(settings, "envelope")
        column.prop(settings, "quick")
        if SESSION.work is not None:
            bar(layout, lists, "progress", SESSION.work.status)
            layout.operator("backbend.cancel", icon="X")
        else:
            layout.operator("backbend.judge", icon="VIEWZOOM")
        if SESSION.error:
            wrapped(layout.box().column(align=True), SESSION.error, "ERROR")
        if SESSION.report is not None:
            self.draw_result(layout, lists)
        column = layout.column(align=True)
        column.enabled = SESSION.work is None
        column.operator("backbend.repair", icon="MOD_VERTEX_WEIGHT")
        even = column.row(align=True)
        even.enabled = SESSION.program.get("exports", True)
        even.operator("backbend.export_even", icon="ARMATURE_DATA",
                      text="Export even" if even.enabled else "no export in this backbend")
        if SESSION.said and (SESSION.report is None or SESSION.said != verdict_text(SESSION.report)):
            wrapped(layout.column(align=True), SESSION.said, "INFO")

    @staticmethod
    def draw_result(layout, lists):
        box = layout.box().column(align=True)
        wrapped(box, verdict_text(SESSION.report), "CHECKMARK" if SESSION.report["exit_code"] == 0 else "CANCEL")
        for row in lists.headroom:
            bar(box, row, "share", row.text)
        layout.template_list("BACKBEND_UL_findings", "", lists, "findings", lists, "active", rows=6)
        findings = SESSION.findings
        if lists.active < len(findings):
            finding = findings[lists.active]
            column = layout.column(align=True)
            wrapped(column, finding["detail"] or lists.findings[lists.active].name, "VIEWZOOM")
            if finding["code"] in SESSION.advice:
                wrapped(column, "Try: " + SESSION.advice[finding["code"]], "LIGHT")
        row = layout.row(align=True)
        row.operator("backbend.rest", icon="LOOP_BACK")
        row.operator("backbend.open_page", icon="URL")


class BackbendFinding(bpy.types.PropertyGroup):
    pose: StringProperty()
    owner: StringProperty()
    verdict: StringProperty()
    number: IntProperty()


class BackbendHeadroom(bpy.types.PropertyGroup):
    share: FloatProperty(min=0, max=1, subtype="FACTOR", description="share of the required range that is clean")
    text: StringProperty()


class BackbendLists(bpy.types.PropertyGroup):
    findings: CollectionProperty(type=BackbendFinding)
    headroom: CollectionProperty(type=BackbendHeadroom)
    active: IntProperty()
    progress: FloatProperty(min=0, max=1, subtype="FACTOR")


ENVELOPES = ("auto", "human", "animal", "long_neck", "snake", "neck", "cartoon", "creature", "sweep")


class BackbendSettings(bpy.types.PropertyGroup):
    armature: PointerProperty(type=bpy.types.Object, name="Rig", poll=lambda self, thing: thing.type == "ARMATURE",
                              description="the armature to judge; empty: the active one, or the only one with a mesh")
    envelope: EnumProperty(name="Range", items=[(name, name, "") for name in ENVELOPES],
                           description="how far the spine must bend; auto: by the kind of body")
    quick: BoolProperty(name="No pictures", description="measure only: faster, without heat and pictures")
    mapping: StringProperty(name="Mapping", subtype="FILE_PATH",
                            description="which controls bend the spine; empty: NAME.map.json beside the file, else found")
    character: StringProperty(name="Character", subtype="FILE_PATH",
                              description="an export of this rig to judge; empty: it is exported")


class BACKBEND_PT_files(bpy.types.Panel):
    bl_label, bl_space_type, bl_region_type, bl_category = "Files", "VIEW_3D", "UI", "backbend"
    bl_parent_id, bl_options = "BACKBEND_PT_panel", {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.prop(context.scene.backbend, "mapping")
        self.layout.prop(context.scene.backbend, "character")


class BackbendPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: StringProperty(name="backbend", subtype="FILE_PATH", description="path of the program; empty: from the PATH")
    folder: StringProperty(name="Folder for runs", subtype="DIR_PATH", description="empty: Blender's temporary folder, which goes when Blender ends")

    def draw(self, context):
        self.layout.prop(self, "program")
        self.layout.prop(self, "folder")


def remember(context):
    """The armature that was taken is shown as chosen: a click on its mesh does not change what is judged."""
    context.scene.backbend.armature = armature_of(context)


def stop():
    if SESSION.work is not None:
        SESSION.work.cancel()
        SESSION.work = None


@bpy.app.handlers.persistent
def forget(*_):
    """Results are of one file: another one has been opened."""
    stop()
    SESSION.clear()
    for manager in bpy.data.window_managers:
        manager.backbend.findings.clear()
        manager.backbend.headroom.clear()


CLASSES = (BackbendFinding, BackbendHeadroom, BackbendLists, BackbendSettings, BackbendPreferences, BACKBEND_OT_judge,
           BACKBEND_OT_cancel, BACKBEND_OT_show_finding, BACKBEND_OT_show_heat, BACKBEND_OT_rest, BACKBEND_OT_open_page,
           BACKBEND_OT_repair, BACKBEND_OT_export_even, BACKBEND_UL_findings, BACKBEND_PT_panel, BACKBEND_PT_files)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.backbend = PointerProperty(type=BackbendSettings)
    bpy.types.WindowManager.backbend = PointerProperty(type=BackbendLists)
    bpy.app.handlers.load_post.append(forget)


def unregister():
    stop()
    bpy.app.handlers.load_post.remove(forget)
    del bpy.types.Scene.backbend, bpy.types.WindowManager.backbend
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)


if __name__ == "__main__":
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    if own[:1] == ["--export"]:
        export_main(own)
    else:
        register()

"""Lets backbend ask a Blender rig for its poses, or exports its motion.

    backbend check hero.glb --rig blender:hero.blend --map mapping.json
    blender --background hero.blend --python backbend_blender.py -- mapping.json hero.clip [--stress]

The first starts this file by itself, with --serve, and speaks docs/rig_protocol.md with it.

The mapping names the armature, its spine, and which control stands for which channel; see
docs/bridges/blender.md. Constraints, drivers, Spline IK and B-Bones are Blender's own: what is
written down is what Blender shows.
"""

import array
import json
import math
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True  # nothing is left beside this file, which may be installed
import backbend_clip  # noqa: E402  (beside this file)
import backbend_rig  # noqa: E402

ROTATIONS = {"rx": 0, "ry": 1, "rz": 2}
LOCATIONS = {"x": 0, "y": 1, "z": 2}


# What a preset's mapping calls the control at the upper end of a spine that follows a curve.
SPLINE_IK_END, B_BONE_END = "spline_ik_end", "b_bone_end"


def scene_objects():
    """What the scene shows: objects of the view layer, and those of collections that stand in it as instances. The
    linked originals of overridden characters have the same names, and are not meant."""
    shown, found = list(bpy.context.view_layer.objects), []
    while shown:
        thing = shown.pop(0)
        if thing in found:
            continue
        found.append(thing)
        if thing.instance_type == "COLLECTION" and thing.instance_collection is not None:
            shown += thing.instance_collection.all_objects
    originals = [thing.override_library.reference for thing in found if thing.override_library]
    return [thing for thing in found if thing not in originals]


def columns(matrix):
    return [matrix[row][column] for column in range(4) for row in range(4)]


def depth(bone):
    return 0 if bone.parent is None else 1 + depth(bone.parent)


class Scene:
    """One armature, and perhaps a mesh, as backbend_clip.record() drives and reads them."""

    def __init__(self, mapping):
        self.armature = self.named(mapping.get("armature"), "ARMATURE")
        self.mesh = self.named(mapping["mesh"], "MESH") if mapping.get("mesh") else None
        self.rest = {}
        # Parents first. A B-Bone is a chain of its own: its segments follow it.
        self.bones = sorted(self.armature.data.bones, key=lambda bone: (depth(bone), bone.name))
        self.joints = []  # (name, parent index, bone name, segment or None)
        where = {}
        for bone in self.bones:
            parent = where.get(bone.parent.name, -1) if bone.parent else -1
            where[bone.name] = len(self.joints)
            self.joints.append((bone.name, parent, bone.name, None))
            for segment in range(bone.bbone_segments if bone.bbone_segments > 1 else 0):
                self.joints.append((self.segment_name(bone.name, segment), len(self.joints) - 1, bone.name, segment))
            where[bone.name] = len(self.joints) - 1  # what follows a B-Bone goes on from its last segment
        self.spine = []
        for name in mapping["spine"]:
            if name not in self.armature.data.bones:
                raise ValueError(f"spine: no bone '{name}' in '{self.armature.name}'")
            segments = self.armature.data.bones[name].bbone_segments
            if segments > 1:
                self.spine += [self.segment_name(name, k) for k in range(segments)]
            else:
                self.spine.append(name)

    @staticmethod
    def segment_name(bone, segment):
        return f"{bone}.seg{segment:02d}"

    @staticmethod
    def named(name, kind):
        found = [thing for thing in scene_objects() if thing.type == kind]
        if name is None:
            if len(found) != 1:
                raise ValueError(f"{len(found)} objects of type {kind}: name one in the mapping")
            return found[0]
        # Two linked characters may have objects of one name, in collections of their own.
        found = [thing for thing in found if thing.name == name]
        if not found:
            raise ValueError(f"no object '{name}' of type {kind}")
        return found[0]

    def rest_matrices(self):
        world = self.armature.matrix_world
        out = []
        for _, _, bone, segment in self.joints:
            matrix = world @ self.armature.data.bones[bone].matrix_local
            if segment is not None:
                matrix = matrix @ self.armature.pose.bones[bone].bbone_segment_matrix(segment, rest=True)
            out.append(columns(matrix))
        return out

    def set_control(self, control, channel, value):
        """`control` is a pose bone or an object. `channel`: rx ry rz (degrees), x y z, or the name
        of a property."""
        if control in self.armature.pose.bones:
            target = self.armature.pose.bones[control]
        else:
            target = next((thing for thing in scene_objects() if thing.name == control), None)
            if target is None:
                raise ValueError(f"no bone or object '{control}'")
        if channel in ROTATIONS:
            if target.rotation_mode in ("QUATERNION", "AXIS_ANGLE"):
                target.rotation_mode = "XYZ"  # a number of degrees beyond 180 needs a number
            holder, key, value = target.rotation_euler, ROTATIONS[channel], math.radians(value)
        elif channel in LOCATIONS:
            holder, key = target.location, LOCATIONS[channel]
        elif channel in target.keys():
            holder, key = target, channel
        else:
            raise ValueError(f"'{control}' has no channel '{channel}'")
        rest = self.rest.setdefault((control, channel), holder[key])
        holder[key] = rest + value
        target.id_data.update_tag()

    def read_pose(self):
        bpy.context.view_layer.update()
        graph = bpy.context.evaluated_depsgraph_get()
        armature = self.armature.evaluated_get(graph)
        matrices = []
        for _, _, bone, segment in self.joints:
            pose = armature.pose.bones[bone]
            matrix = armature.matrix_world @ pose.matrix
            if segment is not None:
                matrix = matrix @ pose.bbone_segment_matrix(segment, rest=False)
            matrices.append(columns(matrix))
        points = []
        if self.mesh is not None:
            body = self.mesh.evaluated_get(graph)
            mesh = body.to_mesh()
            for vertex in mesh.vertices:
                points.extend(body.matrix_world @ vertex.co)
            body.to_mesh_clear()
        return matrices, points


def export(mapping, path, stress=False):
    """Drives the standard (or stress) sweeps and writes the clip."""
    backbend_clip.check_mapping(mapping)
    check_drivers()
    scene = Scene(mapping)
    rest = scene.rest_matrices()
    _, points = scene.read_pose()
    writer = backbend_clip.ClipWriter(
        [(name, parent, rest[k]) for k, (name, parent, _, _) in enumerate(scene.joints)],
        points=len(points) // 3, up="Z", metres_per_unit=bpy.context.scene.unit_settings.scale_length,
        program="Blender " + bpy.app.version_string, scene=bpy.data.filepath,
        spine=scene.spine, arms=mapping.get("arms"))
    backbend_clip.record(mapping, stress, scene.set_control, scene.read_pose, writer)
    writer.save(path)


def values_of(bone, channel):
    """Where a channel of a pose bone is kept: (holder, key, what a degree of it is there)."""
    if channel in ROTATIONS:
        if bone.rotation_mode in ("QUATERNION", "AXIS_ANGLE"):
            bone.rotation_mode = "XYZ"  # a number of degrees beyond 180 needs a number
        return bone.rotation_euler, ROTATIONS[channel], math.pi / 180
    if channel in LOCATIONS:
        return bone.location, LOCATIONS[channel], 1.0
    return bone, channel, 1.0


def range_of(bone, key):
    """(smallest, largest) of a custom property; None where it has no range of its own."""
    try:
        told = bone.id_properties_ui(key).as_dict()
    except (KeyError, TypeError):  # declared by an add-on
        return None
    ends = told.get("min"), told.get("max")
    if None in ends or not ends[0] < ends[1] or max(map(abs, ends)) > 1e9:  # Blender's own ends of a number
        return None
    return ends


class Server:
    """One armature as backbend_rig.serve() asks for it. Controls in another armature are called
    `armature:bone`."""

    def __init__(self, mapping):
        self.armature = self.find_armature(mapping)
        check_drivers()
        hide_meshes()
        self.bodies = self.find_bodies(mapping)
        self.shown = False
        self.rest_points, self.triangles = self.declared_mesh()
        self.controls = {}  # by the channel's name
        for thing in scene_objects():
            if thing.type != "ARMATURE" or thing.pose is None:
                continue
            for bone in thing.pose.bones:
                name = bone.name if thing == self.armature else f"{thing.name}:{bone.name}"
                properties = [key for key, value in bone.items()
                              if isinstance(value, (int, float)) and not isinstance(value, bool)]
                for channel in [*ROTATIONS, *LOCATIONS, *properties]:
                    self.controls[f"{name}.{channel}"] = (bone, channel)
        for name, bone in ends_of_curves(self.armature).items():
            for channel in ROTATIONS:
                self.controls.setdefault(f"{name}.{channel}", (bone, channel))
        self.channels = list(self.controls)
        self.known = {}  # name: (index of the parent, bone, segment or None)
        where = {}
        for bone in sorted(self.armature.data.bones, key=lambda bone: (depth(bone), bone.name)):
            where[bone.name] = len(self.known)
            self.known[bone.name] = (where[bone.parent.name] if bone.parent else -1, bone.name, None)
            # A B-Bone bends and rolls inside: its segments say how.
            for segment in range(bone.bbone_segments if bone.bbone_segments > 1 else 0):
                self.known[Scene.segment_name(bone.name, segment)] = (len(self.known) - 1, bone.name, segment)
        self.joints = list(self.known)
        self.holders = None

    @staticmethod
    def find_armature(mapping):
        if mapping.get("armature"):
            return Scene.named(mapping["armature"], "ARMATURE")
        found = [thing for thing in scene_objects() if thing.type == "ARMATURE"]
        if len(found) == 1:
            return found[0]
        wanted = {target.get("control") for targets in mapping.get("channels", {}).values() for target in targets}
        wanted -= {SPLINE_IK_END, B_BONE_END}
        fits = [thing for thing in found if wanted and wanted & set(thing.pose.bones.keys())]
        if len(fits) == 1:
            return fits[0]
        # A metarig stands beside the rig that was made of it: the one that moves a body is meant.
        moves = [thing for thing in found if any(
            modifier.type == "ARMATURE" and modifier.object == thing
            for body in scene_objects() if body.type == "MESH" for modifier in body.modifiers)]
        if not wanted and len(moves) == 1:
            return moves[0]
        raise ValueError(f"{len(found)} armatures: name one in the mapping (\"armature\")")

    def find_bodies(self, mapping):
        """The meshes that the armature deforms, or those that the mapping names; none where it says false."""
        wanted = mapping.get("mesh")
        if wanted is False:
            return []
        names = [wanted] if isinstance(wanted, str) else wanted
        if names:
            found = [Scene.named(name, "MESH") for name in names]
        else:
            found = [thing for thing in scene_objects() if thing.type == "MESH"
                     and not thing.hide_render and self.is_deformed(thing)]
        for thing in found:
            for modifier in thing.modifiers:
                if modifier.type in ("SUBSURF", "MULTIRES"):
                    modifier.show_viewport = False  # adds points, and no motion of its own
        return sorted(found, key=lambda thing: thing.name)

    def is_deformed(self, thing):
        return (thing.parent == self.armature and thing.parent_type == "ARMATURE") or any(
            modifier.type == "ARMATURE" and modifier.object == self.armature and modifier.show_viewport
            for modifier in thing.modifiers)

    def show(self, shown):
        """A body that is evaluated takes nine tenths of the time: only where its points are wanted."""
        if shown != self.shown:
            for thing in self.bodies:
                thing.hide_viewport = not shown
            self.shown = shown

    def declared_mesh(self):
        if not self.bodies:
            return None, None
        self.show(True)
        bpy.context.view_layer.update()
        points, triangles, first = self.read_points(), [], 0
        for body, mesh in self.evaluated():
            mesh.calc_loop_triangles()
            triangles += [first + vertex for triangle in mesh.loop_triangles for vertex in triangle.vertices]
            first += len(mesh.vertices)
            body.to_mesh_clear()
        return points, triangles

    def evaluated(self):
        graph = bpy.context.evaluated_depsgraph_get()
        for thing in self.bodies:
            body = thing.evaluated_get(graph)
            yield body, body.to_mesh()

    def read_points(self):
        out = array.array("f")
        for body, mesh in self.evaluated():
            mesh.transform(body.matrix_world)
            points = array.array("f", bytes(12 * len(mesh.vertices)))
            mesh.vertices.foreach_get("co", points)
            out.extend(points)
            body.to_mesh_clear()
        return out

    def declared_channels(self):
        out = []
        # What animators take hold of has a shape of its own, in a rig where any bone has.
        shaped = {thing.name for thing in scene_objects() if thing.type == "ARMATURE" and thing.pose
                  and any(bone.custom_shape for bone in thing.pose.bones)}
        for name, (bone, channel) in self.controls.items():
            kind = "rotation" if channel in ROTATIONS else "translation" if channel in LOCATIONS else "scalar"
            owner = bone.id_data.name
            is_control = (owner not in shaped or bone.custom_shape is not None) and name.rpartition(".")[0] not in (
                SPLINE_IK_END, B_BONE_END) and not (
                channel in ROTATIONS and bone.lock_rotation[ROTATIONS[channel]])
            if kind == "rotation" and bone.rotation_mode in ("QUATERNION", "AXIS_ANGLE"):
                out.append((name, kind, math.degrees(bone.matrix_basis.to_euler("XYZ")[ROTATIONS[channel]]), is_control))
                continue
            holder, key, unit = values_of(bone, channel)
            out.append((name, kind, holder[key] / unit, is_control, range_of(bone, channel) if kind == "scalar" else None))
        return out

    def declared_joints(self):
        world, out = self.armature.matrix_world, []
        for name, (parent, bone, segment) in self.known.items():
            matrix = world @ self.armature.data.bones[bone].matrix_local
            if segment is not None:
                matrix = matrix @ self.armature.pose.bones[bone].bbone_segment_matrix(segment, rest=True)
            out.append((name, parent, columns(matrix)))
        return out

    def select(self, channels, joints):
        self.channels, self.joints, self.holders = channels, joints, None

    def pose(self, values):
        self.show(False)
        return self.evaluate(values)

    def pose_with_points(self, values):
        self.show(True)
        matrices, points = self.evaluate(values), self.read_points()
        if len(points) != len(self.rest_points):
            raise ValueError(f"the meshes have {len(points) // 3} points in this pose and {len(self.rest_points) // 3} "
                             "at rest: a modifier makes others")
        return matrices, points

    def evaluate(self, values):
        if self.holders is None:
            for name in self.channels:
                values_of(*self.controls[name])  # all rotation modes first: a switch sets the angles anew
            self.holders = [(*values_of(*self.controls[name]), self.controls[name][0].id_data)
                            for name in self.channels]
            self.touched = {owner for *_, owner in self.holders}
        for (holder, key, unit, _), value in zip(self.holders, values):
            if isinstance(key, int) or not isinstance(holder[key], int):
                holder[key] = value * unit
            else:
                holder[key] = round(value)
        for owner in self.touched:
            owner.update_tag()
        bpy.context.view_layer.update()
        armature = self.armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
        world, bones, out = armature.matrix_world, armature.pose.bones, []
        for name in self.joints:
            _, bone, segment = self.known[name]
            matrix = world @ bones[bone].matrix
            if segment is not None:
                matrix = matrix @ bones[bone].bbone_segment_matrix(segment, rest=False)
            out.append(columns(matrix))
        return out


def ends_of_curves(armature):
    """{SPLINE_IK_END: the bone that the end of the longest Spline IK chain's curve is hooked to, B_BONE_END: the end
    handle of the B-Bone with most segments}, where there are such."""
    found = {}
    chains = [constraint for bone in armature.pose.bones for constraint in bone.constraints
              if constraint.type == "SPLINE_IK" and constraint.target is not None]
    for constraint in sorted(chains, key=lambda constraint: constraint.chain_count, reverse=True)[:1]:
        hooks = [hook for hook in constraint.target.modifiers
                 if hook.type == "HOOK" and hook.object is not None and hook.object.type == "ARMATURE" and hook.subtarget]
        for hook in sorted(hooks, key=lambda hook: max(hook.vertex_indices, default=-1)):
            found[SPLINE_IK_END] = hook.object.pose.bones[hook.subtarget]  # the last point's
    bent = [bone for bone in armature.data.bones if bone.bbone_segments > 1 and bone.bbone_custom_handle_end is not None]
    for bone in sorted(bent, key=lambda bone: (bone.bbone_segments, depth(bone)))[-1:]:
        found[B_BONE_END] = armature.pose.bones[bone.bbone_custom_handle_end.name]
    return found


def check_drivers():
    """Raises ValueError for a driver that Blender does not evaluate: without it another rig would be judged."""
    bpy.context.view_layer.update()
    # Such drivers are valid, and 0.
    if bpy.app.autoexec_fail and bpy.app.autoexec_fail_message.startswith("Driver"):
        raise ValueError(f"drivers that call functions are disabled ({bpy.app.autoexec_fail_message}); "
                         "start Blender with --enable-autoexec")
    for group in (bpy.data.objects, bpy.data.armatures, bpy.data.curves, bpy.data.lattices, bpy.data.meshes,
                  bpy.data.shape_keys):
        for thing in group:
            animation = getattr(thing, "animation_data", None)
            for curve in animation.drivers if animation else []:
                if not curve.driver.is_valid or not curve.is_valid:
                    raise ValueError(f"the driver of '{thing.name}' {curve.data_path}[{curve.array_index}] is not "
                                     f"valid: {curve.driver.expression}")


def hide_meshes():
    """What the armature does not deform is never wanted, and the rest only where its points are."""
    for thing in scene_objects():
        if thing.type == "MESH":
            thing.hide_viewport = True
    bpy.context.view_layer.update()


def serve(files):
    """Speaks the protocol until backbend closes the stream. Errors are said over it: Blender's own exit code
    says nothing about its scripts."""
    streams = backbend_rig.own_streams()
    try:
        mapping = {}
        if files:
            with open(files[0], encoding="utf-8") as file:
                mapping = json.load(file)
        server = Server(mapping)
        channels, joints = server.declared_channels(), server.declared_joints()
    except (OSError, ValueError, KeyError, AttributeError, TypeError) as error:
        backbend_rig.refuse(f"{os.path.basename(bpy.data.filepath)}: {error}", streams)
    backbend_rig.serve(channels, joints, server.pose, program="Blender " + bpy.app.version_string,
                       scene=bpy.data.filepath, up="Z",
                       metres_per_unit=bpy.context.scene.unit_settings.scale_length, select=server.select,
                       mesh=(server.rest_points, server.triangles) if server.bodies else None,
                       pose_with_points=server.pose_with_points, streams=streams)


def main(arguments):
    if arguments[:1] == ["--serve"]:
        serve(arguments[1:])
        return
    stress = "--stress" in arguments
    files = [word for word in arguments if word != "--stress"]
    if len(files) != 2:
        raise SystemExit("usage: ... --python backbend_blender.py -- MAPPING.json OUT.clip [--stress]")
    try:
        with open(files[0], encoding="utf-8") as file:
            mapping = json.load(file)
        export(mapping, files[1], stress)
    except (OSError, ValueError) as error:
        # Blender's own exit code says nothing about its scripts.
        print(f"backbend: {files[0]}: {error}", file=sys.stderr)
        sys.exit(3)


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])

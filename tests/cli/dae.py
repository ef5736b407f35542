"""The smallest Collada character: a skinned tube along a column of joints."""

import math

HUMAN = ["hips", "spine", "chest", "neck", "head"]


def tube(names=HUMAN, body=1.0, rings=9, sides=8):
    """A tube 1.6 m tall around a straight chain of joints; `body` is the size of its mesh against that, as a bind
    shape matrix gives it that was never applied."""
    spacing = 1.6 / len(names)
    positions, shares, triangles = [], [], []
    for ring in range(rings):
        height = 1.6 * ring / (rings - 1)
        along = min(height / spacing, len(names) - 1)
        low = min(int(along), len(names) - 2)
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            positions += [0.15 * math.cos(angle), height, 0.15 * math.sin(angle)]
            shares.append((low, along - low))
    for ring in range(rings - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            triangles += [a, a + sides, b, b, a + sides, b + sides]
    count = rings * sides
    binds = [v for k in range(len(names)) for v in (1, 0, 0, 0, 0, 1, 0, -spacing * k, 0, 0, 1, 0, 0, 0, 0, 1)]
    weights = [w for _, share in shares for w in (1 - share, share)]
    pairs = [v for n, (low, _) in enumerate(shares) for v in (low, 2 * n, low + 1, 2 * n + 1)]

    def numbers(values):
        return " ".join(f"{v:.9g}" for v in values)

    def source(name, values, kind, stride, parameter, of="float"):
        return (f'<source id="{name}"><{kind} id="{name}-data" count="{len(values)}">'
                f'{" ".join(values) if kind == "Name_array" else numbers(values)}</{kind}><technique_common>'
                f'<accessor source="#{name}-data" count="{len(values) // stride}" stride="{stride}">'
                + "".join(f'<param name="{p}" type="{of}"/>' for p in parameter) +
                "</accessor></technique_common></source>")

    joints = ""
    for k in reversed(range(len(names))):
        joints = (f'<node id="{names[k]}" sid="{names[k]}" name="{names[k]}" type="JOINT"><translate sid="t">'
                  f'0 {spacing if k else 0:.9g} 0</translate>{joints}</node>')
    return f'''<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00</created><modified>2026-01-01T00:00:00</modified>
<unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="body" name="body"><mesh>{source("p", positions, "float_array", 3, "XYZ")}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(triangles) // 3}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{numbers(triangles)}</p></triangles></mesh></geometry></library_geometries>
<library_controllers><controller id="skin"><skin source="#body">
<bind_shape_matrix>{body:.9g} 0 0 0 0 {body:.9g} 0 0 0 0 {body:.9g} 0 0 0 0 1</bind_shape_matrix>
{source("j", names, "Name_array", 1, ["JOINT"], "name")}
{source("b", binds, "float_array", 16, ["TRANSFORM"], "float4x4")}
{source("w", weights, "float_array", 1, ["WEIGHT"])}
<joints><input semantic="JOINT" source="#j"/><input semantic="INV_BIND_MATRIX" source="#b"/></joints>
<vertex_weights count="{count}"><input semantic="JOINT" source="#j" offset="0"/>
<input semantic="WEIGHT" source="#w" offset="1"/><vcount>{numbers([2] * count)}</vcount>
<v>{numbers(pairs)}</v></vertex_weights></skin></controller></library_controllers>
<library_visual_scenes><visual_scene id="scene">{joints}
<node id="character"><instance_controller url="#skin"><skeleton>#{names[0]}</skeleton></instance_controller></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>
'''

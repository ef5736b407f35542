"""The smallest skeleton that is somebody, without a body: as BVH."""

# Five joints, one above the other, 0.3 apart; arms and legs so that it is somebody.
WALKER = """HIERARCHY
ROOT hips
{
 OFFSET 0 1 0
 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
 JOINT spine
 {
  OFFSET 0 0.15 0
  CHANNELS 3 Zrotation Xrotation Yrotation
  JOINT chest
  {
   OFFSET 0 0.2 0
   CHANNELS 3 Zrotation Xrotation Yrotation
   JOINT neck
   {
    OFFSET 0 0.2 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT head
    {
     OFFSET 0 0.1 0.01
     CHANNELS 3 Zrotation Xrotation Yrotation
     End Site
     {
      OFFSET 0 0.2 0
     }
    }
   }
%s
  }
 }
%s
}
MOTION
Frames: %d
Frame Time: 0.04
%s
"""


def limb(names, steps):
    """Joints of a limb, each inside the last."""
    text, indent = "", 3
    for name, step in zip(names, steps):
        text += (" " * indent + f"JOINT {name}\n" + " " * indent + "{\n" + " " * indent +
                 f" OFFSET {step}\n" + " " * indent + " CHANNELS 3 Zrotation Xrotation Yrotation\n")
        indent += 1
    text += " " * indent + "End Site\n" + " " * indent + "{\n" + " " * indent + " OFFSET 0 0 0.1\n"
    return text + "}\n" * (len(names) + 1)


def walker(rows=None):
    """As a BVH file. `rows` are the frames, each a dict from channel number to degrees: 6 to 8 the
    spine's Z, X and Y, 9 to 11 the chest's; at rest by default."""
    arms = legs = ""
    for side, x in (("Left", 1), ("Right", -1)):
        arms += limb([side + n for n in ("Shoulder", "Arm", "ForeArm", "Hand")],
                     [f"{0.05 * x} 0.17 0", f"{0.14 * x} 0 0", f"{0.28 * x} 0 0", f"{0.25 * x} 0 0"])
        legs += limb([side + n for n in ("UpLeg", "Leg", "Foot")],
                     [f"{0.1 * x} -0.05 0", "0 -0.43 0", "0 -0.42 0"])
    channels = 3 + 3 * (5 + 8 + 6)
    frames = [" ".join(str(row.get(c, 0)) for c in range(channels)) for row in rows or [{}]]
    return WALKER % (arms, legs, len(frames), "\n".join(frames))

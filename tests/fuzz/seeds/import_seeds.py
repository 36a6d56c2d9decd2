"""Valid files of all formats for motiondb-import: small ones, which it converts itself, and the
scenes of the Debian package assimp-testmodels."""

import base64
import dataclasses
import glob
import io
import json
import math
import os
import struct
import subprocess
import zipfile

MODELS = "/usr/share/assimp/models"
MAX_MODEL_BYTES = 200_000

ASF = b""":version 1.10
:name small
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lfemur
     direction 0.3 -0.9 0
     length 7
     axis 0 0 20  XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name rfemur
     direction -0.3 -0.9 0
     length 7
     axis 0 0 -20  XYZ
    dof rx
  end
:hierarchy
  begin
    root lfemur rfemur
  end
"""
AMC = b":FULLY-SPECIFIED\n:DEGREES\n" + b"".join(
    b"%d\nroot 9.3 17.8 -17 -2 -2 %d\nlfemur 5 6 %d\nrfemur 1\n" % (i, i, i) for i in range(1, 9))

LINKS = ["pelvis", "l_thigh", "l_shin", "r_thigh", "r_shin"]
URDF = ("<robot name='biped'>" + "".join(f"<link name='{link}'/>" for link in LINKS) + "".join(
    f"<joint name='{side}_{name}' type='revolute'><parent link='{parent}'/>"
    f"<child link='{side}_{child}'/><origin xyz='0 {y} {z}'/><axis xyz='0 1 0'/>"
    "<limit lower='-2' upper='2.5'/></joint>\n"
    for side, y in (("l", 0.1), ("r", -0.1))
    for name, parent, child, y, z in (("hip", "pelvis", "thigh", y, 0),
                                      ("knee", side + "_thigh", "shin", 0, -0.4)))
        + "</robot>\n").encode()
TABLE = ("time_s,root_x_m,root_y_m,root_z_m,root_qx,root_qy,root_qz,root_qw,"
         "l_hip,l_knee,r_hip,r_knee\n" + "".join(
             f"{0.02 * i:.2f},{0.01 * i:.2f},0,0.8,0,0,0,1,{0.1 * i:.1f},0.2,{-0.1 * i:.1f},0.4\n"
             for i in range(8))).encode()
PLAIN_TABLE = b"".join(b"0,%d,0.8,0,0,0,1,0.1,0.2,0.3,0.4\n" % i for i in range(8))


@dataclasses.dataclass(frozen=True)
class Seed:
    format: str  # row of the table of results
    suffix: str  # of the file's name
    data: bytes
    skeleton: bytes = b""
    skeleton_suffix: str = ""
    is_ours: bool = True  # read without assimp
    is_motion: bool = True  # False: a scene that is rejected, such as one without animation


def bvh():
    """A figure of a few joints that swings its legs."""
    def joint(kind, name, offset, *children):
        return (f"{kind} {name}\n{{\nOFFSET {offset}\n" +
                ("CHANNELS 6 Xposition Yposition Zposition " if kind == "ROOT" else "CHANNELS 3 ") +
                "Zrotation Xrotation Yrotation\n" +
                ("".join(children) or "End Site\n{\nOFFSET 0 -5 0\n}\n") + "}\n")

    legs = [joint("JOINT", side + "UpLeg", f"{x} -5 0",
                  joint("JOINT", side + "Leg", "0 -40 0", joint("JOINT", side + "Foot", "0 -40 0")))
            for side, x in (("Left", 10), ("Right", -10))]
    spine = joint("JOINT", "Spine", "0 30 0", joint("JOINT", "Head", "0 30 0"))
    frames = 12
    rows = []
    for i in range(frames):
        swing = 20 * math.sin(0.5 * i)
        leg = [0, swing, 0, 0, 10, 0, 0, 0, 0]
        rows.append([i, 90, 0, 0, 0, 0] + leg + [-value for value in leg] + [0] * 6)
    return ("HIERARCHY\n" + joint("ROOT", "Hips", "0 0 0", *legs, spine) +
            f"MOTION\nFrames: {frames}\nFrame Time: 0.02\n" +
            "".join(" ".join(f"{value:.5g}" for value in row) + "\n" for row in rows)).encode()


def amass():
    """An archive of SMPL-H, as AMASS has them."""
    frames = 8
    arrays = {"poses": ((frames, 156), [0.01 * (i % 7) for i in range(frames * 156)]),
              "trans": ((frames, 3), [0.1 * (i % 3) for i in range(frames * 3)]),
              "mocap_framerate": ((), [60]), "betas": ((16,), [0.5] * 16)}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, (shape, numbers) in arrays.items():
            header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
            archive.writestr(name + ".npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) +
                             header + struct.pack(f"<{len(numbers)}d", *numbers))
    return out.getvalue()


def convert(program, path, name):
    """Returns the file in another format."""
    request = json.dumps({"file": path, "written_as": name})
    answer = subprocess.run([program, "convert"], input=request.encode() + b"\n",
                            stdout=subprocess.PIPE, check=True).stdout
    header, _, content = answer.partition(b"\n")
    if "error" in json.loads(header):
        raise RuntimeError(f"convert to {name}: {json.loads(header)['error']}")
    return content


def gltf_of(glb):
    """Returns a GLB file in text form, with its buffer in base64."""
    length, = struct.unpack_from("<I", glb, 12)
    scene = json.loads(glb[20:20 + length])
    buffer = base64.b64encode(glb[28 + length:]).decode()
    scene["buffers"][0]["uri"] = "data:application/octet-stream;base64," + buffer
    return json.dumps(scene).encode()


def curves_of(gltf):
    """Returns a glTF text with steps, and cubic splines of a third of the frames."""
    scene = json.loads(gltf)
    samplers = scene["animations"][0]["samplers"]
    times = dict(scene["accessors"][samplers[0]["input"]])
    times["count"] //= 3
    times["max"] = [1]
    scene["accessors"].append(times)
    for i, sampler in enumerate(samplers):
        sampler["interpolation"] = ("STEP", "CUBICSPLINE", "LINEAR")[i % 3]
        if i % 3 == 1:
            sampler["input"] = len(scene["accessors"]) - 1
    return json.dumps(scene).encode()


def own_seeds(program, folder):
    path = os.path.join(folder, "seed.bvh")
    with open(path, "wb") as file:
        file.write(bvh())
    robot = {"skeleton": URDF, "skeleton_suffix": ".urdf"}
    seeds = [Seed("bvh", ".bvh", bvh()), Seed("amc", ".amc", AMC, ASF, ".asf"),
             Seed("csv", ".csv", TABLE, **robot), Seed("csv", ".csv", PLAIN_TABLE, **robot),
             Seed("npz", ".npz", amass())]
    for name, suffix in (("bvh", ".bvh"), ("trc", ".trc"), ("c3d", ".c3d"), ("csv", ".csv"),
                         ("npz", ".npz"), ("gltf", ".glb")):
        seeds.append(Seed("glb" if suffix == ".glb" else name, suffix, convert(program, path, name),
                          is_ours=suffix != ".glb"))
    text = gltf_of(seeds[-1].data)
    return seeds + [Seed("gltf", ".gltf", one, is_ours=False) for one in (text, curves_of(text))]


def model_seeds(program):
    seeds = []
    for path in sorted(glob.glob(os.path.join(MODELS, "**", "*"), recursive=True)):
        suffix = os.path.splitext(path)[1].lower()
        name = {".fbx": "fbx", ".gltf": "gltf", ".glb": "glb", ".dae": "collada"}.get(suffix)
        if name and os.path.isfile(path) and os.path.getsize(path) <= MAX_MODEL_BYTES:
            inspected = subprocess.run([program, "inspect"], stdout=subprocess.PIPE, check=True,
                                       input=json.dumps({"file": path}).encode()).stdout
            with open(path, "rb") as file:
                seeds.append(Seed(name, suffix, file.read(), is_ours=False,
                                  is_motion="error" not in json.loads(inspected)["result"]))
    return seeds

"""Types of the module, with the shapes and units of its arrays. docs/python.md explains it.

N: poses. J: joints. V: vertices. T: triangles. Angles in degrees, lengths in the file's unit.
"""

from collections.abc import Iterable, Sequence
from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_Floats = NDArray[np.float64]
_Points = NDArray[np.float32]
_File = str | PathLike[str]
_Rig = str | PathLike[str] | Rig | PythonRig
_Mapping = Literal["chest", "spread"]
_Axis = Literal["", "+X", "-X", "+Y", "-Y", "+Z", "-Z"]
_Sweeps = Literal["standard", "stress"]
_Mode = Literal["beauty", "clay", "ao", "matcap", "wireframe", "heat", "xray", "contour", "primary"]
_View = Literal["profile", "front", "back", "three_quarter"]
_Option = bool | float | str | Sequence[float] | Sequence[Sequence[float]]

class Error(Exception):
    exit_code: int
    """What the command would have ended with: docs/exit_codes.md."""

class InputError(Error, ValueError): ...
class WriteError(Error, OSError): ...

class Record(dict[str, Any]):
    def __getattr__(self, name: str) -> Any: ...

class Poses(Record):
    positions: _Floats
    """N x J x 3: joint origins, rig space."""
    turns: _Floats
    """N x J x 4: rotation from rest in rig space, unit quaternion w, x, y, z."""
    flagged: NDArray[np.bool_]
    """N: whether the pose needed a documented fallback."""
    measures: dict[str, _Floats]
    """With measures: by name, N."""
    flags: list[list[str]]
    """With measures: the fallbacks of each pose."""
    flip_margin_deg: _Floats | None
    """With measures: N x J, degrees to the nearest singular pose; None: there is none."""

class SkinnedPoses(Record):
    positions: _Points
    """N x V x 3, world space."""
    normals: _Points
    """N x V x 3, unit length."""
    matrices: _Floats
    """Of pose() alone: N x J x 4 x 4, world from joint, column vectors."""

class Series(Record):
    sweep: str
    channel: str
    mapping: str
    control_deg: _Floats
    """N."""
    metric: dict[str, _Floats]
    """By name, N; NaN where it was not measured or does not apply."""
    unit: dict[str, str]
    limit: dict[str, float | None]
    """Default limits; None: none."""

class Picture(Record):
    layers: dict[str, _Points]
    """height x width x channels, top row first; RGBA is scene-linear Rec.709."""
    attributes: dict[str, str]
    """As in an EXR's header: the names in the Cryptomatte layers among them."""
    camera_from_world: _Floats
    """4 x 4, right-handed, -Z forward."""
    ndc_from_world: _Floats
    """4 x 4; x, y in 0..1 from the upper left, after the division by w."""

class Anatomy(Record):
    spine: list[str]
    """The driven chain, hips to chest."""
    spine_to_head: list[str]
    left_arm: list[str]
    right_arm: list[str]
    left_leg: list[str]
    right_leg: list[str]
    tail: list[str]
    up: tuple[float, float, float]
    forward: tuple[float, float, float]
    left: tuple[float, float, float]
    height: float
    spine_length: float
    sure: bool
    doubts: list[str]
    reasons: list[str]

class Character:
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> str: ...
    @property
    def positions(self) -> _Points:
        """V x 3 at rest, world space. Read-only, as all arrays of a character."""
    @property
    def normals(self) -> _Points:
        """V x 3 at rest, unit length."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """T x 3."""
    @property
    def uv(self) -> _Points:
        """V x 2, or 0 x 2."""
    @property
    def weights(self) -> _Points:
        """V x 8, largest first; they sum to 1."""
    @property
    def weight_joints(self) -> NDArray[np.int32]:
        """V x 8, into joints."""
    @property
    def joints(self) -> list[str]: ...
    @property
    def parents(self) -> list[int]: ...
    @property
    def rest_matrices(self) -> _Floats:
        """J x 4 x 4, world from joint, column vectors."""
    @property
    def chain(self) -> _Floats:
        """N x 3: the driven spine at rest, hips to chest."""
    @property
    def anatomy(self) -> Anatomy: ...
    def inspect(self) -> Record: ...
    def skin(self, matrices: ArrayLike, *, out: tuple[_Points, _Points] | None = None) -> SkinnedPoses: ...
    def pose(self, rig: Rig, controls: ArrayLike, *, out: tuple[_Points, _Points] | None = None) -> SkinnedPoses: ...
    def measure(self, rig: Rig, *, mapping: _Mapping = "chest", extension: float = ..., flexion: float = ...,
                side: float = ..., twist: float = ..., hip: float = ..., stretch: float = ...) -> Series: ...
    def measure_sweep(self, rig: Rig, sweep: str, *, mapping: _Mapping = "chest") -> Series: ...
    def render(self, rig: Rig, *, mapping: _Mapping = "chest", view: _View = "profile", width: int = 640,
               height: int = 360, samples: int = 16, mode: _Mode = "clay", seed: int = 0,
               all_layers: bool = False, transparent: bool = False, denoise: bool = False,
               heat: ArrayLike | None = None, extension: float = ..., flexion: float = ..., side: float = ...,
               twist: float = ..., hip: float = ..., stretch: float = ...) -> Picture: ...

class Chain:
    joints: ArrayLike
    left: ArrayLike
    curve: ArrayLike | None
    path: ArrayLike | None
    up: ArrayLike
    frames: ArrayLike | None
    frame_names: list[str]
    def __init__(self, joints: ArrayLike, *, left: ArrayLike = ..., curve: ArrayLike | None = None,
                 path: ArrayLike | None = None, up: ArrayLike = ..., frames: ArrayLike | None = None,
                 frame_names: Iterable[str] = ()) -> None: ...

class Rig:
    def __init__(self, spec: _Rig, on: Character | Chain | ArrayLike, **options: _Option) -> None: ...
    @staticmethod
    def from_file(file: _File) -> tuple[Rig, _Floats]: ...
    @property
    def name(self) -> str: ...
    @property
    def system(self) -> str: ...
    @property
    def options(self) -> dict[str, Any]: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def units(self) -> dict[str, Literal["degrees", "length", "number"]]: ...
    @property
    def rest_controls(self) -> _Floats: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def parents(self) -> list[int]: ...
    @property
    def rest_positions(self) -> _Floats:
        """J x 3, rig space. Read-only."""
    @property
    def arc_fractions(self) -> list[float]: ...
    def solve(self, controls: ArrayLike, *, measures: bool = False) -> Poses: ...
    def controls(self, *, mapping: _Mapping = "chest", extension: float = ..., flexion: float = ...,
                 side: float = ..., twist: float = ..., hip: float = ..., stretch: float = ...) -> _Floats: ...
    def intended_curve(self, controls: ArrayLike, count: int = 257) -> _Floats:
        """count x 3, hips first."""

class PythonRig:
    def __init__(self, channels: Iterable[str | tuple[str, str] | tuple[str, str, float]], joints: Iterable[str],
                 parents: Iterable[int], rest: ArrayLike, *, points: ArrayLike | None = None,
                 triangles: ArrayLike | None = None, up: Literal["Y", "Z"] = "Y", metres_per_unit: float = 1.0,
                 name: str = "", map: _File = "") -> None: ...
    def pose(self, values: _Floats) -> ArrayLike | tuple[ArrayLike, ArrayLike]: ...

def load(file: _File, *, chain: Literal["", "spine", "neck"] = "", hip: str = "", chest: str = "",
         spine: Sequence[str] = (), left_arm: Sequence[str] = (), right_arm: Sequence[str] = (),
         template: str = "", up: _Axis = "", forward: _Axis = "") -> Character: ...
def judge(character: Character | _File, rig: _Rig = "even", *, mapping: _Mapping = "chest", envelope: str = "auto",
          sweeps: _Sweeps = "standard", folder: _File | None = None, pictures: bool | None = None) -> Report: ...
def compare(a: _Rig | Character, b: _Rig | Character, *, character: Character | _File | None = None,
            rig: _Rig = "even", mapping: _Mapping = "chest", sweeps: _Sweeps = "stress", folder: _File | None = None,
            pictures: bool | None = None) -> Report: ...
def set_threads(count: int) -> None: ...

# report.json: validate/report/report.schema.json says what each name means; null is None.

class Headroom(Record):
    channel: str
    clean_to_deg: float | None
    tested_to_deg: float | None
    needs_deg: float | None
    headroom_deg: float | None
    measured: bool

class SystemHeadroom(Record):
    system: str
    headroom: list[Headroom]

class Corners(Record):
    poses: int
    clean: int
    clean_percent: float
    needed: bool
    worst: str
    code: str

class Search(Record):
    paths: int
    poses: int
    with_jumps: int
    unsure: int
    box: str

class HuntedPose(Record):
    code: str
    unit: str
    pose: str
    value: float | None
    limit: float | None
    over: bool
    sweep: str

class PoseHunt(Record):
    evaluations: int
    seed: int
    box: str
    gap: float
    worst: list[HuntedPose]
    notes: list[str]

class CertifiedVolume(Record):
    share: float
    no_jump: float
    refuted: float
    gain: float

class SearchedVolume(Record):
    poses: int
    clean: int
    at_least: float
    confidence: float

class CleanVolume(Record):
    box: str
    certified: CertifiedVolume | None
    not_certified: str
    searched: SearchedVolume

class SweepValues(Record):
    sweep: str
    channel: str
    mapping: str
    control_deg: list[float | None]
    metric: dict[str, list[float | None]]
    metric_unit: dict[str, str]
    metric_limit: dict[str, float | None]
    frame: list[str]
    pose_deg: dict[str, list[float | None]]

class Coverage(Record):
    code: str
    planned: int
    measured: int
    not_measured: int
    not_applicable: int

class RigResult(Record):
    character: str
    rig: str
    system: str
    mapping: str
    role: Literal["proposed", "reference", "canary"]
    options: dict[str, str]
    verdict: Literal["pass", "fail", "waived", "stress", "not_measured", "not_applicable"]
    headroom: list[Headroom]
    beside: list[SystemHeadroom]
    corners: Corners
    search: Search
    hunt: PoseHunt  # where the run searched
    volume: CleanVolume  # the same
    sweeps: list[SweepValues]
    coverage: list[Coverage]
    summary: dict[str, float | None]

class CharacterFacts(Record):
    name: str
    file: str
    hash: str
    meshes: int
    vertices: int
    triangles: int
    joints: int
    height: float | None
    spine_length: float | None
    spine: list[str]
    arms: Record
    sure: bool
    doubts: list[str]
    kind: str
    kind_reason: str
    envelope: str
    envelope_reason: str
    notes: list[str]

class Cure(Record):
    command: str
    gives: str

class Finding(Record):
    code: str
    character: str
    rig: str
    mapping: str
    sweep: str
    pose: str
    pose_index: int | None
    frame: int | None
    time: float | None
    control_deg: float | None
    place: Record
    value: float | None
    limit: float | None
    unit: str
    verdict: Literal["pass", "fail", "waived", "stress", "not_measured", "not_applicable"]
    owner: Literal["none", "SOLVER", "RIG", "MOTION", "WEIGHTS", "SKELETON", "POSE", "INPUT", "TOOL"]
    inside_envelope: bool
    detail: str
    geometry: dict[str, float | None]
    image: Literal["not_measured"] | Record
    pictures: Record
    reproduce: str
    cures: list[Cure]
    artist: dict[str, str]

class Canary(Record):
    rig: str
    code: str
    joint: str
    expected_deg: float | None
    tolerance_deg: float | None
    found_deg: float | None
    found: bool
    twin_clean: bool
    ok: bool
    detail: str

class Calibration(Record):
    detector: str
    code: str
    body: str
    unit: str
    threshold: float | None
    threshold_unit: str
    compared: int
    alike: int
    clean_poses: int
    false_alarms: int
    target: float | None
    smallest: float | None
    ok: bool

class ComparedPose(Record):
    sweep: str
    pose: str
    index: int
    control_deg: float | None
    code: str
    unit: str
    a: float | None
    b: float | None
    limit: float | None
    a_path: str
    b_path: str
    a_command: str
    b_command: str

class MetricComparison(Record):
    metric: str
    code: str
    unit: str
    tolerance: float | None
    a_better: int
    b_better: int
    same: int
    median_gain: float | None

class Comparison(Record):
    a: str
    b: str
    character: str
    mapping: str
    matched: float | None
    paired: int
    unpaired: int
    a_better: int
    b_better: int
    mixed: int
    same: int
    a_over: int
    b_over: int
    ahead: Literal["a", "b", ""]
    sampled: str
    metrics: list[MetricComparison]
    worst_of_a: list[ComparedPose]
    worst_of_b: list[ComparedPose]
    sweeps: list[Record]

class PicturePair(Record):
    title: str
    caption: str
    a_path: str
    a_label: str
    b_path: str
    b_label: str
    heat_path: str
    finding: int

class Media(Record):
    kind: str
    title: str
    path: str

class MeshView(Record):
    title: str
    pose_path: str
    triangles_path: str
    heat: str
    unit: str
    heat_low: float | None
    heat_high: float | None
    finding: int
    view: str
    mark: list[float | None]

class Trend(Record):
    character: str
    rig: str
    mapping: str
    metric: str
    unit: str
    more_is_worse: bool
    value: list[float | None]
    steps: list[TrendStep]

class TrendStep(Record):
    night: int
    before: float | None
    after: float | None
    worse: bool
    version: str
    last_before: str
    recovered: str

class Check(Record):
    code: str
    name: str
    measures: str
    unit: str
    limit: float | None
    sense: Literal["", "at most", "at least"]
    reason: str

class Report(Record):
    text: str
    """report.json itself."""
    schema: Literal["backbend.report/1"]
    title: str
    suite: str
    headline: str
    reasons: list[str]
    verdict: Literal["pass", "fail", "waived", "stress", "not_measured", "not_applicable"]
    exit_code: int
    provenance: dict[str, str]
    characters: list[CharacterFacts]
    rigs: list[RigResult]
    findings: list[Finding]
    canaries: list[Canary]
    detectors: list[str]
    is_comparison: bool
    calibration: list[Calibration]
    comparisons: list[Comparison]
    pairs: list[PicturePair]
    media: list[Media]
    meshes: list[MeshView]
    checks: list[Check]
    nights: list[str]
    trends: list[Trend]
    next: list[str]

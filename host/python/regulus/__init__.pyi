from os import PathLike
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

_Path = Union[str, PathLike[str]]
_Progress = Callable[[int, int], Optional[bool]]
_Setting = Union[None, bool, int, float, str, Sequence[Union[int, str]]]

class Error(RuntimeError):
    code: str  # FAILED, BAD_USAGE, BAD_FILE, NO_DEVICE, INTERRUPTED

class Camera:
    name: str
    position: List[float]  # metres, world
    direction: List[float]
    up: List[float]
    is_orthographic: bool
    vertical_fov: float  # radians
    half_height: float  # metres
    aspect_ratio: float
    lens_radius: float  # metres
    focus_distance: float  # metres
    def __init__(self) -> None: ...
    def look_at(self, position: Sequence[float], target: Sequence[float], up: Sequence[float] = ...) -> Camera: ...

class PreparedScene: ...

class Scene:
    @property
    def path(self) -> Any: ...
    @property
    def edits(self) -> List[str]: ...
    @property
    def warnings(self) -> List[str]: ...
    @property
    def settings(self) -> Dict[str, str]: ...
    @property
    def cameras(self) -> List[Camera]: ...
    def set_camera(self, index: int, camera: Camera) -> None: ...
    @property
    def bounds_min(self) -> List[float]: ...
    @property
    def bounds_max(self) -> List[float]: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def material_names(self) -> List[str]: ...
    def prepare(self) -> PreparedScene: ...

class Comparison:
    mse: float
    relmse: float
    mae: float
    psnr: float
    flip: float
    mean: List[float]
    reference_mean: List[float]
    non_finite: int

class Picture:
    def __init__(self, rgb: npt.ArrayLike) -> None: ...
    @property
    def rgb(self) -> npt.NDArray[np.float32]: ...
    @property
    def channels(self) -> Dict[str, npt.NDArray[Any]]: ...
    attributes: Dict[str, str]
    width: int
    height: int
    x: int
    y: int
    def __getitem__(self, name: str) -> npt.NDArray[Any]: ...
    def write(self, path: _Path, exposure: float = ...) -> None: ...
    def compare(self, reference: Picture) -> Comparison: ...

class Device:
    @property
    def name(self) -> str: ...

class DeviceDescription:
    name: str
    driver: str
    is_software: bool
    missing: List[str]

class Plan:
    width: int
    height: int
    samples: int
    techniques: List[str]
    merge_radius: float  # metres
    dropped: Dict[str, str]
    warnings: List[str]
    description: Dict[str, str]

class Outcome:
    is_complete: bool
    samples: int
    noise: float
    summary: str
    warnings: List[str]

class Renderer:
    def __init__(self, plan: Plan, device: Device) -> None: ...
    def checkpoint(self, path: _Path, seconds: float = ...) -> None: ...
    def resume(self, path: _Path) -> None: ...
    def render(self, progress: Optional[_Progress] = ...) -> Outcome: ...
    def picture(self) -> Picture: ...
    def write_part(self, path: _Path) -> None: ...
    def statistics(self) -> Dict[str, Any]: ...
    def statistics_json(self) -> str: ...

class CheckLine:
    name: str
    items: int
    is_passed: bool
    text: str

def load(path: _Path, *, scene: Optional[int] = ..., variant: str = ..., animation: str = ...,
         time: Optional[float] = ..., environment: _Path = ..., environment_rotation: Optional[float] = ...,
         environment_scale: Optional[float] = ..., edits: List[str] = ..., allow_external: bool = ..., is_strict: bool = ...,
         memory_bytes: int = ...) -> Scene: ...
def settings() -> Dict[str, str]: ...
def make_plan(scene: Union[Scene, PreparedScene], **settings: _Setting) -> Plan: ...
def render(scene: Union[Scene, PreparedScene], backend: str = ..., device: Union[str, Device] = ...,
           progress: Optional[_Progress] = ..., **settings: _Setting) -> Picture: ...
def list_devices() -> List[DeviceDescription]: ...
def open_device(select: str = ..., memory_bytes: int = ...) -> Device: ...
def reference_device() -> Device: ...
def read_picture(path: _Path) -> Picture: ...
def merge_parts(parts: Sequence[_Path], output: _Path) -> None: ...
def check(scene: Union[Scene, PreparedScene], device: Union[str, Device] = ..., **settings: _Setting) -> List[CheckLine]: ...
def trace_path(scene: Union[Scene, PreparedScene], x: int, y: int, sample: int = ..., device: Union[str, Device] = ...,
               **settings: _Setting) -> Dict[str, Any]: ...

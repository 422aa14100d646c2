"""Drawing one frame of a 3D scene with pyvista, off the screen: no display is needed.

VTK draws through EGL, in software where there is no graphics card (Debian: libegl1, which brings
Mesa), or through OSMesa.
"""

from __future__ import annotations

import ctypes
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem.cloud import unique_faces
from peridem.render_style import DARK, WALL, Style
from peridem.results_output import Output

Array = NDArray[np.float64]

LIBRARIES = ("libEGL.so.1", "libOSMesa.so.8", "libOSMesa.so.6")


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from.

    Attributes:
        azimuth: degrees about z, from the x axis.
        elevation: degrees above the x-y plane.
        up: direction that is up in the picture.
        cut: (point, normal) of a plane; what lies on the side of its normal is not drawn.
    """

    azimuth: float = -60.0
    elevation: float = 20.0
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    cut: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None


def surface(
    output: Output, i: int, camera: Camera | None = None
) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
    """Positions, (n, 3), the triangles around the intact cells, (t, 3), and the nodes in none.

    Cells and nodes that the camera's plane cuts off are left out.
    """
    x = output.frame(i).position[:, :3]
    cells = output.intact_cells(i)
    loose = np.setdiff1d(np.arange(len(x)), cells)
    if camera is not None and camera.cut is not None:
        point, normal = np.array(camera.cut[0]), np.array(camera.cut[1])
        cells = cells[(x[cells].mean(axis=1) - point) @ normal <= 0.0]
        loose = loose[(x[loose] - point) @ normal <= 0.0]
    if len(cells) == 0:
        return x, np.zeros((0, 3), dtype=np.int64), loose
    faces, count = unique_faces(cells, 3)
    return x, faces[count == 1], loose


def image(
    output: Output,
    i: int,
    style: Style,
    bounds: tuple[Array, Array],
    size: tuple[int, int] = (900, 900),
    camera: Camera | None = None,
) -> NDArray[np.uint8]:
    """A picture of frame i: (rows, columns, 3).

    Raises:
        RuntimeError: there is no library to draw with.
    """
    pv = _pyvista()
    camera = camera or Camera()
    x, triangles, loose = surface(output, i, camera)
    shade = style.shade(output.field(style.field, i))
    plotter = pv.Plotter(off_screen=True, window_size=size, lighting="light kit")
    try:
        plotter.set_background("white")
        look = {"clim": (0.0, 1.0), "cmap": style.map(), "show_scalar_bar": False, "ambient": 0.2}
        if len(triangles):
            grains = _mesh(pv, x, triangles, shade, output.frame(i)["mol"], style.is_name)
            plotter.add_mesh(grains, scalars="shade", **look)
        if len(loose):
            dots = pv.PolyData(x[loose])
            dots["shade"] = shade[loose]
            scale = output.contact_radius
            ball = pv.Sphere(radius=0.5, theta_resolution=8, phi_resolution=8)
            balls = dots.glyph(scale=False, orient=False, factor=scale, geom=ball)
            plotter.add_mesh(balls, scalars="shade", **look)
        low, high = bounds
        box = pv.Box(np.column_stack([low, high]).ravel())
        plotter.add_mesh(box, style="wireframe", color=WALL, line_width=1.0)
        _moving_walls(pv, plotter, output, i, bounds)
        _aim(plotter, bounds, camera)
        shot: NDArray[np.uint8] = np.asarray(plotter.screenshot(return_img=True))
        return shot[..., :3]
    finally:
        plotter.close()


def bounds_of(output: Output, frames: list[int]) -> tuple[Array, Array]:
    """Low and high corner of everything in some frames, plane walls included."""
    points = []
    for i in frames:
        points.append(output.frame(i).position[:, :3])
        points += [wall.point[None] for wall in output.walls(output.time(i))]
    everything = np.vstack(points)
    return everything.min(axis=0), everything.max(axis=0)


def _mesh(
    pv: Any, x: Array, triangles: NDArray[np.int64], shade: Array, grain: Array, names: bool
) -> Any:
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    mesh = pv.PolyData(x, faces)
    if names:
        mesh.cell_data["shade"] = shade[triangles[:, 0]]
    else:
        mesh.point_data["shade"] = shade
    mesh = mesh.compute_normals(
        auto_orient_normals=True, consistent_normals=True, split_vertices=not names
    )
    return mesh


def _moving_walls(
    pv: Any, plotter: Any, output: Output, i: int, bounds: tuple[Array, Array]
) -> None:
    size = float(np.linalg.norm(bounds[1] - bounds[0]))
    box = [value for pair in zip(*bounds, strict=True) for value in pair]
    for wall in output.walls(output.time(i)):
        if wall.velocity.any():
            middle = 0.5 * (bounds[0] + bounds[1])
            middle = middle - ((middle - wall.point) @ wall.normal) * wall.normal
            plane = pv.Plane(
                center=middle,
                direction=wall.normal,
                i_size=2.0 * size,
                j_size=2.0 * size,
                i_resolution=1,
                j_resolution=1,
            )
            slice_ = plane.triangulate().clip_box(box, invert=False)
            if slice_.n_points:
                plotter.add_mesh(slice_, color=DARK, opacity=0.25)


def _aim(plotter: Any, bounds: tuple[Array, Array], camera: Camera) -> None:
    low, high = bounds
    a, e = np.radians([camera.azimuth, camera.elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    middle = 0.5 * (low + high)
    plotter.camera.focal_point = middle
    plotter.camera.position = middle + towards * 2.1 * np.linalg.norm(high - low)
    plotter.camera.up = camera.up
    plotter.camera.view_angle = 28.0
    plotter.reset_camera_clipping_range()


def _pyvista() -> Any:
    """pyvista, set to draw without a display."""
    if not os.environ.get("DISPLAY"):
        for number, name in enumerate(LIBRARIES):
            try:
                ctypes.CDLL(name)
            except OSError:
                continue
            window = "vtkEGLRenderWindow" if number == 0 else "vtkOSOpenGLRenderWindow"
            os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", window)
            break
        else:
            raise RuntimeError(
                "3D pictures without a display need one of the libraries "
                f"{', '.join(LIBRARIES)}: install libegl1 (Debian, Ubuntu), or write a .pvd file "
                "and open it in ParaView"
            )
    import pyvista

    return pyvista

"""Small PeriDEM decks, written by the tests that read them."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import yaml
from peridem import cloud, shapes

SPACING = 2.5e-4
SOLID = {
    "Type": "PDState",
    "Horizon": 6.0e-4,
    "Density": 1200.0,
    "Compute_From_Classical": True,
    "K": 2.16e7,
    "G": 1.296e7,
    "Gc": 50.0,
    "Influence_Function": {"Type": 1},
}
TOUCH = {
    "Contact_Radius_Factor": 0.95,
    "Damping_On": False,
    "Friction_On": False,
    "Kn": 1.59e24,
    "Epsilon": 0.9,
    "Friction_Coeff": 0.5,
    "Kn_Factor": 1.0,
    "Beta_n_Factor": 100.0,
}
TABLE = "i, x, y, z, r, o\n0, 0.0, 0.0015, 0.0, 0.001, 0.3\n1, 0.0, 0.0038, 0.0, 0.0011, 1.2\n"

# two discs in two zones above a floor and between two side walls, all one mesh
COLLISION = {
    "Model": {
        "Dimension": 2,
        "Discretization_Type": {"Spatial": "finite_difference", "Time": "central_difference"},
        "Final_Time": 1.0e-5,
        "Time_Steps": 100,
    },
    "Container": {"Geometry": {"Type": "rectangle", "Parameters": [-2e-3, 0, 0, 2e-3, 6e-3, 0]}},
    "Zone": {"Zones": 3, "Zone_1": {"Is_Wall": False}, "Zone_3": {"Is_Wall": True}},
    "Particle": {
        "Test_Name": "collision",
        "Zone_1": {"Type": "circle", "Parameters": [1e-3, 0, 0, 0]},
        "Zone_2": {"Type": "circle", "Parameters": [1e-3]},
        "Zone_3": {
            "Is_Wall": True,
            "Type": "rectangle_minus_rectangle",
            "Parameters": [-2.3e-3, -3e-4, 0, 2.3e-3, 6e-3, 0, -2e-3, 0, 0, 2e-3, 6e-3, 0],
            "All_Dofs_Constrained": True,
            "Create_Particle_Using_ParticleZone_GeomObject": True,
        },
    },
    "Particle_Generation": {"From_File": "table.csv", "File_Data_Type": "loc_rad_orient"},
    "Mesh": {
        "Zone_1": {"File": "disc.msh"},
        "Zone_2": {"File": "disc.msh"},
        "Zone_3": {"File": "box.msh"},
    },
    "Contact": {
        "Zone_11": TOUCH,
        "Zone_12": {**TOUCH, "Friction_On": True, "Damping_On": True, "Kn_Factor": 0.5},
        "Zone_13": {"Copy_Contact_Data": [1, 1]},
        "Zone_22": {"Copy_Contact_Data": [1, 1]},
        "Zone_23": {"Copy_Contact_Data": [1, 1]},
        "Zone_33": {"Copy_Contact_Data": [1, 1]},
    },
    "Neighbor": {"Update_Criteria": "simple_all", "Search_Factor": 10.0, "Search_Interval": 40},
    "Material": {
        "Zone_1": SOLID,
        "Zone_2": {**SOLID, "Density": 2400.0},
        "Zone_3": {"Copy_Material_Data": 1},
    },
    "Force_BC": {"Gravity": [0.0, -10.0, 0.0]},
    "IC": {"Constant_Velocity": {"Velocity_Vector": [0.0, -0.5, 0.0], "Particle_List": [1]}},
    "Displacement_BC": {
        "Sets": 1,
        "Set_1": {"Particle_List": [2], "Direction": [1, 2], "Zero_Displacement": True},
    },
    "Output": {
        "Path": "../out/",
        "Tags": ["Displacement", "Velocity", "Force", "Damage", "Boundary_Node_Flag", "Fixity"],
        "Output_Interval": 10,
        "Test_Output_Interval": 5,
    },
}

# one square of 5 x 5 cells, its lower side held and its upper side driven
SQUARE = {
    "Model": {
        "Dimension": 2,
        "Final_Time": 2.0e-5,
        "Time_Steps": 100,
        "Particle_Sim_Type": "Single_Particle",
    },
    "Particle": {"Zone_1": {"Type": "rectangle", "Parameters": [0, 0, 0, 1e-3, 1e-3, 0]}},
    "Mesh": {"Zone_1": {"CreateMesh": {"Flag": True, "Info": "uniform"}, "Mesh_Size": 1.9e-4}},
    "Material": {"Zone_1": SOLID},
    "Displacement_BC": {
        "Sets": 1,
        "Set_1": {
            "Region": {"Geometry": {"Type": "rectangle", "Parameters": [0, 0, 0, 1e-3, 1e-5, 0]}},
            "Direction": [1, 2],
            "Zero_Displacement": True,
        },
    },
    "Output": {"Output_Interval": 10},
}


def changed(deck: dict, changes: dict) -> dict:
    """A deck with some keys set: ``Material.Zone_1.Gc`` to a value, or None to leave it out."""
    made = copy.deepcopy(deck)
    for key, value in changes.items():
        *path, last = key.split(".")
        block = made
        for part in path:
            block = block.setdefault(part, {})
        if value is None:
            block.pop(last, None)
        else:
            block[last] = copy.deepcopy(value)
    return made


def without_none(data: object) -> object:
    """The same without keys whose value is None."""
    if isinstance(data, dict):
        return {key: without_none(value) for key, value in data.items() if value is not None}
    return data


def write(folder: Path, deck: dict, table: str = TABLE, **changes: object) -> Path:
    """A deck with its meshes and table in a folder; keys of changes have __ for dots."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "input.yaml"
    made = changed(deck, {key.replace("__", "."): value for key, value in changes.items()})
    path.write_text(yaml.safe_dump(without_none(made), sort_keys=False))
    (folder / "table.csv").write_text(table)
    if not (folder / "disc.msh").is_file():
        cloud.mesh(shapes.circle(1e-3), SPACING).write(folder / "disc.msh")
        box_mesh().write(folder / "box.msh")
    return path


def box_mesh() -> cloud.Cloud:
    """A box open at the top, 0.3 mm thick, of squares cut into triangles."""
    h = 1e-4
    x = np.round(np.arange(-23, 24) * h, 12)
    y = np.round(np.arange(-3, 61) * h, 12)
    nodes = np.column_stack([g.ravel() for g in np.meshgrid(x, y, indexing="ij")])
    i, j = (g.ravel() for g in np.meshgrid(np.arange(46), np.arange(63), indexing="ij"))
    keep = (i < 3) | (i >= 43) | (j < 3)
    a = (i * 64 + j)[keep]
    cells = np.vstack([np.column_stack([a, a + 64, a + 65]), np.column_stack([a, a + 65, a + 1])])
    used, cells = np.unique(cells, return_inverse=True)
    return cloud.from_cells(nodes[used], cells.reshape(-1, 3), "box")

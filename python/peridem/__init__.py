"""Scenes of breakable grains for LAMMPS with the PERIDEM package.

The modules, in the order in which a scene uses them: :mod:`~peridem.shapes` (outlines),
:mod:`~peridem.cloud` (meshes and nodes), :mod:`~peridem.packing` (where the grains go),
:mod:`~peridem.material`, :mod:`~peridem.scene` (data file and input script), :mod:`~peridem.run`,
:mod:`~peridem.results` and :mod:`~peridem.render`.
"""

__version__ = "0.1.0"

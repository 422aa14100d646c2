"""Shared code of the tests: an independent numpy model and helpers that run LAMMPS."""

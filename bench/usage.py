"""Runs a program from a process that is small itself: ``python -I -S usage.py FILE PROGRAM ...``.

Linux counts as a program's own the memory of the process that started it, up to the moment of its
start; a Python with numpy and gmsh in it would hide what a small LAMMPS takes.  Writes bytes of the
largest resident size and seconds of processor time of the program and its children to FILE.
"""

import os
import resource
import sys

if __name__ == "__main__":
    status = os.spawnvp(os.P_WAIT, sys.argv[2], sys.argv[2:])
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(sys.argv[1], "w") as file:
        file.write(f"{used.ru_maxrss * 1024} {used.ru_utime + used.ru_stime}\n")
    sys.exit(status if status >= 0 else 1)

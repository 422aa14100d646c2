"""Latency and bandwidth between two ranks; ``ranks.py`` runs it under ``mpirun -np 2``."""

from __future__ import annotations

import time

import numpy as np
from mpi4py import MPI


def seconds(size: int, rounds: int) -> float:
    """Seconds of one message of so many bytes, the best of five."""
    world = MPI.COMM_WORLD
    buffer = np.zeros(size, dtype=np.uint8)
    best = float("inf")
    for _ in range(5):
        world.Barrier()
        start = time.perf_counter()
        for _ in range(rounds):
            if world.rank == 0:
                world.Send(buffer, 1)
                world.Recv(buffer, 1)
            else:
                world.Recv(buffer, 0)
                world.Send(buffer, 0)
        best = min(best, (time.perf_counter() - start) / (2 * rounds))
    return best


if __name__ == "__main__":
    short, long = seconds(8, 2000), seconds(4_000_000, 20)
    if MPI.COMM_WORLD.rank == 0:
        print(short, 4_000_000 / (long - short))

/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Things that several ranks own parts of (grains across the borders of ranks): numbers are summed
// over these ranks, which talk to each other and to nobody else, however many ranks there are.

#ifndef LMP_PERIDEM_SHARING_H
#define LMP_PERIDEM_SHARING_H

#include "peridem_messages.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemSharing : protected Pointers {
 public:
  explicit PeridemSharing(class LAMMPS *lmp) : Pointers(lmp) {}

  // ids > 0, ascending, of the things that this rank has a part of; collective
  void find(const std::vector<bigint> &ids);

  // positions in ids of those that other ranks have parts of too
  const std::vector<int> &shared() const { return places; }

  // data: so many numbers of each shared thing, that become their sums over the ranks, the same
  // to the last digit on all of them; all ranks call it, in the same order
  void sum(std::vector<double> &data, int width);

  // of each shared thing a list, that goes to the others with a part of it; returns what they have
  // sent here, in the order of the ranks; all ranks call it
  template <class T> std::vector<T> swap(const std::vector<std::vector<T>> &lists) const
  {
    std::vector<std::vector<T>> outgoing(nprocs());
    for (const auto &peer : peers)
      for (const int n : peer.things)
        outgoing[peer.rank].insert(outgoing[peer.rank].end(), lists[n].begin(), lists[n].end());
    return PeridemMessages::exchange(world, outgoing);
  }

  double memory_usage() const;

 private:
  struct Peer {
    int rank;
    std::vector<int> things;    // that it has a part of: positions in places
    std::vector<double> ours, theirs;
  };
  std::vector<int> places;
  std::vector<Peer> peers;    // by rank, ascending
  std::vector<double> own;
  std::vector<MPI_Request> requests;

  struct Part {
    bigint id;
    int rank;    // that has a part of it
  };
  int nprocs() const;
  std::vector<Part> find_parts(const std::vector<bigint> &ids) const;
  void swap_parts(const std::vector<double> &data, int width);
};

}    // namespace LAMMPS_NS

#endif

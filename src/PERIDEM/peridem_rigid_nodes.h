/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The nodes of rigid grains that this rank owns, in one piece of memory per grain: where they are in
// the axes of the body, and the loops that every step needs.

#ifndef LMP_PERIDEM_RIGID_NODES_H
#define LMP_PERIDEM_RIGID_NODES_H

#include "peridem_adapt_table.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemRigidNodes : protected Pointers {
 public:
  // of one grain, over all its nodes
  struct Sums {
    double force[3];
    double moment[9];    // sum f (x) d, d in the axes of the body
    double sizes;        // of the forces; 0 unless asked for
  };

  std::vector<tagint> grains;     // rigid ones
  std::vector<Sums> sums;         // of each of them
  std::vector<double> highest;    // of each, largest squared force that bends it over h^(2 (d - 1))

  PeridemRigidNodes(class LAMMPS *, PeridemAdaptTable &);

  void collect();                      // after a grain has changed its state, or nodes their places
  void place();                        // nodes where the bodies are, with their velocities
  void set_velocities(bool asleep);    // theirs alone; of sleeping grains too?
  void sum_forces(bool with_sizes);    // and torques, into the bodies; collective
  // the same, and the second half of a step of velocities
  void finish_step(bool with_sizes, double dtf);
  // sum f (x) r in space, of the k-th
  void moment(std::size_t k, double *moment) const;
  double memory_usage() const;

 private:
  struct Piece {
    int slot;    // of the grain in the list
    int first, last;
    int axes[3];     // of the body, that its nodes need: in 2d the two in the plane come first
    double unit;     // h^(-2 (d - 1)) of its first node
    bool shifted;    // some node of it is at a periodic image
    bool whole;      // no other rank has nodes of the grain
  };

  // what is read at every step lies close together: the loops wait for memory
  PeridemAdaptTable &table;
  const int dimension;
  std::vector<Piece> pieces;
  std::vector<int> index;        // of nodes, piece by piece
  std::vector<double> offset;    // dimension numbers each, in the axes of the piece
  // for estimates only: mass, and h^(-2 (d - 1)) over that of the first node of the piece
  std::vector<float> mass, per_area;
  std::vector<double> shifts;    // three each, in shifted pieces: to the images LAMMPS has

  Piece new_piece(int slot, int first) const;
  void find_shifts();
  bool moves(const Piece &) const;
  void sum_up(bool with_sizes, double dtf);
  template <int D> void set_nodes(const Piece &, const PeridemRigidBody &, bool move);
  template <int D> void sum_nodes(const Piece &, bool with_sizes);
  void set_velocities(const Piece &, const PeridemRigidBody &);
  void set_forces(PeridemRigidBody &, const Sums &) const;
};

}    // namespace LAMMPS_NS

#endif

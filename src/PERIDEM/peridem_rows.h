/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The bonds of every node, in both directions, in one compressed pool without padding: those of node
// i are start[i] <= k < start[i] + num[i].  A broken bond is taken out of its row and leaves a gap,
// and so do nodes that leave; the pool is put in order when that is worth while.  Rows are sorted
// by the partner's ID, so that sums do not depend on how nodes are spread over processors.
//
// Bonds are most of what a run holds in memory, so of each there is only what does not follow from
// anything else: the ID of the partner and the length.

#ifndef LMP_PERIDEM_ROWS_H
#define LMP_PERIDEM_ROWS_H

#include "lmptype.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemRows {
 public:
  // ---- the pool

  std::vector<tagint> ptag;      // ID of the other node
  std::vector<double> length;    // reference length R

  // what follows from these, for solids that read rows in every step; else, and while nodes migrate,
  // there is none
  std::vector<int> partners;      // local index of the other node
  std::vector<double> weights;    // w v_ij V_i V_j

  // ---- per node

  bigint *start{nullptr};
  int *num{nullptr};              // bonds still intact; -1 = no family yet
  int *nref{nullptr};             // bonds in the reference configuration
  double *wvolume{nullptr};       // weighted volume m_i of the reference configuration
  double *famvolume{nullptr};     // sum of v_ij V_j over the reference family
  double *maxstretch{nullptr};    // largest stretch so far, as a fraction of the critical one
  tagint *known_id{nullptr};      // the ID by which bonds know the node; 0 = none yet

  bool bonded(int i, tagint jtag) const;

  // take bond k out of the row of node i; the rest keeps its order
  void erase_bond(int i, bigint k);

 protected:
  // numbers that a node packs into, and those of each of its bonds
  static constexpr int NODE = 6, BOND = 2;

  explicit PeridemRows(class Memory *_storage) : storage(_storage) {}
  ~PeridemRows();
  PeridemRows(const PeridemRows &) = delete;
  PeridemRows &operator=(const PeridemRows &) = delete;

  void grow_rows(int nmax);
  void empty_row(int i);
  void copy_row(int i, int j);
  int pack_row(int i, double *buf) const;
  int unpack_row(int i, const double *buf);
  void append(tagint tag, double R);
  void reserve_pool(std::size_t more);

  // partners and weights
  void make_room_for_stored();
  void drop_stored();

  int longest_row(int nlocal) const;
  // rows as the nodes stand, if too many are not, or if there are too many gaps
  void order_pool(int nlocal);
  double pool_bytes(int nmax) const;

 private:
  class Memory *storage;

  template <class T> void copy_rows(std::vector<T> &, int nlocal, bigint total) const;
};

}    // namespace LAMMPS_NS

#endif

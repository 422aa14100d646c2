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

#ifndef LMP_PERIDEM_ROWS_H
#define LMP_PERIDEM_ROWS_H

#include "lmptype.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemRows {
 public:
  // ---- the pool; local indices are those of the last reneighbouring

  std::vector<int> partner;      // local index of the other node
  std::vector<double> length;    // reference length R
  std::vector<double> weight;    // w v_ij V_i V_j, the same from both ends
  std::vector<tagint> ptag;      // ID of the other node

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
  // numbers that a node packs into, and those of each of its bonds, with and without its weight
  static constexpr int NODE = 6, BOND = 3, BOND_WITHOUT = 2;

  explicit PeridemRows(class Memory *_storage) : storage(_storage) {}
  ~PeridemRows();
  PeridemRows(const PeridemRows &) = delete;
  PeridemRows &operator=(const PeridemRows &) = delete;

  void grow_rows(int nmax);
  void empty_row(int i);
  void copy_row(int i, int j);
  int pack_row(int i, double *buf, bool with_weights) const;
  int unpack_row(int i, const double *buf, bool with_weights);    // weights are 0 if there are none
  void append(tagint tag, double R, double w);

  // tags and lengths of that many bonds may be appended before fill_pool(), and then have no weights
  void reserve_pool(std::size_t more);
  void fill_pool();
  int longest_row(int nlocal) const;
  // rows as the nodes stand, if too many are not, or if there are too many gaps; did rows move?
  bool order_pool(int nlocal);
  double pool_bytes(int nmax) const;

 private:
  class Memory *storage;

  template <class T> void copy_rows(std::vector<T> &, int nlocal, bigint total) const;
};

}    // namespace LAMMPS_NS

#endif

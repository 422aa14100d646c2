/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The grains of fix peridem/adapt, by molecule-ID, and which nodes of each this rank owns.  All
// ranks hold the table and see the same sums, so they decide alike.

#ifndef LMP_PERIDEM_ADAPT_TABLE_H
#define LMP_PERIDEM_ADAPT_TABLE_H

#include "peridem_adapt_grain.h"
#include "peridem_adapt_options.h"

#include "atom.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;
class PairPeridem;

class PeridemAdaptTable : protected Pointers {
 public:
  using Grain = PeridemAdaptGrain;

  struct Nodes {    // for loops: of one grain, by local index
    const int *first, *last;
    const int *begin() const { return first; }
    const int *end() const { return last; }
  };

  std::vector<Grain> grains;
  double **offset{nullptr};    // of nodes of rigid grains, in the body's axes

  PeridemAdaptTable(class LAMMPS *, int group, const PeridemAdaptOptions &);
  ~PeridemAdaptTable() override;

  void find_styles();    // bonds and solids, at the start of a run
  void check_whole();    // no grain with nodes in the group and nodes that are not; collective
  void survey();         // adds grains that are not in the table yet; collective
  void set_limits(Grain &) const;
  tagint highest_molecule() const;    // of nodes of the group; collective
  void sort_nodes();                  // after nodes have come, gone or changed places

  tagint highest() const { return static_cast<tagint>(grains.size()) - 1; }
  Nodes nodes(tagint mol) const
  {
    return {sorted.data() + first[mol], sorted.data() + first[mol + 1]};
  }
  // of the group, but of no grain
  Nodes loose() const { return {sorted.data(), sorted.data() + first[1]}; }
  // is the node part of a rigid grain? i may be a ghost
  bool rigid(int i) const
  {
    const tagint mol = atom->molecule[i];
    return (atom->mask[i] & groupbit) && mol && mol < static_cast<tagint>(grains.size()) &&
        grains[mol].rigid();
  }
  bool in_group(int i) const { return atom->mask[i] & groupbit; }
  std::vector<tagint> listed(int state) const;
  bool any(int state) const;

  // position of owned node i from a point, without periodic images
  void place_from(int i, const double *point, double *r) const;
  // sums over the nodes of some grains, about the centres that the table has; collective
  std::vector<PeridemMoments> moments(const std::vector<tagint> &which) const;
  std::vector<double> strain_energies(const std::vector<tagint> &which) const;
  double largest_stretch(tagint) const;    // of bonds of owned nodes; infinite if one is broken
  bool bonded(int i) const;

 private:
  const int igroup, groupbit;
  const PeridemAdaptOptions &options;
  std::vector<int> first, sorted;    // nodes by grain; before them those of the group without one
  FixPeridemBonds *bonds{nullptr};
  std::vector<PairPeridem *> solids;

  struct Sums;
  struct Weakest;
  void add_node(int i, Sums &) const;
  void weaken(int i, Weakest &) const;
  Grain new_grain(const Sums &, const Weakest &) const;
};

}    // namespace LAMMPS_NS

#endif

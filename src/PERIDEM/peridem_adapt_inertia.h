/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What springs of contacts have to move, for the time step: nodes, rigid grains, or bodies that move
// as they are told.

#ifndef LMP_PERIDEM_ADAPT_INERTIA_H
#define LMP_PERIDEM_ADAPT_INERTIA_H

#include "peridem_adapt_table.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemAdaptInertia : protected Pointers {
 public:
  PeridemAdaptInertia(class LAMMPS *, const PeridemAdaptTable &);

  void find_prescribed();    // at the start of a run
  void find_lightest();      // after a switch; collective

  void clear_springs() { springs.assign(table.grains.size(), 0.0); }
  // a spring that pushes node i at this step
  void note_spring(int i, double k)
  {
    if (table.rigid(i)) springs[atom->molecule[i]] += k;
  }

  // does a spring at node i, which may be a ghost, push that node alone?
  bool moves_alone(int i) const { return !table.rigid(i) && !prescribed(i); }
  // the lightest that a contact can push of a type: a node, or a rigid grain as it is felt at its
  // farthest node; infinite where all are prescribed
  double lightest(int itype) const { return lightest_of.at(itype); }
  // bound from the springs that push rigid grains; collective
  double largest_frequency_sq() const;

 private:
  const PeridemAdaptTable &table;
  std::vector<double> lightest_of;    // by type
  std::vector<double> springs;        // by molecule-ID, of this step on this rank
  int free_bits{0}, held_bits{0};     // groups whose motion forces change; groups where they do not

  // nothing that pushes it changes its motion
  bool prescribed(int i) const
  {
    const int mask = atom->mask[i];
    return !(mask & free_bits) || (mask & held_bits);
  }
  double felt_mass(int i) const;
  bool holds(const class Fix *) const;
};

}    // namespace LAMMPS_NS

#endif

/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What the command delete_atoms, which asks no fix, leaves to the bonds: nodes that are gone, and
// IDs that are not those by which bonds and the memory of contacts know the others.

#ifndef LMP_PERIDEM_DELETED_H
#define LMP_PERIDEM_DELETED_H

#include "pointers.h"

#include <set>

namespace LAMMPS_NS {

class PeridemRows;

class PeridemDeleted : protected Pointers {
 public:
  explicit PeridemDeleted(class LAMMPS *lmp) : Pointers(lmp) {}

  // both are collective
  void give_ids_back(const PeridemRows &);
  void drop_bonds(PeridemRows &);

 private:
  std::set<tagint> missing_partners(const PeridemRows &) const;
};

}    // namespace LAMMPS_NS

#endif

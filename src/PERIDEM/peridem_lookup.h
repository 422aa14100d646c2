/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Local indices by ID, as Atom::map() finds them, without the virtual call for each: for loops over
// all bonds.  Good until LAMMPS makes its map anew.

#ifndef LMP_PERIDEM_LOOKUP_H
#define LMP_PERIDEM_LOOKUP_H

#include "atom.h"

namespace LAMMPS_NS {

class PeridemLookup {
 public:
  explicit PeridemLookup(Atom *_atom) :
      atom(_atom), table(_atom->map_style == Atom::MAP_ARRAY ? _atom->get_map_array() : nullptr)
  {
  }

  // an owned node if there is one, else a ghost; -1 if there is neither
  int operator()(tagint id) const { return table ? table[id] : atom->map(id); }

 private:
  Atom *atom;
  const int *table;
};

}    // namespace LAMMPS_NS

#endif

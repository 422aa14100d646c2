/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What families were built from.  They and their weighted volumes belong to the horizon, influence
// function and volume scheme they were made with, so none of these may change while they live.

#ifndef LMP_PERIDEM_FAMILY_LAWS_H
#define LMP_PERIDEM_FAMILY_LAWS_H

#include "peridem_influence.h"
#include "pointers.h"

#include <functional>
#include <vector>

namespace LAMMPS_NS {

class Fix;
struct PeridemMaterial;

class PeridemFamilyLaws : protected Pointers {
 public:
  explicit PeridemFamilyLaws(class LAMMPS *lmp) : Pointers(lmp) {}

  // the material of bonds between two types, null where there are none
  using MaterialOf = std::function<const PeridemMaterial *(int, int)>;

  void note(int ntypes, const MaterialOf &);

  // an error of this fix if they are others by now
  void check(const Fix &, int ntypes, const MaterialOf &) const;

  // for restart files
  void pack(std::vector<double> &) const;
  void unpack(const double *);

 private:
  struct Law {
    double horizon, cell;    // horizon 0: this pair had no material
    PeridemInfluence influence;
    int volume;
  };
  std::vector<Law> laws;    // by type pair; none before there are families
};

}    // namespace LAMMPS_NS

#endif

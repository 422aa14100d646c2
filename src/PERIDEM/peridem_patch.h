/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The patch of a node: itself and the nodes that intact bonds tie to it.  What makes a collision of
// deformable grains lose energy acts between patches, because the two nodes that touch hardly move
// against each other: a stiff contact follows the bulk behind it.

#ifndef LMP_PERIDEM_PATCH_H
#define LMP_PERIDEM_PATCH_H

#include "atom.h"
#include "fix_peridem_bonds.h"

namespace LAMMPS_NS {

struct PeridemPatch {
  double offset[3];      // of the centre of mass from the node
  double velocity[3];    // of the centre of mass
  double mass;

  static constexpr int SIZE = 7;    // as doubles, for communication

  // patch of an owned node; bonds may be null
  static PeridemPatch of(const Atom *atom, const FixPeridemBonds *bonds, int i)
  {
    PeridemPatch patch{};
    auto add = [&](int j) {
      const double m = atom->rmass[j];
      patch.mass += m;
      for (int k = 0; k < 3; k++) {
        patch.offset[k] += m * (atom->x[j][k] - atom->x[i][k]);
        patch.velocity[k] += m * atom->v[j][k];
      }
    };
    for_each(bonds, i, add);
    for (int k = 0; k < 3; k++) {
      patch.offset[k] /= patch.mass;
      patch.velocity[k] /= patch.mass;
    }
    return patch;
  }

  // spread a force over the patch of node i, by mass: it acts at the centre of mass
  // f: three numbers for each owned and ghost node
  void push(const Atom *atom, const FixPeridemBonds *bonds, int i, const double *force,
            double *f) const
  {
    for_each(bonds, i, [&](int j) {
      const double share = atom->rmass[j] / mass;
      for (int k = 0; k < 3; k++) f[3 * j + k] += share * force[k];
    });
  }

 private:
  template <class Visit> static void for_each(const FixPeridemBonds *bonds, int i, Visit visit)
  {
    visit(i);
    if (!bonds) return;
    for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
      visit(bonds->partner[k]);
  }
};

}    // namespace LAMMPS_NS

#endif

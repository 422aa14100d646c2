/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Contributing author: the PERIDEM developers
------------------------------------------------------------------------- */

#include "peridem_lookup.h"

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   owned nodes come first, so that none of their ghosts takes their place
------------------------------------------------------------------------- */

void PeridemLookup::fill(Atom *atom)
{
  const int nall = atom->nlocal + atom->nghost;
  std::size_t blocks = 2;
  for (shift = 63; blocks * SIDE_BY_SIDE < 2 * static_cast<std::size_t>(nall); shift--) blocks *= 2;
  entries.assign(blocks * SIDE_BY_SIDE, Entry());
  for (int i = 0; i < nall; i++) {
    auto &entry = entries[place(atom->tag[i])];
    if (entry.i < 0) entry = {atom->tag[i], i};
  }
}

/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What differs between the LAMMPS versions that the package compiles with.

#ifndef LMP_PERIDEM_COMPAT_H
#define LMP_PERIDEM_COMPAT_H

#include "domain.h"
#include "error.h"

namespace LAMMPS_NS {
namespace PeridemCompat {

  // Domain::minimum_image() takes file and line of the caller in LAMMPS after 4Feb2025

  template <class D>
  auto minimum_image(D *domain, double *d,
                     int) -> decltype(domain->minimum_image(FLERR, d[0], d[1], d[2]))
  {
    domain->minimum_image(FLERR, d[0], d[1], d[2]);
  }

  template <class D>
  auto minimum_image(D *domain, double *d,
                     long) -> decltype(domain->minimum_image(d[0], d[1], d[2]))
  {
    domain->minimum_image(d[0], d[1], d[2]);
  }

  inline void minimum_image(Domain *domain, double *d)
  {
    minimum_image(domain, d, 0);
  }

}    // namespace PeridemCompat
}    // namespace LAMMPS_NS

#endif

/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// How much the forces on a grain could stretch its bonds, without computing bonds.
//
// Two parts, both of the forces f' = f - m a that bend the grain (a: its rigid acceleration):
//  - the average stress of the grain, sum f' (x) r / V (Love 1927, Weber 1966), over Young's modulus;
//  - near the node that is loaded most, |f'| / (E h^(d-1)) with h = V_node^(1/d).
// FACTOR times their sum bounds the largest stretch of grains of several shapes under random loads,
// found by solving for their elastic equilibrium (bench/load_measure.py); typical tensile stretches
// are a tenth to a third of it.  Where bonds break in compression too the factor is larger.

#ifndef LMP_PERIDEM_LOAD_H
#define LMP_PERIDEM_LOAD_H

namespace LAMMPS_NS {

struct PeridemLoad {
  static constexpr double FACTOR_TENSION = 1.7, FACTOR_BOTH = 3.5;

  double moment[9];    // sum f (x) r over the nodes of the grain
  double node;         // largest |f'| / h^(d-1)

  // largest principal value of the symmetric part of moment / volume, in size
  double average_stress(double volume) const;
  // no less than that, and cheap
  double stress_at_most(double volume) const;
  double stretch(double volume, double young, double factor) const
  {
    return factor * (average_stress(volume) + node) / young;
  }
  double stretch_at_most(double volume, double young, double factor) const
  {
    return factor * (stress_at_most(volume) + node) / young;
  }
};

}    // namespace LAMMPS_NS

#endif

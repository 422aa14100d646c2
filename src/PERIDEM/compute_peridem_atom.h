/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(peridem/atom,ComputePeridemAtom);
// clang-format on
#else

#ifndef LMP_COMPUTE_PERIDEM_ATOM_H
#define LMP_COMPUTE_PERIDEM_ATOM_H

#include "compute.h"

#include <array>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;
class PairPeridem;

// State of the bonds of each node: damage, stretch, dilatation, energy, number of bonds, surface,
// fragment, Cauchy stress.

class ComputePeridemAtom : public Compute {
 public:
  ComputePeridemAtom(class LAMMPS *, int, char **);
  ~ComputePeridemAtom() override;
  void init() override;
  void compute_peratom() override;
  double memory_usage() override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;

 private:
  std::vector<int> fields;
  int nmax{0};
  FixPeridemBonds *bonds{nullptr};
  std::vector<PairPeridem *> solids;

  std::vector<std::array<double, 3>> directions;    // to look for open sides

  std::vector<double> piece;    // per node: smallest atom-ID of its fragment

  double value(int field, int i) const;
  const PairPeridem *solid(int i) const;
  double damage(int i) const;
  double surface(int i) const;
  std::vector<std::array<double, 3>> near_directions(int i) const;
  void spread_directions();
  bool wants(int field) const;
  void find_fragments();
  bool sweep_fragments();
};

}    // namespace LAMMPS_NS

#endif
#endif

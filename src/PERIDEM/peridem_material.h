/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What pair_coeff says of a solid: elastic moduli, horizon, strength, and the constants of the
// linear peridynamic solid that follow from them.

#ifndef LMP_PERIDEM_MATERIAL_H
#define LMP_PERIDEM_MATERIAL_H

#include "peridem_influence.h"

#include "pointers.h"

#include <cstdio>
#include <string>

namespace LAMMPS_NS {

struct PeridemMaterial {
  enum Plane { THREE_D, STRAIN, STRESS, JHA };
  enum Strength { UNSET, GC, S0, UNBREAKABLE };
  enum Volume { TAPER, FULL };

  double bulk{0.0}, shear{0.0};    // 0 = not given (allowed for I != J only)
  double horizon{0.0};             // 0 = not given (allowed for I != J only)
  int strength{UNSET};
  double gc{0.0};           // critical energy release rate, if given
  double s0{0.0};           // critical stretch, infinite if unbreakable
  double viscosity{0.0};    // of the dashpot along the bonds, pressure * time
  PeridemInfluence influence;
  int plane{THREE_D};
  int volume{TAPER};
  double cell{0.0};      // cell size of the taper; 0 = from the volumes of the two nodes
  int break_both{0};     // 1: bonds break in compression too

  // dimension that the constants are made for (3 with plane jha), lambda' of DESIGN section 2
  int dim() const { return plane == THREE_D || plane == JHA ? 3 : 2; }
  double lambda() const;

  // t_i = w [ dilatation_modulus() theta_i R / m_i + extension_modulus() e / m_i ]
  double dilatation_modulus() const { return dim() * (lambda() - shear); }
  double extension_modulus() const { return dim() * (dim() + 2) * shear; }
  double viscous_modulus() const { return dim() * (dim() + 2) * viscosity; }

  double poisson() const { return (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear)); }

  // critical stretch that spends Gc per unit of crack area, for any influence function
  double stretch_from_gc() const;

  // partial-volume factor of a cell of size h at distance R
  double volume_factor(double R, double h) const
  {
    if (volume == FULL) return 1.0;
    const double start = horizon - 0.5 * h;
    if (R <= start) return 1.0;
    const double v = (horizon + 0.5 * h - R) / h;
    return v > 0.0 ? v : 0.0;
  }

  void write_restart(FILE *) const;
  void read_restart(FILE *, class LAMMPS *);
};

// Reads the keywords of pair_coeff. Each error names the keyword, what was given and what is
// allowed; iarg0 is where arg[0] stands on the input line.

class PeridemMaterialParser : protected Pointers {
 public:
  PeridemMaterialParser(class LAMMPS *, const std::string &style, int iarg0);
  PeridemMaterial parse(int narg, char **arg, bool one_type);

 private:
  std::string style;
  int iarg0;
  int narg{0};
  char **arg{nullptr};

  double positive(int iarg, const std::string &keyword);
  double non_negative(int iarg, const std::string &keyword);
  void need(int iarg, int nvalues);
  int influence(int iarg, PeridemMaterial &);
  int volume(int iarg, PeridemMaterial &);
  void plane(int iarg, PeridemMaterial &);
  void moduli(const double *given, const int *where, PeridemMaterial &, bool required);
};

}    // namespace LAMMPS_NS

#endif

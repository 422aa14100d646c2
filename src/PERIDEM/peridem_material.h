/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What pair_coeff says of a solid: elastic moduli, horizon, strength, and the constants of the
// linear peridynamic solid or of the bond-based solid that follow from them.

#ifndef LMP_PERIDEM_MATERIAL_H
#define LMP_PERIDEM_MATERIAL_H

#include "peridem_influence.h"

#include "pointers.h"

#include <cstdio>
#include <map>
#include <string>

namespace LAMMPS_NS {

struct PeridemMaterial {
  enum Model { LPS, PMB };
  enum Potential { BRITTLE, ELASTIC, RNP };                      // of the bond-based solid
  enum Plane { AS_TYPES = -1, THREE_D, STRAIN, STRESS, JHA };    // AS_TYPES: for I != J only
  enum Strength { UNSET, GC, S0, UNBREAKABLE };
  enum Volume { TAPER, FULL };

  int model{LPS};
  int potential{BRITTLE};
  double bulk{0.0}, shear{0.0};    // 0 = not given (allowed for I != J only)
  double horizon{0.0};             // 0 = not given (allowed for I != J only)
  int strength{UNSET};
  double gc{0.0};           // critical energy release rate, if given
  double spacing{0.0};      // of a lattice whose bonds spend gc; 0 = integrals in place of sums
  double s0{0.0};           // critical stretch, infinite if unbreakable
  double viscosity{0.0};    // of the dashpot along the bonds, pressure * time
  PeridemInfluence influence;
  int plane{THREE_D};
  int volume{TAPER};
  double cell{0.0};     // cell size of the taper; 0 = from the volumes of the two nodes
  int break_both{0};    // 1: bonds break in compression too

  // dimension that the constants are made for (3 with plane jha), lambda' of DESIGN section 2
  int dim() const { return plane == THREE_D || plane == JHA ? 3 : 2; }
  double lambda() const;

  // t_i = w [ dilatation_modulus() theta_i R / m_i + extension_modulus() e / m_i ]
  double dilatation_modulus() const { return dim() * (lambda() - shear); }
  double extension_modulus() const { return dim() * (dim() + 2) * shear; }
  double viscous_modulus() const { return dim() * (dim() + 2) * viscosity; }

  // The bond-based solid pulls a bond with c w s v V_i V_j; it is the solid with lambda' = G. The
  // regularised potential is C (1 - exp(-beta R s^2)) with 2 C beta = c; s0 is the stretch at which
  // a bond as long as the horizon pulls hardest.
  double micromodulus() const;
  void moduli_from_micromodulus(double c);
  double rnp_beta() const { return 0.5 / (horizon * s0 * s0); }
  double rnp_depth() const { return micromodulus() * horizon * s0 * s0; }

  double poisson() const { return (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear)); }

  // critical stretch that spends Gc per unit of crack area, for any influence function
  double stretch_from_gc() const;
  std::string spacing_text() const;    // for messages

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
  PeridemMaterialParser(class LAMMPS *, const std::string &style, int iarg0,
                        int model = PeridemMaterial::LPS);
  PeridemMaterial parse(int narg, char **arg, bool one_type);

 private:
  enum { YOUNG, BULK, SHEAR, POISSON, NMODULI };
  static const char *const modulus_names[NMODULI];

  std::string style;
  int iarg0, model;
  int narg{0};
  char **arg{nullptr};

  // what one pair_coeff has said so far
  PeridemMaterial mat;
  std::map<std::string, int> seen;    // keyword and where it stands
  double given[NMODULI] = {};
  int where[NMODULI] = {};     // -1 = not given
  double micromodulus{0.0};    // keyword c, 0 = not given
  double rnp[2] = {};          // C and beta of the regularised potential, 0 = not given

  void clear();
  int keyword(int iarg);
  int pmb_keyword(int iarg);
  std::string known() const;
  double positive(int iarg, const std::string &keyword);
  double non_negative(int iarg, const std::string &keyword);
  void need(int iarg, int nvalues);
  void check_strength(int iarg);
  int strength(int iarg);
  void check_spacing();
  int influence(int iarg);
  int volume(int iarg);
  int potential(int iarg);
  void plane(int iarg);
  void breaking(int iarg);
  void moduli(bool required);
  void pmb_moduli(bool required);
  void pmb_strength(bool required);
};

}    // namespace LAMMPS_NS

#endif

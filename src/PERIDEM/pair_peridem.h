/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What the pair styles of peridynamic solids share: coefficients, mixing, the fix that holds the
// families, restart.  Not a pair style by itself.

#ifndef LMP_PAIR_PERIDEM_H
#define LMP_PAIR_PERIDEM_H

#include "pair.h"
#include "peridem_books.h"
#include "peridem_material.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

class PairPeridem : public Pair {
 public:
  PairPeridem(class LAMMPS *, const char *name);
  ~PairPeridem() override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;
  void *extract(const char *, int &) override;

  // all solids among the pair styles in use
  static std::vector<PairPeridem *> find_all(class LAMMPS *);

  // does this style hold a material for the type?
  bool covers(int itype) const { return !given.empty() && setflag[itype][itype]; }

  // the material of bonds between two types, as given or mixed (after init_style)
  const PeridemMaterial &material(int itype, int jtype) const { return mixed[index(itype, jtype)]; }

  // the material of one type as pair_coeff gave it (before init_style too)
  const PeridemMaterial &own_material(int itype) const { return given[index(itype, itype)]; }

  // of owned nodes, in the state of the last force evaluation
  virtual double dilatation(int) const = 0;
  virtual double strain_energy(int) const = 0;
  // Cauchy stress xx, yy, zz, xy, xz, yz from the force state of the node
  virtual void stress(int, double *) const = 0;

  // largest squared frequency of the bonds, in units of force / (length mass); collective
  double largest_frequency_sq();
  // largest ratio of viscosity to shear modulus
  double largest_viscous_time() const;
  // does it look at rows of fix peridem/bonds in every step?
  virtual bool reads_rows() const { return books_viscous; }
  int init_count() const { return ninit; }
  int coeff_version() const { return ncoeff; }

  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;

  PeridemBooks books;    // viscous forces, for the energy ledger

  // energy that went with broken bonds on this rank since the style was made
  double broken_energy{0.0};

 protected:
  const std::string name;    // of the style, for messages
  FixPeridemBonds *bonds{nullptr};
  std::string bonds_id{"peridem_bonds"};    // the fix whose state a restart file holds
  bool from_restart{false};

  // PeridemMaterial::Model of what pair_coeff gives
  virtual int model() const { return PeridemMaterial::LPS; }

  std::size_t index(int itype, int jtype) const { return itype * (ntypes + 1) + jtype; }

  // linear response of the bonds at the present positions: force on owned nodes from small
  // displacements u of owned and ghost nodes
  virtual void apply_stiffness(const std::vector<double> &u, std::vector<double> &force) = 0;

  // how long bonds that break now have not pulled any more
  double time_without_broken() const;

  // send per-node values, size of them for each node, from owned nodes to their ghosts
  void to_ghosts(double *values, int size);

 private:
  int ntypes{0};
  int ninit{0};
  int ncoeff{0};                // counts the pair_coeff commands
  bool books_viscous{false};    // are viscous forces booked?
  double *comm_values{nullptr};
  std::vector<PeridemMaterial> given, mixed;

  void allocate();
  PeridemMaterial mix(int itype, int jtype) const;
  void mix_unlike(PeridemMaterial &, int itype, int jtype) const;
  void check_alike(int itype, int jtype) const;
  void find_bonds();
  std::string placeholder() const;
  void keep_places();
};

}    // namespace LAMMPS_NS

#endif

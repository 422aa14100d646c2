/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(peridem/pmb,PairPeridemPMB);
// clang-format on
#else

#ifndef LMP_PAIR_PERIDEM_PMB_H
#define LMP_PAIR_PERIDEM_PMB_H

#include "pair_peridem.h"

#include <memory>

namespace LAMMPS_NS {

// The bond-based solid (Silling 2000; Silling & Askari 2005), each bond a spring of its own:
//   F_ij = w v V_i V_j c s                         linear: elastic for ever, or broken beyond s0
//   F_ij = w v V_i V_j c s exp(-beta R s^2)        from the potential C (1 - exp(-beta R s^2)),
//                                                  2 C beta = c (Lipton 2014)

class PairPeridemPMB : public PairPeridem {
 public:
  PairPeridemPMB(class LAMMPS *);
  ~PairPeridemPMB() override;
  void init_style() override;
  void compute(int, int) override;
  double dilatation(int) const override;
  double strain_energy(int) const override;
  void stress(int, double *) const override;
  bool reads_rows() const override;
  double memory_usage() override;

 protected:
  int model() const override { return PeridemMaterial::PMB; }
  void apply_stiffness(const std::vector<double> &, std::vector<double> &) override;

 private:
  // the bonds between two types
  struct Law {
    double c{0.0};          // micro-modulus
    double beta{0.0};       // of the regularised potential; 0 = linear
    double dashpot{0.0};    // c times viscosity / shear modulus
    double s0{0.0};         // stretch that breaks; with beta, of a bond of length 1
    bool both{false};       // breaks in compression too

    double softening(double R, double s) const;
    double energy(double R, double s) const;
    double reached(double R, double s) const;
  };
  std::vector<Law> laws;

  // Bonds of nodes whose bonds are linear and within one type are in a list, which has each of them
  // once; those of others are taken from the rows of fix peridem/bonds.
  std::unique_ptr<class PeridemGeneral> list;
  bigint list_version{-1};                          // of the bonds that it lists
  std::vector<double> half_spring, half_dashpot;    // c/2 and so on of owned and ghost nodes

  const Law &law(int itype, int jtype) const { return laws[index(itype, jtype)]; }
  Law make_law(const PeridemMaterial &) const;
  void report(int itype) const;
  void init_list();
  bool listed(int i) const;
  void update_list();
  void row(int i);

  struct Bond {
    int j;
    double d[3];    // x_j - x_i
    double r, R, s, weight;
  };
  Bond look_at(int i, bigint k) const;
  double rate(int i, const Bond &) const;
  double energy_to_break(int i, const Bond &) const;
  template <class What> void each_bond(int i, What what) const;
  double spring(int i, const Bond &) const;
  double viscous(int i, const Bond &) const;
  double fast_row(int i, double *f) const;
  template <bool VISCOUS> double fast_row(int i, const Law &, double *f) const;
  void careful_row(int i);
  void slow_row(int i, double *f) const;
  void tally(int i);
  void book_viscous_forces();
};

}    // namespace LAMMPS_NS

#endif
#endif

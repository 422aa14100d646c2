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
PairStyle(peridem/lps,PairPeridemLPS);
// clang-format on
#else

#ifndef LMP_PAIR_PERIDEM_LPS_H
#define LMP_PAIR_PERIDEM_LPS_H

#include "pair_peridem.h"

#include <memory>

namespace LAMMPS_NS {

// The linear peridynamic solid (Silling et al. 2007), in 3d, plane strain and plane stress:
//   theta_i = d/m_i sum w R e v V_j
//   F_ij = w v V_i V_j [ (a_i + a_j) R + (b_i + b_j) e ],  a = d (lambda' - G) theta / m,
//                                                          b = d (d + 2) G / m

class PairPeridemLPS : public PairPeridem {
 public:
  PairPeridemLPS(class LAMMPS *);
  ~PairPeridemLPS() override;
  void settings(int, char **) override;
  void init_style() override;
  void compute(int, int) override;
  double dilatation(int) const override;
  double strain_energy(int) const override;
  void stress(int, double *) const override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;
  double memory_usage() override;

 protected:
  void apply_stiffness(const std::vector<double> &, std::vector<double> &) override;

 private:
  int nmax{0};
  double *theta{nullptr};        // dilatation of owned nodes
  double *pressure{nullptr};     // a_i of owned and ghost nodes
  double *stiffness{nullptr};    // b_i
  double *dashpot{nullptr};      // d (d + 2) viscosity / m_i

  struct Moduli {
    double dilatation_modulus, extension_modulus, viscous_modulus;
  };
  std::vector<Moduli> moduli;    // per type
  bool any_viscous{false};
  bigint constants_version{-1};

  enum Engine { AUTO, GENERAL, BATCHED };
  int engine{AUTO};
  std::unique_ptr<class PeridemGeneral> general;
  bigint list_version{-1};                      // of the bonds that the general engine lists
  std::unique_ptr<class PeridemBatch> batch;    // null with engine general
  bigint batch_version{-1};
  bool batching{false};               // does the present step use the batches?
  mutable bool theta_stale{false};    // dilatations of the last step are still in the batches

  void init_general();
  void init_batch();
  void fetch_dilatations() const;
  bool elsewhere(int) const;
  void general_passes();

  void grow();
  void node_constants();
  double extension_sum(int) const;
  double softness(int) const;
  double extension(int, int, const std::vector<double> &, double *) const;
  double extension_sum(int, const std::vector<double> &) const;
  void add_response(int, const std::vector<double> &, const std::vector<double> &, double *) const;
  void careful_row(int);
  double energy_rate(int) const;
  double energy_to_break(int) const;
  void set_dilatation(int, double) const;
  void tally();
  void tally_virial(int, double *) const;
  void book_viscous_forces();
};

}    // namespace LAMMPS_NS

#endif
#endif

/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The batched engine of pair_style peridem/lps: grains of like families side by side, one in each lane
// of the processor's registers.  Families, broken bonds and largest stretches stay those of
// fix peridem/bonds: whoever reads them need not know which engine is at work.

#ifndef LMP_PERIDEM_BATCH_H
#define LMP_PERIDEM_BATCH_H

#include "peridem_batch_kernel.h"
#include "peridem_batch_plan.h"

#include <functional>
#include <string>

namespace LAMMPS_NS {

class PeridemBatch : protected Pointers {
 public:
  struct Law : PeridemBatchPlan::Law {    // of one atom type
    double s0;                            // critical stretch
    bool both;                            // bonds break in compression too
    bool viscous;
  };
  // looks at every bond of an owned node, and breaks what must break
  using CarefulRow = std::function<void(int)>;

  PeridemBatch(class LAMMPS *, CarefulRow);

  void init(FixPeridemBonds *, const std::vector<Law> &, bool forced);
  // batches for the present local indices; collective
  void plan(const double *stiffness, const double *dashpot);

  // does any rank have bonds for the general engine?
  bool general_too() const { return general; }
  bool covers(int i) const { return thePlan.covered[i]; }

  // add forces, break bonds; with tally, find energy and virial of all bonds; collective
  void compute(bool tally);
  double energy() const { return tallies[0]; }
  const double *virial() const { return tallies + 1; }
  // after a step without compute(): have bonds broken that only another rank knows of? Then there must
  // be a new plan(). Collective.
  bool outdated();
  // linear response to displacements u, three of each owned node: forces on the nodes of grains that
  // are on this rank alone
  void respond(const std::vector<double> &u, std::vector<double> &forces);
  bool responds(int i) const;
  // of owned nodes in batches: sum of w v V_i V_j R e over the bonds at the last compute()
  void each_sum(const std::function<void(int, double)> &) const;

  double memory_usage() const;

 private:
  CarefulRow careful_row;
  FixPeridemBonds *bonds{nullptr};
  std::vector<Law> laws;
  bool forced{false}, reported{false}, general{true}, any_viscous{false};
  std::string said;    // the last report
  PeridemBatchPlan thePlan;
  std::size_t broken_seen{0};    // entries of bonds->broken that the batches know

  // one batch at work, in cache
  std::vector<PeridemSimd::Pack> x, v, top, pressure, force;
  std::vector<PeridemBatchKernel::Found> found;
  std::vector<double> lent_sums;    // by local index
  bool tallying{false};
  double tallies[7] = {};    // energy, virial

  void report();
  void drop_broken();
  void compute_groups(std::size_t begin, std::size_t end);
  void take_results(int, const double *);
  using Borrowed = const double *(PeridemBatchShare::*) (int) const;
  template <int DIM>
  void gather(const PeridemBatchGroup &, const double *own, Borrowed,
              std::vector<PeridemSimd::Pack> &) const;
  template <int DIM> void shift(const PeridemBatchGroup &);
  template <int DIM> void one_group(PeridemBatchGroup &);
  bool keeps_found(const PeridemBatchGroup &) const;
  template <int DIM> void stretches(PeridemBatchGroup &);
  template <int DIM, bool KEEP> void stretch_pass(PeridemBatchGroup &);
  bool look_closely(PeridemBatchGroup &);
  bool careful_borrowed(PeridemBatchGroup &, int lane, int n);
  void record_stretches(PeridemBatchGroup &);
  void record_stretch(PeridemBatchGroup &, int n, double scale);
  template <int DIM> void forces(PeridemBatchGroup &);
  template <int DIM, bool TALLY> void force_pass(const PeridemBatchGroup &, PeridemSimd::Pack *);
  void add_tallies(const PeridemBatchGroup &, const PeridemSimd::Pack *);
  template <int DIM> void scatter(const PeridemBatchGroup &, double *to);
  template <int DIM>
  void respond(const PeridemBatchGroup &, const std::vector<double> &, std::vector<double> &);
};

}    // namespace LAMMPS_NS

#endif

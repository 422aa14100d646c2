/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(PERIDEM_LEDGER,FixPeridemLedger);
// clang-format on
#else

#ifndef LMP_FIX_PERIDEM_LEDGER_H
#define LMP_FIX_PERIDEM_LEDGER_H

#include "fix.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class FixPeridemWall;
class PairPeridem;
class PairPeridemContact;

// Books energies step by step for compute peridem/energy, which makes this fix; not for scripts.

class FixPeridemLedger : public Fix {
 public:
  FixPeridemLedger(class LAMMPS *, int, char **);
  ~FixPeridemLedger() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void initial_integrate(int) override { open(); }
  void post_force(int) override;
  void end_of_step() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  double memory_usage() override;

  // strain, contact, broken bonds, friction loss, damping loss, wall work, kinetic, drift, other
  // work; over all ranks, since the ledger was opened
  void balance(double *totals);

  // Pair styles keep a place for this fix at the head of the list of fixes, so that it sees the
  // forces before other fixes add theirs.
  static void keep_place(class LAMMPS *);
  static Fix *make(class LAMMPS *);

 private:
  enum { STRAIN, CONTACT, BROKEN, FRICTION, DAMPING, WALLS, KINETIC, DRIFT, OTHER, NITEMS };

  std::vector<PairPeridem *> solids;
  PairPeridemContact *contact{nullptr};
  std::vector<FixPeridemWall *> walls;
  const FixPeridemAdapt *adapt{nullptr};
  int prescribed_bits{0};    // groups whose motion fix move prescribes
  bool started{false};
  std::vector<double> internal;    // forces of bonds and contacts on owned nodes
  struct Work {
    double friction, damping, other, on_prescribed;
  };
  Work work{0.0, 0.0, 0.0, 0.0};    // so far, this rank
  Work last{0.0, 0.0, 0.0, 0.0};    // of the last step: half of it is still to come
  double walls_at_start{0.0};       // work that walls had done before
  double stored_at_start{0.0};      // all ranks
  double kinetic_prescribed_at_start{0.0}, broken_at_start{0.0};    // this rank

  // the books as a restart file has them, over all ranks
  struct Saved {
    double stamp, started, stored_at_start;
    Work work, last;
    double kinetic_prescribed_at_start, broken, walls;
  };
  Saved saved{};
  bool resumed{false};

  // energy at the start is taken when all other fixes have been set up
  bool opening{false};

  void open();
  void resume();
  double wall_work() const;
  void find_styles();
  double kinetic(int groupbits) const;
  double broken() const;
};

}    // namespace LAMMPS_NS

#endif
#endif

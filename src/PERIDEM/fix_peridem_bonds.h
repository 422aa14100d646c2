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
FixStyle(peridem/bonds,FixPeridemBonds);
// clang-format on
#else

#ifndef LMP_FIX_PERIDEM_BONDS_H
#define LMP_FIX_PERIDEM_BONDS_H

#include "fix.h"
#include "peridem_bond_watch.h"
#include "peridem_cut.h"
#include "peridem_families.h"
#include "peridem_family_laws.h"
#include "peridem_rows.h"

#include <map>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class PairPeridem;
struct PeridemMaterial;

// Gives every node its family, the nodes of its grain that it is bonded to, and keeps the bonds:
// they travel with their nodes, break, and come back from restart files.

class FixPeridemBonds : public Fix, public PeridemRows {
 public:
  FixPeridemBonds(class LAMMPS *, int, char **);
  ~FixPeridemBonds() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void setup_pre_exchange() override;
  void setup_post_neighbor() override;
  void pre_exchange() override;
  void post_neighbor() override;
  void min_pre_exchange() override { pre_exchange(); }
  void min_post_neighbor() override { post_neighbor(); }

  void write_restart(FILE *) override;
  void restart(char *) override;
  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  double compute_vector(int) override;

  std::vector<char> mixed;    // per node: 1 if some bond leads to another type
  std::vector<char> rigid;    // per node: 1 if it and its whole family belong to rigid bodies

  int unbroken_bit{0};    // bonds between two nodes of this group never break

  bigint version{0};    // counts the rebuilds of local indices and changes of what is rigid

  // bonds broken since the last reneighbouring, by local index
  struct Broken {
    int i, j;
  };
  std::vector<Broken> broken;

  // look again which nodes belong to rigid bodies
  void flag_rigid();

  // of a bond of length R; every engine decides by this number, the same to the last digit from both ends
  static double stretch(const double *xi, const double *xj, double R);
  void break_bond(int i, bigint k);
  double intact_volume(int i) const;

 private:
  std::vector<PairPeridem *> solids;              // the pair styles that own materials
  std::vector<std::pair<tagint, tagint>> told;    // broken bonds that another rank must hear of
  std::vector<double> cellsize;                   // per node: V^(1/d)
  int max_family{0};                              // longest reference row of all ranks
  double longest{0.0};                            // longest bond at the last reneighbouring
  double cutghost_set{0.0};                       // ghost cutoff that this fix has asked for
  bigint natoms_seen{-1};
  bool weights_stale{true};
  struct {    // at the last reneighbouring
    std::vector<tagint> ids, grains;
    std::vector<int> types;
  } seen;
  bool ghost_partners{true};    // may a partner be another ghost at the next one?
  int rigid_bits{0};            // groups of fixes that move rigid bodies
  const FixPeridemAdapt *adapt{nullptr};
  PeridemBondWatch watch;
  PeridemFamilyLaws laws;
  PeridemCuts cuts;

  const PeridemMaterial *material(int itype, int jtype) const;
  double cell_size(int i) const;
  void parse(int, char **);
  void find_solids();
  void check_order() const;
  void find_rigid_bodies();
  void require_ghost_cutoff(double, bool at_init);
  void reconcile();
  void remove_row_entry(int i, tagint jtag);
  void build_if_new_nodes();
  void build_families();
  double enter_families(const std::vector<int> &, double reach,
                        const PeridemFamilies::MaterialOf &);
  double longest_reference() const;
  std::vector<int> nodes_without_family();
  std::map<tagint, bigint> grain_sizes(const std::vector<int> &) const;
  void check_unit(double horizon) const;
  void check_periods(double bond) const;
  void check_families(const std::vector<int> &fresh);
  void build_local();
  void compute_weights();
  bool same_nodes();
  void map_partners();
  bool moves_rigidly(int i) const;
  void lost_partner(int i, tagint jtag);
};

}    // namespace LAMMPS_NS

#endif
#endif

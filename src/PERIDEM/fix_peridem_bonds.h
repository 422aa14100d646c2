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
#include "peridem_cut.h"
#include "peridem_influence.h"
#include "peridem_stability.h"

#include <map>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class PairPeridem;
struct PeridemMaterial;

// The family of every owned node: which nodes of its grain it is bonded to, and how long each bond
// is in the reference configuration.  Bonds are kept in both directions, in one compressed pool
// without padding; a broken bond is taken out of its row.  Rows are sorted by the partner's ID, so
// that sums do not depend on how nodes are spread over processors.

class FixPeridemBonds : public Fix {
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

  // ---- the rows, valid from one reneighbouring to the next: bonds of node i are start[i] <= k <
  // ---- start[i] + num[i] of the pool

  bigint *start{nullptr};
  int *num{nullptr};             // bonds still intact; -1 = no family yet
  std::vector<int> partner;      // local index of the other node
  std::vector<double> length;    // reference length R
  std::vector<double> weight;    // w v_ij V_i V_j, the same from both ends

  // ---- per node

  int *nref{nullptr};             // bonds in the reference configuration
  double *wvolume{nullptr};       // weighted volume m_i of the reference configuration
  double *famvolume{nullptr};     // sum of v_ij V_j over the reference family
  std::vector<char> mixed;        // 1 if some bond leads to another type
  std::vector<char> rigid;        // 1 if the node and its whole family belong to rigid bodies
  double *maxstretch{nullptr};    // largest stretch so far, as a fraction of the critical one

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
  bool bonded(int i, tagint jtag) const;
  double intact_volume(int i) const;

 private:
  struct FamilyLaw {    // what families were built from
    double horizon, cell;
    PeridemInfluence influence;
    int volume;
  };

  std::vector<tagint> ptag;                       // pool: ID of the other node
  std::vector<PairPeridem *> solids;              // the pair styles that own materials
  std::vector<std::pair<tagint, tagint>> told;    // broken bonds that another rank must hear of
  std::vector<FamilyLaw> laws;                    // by type pair, once families exist
  std::vector<double> cellsize;                   // per node: V^(1/d)
  int max_family{0};                              // longest reference row of all ranks
  double longest{0.0};                            // longest bond at the last reneighbouring
  bool said_compressed{false};                    // in this run
  bool said_rerun{false};
  int solids_inits{-1};        // how often the solids had been initialised when this fix was
  double cutghost_set{0.0};    // ghost cutoff that this fix has asked for
  bigint natoms_seen{-1};
  bool weights_stale{true};
  int rigid_bits{0};    // groups of fixes that move rigid bodies
  const FixPeridemAdapt *adapt{nullptr};
  PeridemStability stability;
  PeridemCuts cuts;
  tagint *known_id{nullptr};    // per node: the ID by which bonds know it; 0 = none yet

  const PeridemMaterial *material(int itype, int jtype) const;
  double cell_size(int i) const;
  void parse(int, char **);
  void find_solids();
  void watch_rerun();
  void check_laws();
  void require_ghost_cutoff(double, bool at_init);
  void reconcile();
  std::vector<tagint> gather(const std::vector<tagint> &) const;
  void erase_bond(int i, bigint k);
  void give_ids_back();
  void drop_deleted();
  void measure_bonds();
  void say_compressed(double shortest, int i, int j);
  void check_box() const;
  void remove_row_entry(int i, tagint jtag);
  void build_if_new_nodes();
  void build_families();
  std::map<tagint, bigint> grain_sizes(const std::vector<int> &) const;
  void check_unit(double horizon) const;
  void check_families(const std::vector<int> &fresh);
  void build_local();
  void compute_weights();
  void map_partners();
  bool moves_rigidly(int i) const;
  void lost_partner(int i, tagint jtag);
};

}    // namespace LAMMPS_NS

#endif
#endif

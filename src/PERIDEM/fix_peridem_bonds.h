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
#include "peridem_lookup.h"
#include "peridem_material.h"
#include "peridem_rows.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class PairPeridem;

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

  bigint version{0};    // counts reneighbourings and changes of what is rigid

  // changes whenever a node may be elsewhere in the arrays; while it does not, no bond leads to a ghost
  bigint layout{0};

  // ---- what follows from the rows (loops over all bonds look nodes up by a PeridemLookup)

  // local index of the other node of bond k of node i, that copy of it which is nearest to node i
  int partner(int i, bigint k) const
  {
    return partners.empty() ? nearest(i, atom->map(ptag[k])) : partners[k];
  }
  // that of the copies of node j
  int nearest(int i, int j) const { return periodic && !beside(i, j) ? nearest_image(i, j) : j; }

  // w v_ij V_i V_j of bond k between nodes i and j, the same from both ends
  double weight(int i, int j, bigint k) const
  {
    return weights.empty() ? bond_weight(i, j, length[k]) : weights[k];
  }
  // the same of a bond of length R
  double bond_weight(int i, int j, double R) const
  {
    const auto &mat = *material(atom->type[i], atom->type[j]);
    return mat.influence(R / mat.horizon) * mat.volume_factor(R, cell_size(mat, i, j)) *
        (atom->vfrac[i] * atom->vfrac[j]);
  }

  // of owned nodes, to nodes that other ranks own, at the last reneighbouring
  bigint ghost_bonds{0};

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
  std::vector<PairPeridem *> solids;                 // the pair styles that own materials
  std::vector<std::pair<tagint, tagint>> told;       // broken bonds that another rank must hear of
  std::vector<const PeridemMaterial *> materials;    // by pair of types; null: no bonds
  std::vector<double> cellsize;                      // of owned and ghost nodes: V^(1/d)
  bool store_all{false};                             // does a solid read rows in every step?
  bool periodic{false};
  double beside_within[3] = {};    // any other image of a node that is nearer than that is farther
  int max_family{0};               // longest reference row of all ranks
  double longest{0.0};             // longest bond at the last reneighbouring
  double cutghost_set{0.0};        // ghost cutoff that this fix has asked for
  bigint natoms_seen{-1};
  bool volumes_checked{false};
  struct {    // at the last reneighbouring
    std::vector<tagint> ids, grains;
    std::vector<int> types;
  } seen;
  int rigid_bits{0};    // groups of fixes that move rigid bodies
  const FixPeridemAdapt *adapt{nullptr};
  PeridemBondWatch watch;
  PeridemFamilyLaws laws;
  PeridemCuts cuts;

  const PeridemMaterial *material(int itype, int jtype) const
  {
    return materials[itype * (atom->ntypes + 1) + jtype];
  }
  double cell_size(const PeridemMaterial &mat, int i, int j) const
  {
    return mat.cell > 0.0 ? mat.cell : 0.5 * (cellsize[i] + cellsize[j]);
  }
  bool beside(int i, int j) const;
  int nearest_image(int i, int j) const;
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
  void find_cell_sizes();
  void find_periods();
  void check_volumes() const;
  bool same_nodes();
  void check_partners();
  void store();
  bool moves_rigidly(int i) const;
  void lost_partner(int i, tagint jtag);
};

inline bool FixPeridemBonds::beside(int i, int j) const
{
  if (j < 0) return true;
  const double *const xi = atom->x[i], *const xj = atom->x[j];
  return std::fabs(xj[0] - xi[0]) < beside_within[0] &&
      std::fabs(xj[1] - xi[1]) < beside_within[1] && std::fabs(xj[2] - xi[2]) < beside_within[2];
}

}    // namespace LAMMPS_NS

#endif
#endif

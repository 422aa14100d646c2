/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Contributing author: the PERIDEM developers
------------------------------------------------------------------------- */

#include "fix_peridem_bonds.h"

#include "fix_peridem_adapt.h"
#include "pair_peridem.h"
#include "peridem_families.h"
#include "peridem_material.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

using namespace LAMMPS_NS;
using namespace FixConst;

// times the longest edge of the box: no grain is larger than that
static constexpr double DWARFS = 1000.0;

// positions that decide on the ghost cutoff may be one step old
static constexpr double STEP_MARGIN = 1.02;

// when bonds outgrow the ghost cutoff, it grows by this factor beyond them
static constexpr double GROWTH = 1.25;

// part of its length to which a bond may be compressed without a warning
static constexpr double CRUSHED = 0.25;

// relative difference of weighted volumes that is not rounding
static constexpr double CHANGED = 1.0e-9;

/* ---------------------------------------------------------------------- */

FixPeridemBonds::FixPeridemBonds(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), stability(lmp), cuts(lmp)
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, 2, "Fix {} requires atom style peridem; the atom style is {}", style,
               atom->get_style());
  if (modify->get_fix_by_style("^peridem/bonds$").size() > 0)
    error->all(FLERR, 2, "There is a fix {} already: only one is allowed", style);
  parse(narg, arg);

  restart_global = 1;
  restart_peratom = 1;
  create_attribute = 1;
  stores_ids = 1;
  maxexchange_dynamic = 1;
  comm_forward = 1;
  vector_flag = 1;
  size_vector = 3;
  global_freq = 1;
  extvector = 0;

  FixPeridemBonds::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixPeridemBonds::set_arrays(i);
}

/* ----------------------------------------------------------------------
   cut plane|segment|region ... (any number of them), unbroken group-ID
------------------------------------------------------------------------- */

void FixPeridemBonds::parse(int narg, char **arg)
{
  int iarg = 3;
  while (iarg < narg) {
    if (strcmp(arg[iarg], "cut") == 0) {
      iarg = cuts.add(iarg + 1, narg, arg, style);
    } else if (strcmp(arg[iarg], "unbroken") == 0) {
      if (unbroken_bit) error->all(FLERR, iarg, "Repeated fix {} keyword unbroken", style);
      if (iarg + 1 >= narg) error->all(FLERR, iarg, "Fix {} unbroken needs a group-ID", style);
      const int igroup_unbroken = group->find(arg[iarg + 1]);
      if (igroup_unbroken < 0)
        error->all(FLERR, iarg + 1, "Fix {} unbroken {}: there is no such group", style,
                   arg[iarg + 1]);
      unbroken_bit = group->bitmask[igroup_unbroken];
      iarg += 2;
    } else {
      error->all(FLERR, iarg, "Unknown fix {} keyword {}: known are cut, unbroken", style,
                 arg[iarg]);
    }
  }
}

/* ---------------------------------------------------------------------- */

FixPeridemBonds::~FixPeridemBonds()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  memory->destroy(start);
  memory->destroy(num);
  memory->destroy(nref);
  memory->destroy(wvolume);
  memory->destroy(famvolume);
  memory->destroy(maxstretch);
  memory->destroy(known_id);
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::setmask()
{
  return PRE_EXCHANGE | POST_NEIGHBOR | MIN_PRE_EXCHANGE | MIN_POST_NEIGHBOR;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::init()
{
  said_compressed = false;
  give_ids_back();
  find_solids();
  watch_rerun();

  // what happens before nodes migrate must happen before any other fix migrates them

  for (const auto *fix : modify->get_fix_list()) {
    if (fix == this) break;
    if (fix->pre_exchange_migrate)
      error->all(FLERR, Error::NOLASTLINE, "Fix {} {} must be defined before fix {} {}", id, style,
                 fix->id, fix->style);
  }

  rigid_bits = 0;
  for (const auto *fix : modify->get_fix_list())
    if (fix->rigid_flag) rigid_bits |= fix->groupbit;
  const auto adapts = modify->get_fix_by_style("^peridem/adapt$");
  adapt = adapts.empty() ? nullptr : dynamic_cast<const FixPeridemAdapt *>(adapts[0]);

  check_laws();
  weights_stale = true;
  natoms_seen = -1;

  double need = 0.0;
  const int ntypes = atom->ntypes;
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++)
      if (const auto *mat = material(i, j))
        need = MAX(need, mat->horizon * (1.0 + 2.0 * PeridemFamilies::SLACK));
  check_unit(need);
  if (longest > 0.0) need = MAX(need, longest + MIN(neighbor->skin, longest));
  require_ghost_cutoff(need, true);

  for (int k = 0; k < domain->dimension; k++) {
    const double period = domain->triclinic ? domain->prd_lamda[k] : domain->prd[k];
    if (!domain->triclinic && domain->periodicity[k] && period < 2.0 * need)
      error->all(
          FLERR, Error::NOLASTLINE,
          "Periodic box is {:.6g} long in {}: it must be at least twice the longest bond, {:.6g}",
          period, "xyz"[k], need);
  }
}

/* ----------------------------------------------------------------------
   "rerun" initialises fixes for every snapshot, but pair styles once
------------------------------------------------------------------------- */

void FixPeridemBonds::watch_rerun()
{
  int count = 0;
  bool breakable = false;
  for (const auto *solid : solids) {
    count += solid->init_count();
    for (int i = 1; i <= atom->ntypes; i++)
      if (solid->covers(i)) breakable = breakable || std::isfinite(solid->material(i, i).s0);
  }
  const bool again = count == solids_inits;
  if (again && !said_rerun && breakable && comm->me == 0)
    error->warning(FLERR,
                   "Rerun: bonds break where a snapshot shows them beyond their critical stretch; "
                   "those that broke between snapshots and closed again hold");
  said_rerun = again;
  solids_inits = count;
}

/* ----------------------------------------------------------------------
   a horizon that dwarfs the box is a wrong unit, and more ghosts than LAMMPS can count
------------------------------------------------------------------------- */

void FixPeridemBonds::check_unit(double horizon) const
{
  const double box = MAX(MAX(domain->xprd, domain->yprd), domain->zprd);
  if (horizon > DWARFS * box)
    error->all(
        FLERR, Error::NOLASTLINE,
        "The horizon is {:.6g} and the box only {:.6g} long: is that the right unit of length?",
        horizon, box);
}

/* ----------------------------------------------------------------------
   the solids among the pair styles in use
------------------------------------------------------------------------- */

void FixPeridemBonds::find_solids()
{
  solids = PairPeridem::find_all(lmp);
  if (solids.empty() && comm->me == 0)
    error->warning(FLERR, "Fix {}: no pair style of a peridem solid is defined, so no bonds",
                   style);
}

/* ---------------------------------------------------------------------- */

const PeridemMaterial *FixPeridemBonds::material(int itype, int jtype) const
{
  for (auto *solid : solids)
    if (solid->covers(itype) && solid->covers(jtype)) return &solid->material(itype, jtype);
  return nullptr;
}

/* ----------------------------------------------------------------------
   families and weighted volumes belong to the horizon, influence function and volume scheme they
   were made with
------------------------------------------------------------------------- */

void FixPeridemBonds::check_laws()
{
  if (laws.empty()) return;
  const int ntypes = atom->ntypes;
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const auto *mat = material(i, j);
      if (!mat) continue;
      const auto &law = laws[(i - 1) * ntypes + j - 1];
      if (law.horizon == 0.0) continue;    // this pair had no material when families were built
      if (law.horizon != mat->horizon || law.cell != mat->cell || law.volume != mat->volume ||
          !(law.influence == mat->influence))
        error->all(FLERR, Error::NOLASTLINE,
                   "Families of types {} {} were built with horizon {:.8g}: horizon (now {:.8g}), "
                   "influence and volume cannot change afterwards, unless fix {} is made anew "
                   "(unfix {})",
                   i, j, law.horizon, mat->horizon, style, id);
    }
}

/* ----------------------------------------------------------------------
   every partner of an owned node must be owned or a ghost
------------------------------------------------------------------------- */

void FixPeridemBonds::require_ghost_cutoff(double need, bool at_init)
{
  if (comm->mode != Comm::SINGLE)
    error->all(FLERR, Error::NOLASTLINE, "Fix {} needs comm_modify mode single", style);

  // a smaller cutoff that somebody asked for is an error, not something to be overruled

  const double have = comm->cutghostuser;
  if (at_init && have > 0.0 && have != cutghost_set && have < need)
    error->all(FLERR, Error::NOLASTLINE,
               "Ghost cutoff too small: comm_modify cutoff is {:.8g}, bonds need {:.8g}", have,
               need);
  if (have >= need) return;

  comm->cutghostuser = cutghost_set = need;
  if (comm->me == 0)
    utils::logmesg(lmp, "PERIDEM: ghost cutoff set to {:.6g}, which the longest bonds need\n",
                   need);
}

/* ----------------------------------------------------------------------
   a time step that somebody chose by hand may be too long
------------------------------------------------------------------------- */

void FixPeridemBonds::setup(int)
{
  if (update->whichflag != 1 || modify->get_fix_by_style("^peridem/timestep$").size()) return;
  const auto limits = stability.find();
  const bool levels = limits.bond_count * limits.contact_count > 1;
  if (update->dt > limits.stable && comm->me == 0)
    error->warning(
        FLERR,
        "The time step {:.4g} is longer than the largest stable one, {:.4g} (bonds alone "
        "{:.4g}, contacts alone {:.4g}{}): use fix peridem/timestep or a smaller timestep",
        update->dt, limits.stable, limits.bonds, limits.contacts,
        levels ? fmt::format(", at levels with {} and {} steps in it", limits.bond_count,
                             limits.contact_count)
               : "");
  else if (update->dt > limits.speeds && comm->me == 0)
    error->warning(
        FLERR,
        "The fastest node moves {:.2g} of the contact distance in one step: contacts may "
        "gain energy or be jumped over; use fix peridem/timestep or a timestep of {:.4g}",
        PeridemStability::TRAVEL * update->dt / limits.speeds, limits.speeds);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::setup_pre_exchange()
{
  reconcile();
  build_if_new_nodes();
}

/* ----------------------------------------------------------------------
   before nodes migrate: local indices are still those of the last steps
------------------------------------------------------------------------- */

void FixPeridemBonds::pre_exchange()
{
  reconcile();
  if (!domain->triclinic) check_box();
  measure_bonds();
  const double have = MAX(comm->cutghostuser, neighbor->cutneighmax);
  if (longest * STEP_MARGIN > have) {
    require_ghost_cutoff(longest * GROWTH, false);
    comm->setup();
    if (neighbor->style) neighbor->setup_bins();
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::measure_bonds()
{
  double **x = atom->x;
  double rsqmax = 0.0, least = 1.0;    // least: squared length over that in the reference
  int least_i = -1, least_j = -1;
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = start[i]; k < start[i] + num[i]; k++) {
      const double *xj = x[partner[k]];
      const double dx = xj[0] - x[i][0], dy = xj[1] - x[i][1], dz = xj[2] - x[i][2];
      const double rsq = dx * dx + dy * dy + dz * dz;
      rsqmax = MAX(rsqmax, rsq);
      if (rsq < least * length[k] * length[k]) {
        least = rsq / (length[k] * length[k]);
        least_i = i;
        least_j = partner[k];
      }
    }
  const double mine[2] = {std::sqrt(rsqmax), -std::sqrt(least)};
  double all[2];
  MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_MAX, world);
  longest = all[0];
  if (-all[1] < CRUSHED && !said_compressed)
    say_compressed(-all[1], mine[1] == all[1] ? least_i : -1, least_j);
}

/* ----------------------------------------------------------------------
   once per run; i < 0 on ranks that do not own the shortest bond
------------------------------------------------------------------------- */

void FixPeridemBonds::say_compressed(double shortest, int i, int j)
{
  said_compressed = true;
  const tagint *const tag = atom->tag;
  tagint who[3] = {0, 0, 0}, all[3];
  if (i >= 0) {
    who[0] = MIN(tag[i], tag[j]);
    who[1] = MAX(tag[i], tag[j]);
    who[2] = atom->molecule[i];
  }
  MPI_Allreduce(who, all, 3, MPI_LMP_TAGINT, MPI_MAX, world);
  if (comm->me == 0)
    error->warning(
        FLERR,
        "Bonds are compressed to {:.3g} of their length (nodes {} and {} of grain {}): "
        "bonded nodes do not touch, so they may pass through each other; use break both, "
        "a stiffer solid or a smaller load",
        shortest, all[0], all[1], all[2]);
}

/* ----------------------------------------------------------------------
   nodes beyond a fixed face are about to be lost, and bonds to them would be missed first
------------------------------------------------------------------------- */

void FixPeridemBonds::check_box() const
{
  constexpr int FIXED = 1;
  bigint out = 0, out_all;
  tagint first = MAXTAGINT, first_all;
  for (int i = 0; i < atom->nlocal; i++) {
    if (num[i] <= 0) continue;
    bool left = false;
    for (int k = 0; k < domain->dimension; k++) {
      const double x = atom->x[i][k];
      left = left || (domain->boundary[k][0] == FIXED && x < domain->boxlo[k]) ||
          (domain->boundary[k][1] == FIXED && x > domain->boxhi[k]);
    }
    if (!left) continue;
    out++;
    first = MIN(first, atom->tag[i]);
  }
  MPI_Allreduce(&out, &out_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (out_all == 0) return;
  MPI_Allreduce(&first, &first_all, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  error->all(
      FLERR, Error::NOLASTLINE,
      "{} bonded nodes have left the box through a fixed boundary (the first is atom-ID {}): "
      "make the box larger, or use boundary s or m",
      out_all, first_all);
}

/* ----------------------------------------------------------------------
   Both ends see a bond with the same stretch, so both break it; only across a periodic boundary
   may the last digit differ. What one rank has broken, the rank that owns the other end breaks
   too, at the latest here.
------------------------------------------------------------------------- */

void FixPeridemBonds::reconcile()
{
  int mine = static_cast<int>(told.size()), any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (any == 0) return;

  std::vector<tagint> send;
  send.reserve(2 * told.size());
  for (const auto &pair : told) {
    send.push_back(pair.first);
    send.push_back(pair.second);
  }
  const auto all = gather(send);
  for (std::size_t m = 0; m < all.size(); m += 2) {
    const int j = atom->map(all[m + 1]);
    if (j >= 0 && j < atom->nlocal) remove_row_entry(j, all[m]);
  }
  told.clear();
}

/* ----------------------------------------------------------------------
   the lists of all ranks, one after the other
------------------------------------------------------------------------- */

std::vector<tagint> FixPeridemBonds::gather(const std::vector<tagint> &list) const
{
  const int nprocs = comm->nprocs, mine = static_cast<int>(list.size());
  std::vector<int> counts(nprocs), displs(nprocs, 0);
  MPI_Allgather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int p = 1; p < nprocs; p++) displs[p] = displs[p - 1] + counts[p - 1];
  std::vector<tagint> all(displs.back() + counts.back());
  MPI_Allgatherv(list.data(), mine, MPI_LMP_TAGINT, all.data(), counts.data(), displs.data(),
                 MPI_LMP_TAGINT, world);
  return all;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::remove_row_entry(int i, tagint jtag)
{
  for (bigint k = start[i]; k < start[i] + num[i]; k++)
    if (ptag[k] == jtag) {
      break_bond(i, k);
      return;
    }
}

/* ---------------------------------------------------------------------- */

double FixPeridemBonds::stretch(const double *xi, const double *xj, double R)
{
  const double dx = xj[0] - xi[0], dy = xj[1] - xi[1], dz = xj[2] - xi[2];
  return (std::sqrt(dx * dx + dy * dy + dz * dz) - R) / R;
}

/* ----------------------------------------------------------------------
   take bond k out of the row of node i; the rest keeps its order
------------------------------------------------------------------------- */

void FixPeridemBonds::break_bond(int i, bigint k)
{
  const int j = partner[k];
  broken.push_back({i, j});
  if (j >= atom->nlocal) told.emplace_back(atom->tag[i], ptag[k]);
  erase_bond(i, k);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::erase_bond(int i, bigint k)
{
  const bigint last = start[i] + num[i] - 1;
  for (bigint m = k; m < last; m++) {
    ptag[m] = ptag[m + 1];
    partner[m] = partner[m + 1];
    length[m] = length[m + 1];
    weight[m] = weight[m + 1];
  }
  num[i]--;
}

/* ---------------------------------------------------------------------- */

bool FixPeridemBonds::bonded(int i, tagint jtag) const
{
  if (num[i] <= 0) return false;
  const auto row = ptag.begin() + start[i];
  return std::binary_search(row, row + num[i], jtag);
}

/* ----------------------------------------------------------------------
   sum of v_ij V_j over the bonds that hold
------------------------------------------------------------------------- */

double FixPeridemBonds::intact_volume(int i) const
{
  const int *const type = atom->type;
  double sum = 0.0;
  for (bigint k = start[i]; k < start[i] + num[i]; k++) {
    const int j = partner[k];
    const auto *mat = material(type[i], type[j]);
    const double h = mat->cell > 0.0 ? mat->cell : 0.5 * (cell_size(i) + cell_size(j));
    sum += mat->volume_factor(length[k], h) * atom->vfrac[j];
  }
  return sum;
}

/* ---------------------------------------------------------------------- */

double FixPeridemBonds::cell_size(int i) const
{
  return std::pow(atom->vfrac[i], 1.0 / domain->dimension);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::setup_post_neighbor()
{
  drop_deleted();
  post_neighbor();
}

/* ----------------------------------------------------------------------
   delete_atoms numbers nodes anew unless told not to, and asks no fix; bonds and the memory of
   contacts go by the old IDs.  Nodes that came afterwards get IDs behind all others.
------------------------------------------------------------------------- */

void FixPeridemBonds::give_ids_back()
{
  tagint *const tag = atom->tag;
  int mine = 0, any;
  for (int i = 0; i < atom->nlocal; i++)
    if (known_id[i] && known_id[i] != tag[i]) mine = 1;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;
  std::copy(known_id, known_id + atom->nlocal, tag);
  atom->tag_extend();
  atom->nghost = 0;
  atom->map_init();
  atom->map_set();
  if (comm->me == 0)
    error->warning(FLERR,
                   "Bonds go by atom-IDs, and delete_atoms has numbered the nodes anew: they have "
                   "their IDs back; say delete_atoms ... compress no");
}

/* ----------------------------------------------------------------------
   bonds to nodes that delete_atoms has taken away count as broken
------------------------------------------------------------------------- */

void FixPeridemBonds::drop_deleted()
{
  std::vector<tagint> missing;
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = start[i]; k < start[i] + num[i]; k++)
      if (atom->map(ptag[k]) < 0) missing.push_back(ptag[k]);
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());

  const auto all = gather(missing);
  std::vector<int> exists(all.size(), 0);
  for (std::size_t m = 0; m < all.size(); m++) {
    const int j = atom->map(all[m]);
    exists[m] = j >= 0 && j < atom->nlocal;
  }
  MPI_Allreduce(MPI_IN_PLACE, exists.data(), static_cast<int>(exists.size()), MPI_INT, MPI_MAX,
                world);
  std::set<tagint> deleted;
  for (std::size_t m = 0; m < all.size(); m++)
    if (!exists[m]) deleted.insert(all[m]);

  bigint dropped = 0, dropped_all;
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = start[i]; k < start[i] + num[i];)
      if (deleted.count(ptag[k])) {
        erase_bond(i, k);
        dropped++;
      } else
        k++;
  MPI_Allreduce(&dropped, &dropped_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (dropped_all && comm->me == 0)
    error->warning(FLERR, "{} bonds to {} deleted nodes count as broken", dropped_all,
                   deleted.size());
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::post_neighbor()
{
  build_if_new_nodes();
  build_local();
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::build_if_new_nodes()
{
  if (atom->natoms == natoms_seen) return;
  natoms_seen = atom->natoms;
  int mine = 0, any;
  for (int i = 0; i < atom->nlocal; i++)
    if (num[i] < 0) mine = 1;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (any) build_families();
}

/* ----------------------------------------------------------------------
   families of all nodes that have none, from reference positions
   nodes of one grain that all came at the same time find each other
------------------------------------------------------------------------- */

void FixPeridemBonds::build_families()
{
  const int *const type = atom->type;
  const int ntypes = atom->ntypes;
  laws.assign(static_cast<std::size_t>(ntypes) * ntypes, {0.0, 0.0, {}, 0});
  double reach = 0.0;
  for (int i = 1; i <= ntypes; i++)
    for (int j = 1; j <= ntypes; j++)
      if (const auto *mat = material(i, j)) {
        reach = MAX(reach, mat->horizon * (1.0 + 2.0 * PeridemFamilies::SLACK));
        laws[(i - 1) * ntypes + j - 1] = {mat->horizon, mat->cell, mat->influence, mat->volume};
      }
  if (reach == 0.0) return;

  std::vector<int> fresh;
  for (int i = 0; i < atom->nlocal; i++)
    if (num[i] < 0) {
      start[i] = static_cast<bigint>(ptag.size());
      num[i] = nref[i] = 0;
      wvolume[i] = famvolume[i] = maxstretch[i] = 0.0;
      if (material(type[i], type[i]) && atom->molecule[i] != 0 && (atom->mask[i] & groupbit))
        fresh.push_back(i);
    }

  cuts.init();
  PeridemFamilies finder(
      lmp,
      [this](int itype, int jtype) {
        return material(itype, jtype);
      },
      cuts, reach);
  for (const auto &family : finder.build(fresh)) {
    const int i = family.node;
    start[i] = static_cast<bigint>(ptag.size());
    nref[i] = family.reference;
    num[i] = static_cast<int>(family.bonds.size());
    wvolume[i] = family.wvolume;
    famvolume[i] = family.volume;
    for (const auto &bond : family.bonds) {
      ptag.push_back(bond.tag);
      length.push_back(bond.length);
      partner.push_back(-1);
      weight.push_back(0.0);
    }
  }

  // the pool has grown by doubling: give back what it does not need

  ptag.shrink_to_fit();
  length.shrink_to_fit();
  weight.shrink_to_fit();
  partner.shrink_to_fit();

  longest = MAX(longest, finder.longest());
  require_ghost_cutoff(finder.longest() * (1.0 + 2.0 * PeridemFamilies::SLACK), false);
  check_families(fresh);
  weights_stale = true;
}

/* ----------------------------------------------------------------------
   number of these nodes in each grain, over all ranks; grain IDs may be as large as they like
------------------------------------------------------------------------- */

std::map<tagint, bigint> FixPeridemBonds::grain_sizes(const std::vector<int> &nodes) const
{
  std::map<tagint, bigint> mine;
  for (int i : nodes) mine[atom->molecule[i]]++;
  std::vector<tagint> list;
  for (const auto &grain : mine) {
    list.push_back(grain.first);
    list.push_back(static_cast<tagint>(grain.second));
  }
  const auto all = gather(list);
  std::map<tagint, bigint> sizes;
  for (std::size_t m = 0; m < all.size(); m += 2) sizes[all[m]] += all[m + 1];
  return sizes;
}

/* ----------------------------------------------------------------------
   say what was built; a node of a larger grain without a family is a mistake in the input
------------------------------------------------------------------------- */

void FixPeridemBonds::check_families(const std::vector<int> &fresh)
{
  const tagint *const mol = atom->molecule;
  const auto size = grain_sizes(fresh);

  bigint sums[4] = {0, 0, 0, 0};    // nodes, bonds, lonely nodes of grains with others, cut bonds
  int extremes[2] = {-MAXSMALLINT, 0};
  tagint first_lonely = MAXTAGINT;
  for (int i : fresh) {
    sums[0]++;
    sums[1] += nref[i];
    sums[3] += nref[i] - num[i];
    extremes[0] = MAX(extremes[0], -nref[i]);
    extremes[1] = MAX(extremes[1], nref[i]);
    if (nref[i] == 0 && size.at(mol[i]) > 1) {
      sums[2]++;
      first_lonely = MIN(first_lonely, atom->tag[i]);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, extremes, 2, MPI_INT, MPI_MAX, world);
  MPI_Allreduce(MPI_IN_PLACE, &first_lonely, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  max_family = MAX(max_family, extremes[1]);

  if (sums[2])
    error->all(
        FLERR, Error::NOLASTLINE,
        "{} nodes have no other node of their grain within the horizon (the first is atom-ID "
        "{}): the horizon must be larger than the node spacing, usually 3 times",
        sums[2], first_lonely);
  if (comm->me == 0 && sums[0]) {
    utils::logmesg(
        lmp,
        "PERIDEM: {} nodes in {} grains, {} bonds; families of {} to {} nodes, {:.1f} on "
        "average\n",
        sums[0], size.size(), sums[1] / 2, -extremes[0], extremes[1],
        static_cast<double>(sums[1]) / sums[0]);
    if (!cuts.empty())
      utils::logmesg(lmp, "PERIDEM: {} bonds are cut from the start\n", sums[3] / 2);
  }
}

/* ----------------------------------------------------------------------
   turn partner IDs into local indices, in a pool that follows the order of the nodes
------------------------------------------------------------------------- */

void FixPeridemBonds::build_local()
{
  const int nlocal = atom->nlocal;
  bigint total = 0;
  int longest_row = 0;
  bool in_order = true;
  for (int i = 0; i < nlocal; i++) {
    if (num[i] <= 0) start[i] = total;    // without a solid nodes have no families: num is -1
    in_order = in_order && start[i] == total;
    total += MAX(num[i], 0);
    longest_row = MAX(longest_row, num[i]);
  }
  in_order = in_order && total == static_cast<bigint>(ptag.size());

  if (!in_order) {
    std::vector<tagint> new_ptag(total);
    std::vector<double> new_length(total), new_weight(total);
    bigint at = 0;
    for (int i = 0; i < nlocal; i++) {
      if (num[i] <= 0) continue;
      std::copy_n(ptag.begin() + start[i], num[i], new_ptag.begin() + at);
      std::copy_n(length.begin() + start[i], num[i], new_length.begin() + at);
      std::copy_n(weight.begin() + start[i], num[i], new_weight.begin() + at);
      start[i] = at;
      at += num[i];
    }
    ptag.swap(new_ptag);
    length.swap(new_length);
    weight.swap(new_weight);
    partner.resize(total);
  }

  std::copy(atom->tag, atom->tag + atom->nlocal, known_id);
  map_partners();
  if (weights_stale) compute_weights();
  weights_stale = false;
  comm->forward_comm(this);
  broken.clear();
  maxexchange = 7 + 3 * longest_row;
  version++;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::map_partners()
{
  const bool periodic = domain->xperiodic || domain->yperiodic ||
      (domain->dimension == 3 && domain->zperiodic);
  const int *const type = atom->type;
  const tagint *const molecule = atom->molecule;
  mixed.assign(atom->nlocal, 0);
  for (int i = 0; i < atom->nlocal; i++) {
    for (bigint k = start[i]; k < start[i] + num[i]; k++) {
      int j = atom->map(ptag[k]);
      if (j < 0) lost_partner(i, ptag[k]);
      if (periodic) j = domain->closest_image(i, j);
      partner[k] = j;
      if (type[j] != type[i]) mixed[i] = 1;
      if (molecule[j] != molecule[i])
        error->one(FLERR,
                   "Nodes {} and {} are bonded, but now they are of grains {} and {}: molecule-IDs "
                   "cannot change while bonds hold",
                   atom->tag[i], atom->tag[j], molecule[i], molecule[j]);
    }
  }
  flag_rigid();
}

/* ---------------------------------------------------------------------- */

bool FixPeridemBonds::moves_rigidly(int i) const
{
  return (atom->mask[i] & rigid_bits) || (adapt && adapt->rigid(i));
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::flag_rigid()
{
  rigid.assign(atom->nlocal, 0);
  for (int i = 0; i < atom->nlocal; i++) {
    rigid[i] = moves_rigidly(i);
    for (bigint k = start[i]; rigid[i] && k < start[i] + num[i]; k++)
      rigid[i] = moves_rigidly(partner[k]);
  }
  version++;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::lost_partner(int i, tagint jtag)
{
  error->one(
      FLERR,
      "Node {} of grain {} is bonded to node {}, which is neither on this rank nor among its "
      "ghosts: it was deleted or lost, or moved further than the ghost cutoff {:.6g} "
      "(comm_modify cutoff), as when the time step is unstable",
      atom->tag[i], atom->molecule[i], jtag, MAX(comm->cutghostuser, neighbor->cutneighmax));
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::compute_weights()
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost;
  const int *const type = atom->type;
  const double *const V = atom->vfrac;

  cellsize.resize(nall);
  for (int i = 0; i < nall; i++) cellsize[i] = cell_size(i);

  for (int i = 0; i < nlocal; i++) {
    double m = 0.0;
    for (bigint k = start[i]; k < start[i] + num[i]; k++) {
      const int j = partner[k];
      const auto *mat = material(type[i], type[j]);
      if (!mat)
        error->one(FLERR, "Nodes {} and {} are bonded, but no pair_coeff covers types {} and {}",
                   atom->tag[i], atom->tag[j], type[i], type[j]);
      const double R = length[k];
      const double h = mat->cell > 0.0 ? mat->cell : 0.5 * (cellsize[i] + cellsize[j]);
      weight[k] = mat->influence(R / mat->horizon) * mat->volume_factor(R, h) * (V[i] * V[j]);
      m += weight[k] * R * R;
    }
    if (num[i] == nref[i] && std::fabs(m / V[i] - wvolume[i]) > CHANGED * wvolume[i])
      error->one(
          FLERR,
          "Volumes or types of node {} or of its family have changed since the families were "
          "built: they cannot, unless fix {} is made anew (unfix {})",
          atom->tag[i], style, id);
  }
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  for (int m = 0; m < n; m++) buf[m] = wvolume[list[m]];
  return n;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::unpack_forward_comm(int n, int first, double *buf)
{
  for (int m = 0; m < n; m++) wvolume[first + m] = buf[m];
}

/* ----------------------------------------------------------------------
   1 = intact bonds, 2 = broken bonds, 3 = length of the longest bond at the last reneighbouring
------------------------------------------------------------------------- */

double FixPeridemBonds::compute_vector(int n)
{
  if (n == 2) return longest;
  bigint mine = 0, all;
  for (int i = 0; i < atom->nlocal; i++)
    if (num[i] >= 0) mine += (n == 0) ? num[i] : nref[i] - num[i];
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  return 0.5 * static_cast<double>(all);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::grow_arrays(int nmax)
{
  memory->grow(start, nmax, "peridem/bonds:start");
  memory->grow(num, nmax, "peridem/bonds:num");
  memory->grow(nref, nmax, "peridem/bonds:nref");
  memory->grow(wvolume, nmax, "peridem/bonds:wvolume");
  memory->grow(famvolume, nmax, "peridem/bonds:famvolume");
  memory->grow(maxstretch, nmax, "peridem/bonds:maxstretch");
  memory->grow(known_id, nmax, "peridem/bonds:known_id");
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::set_arrays(int i)
{
  start[i] = 0;
  num[i] = -1;
  nref[i] = 0;
  wvolume[i] = famvolume[i] = maxstretch[i] = 0.0;
  known_id[i] = 0;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::copy_arrays(int i, int j, int)
{
  start[j] = start[i];
  num[j] = num[i];
  nref[j] = nref[i];
  wvolume[j] = wvolume[i];
  famvolume[j] = famvolume[i];
  maxstretch[j] = maxstretch[i];
  known_id[j] = known_id[i];
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::pack_exchange(int i, double *buf)
{
  int m = 0;
  buf[m++] = ubuf(num[i]).d;
  buf[m++] = ubuf(nref[i]).d;
  buf[m++] = wvolume[i];
  buf[m++] = famvolume[i];
  buf[m++] = maxstretch[i];
  buf[m++] = ubuf(known_id[i]).d;
  for (bigint k = start[i]; k < start[i] + num[i]; k++) {
    buf[m++] = ubuf(ptag[k]).d;
    buf[m++] = length[k];
    buf[m++] = weight[k];
  }
  return m;
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::unpack_exchange(int i, double *buf)
{
  int m = 0;
  num[i] = (int) ubuf(buf[m++]).i;
  nref[i] = (int) ubuf(buf[m++]).i;
  wvolume[i] = buf[m++];
  famvolume[i] = buf[m++];
  maxstretch[i] = buf[m++];
  known_id[i] = (tagint) ubuf(buf[m++]).i;
  start[i] = static_cast<bigint>(ptag.size());
  for (int k = 0; k < num[i]; k++) {
    ptag.push_back((tagint) ubuf(buf[m++]).i);
    length.push_back(buf[m++]);
    weight.push_back(buf[m++]);
    partner.push_back(-1);
  }
  return m;
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::size_restart(int i)
{
  return 7 + 2 * MAX(num[i], 0);
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::maxsize_restart()
{
  return 7 + 2 * max_family;
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::pack_restart(int i, double *buf)
{
  int m = 0;
  buf[m++] = size_restart(i);
  buf[m++] = ubuf(num[i]).d;
  buf[m++] = ubuf(nref[i]).d;
  buf[m++] = wvolume[i];
  buf[m++] = famvolume[i];
  buf[m++] = maxstretch[i];
  buf[m++] = ubuf(known_id[i]).d;
  for (bigint k = start[i]; k < start[i] + num[i]; k++) {
    buf[m++] = ubuf(ptag[k]).d;
    buf[m++] = length[k];
  }
  return m;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::unpack_restart(int i, int nth)
{
  double *buf = atom->extra[i];
  int m = 0;
  for (int k = 0; k < nth; k++) m += static_cast<int>(buf[m]);
  m++;
  num[i] = (int) ubuf(buf[m++]).i;
  nref[i] = (int) ubuf(buf[m++]).i;
  wvolume[i] = buf[m++];
  famvolume[i] = buf[m++];
  maxstretch[i] = buf[m++];
  known_id[i] = (tagint) ubuf(buf[m++]).i;
  start[i] = static_cast<bigint>(ptag.size());
  for (int k = 0; k < num[i]; k++) {
    ptag.push_back((tagint) ubuf(buf[m++]).i);
    length.push_back(buf[m++]);
    weight.push_back(0.0);
    partner.push_back(-1);
  }
}

/* ----------------------------------------------------------------------
   global state: longest row, longest bond, ghost cutoff asked for, what families were built from
------------------------------------------------------------------------- */

void FixPeridemBonds::write_restart(FILE *fp)
{
  if (comm->me) return;
  std::vector<double> list = {static_cast<double>(max_family), longest, cutghost_set,
                              static_cast<double>(laws.size())};
  for (const auto &law : laws) {
    list.insert(list.end(),
                {law.horizon, law.cell, static_cast<double>(law.influence.kind),
                 law.influence.width, static_cast<double>(law.volume)});
  }
  const int size = static_cast<int>(list.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(list.data(), sizeof(double), list.size(), fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::restart(char *buf)
{
  const auto *list = reinterpret_cast<double *>(buf);
  max_family = static_cast<int>(*list++);
  longest = *list++;
  cutghost_set = *list++;
  laws.resize(static_cast<std::size_t>(*list++));
  for (auto &law : laws) {
    law.horizon = *list++;
    law.cell = *list++;
    law.influence.kind = static_cast<int>(*list++);
    law.influence.width = *list++;
    law.volume = static_cast<int>(*list++);
  }
}

/* ---------------------------------------------------------------------- */

double FixPeridemBonds::memory_usage()
{
  double bytes = static_cast<double>(atom->nmax) *
      (sizeof(bigint) + 2 * sizeof(int) + 3 * sizeof(double) + sizeof(tagint));
  bytes += static_cast<double>(ptag.capacity()) * sizeof(tagint);
  bytes += static_cast<double>(partner.capacity()) * sizeof(int);
  bytes += static_cast<double>(length.capacity() + weight.capacity()) * sizeof(double);
  return bytes;
}

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
#include "peridem_deleted.h"
#include "peridem_families.h"
#include "peridem_messages.h"
#include "peridem_stamp.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "neighbor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

using namespace LAMMPS_NS;
using namespace FixConst;

// times the longest edge of the box: no grain is larger than that
static constexpr double DWARFS = 1000.0;

// positions that decide on the ghost cutoff may be one step old
static constexpr double STEP_MARGIN = 1.02;

// when bonds outgrow the ghost cutoff, it grows by this factor beyond them
static constexpr double GROWTH = 1.25;

// part of a period within which a node has no nearer image
static constexpr double PART_OF_PERIOD = 0.4;
static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// relative difference of weighted volumes that is not rounding
static constexpr double CHANGED = 1.0e-9;

/* ---------------------------------------------------------------------- */

FixPeridemBonds::FixPeridemBonds(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), PeridemRows(lmp->memory), watch(lmp), laws(lmp), cuts(lmp)
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
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::setmask()
{
  return PRE_EXCHANGE | POST_NEIGHBOR | MIN_PRE_EXCHANGE | MIN_POST_NEIGHBOR;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::init()
{
  PeridemDeleted(lmp).give_ids_back(*this);
  find_solids();
  watch.init(solids);
  check_order();
  find_rigid_bodies();
  laws.check(*this, atom->ntypes, [this](int itype, int jtype) {
    return material(itype, jtype);
  });
  periodic = domain->xperiodic || domain->yperiodic ||
      (domain->dimension == 3 && domain->zperiodic);
  volumes_checked = false;
  natoms_seen = -1;
  seen = {};

  double need = longest_reference();
  check_unit(need);
  if (longest > 0.0) need = MAX(need, longest + MIN(neighbor->skin, longest));
  require_ghost_cutoff(need, true);
  check_periods(need);
}

/* ----------------------------------------------------------------------
   what happens before nodes migrate must happen before any other fix migrates them
------------------------------------------------------------------------- */

void FixPeridemBonds::check_order() const
{
  for (const auto *fix : modify->get_fix_list()) {
    if (fix == this) break;
    if (fix->pre_exchange_migrate)
      error->all(FLERR, Error::NOLASTLINE, "Fix {} {} must be defined before fix {} {}", id, style,
                 fix->id, fix->style);
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::find_rigid_bodies()
{
  rigid_bits = 0;
  for (const auto *fix : modify->get_fix_list())
    if (fix->rigid_flag) rigid_bits |= fix->groupbit;
  const auto adapts = modify->get_fix_by_style("^peridem/adapt$");
  adapt = adapts.empty() ? nullptr : dynamic_cast<const FixPeridemAdapt *>(adapts[0]);
}

/* ----------------------------------------------------------------------
   a partner must have one closest image
------------------------------------------------------------------------- */

void FixPeridemBonds::check_periods(double bond) const
{
  if (domain->triclinic) return;
  for (int k = 0; k < domain->dimension; k++)
    if (domain->periodicity[k] && domain->prd[k] < 2.0 * bond)
      error->all(
          FLERR, Error::NOLASTLINE,
          "Periodic box is {:.6g} long in {}: it must be at least twice the longest bond, {:.6g}",
          domain->prd[k], "xyz"[k], bond);
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

  const int ntypes = atom->ntypes;
  store_all = false;
  materials.assign((ntypes + 1) * (ntypes + 1), nullptr);
  for (const auto *solid : solids) {
    store_all = store_all || solid->reads_rows();
    for (int i = 1; i <= ntypes; i++)
      for (int j = 1; j <= ntypes; j++)
        if (auto &one = materials[i * (ntypes + 1) + j];
            !one && solid->covers(i) && solid->covers(j))
          one = &solid->material(i, j);
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

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::setup(int)
{
  watch.look_at_time_step();
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::setup_pre_exchange()
{
  drop_stored();
  reconcile();
  build_if_new_nodes();
}

/* ----------------------------------------------------------------------
   before nodes migrate: local indices are still those of the last steps
------------------------------------------------------------------------- */

void FixPeridemBonds::pre_exchange()
{
  reconcile();
  if (!domain->triclinic) watch.look_at_box(*this);
  longest = watch.longest_bond(*this);
  const double have = MAX(comm->cutghostuser, neighbor->cutneighmax);
  if (longest * STEP_MARGIN > have) {
    require_ghost_cutoff(longest * GROWTH, false);
    comm->setup();
    if (neighbor->style) neighbor->setup_bins();
  }
  drop_stored();
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
  const auto all = PeridemMessages::gather(world, send);
  for (std::size_t m = 0; m < all.size(); m += 2) {
    const int j = atom->map(all[m + 1]);
    if (j >= 0 && j < atom->nlocal) remove_row_entry(j, all[m]);
  }
  told.clear();
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
  const int j = partner(i, k);
  broken.push_back({i, j});
  if (j >= atom->nlocal) told.emplace_back(atom->tag[i], ptag[k]);
  erase_bond(i, k);
}

/* ----------------------------------------------------------------------
   sum of v_ij V_j over the bonds that hold
------------------------------------------------------------------------- */

double FixPeridemBonds::intact_volume(int i) const
{
  const int *const type = atom->type;
  double sum = 0.0;
  for (bigint k = start[i]; k < start[i] + num[i]; k++) {
    const int j = atom->map(ptag[k]);
    const auto &mat = *material(type[i], type[j]);
    sum += mat.volume_factor(length[k], cell_size(mat, i, j)) * atom->vfrac[j];
  }
  return sum;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::setup_post_neighbor()
{
  PeridemDeleted(lmp).drop_bonds(*this);
  post_neighbor();
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
  const auto material_of = [this](int itype, int jtype) {
    return material(itype, jtype);
  };
  laws.note(atom->ntypes, material_of);
  const double reach = longest_reference();
  if (reach == 0.0) return;

  const auto fresh = nodes_without_family();
  cuts.init();
  const double longest_now = enter_families(fresh, reach, material_of);
  longest = MAX(longest, longest_now);
  check_families(fresh);
  volumes_checked = false;
}

/* ----------------------------------------------------------------------
   returns the longest bond of all ranks; what found them goes as they are entered
------------------------------------------------------------------------- */

double FixPeridemBonds::enter_families(const std::vector<int> &fresh, double reach,
                                       const PeridemFamilies::MaterialOf &material_of)
{
  PeridemFamilies finder(lmp, material_of, cuts, reach);
  finder.build(fresh);
  const double longest_now = finder.longest();
  reserve_pool(finder.bonds());
  finder.hand_over([this](const PeridemFamilies::Family &family) {
    const int i = family.node;
    start[i] = static_cast<bigint>(ptag.size());
    nref[i] = family.reference;
    num[i] = static_cast<int>(family.count);
    wvolume[i] = family.wvolume;
    famvolume[i] = family.volume;
    for (std::size_t k = 0; k < family.count; k++) append(family.tag(k), family.length(k));
  });
  require_ghost_cutoff(longest_now * (1.0 + 2.0 * PeridemFamilies::SLACK), false);
  return longest_now;
}

/* ----------------------------------------------------------------------
   no bond is longer in the reference configuration; 0 if there are none
------------------------------------------------------------------------- */

double FixPeridemBonds::longest_reference() const
{
  double reach = 0.0;
  for (int i = 1; i <= atom->ntypes; i++)
    for (int j = i; j <= atom->ntypes; j++)
      if (const auto *mat = material(i, j))
        reach = MAX(reach, mat->horizon * (1.0 + 2.0 * PeridemFamilies::SLACK));
  return reach;
}

/* ----------------------------------------------------------------------
   they get an empty one; returned are those that a solid, a grain and this fix cover
------------------------------------------------------------------------- */

std::vector<int> FixPeridemBonds::nodes_without_family()
{
  const int *const type = atom->type;
  std::vector<int> fresh;
  for (int i = 0; i < atom->nlocal; i++) {
    if (num[i] >= 0) continue;
    empty_row(i);
    num[i] = 0;
    if (material(type[i], type[i]) && atom->molecule[i] != 0 && (atom->mask[i] & groupbit))
      fresh.push_back(i);
  }
  return fresh;
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
  const auto all = PeridemMessages::gather(world, list);
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
   what the rows mean for nodes where they are now, in a pool that follows the order of the nodes
------------------------------------------------------------------------- */

void FixPeridemBonds::build_local()
{
  maxexchange = 1 + NODE + BOND * longest_row(atom->nlocal);
  std::copy(atom->tag, atom->tag + atom->nlocal, known_id);
  order_pool(atom->nlocal);
  find_cell_sizes();
  find_periods();
  const bool same = same_nodes();
  if (!same) check_partners();
  if (!same || periodic) layout++;    // the nearest image may be another
  if (!volumes_checked) check_volumes();
  volumes_checked = true;
  if (store_all) store();
  flag_rigid();
  comm->forward_comm(this);
  broken.clear();
  version++;
}

/* ----------------------------------------------------------------------
   Are all nodes where they were in the arrays, and no partner but them? Most reneighbourings of a
   rank that has whole grains move none.
------------------------------------------------------------------------- */

bool FixPeridemBonds::same_nodes()
{
  const int nlocal = atom->nlocal;
  auto same = [nlocal](const auto &list, const auto *now) {
    return std::equal(list.begin(), list.end(), now, now + nlocal);
  };
  if (ghost_bonds == 0 && same(seen.ids, atom->tag) && same(seen.grains, atom->molecule) &&
      same(seen.types, atom->type))
    return true;
  seen.ids.assign(atom->tag, atom->tag + nlocal);
  seen.grains.assign(atom->molecule, atom->molecule + nlocal);
  seen.types.assign(atom->type, atom->type + nlocal);
  return false;
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::check_partners()
{
  const PeridemLookup find(atom);
  const int *const type = atom->type;
  const tagint *const molecule = atom->molecule;
  mixed.assign(atom->nlocal, 0);
  ghost_bonds = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    for (bigint k = start[i]; k < start[i] + num[i]; k++) {
      const int j = find(ptag[k]);
      if (j < 0) lost_partner(i, ptag[k]);
      if (j >= atom->nlocal) ghost_bonds++;
      if (type[j] != type[i]) mixed[i] = 1;
      if (!material(type[i], type[j]))
        error->one(FLERR, "Nodes {} and {} are bonded, but no pair_coeff covers types {} and {}",
                   atom->tag[i], atom->tag[j], type[i], type[j]);
      if (molecule[j] != molecule[i])
        error->one(FLERR,
                   "Nodes {} and {} are bonded, but now they are of grains {} and {}: molecule-IDs "
                   "cannot change while bonds hold",
                   atom->tag[i], atom->tag[j], molecule[i], molecule[j]);
    }
  }
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::nearest_image(int i, int j) const
{
  return domain->closest_image(i, j);
}

/* ----------------------------------------------------------------------
   less than half a period of the box as it is now, and as it soon may be
------------------------------------------------------------------------- */

void FixPeridemBonds::find_periods()
{
  for (int k = 0; k < 3; k++) {
    beside_within[k] = domain->periodicity[k] ? PART_OF_PERIOD * domain->prd[k] : INFINITE;
    if (domain->triclinic) beside_within[k] = 0.0;    // periods are not along the axes
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::store()
{
  const PeridemLookup find(atom);
  make_room_for_stored();
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = start[i]; k < start[i] + num[i]; k++) {
      partners[k] = nearest(i, find(ptag[k]));
      weights[k] = bond_weight(i, partners[k], length[k]);
    }
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
    if (adapt && adapt->rigid(i)) continue;    // all of its grain is
    for (bigint k = start[i]; rigid[i] && k < start[i] + num[i]; k++)
      rigid[i] = moves_rigidly(atom->map(ptag[k]));
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

void FixPeridemBonds::find_cell_sizes()
{
  const int nall = atom->nlocal + atom->nghost;
  const double *const V = atom->vfrac;
  cellsize.resize(nall);
  for (int i = 0; i < nall; i++)
    cellsize[i] = domain->dimension == 3 ? std::cbrt(V[i]) : std::sqrt(V[i]);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::check_volumes() const
{
  const PeridemLookup find(atom);
  for (int i = 0; i < atom->nlocal; i++) {
    if (num[i] != nref[i]) continue;
    double m = 0.0;
    for (bigint k = start[i]; k < start[i] + num[i]; k++)
      m += bond_weight(i, find(ptag[k]), length[k]) * length[k] * length[k];
    if (std::fabs(m / atom->vfrac[i] - wvolume[i]) > CHANGED * wvolume[i])
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
  grow_rows(nmax);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::set_arrays(int i)
{
  empty_row(i);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::copy_arrays(int i, int j, int)
{
  copy_row(i, j);
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::pack_exchange(int i, double *buf)
{
  return pack_row(i, buf);
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::unpack_exchange(int i, double *buf)
{
  return unpack_row(i, buf);
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::size_restart(int i)
{
  return 1 + NODE + BOND * MAX(num[i], 0);
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::maxsize_restart()
{
  return 1 + NODE + BOND * max_family;
}

/* ---------------------------------------------------------------------- */

int FixPeridemBonds::pack_restart(int i, double *buf)
{
  buf[0] = size_restart(i);
  return 1 + pack_row(i, buf + 1);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::unpack_restart(int i, int nth)
{
  const double *buf = atom->extra[i];
  for (int k = 0; k < nth; k++) buf += static_cast<int>(*buf);
  unpack_row(i, buf + 1);
}

/* ----------------------------------------------------------------------
   global state: longest row, longest bond, ghost cutoff asked for, what families were built from.
   The stamp is for what nodes have in the file too.
------------------------------------------------------------------------- */

static constexpr PeridemStamp STAMP(1);

void FixPeridemBonds::write_restart(FILE *fp)
{
  if (comm->me) return;
  std::vector<double> list = {STAMP.number, static_cast<double>(max_family), longest, cutghost_set};
  laws.pack(list);
  const int size = static_cast<int>(list.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(list.data(), sizeof(double), list.size(), fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemBonds::restart(char *buf)
{
  const auto *list = reinterpret_cast<double *>(buf);
  STAMP.check(list[0], fmt::format("Fix {}", style), error);
  max_family = static_cast<int>(list[1]);
  longest = list[2];
  cutghost_set = list[3];
  laws.unpack(list + 4);
}

/* ---------------------------------------------------------------------- */

double FixPeridemBonds::memory_usage()
{
  return pool_bytes(atom->nmax) + static_cast<double>(cellsize.capacity() * sizeof(double));
}

/* --------------------------------------------------------------------
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

#include "peridem_batch_plan.h"

#include "fix_peridem_bonds.h"

#include "atom.h"
#include "domain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

using namespace LAMMPS_NS;
using PeridemSimd::Pack;
using PeridemSimd::WIDTH;

// Distances from the centroid that differ by less, as a fraction of the grain's size, belong to one
// shape. Nothing but the choice of neighbours in a batch depends on it.
static constexpr double ALIKE = 1.0e-3;

// One bond in all lanes takes as long as this many in the general engine, counted once each
static constexpr double BREAK_EVEN = 1.5;

// Grains of a batch are copies of each other if the lengths of their bonds differ by a smaller part,
// and their strengths by a smaller part of the largest. What a float loses of such a difference in
// length is less than the rounding of the length; strengths as unlike change forces by 1e-13 of the
// largest.
static constexpr double SAME_LENGTH = 1.0e-9;
static constexpr double SAME_STRENGTH = 1.0e-13;

// With few lanes there is little to save, and masks and rests cost half as many instructions again
// (counted with two lanes).
static constexpr int LEAN_WIDTH = 8;

/* ---------------------------------------------------------------------- */

bool PeridemBatchGroup::drop_bond(int lane, int n, int m)
{
  if (n > m) std::swap(n, m);
  const auto begin = partner.begin() + first[n], end = partner.begin() + first[n + 1];
  const auto at = std::lower_bound(begin, end, m);
  if (at == end || *at != m) return false;
  const auto k = at - partner.begin();
  bool had;
  if (lean) {
    const auto bit = static_cast<unsigned char>(1 << lane);
    had = here[k] & bit;
    here[k] = static_cast<unsigned char>(here[k] & ~bit);
  } else {
    had = PeridemSimd::get(inverse[k], lane) != 0.0;
    PeridemSimd::set(inverse[k], lane, 0.0);
    PeridemSimd::set(strength[k], lane, 0.0);
  }
  if (had) held[lane] -= 2;
  return had;
}

/* ----------------------------------------------------------------------
   Copies of one grain, turned and put elsewhere, differ by rounding: 1/R then is that of the first
   one and a small rest.
------------------------------------------------------------------------- */

void PeridemBatchGroup::make_lean()
{
  if (WIDTH < LEAN_WIDTH) return;
  double largest = 0.0;
  for (const auto &q : strength)
    for (int lane = 0; lane < lanes; lane++) largest = MAX(largest, PeridemSimd::get(q, lane));
  const std::size_t count = partner.size();
  std::vector<int> model(count, 0);    // the first lane with the bond
  for (std::size_t k = 0; k < count; k++) {
    while (PeridemSimd::get(inverse[k], model[k]) == 0.0) model[k]++;
    if (!alike(k, model[k], largest * SAME_STRENGTH)) return;
  }

  lean = true;
  common.resize(count);
  one_strength.resize(count);
  here.assign(count, 0);
  rest.assign(count * WIDTH, 0.0f);
  for (std::size_t k = 0; k < count; k++) {
    common[k] = PeridemSimd::get(inverse[k], model[k]);
    one_strength[k] = PeridemSimd::get(strength[k], model[k]);
    for (int lane = 0; lane < lanes; lane++) {
      const double one = PeridemSimd::get(inverse[k], lane);
      if (one == 0.0) continue;
      here[k] = static_cast<unsigned char>(here[k] | 1 << lane);
      rest[k * WIDTH + lane] = static_cast<float>(one - common[k]);
    }
  }
  std::vector<Pack>().swap(inverse);
  std::vector<Pack>().swap(strength);
}

/* ----------------------------------------------------------------------
   is bond k the same in all grains that have it?
------------------------------------------------------------------------- */

bool PeridemBatchGroup::alike(std::size_t k, int model, double tolerance) const
{
  const double common_one = PeridemSimd::get(inverse[k], model);
  const double q = PeridemSimd::get(strength[k], model);
  for (int lane = 0; lane < lanes; lane++) {
    const double one = PeridemSimd::get(inverse[k], lane);
    if (one == 0.0) continue;
    if (std::fabs(one - common_one) > SAME_LENGTH * common_one) return false;
    if (std::fabs(PeridemSimd::get(strength[k], lane) - q) > tolerance) return false;
  }
  return true;
}

/* ---------------------------------------------------------------------- */

double PeridemBatchGroup::memory_usage() const
{
  const std::size_t packs = inverse.size() + strength.size() + soft.size() + stiff.size() +
      dashpot.size() + sum.size() + most.size();
  return static_cast<double>(
      packs * sizeof(Pack) + (common.size() + one_strength.size()) * sizeof(double) +
      rest.size() * sizeof(float) + here.size() + (index.size() + first.size()) * sizeof(int) +
      ids.size() * sizeof(tagint) + partner.size() * sizeof(unsigned short));
}

/* ---------------------------------------------------------------------- */

double PeridemBatchPlan::memory_usage() const
{
  double bytes = share.memory_usage() +
      static_cast<double>(covered.size() + number.size() * (sizeof(int) + sizeof(Place)));
  for (const auto &group : groups) bytes += group.memory_usage();
  return bytes;
}

/* ---------------------------------------------------------------------- */

bigint PeridemBatchPlan::grains_batched() const
{
  bigint sum = 0;
  for (const auto &group : groups) sum += group.lanes;
  return sum;
}

// ---- nodes, own or borrowed -----------------------------------------------------------------------

tagint PeridemBatchPlan::tag(int i) const
{
  return i < nlocal ? atom->tag[i] : static_cast<tagint>(share.nodes[i - nlocal].tag);
}

/* ---------------------------------------------------------------------- */

int PeridemBatchPlan::type(int i) const
{
  return i < nlocal ? atom->type[i] : static_cast<int>(share.nodes[i - nlocal].type);
}

/* ---------------------------------------------------------------------- */

const double *PeridemBatchPlan::place(int i) const
{
  return i < nlocal ? atom->x[i] : share.nodes[i - nlocal].x;
}

/* ---------------------------------------------------------------------- */

const double *PeridemBatchPlan::reference(int i) const
{
  return i < nlocal ? atom->x0[i] : share.nodes[i - nlocal].X;
}

/* ---------------------------------------------------------------------- */

int PeridemBatchPlan::bond_count(int i) const
{
  if (i < nlocal) return bonds->num[i];
  return static_cast<int>(share.first[i - nlocal + 1] - share.first[i - nlocal]);
}

/* ---------------------------------------------------------------------- */

int PeridemBatchPlan::partner(int i, int k) const
{
  if (i < nlocal) return number_of_tag(bonds->ptag[bonds->start[i] + k]);
  return number_of_tag(static_cast<tagint>(share.rows[share.first[i - nlocal] + k].tag));
}

/* ---------------------------------------------------------------------- */

PeridemBatchPlan::Bond PeridemBatchPlan::bond(int i, int k) const
{
  if (i < nlocal) {
    const bigint at = bonds->start[i] + k;
    return {bonds->length[at], bonds->weight(i, atom->map(bonds->ptag[at]), at)};
  }
  const auto &borrowed = share.rows[share.first[i - nlocal] + k];
  return {borrowed.length, borrowed.weight};
}

/* ---------------------------------------------------------------------- */

int PeridemBatchPlan::number_of(int j) const
{
  return j < nlocal ? number[j] : number_of_tag(atom->tag[j]);
}

/* ---------------------------------------------------------------------- */

int PeridemBatchPlan::number_of_tag(tagint who) const
{
  const int i = atom->map(who);
  if (i >= 0 && i < nlocal) return number[i];
  const int k = share.slot(who);
  return k < 0 ? -1 : number[nlocal + k];
}

/* ---------------------------------------------------------------------- */

bool PeridemBatchPlan::unbroken(int i) const
{
  if (i < nlocal) return atom->mask[i] & bonds->unbroken_bit;
  return share.nodes[i - nlocal].unbroken != 0.0;
}

// ---- choosing ----------------------------------------------------------------------------------------

void PeridemBatchPlan::build(const FixPeridemBonds *_bonds, const std::vector<Law> &laws,
                             const double *_stiffness, const double *_dashpot, bool forced)
{
  bonds = _bonds;
  stiffness = _stiffness;
  dashpot = _dashpot;
  nlocal = atom->nlocal;
  left.fill(0);
  covered.assign(nlocal, 0);
  number.assign(nlocal, -1);
  places.assign(nlocal, {-1, -1});
  keep_groups(forced);

  const auto mine = candidates(laws);
  share.assemble(bonds, mine, stiffness, dashpot);
  const std::size_t count = nlocal + share.nodes.size();
  covered.resize(count, 0);
  number.resize(count, -1);
  places.resize(count, {-1, -1});
  auto grains = find_grains(mine);
  if (share.any()) add_borrowed(grains);

  for (const auto &grain : grains)
    for (std::size_t n = 0; n < grain.nodes.size(); n++)
      number[grain.nodes[n]] = static_cast<int>(n);
  Grains fit;
  for (auto &grain : grains) {
    const int reason = unfit(grain);
    if (reason < NREASONS)
      left[reason]++;
    else
      fit.push_back(std::move(grain));
  }
  if (news(fit))
    dissolve_small(fit);
  else
    leave_loners(fit);
  find_shapes(fit);
  form_groups(fit, laws, forced);
  settle();
}

/* ----------------------------------------------------------------------
   is there a grain that could be batched and has not been left out last time?
------------------------------------------------------------------------- */

bool PeridemBatchPlan::news(const Grains &grains) const
{
  return std::any_of(grains.begin(), grains.end(), [this](const Grain &grain) {
    return !grain.shared &&
        !std::binary_search(loners.begin(), loners.end(), atom->molecule[grain.nodes[0]]);
  });
}

/* ----------------------------------------------------------------------
   grains without company last time have none now: all others are where they were
------------------------------------------------------------------------- */

void PeridemBatchPlan::leave_loners(Grains &grains)
{
  const auto end = std::remove_if(grains.begin(), grains.end(), [](const Grain &grain) {
    return !grain.shared;
  });
  left[FEW] += grains.end() - end;
  grains.erase(end, grains.end());
}

/* ----------------------------------------------------------------------
   groups with free lanes could take in new grains: their grains are up for choice again
------------------------------------------------------------------------- */

void PeridemBatchPlan::dissolve_small(Grains &grains)
{
  loners.clear();
  std::vector<PeridemBatchGroup> full;
  for (auto &group : groups) {
    if (group.lanes == WIDTH) {
      full.push_back(std::move(group));
      continue;
    }
    for (int lane = 0; lane < group.lanes; lane++) {
      Grain grain;
      grain.type = group.type;
      find_lane(group, lane, grain);
      for (const int i : grain.nodes) {
        covered[i] = 0;
        places[i] = {-1, -1};
      }
      grains.push_back(std::move(grain));
    }
  }
  groups.swap(full);
  for (std::size_t g = 0; g < groups.size(); g++) enter(groups[g], g);
}

/* ----------------------------------------------------------------------
   Groups whose grains are still here, with the bonds that they had, need new indices alone: most
   reneighbourings change little.
------------------------------------------------------------------------- */

void PeridemBatchPlan::keep_groups(bool forced)
{
  if (natoms != atom->natoms) groups.clear();
  natoms = atom->natoms;
  std::size_t next = 0;
  for (std::size_t g = 0; g < groups.size(); g++) {
    if (g >= first_shared || !keep(groups[g], forced)) continue;
    if (g != next) groups[next] = std::move(groups[g]);
    enter(groups[next], next);
    next++;
  }
  groups.resize(next);
}

/* ---------------------------------------------------------------------- */

bool PeridemBatchPlan::keep(PeridemBatchGroup &group, bool forced) const
{
  if (!(forced || gains(group))) return false;
  group.shift.clear();
  for (int lane = 0; lane < WIDTH; lane++) {
    Grain grain;
    if (!find_lane(group, lane, grain)) return false;
    put_shift(group, lane, grain);
  }
  return true;
}

/* ---------------------------------------------------------------------- */

bool PeridemBatchPlan::find_lane(PeridemBatchGroup &group, int lane, Grain &grain) const
{
  bigint found = 0;
  for (int n = 0; n < group.nodes; n++) {
    const int at = n * WIDTH + lane, i = atom->map(group.ids[at]);
    if (i < 0 || i >= nlocal || bonds->rigid[i]) return false;
    group.index[at] = i;
    grain.nodes.push_back(i);
    found += bonds->num[i];
  }
  return (lane >= group.lanes || found == group.held[lane]) && unwrap(grain);
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::put_shift(PeridemBatchGroup &group, int lane, const Grain &grain)
{
  if (grain.shift.empty()) return;
  group.shift.resize(3 * group.index.size(), 0.0);
  for (int n = 0; n < group.nodes; n++)
    std::copy_n(&grain.shift[3 * n], 3, &group.shift[3 * (n * WIDTH + lane)]);
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::enter(const PeridemBatchGroup &group, std::size_t place)
{
  for (int n = 0; n < group.nodes; n++)
    for (int lane = 0; lane < group.lanes; lane++) {
      const int i = group.index[n * WIDTH + lane];
      covered[i] = 1;
      number[i] = n;
      places[i] = {static_cast<int>(place), lane};
    }
}

/* ----------------------------------------------------------------------
   is the group faster than the general engine?
------------------------------------------------------------------------- */

bool PeridemBatchPlan::gains(const PeridemBatchGroup &group)
{
  const bigint directed = std::accumulate(group.held.begin(), group.held.end(), bigint{0});
  return 0.5 * static_cast<double>(directed) >=
      BREAK_EVEN * static_cast<double>(group.partner.size());
}

/* ----------------------------------------------------------------------
   nodes in no group yet that have, or had, bonds, by grain and ID
------------------------------------------------------------------------- */

std::vector<int> PeridemBatchPlan::candidates(const std::vector<Law> &laws) const
{
  const tagint *const mol = atom->molecule, *const id = atom->tag;
  std::vector<int> nodes;
  for (int i = 0; i < nlocal; i++)
    if (laws[atom->type[i]].here && bonds->num[i] >= 0 && bonds->nref[i] > 0 && !covered[i])
      nodes.push_back(i);
  std::sort(nodes.begin(), nodes.end(), [&](int i, int j) {
    return mol[i] < mol[j] || (mol[i] == mol[j] && id[i] < id[j]);
  });
  return nodes;
}

/* ----------------------------------------------------------------------
   grains that are computed on this rank, if they are batched
------------------------------------------------------------------------- */

PeridemBatchPlan::Grains PeridemBatchPlan::find_grains(const std::vector<int> &nodes) const
{
  Grains grains;
  for (std::size_t begin = 0, end = 0; begin < nodes.size(); begin = end) {
    const tagint mol = atom->molecule[nodes[begin]];
    while (end < nodes.size() && atom->molecule[nodes[end]] == mol) end++;
    if (share.lends(mol)) continue;
    grains.emplace_back();
    grains.back().nodes.assign(nodes.begin() + begin, nodes.begin() + end);
  }
  return grains;
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::add_borrowed(Grains &grains) const
{
  std::map<tagint, Grain *> by_molecule;
  for (auto &grain : grains) by_molecule[atom->molecule[grain.nodes[0]]] = &grain;
  for (std::size_t k = 0; k < share.nodes.size(); k++) {
    auto *const grain = by_molecule.at(static_cast<tagint>(share.nodes[k].mol));
    grain->shared = true;
    grain->nodes.push_back(nlocal + static_cast<int>(k));
  }
  for (auto &grain : grains)
    if (grain.shared)
      std::sort(grain.nodes.begin(), grain.nodes.end(), [this](int i, int j) {
        return tag(i) < tag(j);
      });
}

/* ----------------------------------------------------------------------
   why a grain cannot be batched; NREASONS if it can
------------------------------------------------------------------------- */

int PeridemBatchPlan::unfit(Grain &grain) const
{
  if (grain.nodes.size() > MAXNODES) return LARGE;
  grain.type = type(grain.nodes[0]);
  bool mixed = false, rigid = false;
  for (int i : grain.nodes) {
    const bool own = i < nlocal;
    mixed = mixed || type(i) != grain.type ||
        (own ? bonds->mixed[i] != 0 : share.nodes[i - nlocal].mixed != 0.0);
    rigid = rigid || (own ? bonds->rigid[i] != 0 : share.nodes[i - nlocal].rigid != 0.0);
  }
  if (mixed || !flat(grain)) return MIXED;
  if (rigid) return RIGID;
  return unwrap(grain) ? NREASONS : WIDE;
}

/* ----------------------------------------------------------------------
   in 2d: do all nodes lie, and stay, in one plane?
------------------------------------------------------------------------- */

bool PeridemBatchPlan::flat(const Grain &grain) const
{
  if (domain->dimension == 3) return true;
  const double z = place(grain.nodes[0])[2];
  return std::all_of(grain.nodes.begin(), grain.nodes.end(), [&](int i) {
    const double vz = i < nlocal ? atom->v[i][2] : share.nodes[i - nlocal].vz;
    return place(i)[2] == z && vz == 0.0;
  });
}

/* ----------------------------------------------------------------------
   All nodes on one side of the periodic box. Where the grain spans less than half of it, the
   nearest images of any two of its nodes are on the same side then.
------------------------------------------------------------------------- */

bool PeridemBatchPlan::unwrap(Grain &grain) const
{
  const double *const origin = place(grain.nodes[0]);
  for (int k = 0; k < domain->dimension; k++) {
    if (!domain->periodicity[k]) continue;
    const double period = domain->prd[k];
    double lo = 0.0, hi = 0.0;
    for (std::size_t n = 0; n < grain.nodes.size(); n++) {
      double d = place(grain.nodes[n])[k] - origin[k];
      const double turns = std::round(d / period);
      if (turns != 0.0) {
        grain.shift.resize(3 * grain.nodes.size(), 0.0);
        grain.shift[3 * n + k] = -turns * period;
        d -= turns * period;
      }
      lo = MIN(lo, d);
      hi = MAX(hi, d);
    }
    if (hi - lo >= 0.5 * period) return false;
  }
  return grain.shift.empty() || !(domain->triclinic || domain->box_change);
}

/* ----------------------------------------------------------------------
   distances of the nodes from their centroid in the reference, over their root mean square
------------------------------------------------------------------------- */

std::vector<double> PeridemBatchPlan::profile(Grain &grain) const
{
  const auto n = static_cast<double>(grain.nodes.size());
  double centre[3] = {0.0, 0.0, 0.0}, sum = 0.0;
  for (int i : grain.nodes)
    for (int k = 0; k < 3; k++) centre[k] += reference(i)[k] / n;
  std::vector<double> distance;
  for (int i : grain.nodes) {
    const double *const X = reference(i);
    double rsq = 0.0;
    for (int k = 0; k < 3; k++) rsq += (X[k] - centre[k]) * (X[k] - centre[k]);
    distance.push_back(std::sqrt(rsq));
    sum += rsq;
  }
  grain.size = std::sqrt(sum / n);
  for (auto &one : distance) one /= grain.size > 0.0 ? grain.size : 1.0;
  return distance;
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::find_shapes(Grains &grains) const
{
  std::vector<std::vector<double>> known;
  for (auto &grain : grains) {
    auto mine = profile(grain);
    auto same = [&](const std::vector<double> &other) {
      return std::equal(mine.begin(), mine.end(), other.begin(), other.end(),
                        [](double a, double b) {
                          return std::fabs(a - b) < ALIKE;
                        });
    };
    const auto at = std::find_if(known.begin(), known.end(), same);
    grain.shape = static_cast<int>(at - known.begin());
    if (at == known.end()) known.push_back(std::move(mine));
  }
}

/* ----------------------------------------------------------------------
   of one type, number of nodes and shape, by size; those that wait for other ranks last
------------------------------------------------------------------------- */

void PeridemBatchPlan::form_groups(Grains &grains, const std::vector<Law> &laws, bool forced)
{
  auto kind = [](const Grain &g) {
    return std::make_tuple(g.shared, g.type, g.nodes.size(), g.shape);
  };
  std::sort(grains.begin(), grains.end(), [&](const Grain &a, const Grain &b) {
    const auto ka = kind(a), kb = kind(b);
    return ka < kb || (ka == kb && a.size < b.size);
  });
  first_shared = groups.size();
  const auto *const stop = grains.data() + grains.size();
  for (const auto *first = grains.data(), *last = first; first < stop; first = last) {
    while (last < stop && last < first + WIDTH && kind(*last) == kind(*first)) last++;
    if (build_group(first, last, forced))
      fill_nodes(groups.back(), laws);
    else
      leave(first, last);
    if (!first->shared) first_shared = groups.size();
  }
  std::sort(loners.begin(), loners.end());
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::leave(const Grain *first, const Grain *last)
{
  left[FEW] += last - first;
  for (const auto *grain = first; grain < last; grain++)
    if (!grain->shared) loners.push_back(atom->molecule[grain->nodes[0]]);
}

/* ----------------------------------------------------------------------
   grains first to last side by side, if that is faster
------------------------------------------------------------------------- */

bool PeridemBatchPlan::build_group(const Grain *first, const Grain *last, bool forced)
{
  PeridemBatchGroup group;
  group.lanes = static_cast<int>(last - first);
  group.nodes = static_cast<int>(first->nodes.size());
  group.type = first->type;
  unite(first, group);

  count_bonds(first, group);
  if (!forced && !gains(group)) return false;
  fill(first, group);
  group.make_lean();
  enter(group, groups.size());
  groups.push_back(std::move(group));
  return true;
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::count_bonds(const Grain *first, PeridemBatchGroup &group) const
{
  group.held.assign(group.lanes, 0);
  for (int lane = 0; lane < group.lanes; lane++)
    for (int i : first[lane].nodes) group.held[lane] += bond_count(i);
}

/* ----------------------------------------------------------------------
   the bonds that at least one grain has
------------------------------------------------------------------------- */

void PeridemBatchPlan::unite(const Grain *first, PeridemBatchGroup &group) const
{
  std::vector<int> seen(group.nodes, -1);    // for which node a partner is in the list
  std::vector<unsigned short> found;
  group.first.assign(1, 0);
  for (int n = 0; n < group.nodes; n++) {
    found.clear();
    for (int lane = 0; lane < group.lanes; lane++) {
      const int i = first[lane].nodes[n], count = bond_count(i);
      for (int k = 0; k < count; k++) {
        const int m = partner(i, k);
        if (m <= n || seen[m] == n) continue;
        seen[m] = n;
        found.push_back(static_cast<unsigned short>(m));
      }
    }
    std::sort(found.begin(), found.end());
    group.partner.insert(group.partner.end(), found.begin(), found.end());
    group.first.push_back(static_cast<int>(group.partner.size()));
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::fill(const Grain *first, PeridemBatchGroup &group) const
{
  const Pack zero{};
  group.inverse.assign(group.partner.size(), zero);
  group.strength.assign(group.partner.size(), zero);
  group.index.resize(group.nodes * WIDTH);
  group.ids.resize(group.nodes * WIDTH);
  for (int lane = 0; lane < WIDTH; lane++)
    put_shift(group, lane, first[lane < group.lanes ? lane : 0]);
  std::vector<int> slot(group.nodes);
  for (int n = 0; n < group.nodes; n++) {
    for (int k = group.first[n]; k < group.first[n + 1]; k++) slot[group.partner[k]] = k;
    for (int lane = 0; lane < WIDTH; lane++) {
      const int used = lane < group.lanes ? lane : 0;
      const auto &grain = first[used];
      const int i = group.index[n * WIDTH + lane] = grain.nodes[n];
      group.ids[n * WIDTH + lane] = tag(i);
      if (lane != used) continue;
      for (int k = 0; k < bond_count(i); k++) {
        const int m = partner(i, k);
        if (m <= n) continue;
        const auto one = bond(i, k);
        const double R = one.length;
        PeridemSimd::set(group.inverse[slot[m]], lane, 1.0 / R);
        PeridemSimd::set(group.strength[slot[m]], lane, one.weight * R * R);
      }
    }
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::fill_nodes(PeridemBatchGroup &group, const std::vector<Law> &laws) const
{
  const Pack zero{};
  const double softness = laws[group.type].softness;
  for (auto *list : {&group.soft, &group.stiff, &group.dashpot, &group.sum, &group.most})
    list->assign(group.nodes, zero);
  for (int n = 0; n < group.nodes; n++)
    for (int lane = 0; lane < group.lanes; lane++) {
      const int i = group.index[n * WIDTH + lane];
      const auto *const other = i < nlocal ? nullptr : &share.nodes[i - nlocal];
      const double m = other ? other->wvolume : bonds->wvolume[i];
      const double V = other ? other->volume : atom->vfrac[i];
      if (m > 0.0) PeridemSimd::set(group.soft[n], lane, softness / (m * m * V));
      PeridemSimd::set(group.stiff[n], lane, other ? other->stiffness : stiffness[i]);
      PeridemSimd::set(group.dashpot[n], lane, other ? other->dashpot : dashpot[i]);
      if (!other) PeridemSimd::set(group.most[n], lane, bonds->maxstretch[i]);
    }
}

/* ----------------------------------------------------------------------
   lenders hear which of their nodes are in batches
------------------------------------------------------------------------- */

void PeridemBatchPlan::settle()
{
  share.settle(std::vector<char>(covered.begin() + nlocal, covered.end()));
  for (int i : share.lent()) covered[i] = 1;
}

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
#include <limits>
#include <tuple>

using namespace LAMMPS_NS;
using PeridemSimd::Pack;
using PeridemSimd::WIDTH;

// Distances from the centroid that differ by less, as a fraction of the grain's size, belong to one
// shape. Nothing but the choice of neighbours in a batch depends on it.
static constexpr double ALIKE = 1.0e-3;

// One bond in all lanes takes as long as this many in the general engine, counted once each
static constexpr double BREAK_EVEN = 1.5;

/* ---------------------------------------------------------------------- */

void PeridemBatchGroup::drop_bond(int lane, int n, int m)
{
  if (n > m) std::swap(n, m);
  const auto begin = partner.begin() + first[n], end = partner.begin() + first[n + 1];
  const auto at = std::lower_bound(begin, end, m);
  if (at == end || *at != m) return;
  const auto k = at - partner.begin();
  PeridemSimd::set(inverse[k], lane, 0.0);
  PeridemSimd::set(strength[k], lane, 0.0);
}

/* ---------------------------------------------------------------------- */

double PeridemBatchGroup::memory_usage() const
{
  const std::size_t packs = inverse.size() + strength.size() + soft.size() + stiff.size() +
      dashpot.size() + sum.size() + most.size();
  return static_cast<double>(packs * sizeof(Pack) + (index.size() + first.size()) * sizeof(int) +
                             partner.size() * sizeof(unsigned short));
}

/* ---------------------------------------------------------------------- */

double PeridemBatchPlan::memory_usage() const
{
  double bytes = static_cast<double>(covered.size() + (number.size() + nodes.size()) * sizeof(int));
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

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::build(const FixPeridemBonds *_bonds, const std::vector<Law> &laws,
                             const double *stiffness, const double *dashpot, bool forced)
{
  bonds = _bonds;
  groups.clear();
  left.fill(0);
  covered.assign(atom->nlocal, 0);
  number.assign(atom->nlocal, -1);
  places.assign(atom->nlocal, {-1, -1});
  sort_nodes(laws);

  std::vector<Grain> fit;
  for (const auto &grain : find_grains()) {
    for (int m = grain.begin; m < grain.end; m++) number[nodes[m]] = m - grain.begin;
    const int reason = unfit(grain);
    if (reason < NREASONS)
      left[reason]++;
    else
      fit.push_back(grain);
  }
  find_shapes(fit);

  // of one type, number of nodes and shape, by size

  auto kind = [&](const Grain &g) {
    return std::make_tuple(atom->type[nodes[g.begin]], g.end - g.begin, g.shape);
  };
  std::sort(fit.begin(), fit.end(), [&](const Grain &a, const Grain &b) {
    const auto ka = kind(a), kb = kind(b);
    return ka < kb || (ka == kb && a.size < b.size);
  });
  for (std::size_t begin = 0, end = 0; begin < fit.size(); begin = end) {
    end = begin + 1;
    while (end < fit.size() && end < begin + WIDTH && kind(fit[end]) == kind(fit[begin])) end++;
    if (build_group(fit, begin, end, forced))
      fill_nodes(groups.back(), laws, stiffness, dashpot);
    else
      left[FEW] += static_cast<bigint>(end - begin);
  }
}

/* ----------------------------------------------------------------------
   nodes that have, or had, bonds
------------------------------------------------------------------------- */

void PeridemBatchPlan::sort_nodes(const std::vector<Law> &laws)
{
  const tagint *const mol = atom->molecule, *const tag = atom->tag;
  nodes.clear();
  for (int i = 0; i < atom->nlocal; i++)
    if (laws[atom->type[i]].here && bonds->num[i] >= 0 && bonds->nref[i] > 0) nodes.push_back(i);
  std::sort(nodes.begin(), nodes.end(), [&](int i, int j) {
    return mol[i] < mol[j] || (mol[i] == mol[j] && tag[i] < tag[j]);
  });
}

/* ---------------------------------------------------------------------- */

std::vector<PeridemBatchPlan::Grain> PeridemBatchPlan::find_grains() const
{
  const int count = static_cast<int>(nodes.size());
  std::vector<Grain> grains;
  for (int begin = 0, end = 0; begin < count; begin = end) {
    const tagint mol = atom->molecule[nodes[begin]];
    while (end < count && atom->molecule[nodes[end]] == mol) end++;
    grains.push_back({begin, end, 0, 0.0});
  }
  return grains;
}

/* ----------------------------------------------------------------------
   why a grain cannot be batched; NREASONS if it can
------------------------------------------------------------------------- */

int PeridemBatchPlan::unfit(const Grain &grain) const
{
  if (grain.end - grain.begin > MAXNODES) return LARGE;
  const int type = atom->type[nodes[grain.begin]];
  bool mixed = false, rigid = false;
  for (int m = grain.begin; m < grain.end; m++) {
    const int i = nodes[m];
    mixed = mixed || bonds->mixed[i] || atom->type[i] != type;
    rigid = rigid || bonds->rigid[i];
    for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
      if (bonds->partner[k] >= atom->nlocal) return SPANS;
  }
  if (mixed || !flat(grain)) return MIXED;
  return rigid ? RIGID : NREASONS;
}

/* ----------------------------------------------------------------------
   in 2d: do all nodes lie, and stay, in one plane?
------------------------------------------------------------------------- */

bool PeridemBatchPlan::flat(const Grain &grain) const
{
  if (domain->dimension == 3) return true;
  const double z = atom->x[nodes[grain.begin]][2];
  for (int m = grain.begin; m < grain.end; m++)
    if (atom->x[nodes[m]][2] != z || atom->v[nodes[m]][2] != 0.0) return false;
  return true;
}

/* ----------------------------------------------------------------------
   distances of the nodes from their centroid in the reference, over their root mean square
------------------------------------------------------------------------- */

std::vector<double> PeridemBatchPlan::profile(Grain &grain) const
{
  const int n = grain.end - grain.begin;
  double centre[3] = {0.0, 0.0, 0.0}, sum = 0.0;
  for (int m = grain.begin; m < grain.end; m++)
    for (int k = 0; k < 3; k++) centre[k] += atom->x0[nodes[m]][k] / n;
  std::vector<double> distance(n);
  for (int m = 0; m < n; m++) {
    const double *const X = atom->x0[nodes[grain.begin + m]];
    double rsq = 0.0;
    for (int k = 0; k < 3; k++) rsq += (X[k] - centre[k]) * (X[k] - centre[k]);
    distance[m] = std::sqrt(rsq);
    sum += rsq;
  }
  grain.size = std::sqrt(sum / n);
  for (auto &one : distance) one /= grain.size > 0.0 ? grain.size : 1.0;
  return distance;
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::find_shapes(std::vector<Grain> &grains)
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
  shapes = static_cast<int>(known.size());
}

/* ----------------------------------------------------------------------
   grains begin to end side by side, if that is faster
------------------------------------------------------------------------- */

bool PeridemBatchPlan::build_group(const std::vector<Grain> &grains, std::size_t begin,
                                   std::size_t end, bool forced)
{
  PeridemBatchGroup group;
  group.lanes = static_cast<int>(end - begin);
  group.nodes = grains[begin].end - grains[begin].begin;
  group.type = atom->type[nodes[grains[begin].begin]];
  unite(grains, begin, group);

  bigint directed = 0;
  for (std::size_t g = begin; g < end; g++)
    for (int m = grains[g].begin; m < grains[g].end; m++) directed += bonds->num[nodes[m]];
  const double united = static_cast<double>(group.partner.size());
  if (!forced && 0.5 * static_cast<double>(directed) < BREAK_EVEN * united) return false;

  fill(grains, begin, group);
  for (std::size_t g = begin; g < end; g++)
    for (int m = grains[g].begin; m < grains[g].end; m++) {
      covered[nodes[m]] = 1;
      places[nodes[m]] = {static_cast<int>(groups.size()), static_cast<int>(g - begin)};
    }
  groups.push_back(std::move(group));
  return true;
}

/* ----------------------------------------------------------------------
   the bonds that at least one grain has
------------------------------------------------------------------------- */

void PeridemBatchPlan::unite(const std::vector<Grain> &grains, std::size_t begin,
                             PeridemBatchGroup &group) const
{
  std::vector<int> seen(group.nodes, -1);    // for which node a partner is in the list
  std::vector<unsigned short> found;
  group.first.assign(1, 0);
  for (int n = 0; n < group.nodes; n++) {
    found.clear();
    for (int lane = 0; lane < group.lanes; lane++) {
      const int i = nodes[grains[begin + lane].begin + n];
      for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
        const int m = number[bonds->partner[k]];
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

void PeridemBatchPlan::fill(const std::vector<Grain> &grains, std::size_t begin,
                            PeridemBatchGroup &group) const
{
  const Pack zero{};
  group.inverse.assign(group.partner.size(), zero);
  group.strength.assign(group.partner.size(), zero);
  group.index.resize(group.nodes * WIDTH);
  std::vector<int> slot(group.nodes);
  for (int n = 0; n < group.nodes; n++) {
    for (int k = group.first[n]; k < group.first[n + 1]; k++) slot[group.partner[k]] = k;
    for (int lane = 0; lane < WIDTH; lane++) {
      const int used = lane < group.lanes ? lane : 0;
      const int i = group.index[n * WIDTH + lane] = nodes[grains[begin + used].begin + n];
      if (lane != used) continue;
      for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
        const int m = number[bonds->partner[k]];
        if (m <= n) continue;
        const double R = bonds->length[k];
        PeridemSimd::set(group.inverse[slot[m]], lane, 1.0 / R);
        PeridemSimd::set(group.strength[slot[m]], lane, bonds->weight[k] * R * R);
      }
    }
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBatchPlan::fill_nodes(PeridemBatchGroup &group, const std::vector<Law> &laws,
                                  const double *stiffness, const double *dashpot) const
{
  const Pack zero{};
  const double softness = laws[group.type].softness;
  for (auto *list : {&group.soft, &group.stiff, &group.dashpot, &group.sum, &group.most})
    list->assign(group.nodes, zero);
  for (int n = 0; n < group.nodes; n++)
    for (int lane = 0; lane < group.lanes; lane++) {
      const int i = group.index[n * WIDTH + lane];
      const double m = bonds->wvolume[i];
      if (m > 0.0) PeridemSimd::set(group.soft[n], lane, softness / (m * m * atom->vfrac[i]));
      PeridemSimd::set(group.stiff[n], lane, stiffness[i]);
      PeridemSimd::set(group.dashpot[n], lane, dashpot[i]);
      PeridemSimd::set(group.most[n], lane, bonds->maxstretch[i]);
    }
}

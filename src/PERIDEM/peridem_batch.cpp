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

#include "peridem_batch.h"

#include "fix_peridem_bonds.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using PeridemSimd::Lanes;
using PeridemSimd::Pack;
using PeridemSimd::WIDTH;

// The batches pick nodes that may have a breaking bond; the general engine's row decides. The margin
// covers what the two may differ by.
static constexpr double MARGIN = 1.0e-10;

/* ---------------------------------------------------------------------- */

PeridemBatch::PeridemBatch(LAMMPS *lmp, CarefulRow _careful_row) :
    Pointers(lmp), careful_row(std::move(_careful_row)), thePlan(lmp)
{
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::init(FixPeridemBonds *_bonds, const std::vector<Law> &_laws, bool _forced)
{
  bonds = _bonds;
  laws = _laws;
  forced = _forced;
  reported = false;
  thePlan.forget();
  any_viscous = std::any_of(laws.begin(), laws.end(), [](const Law &law) {
    return law.here && law.viscous;
  });
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::plan(const double *stiffness, const double *dashpot)
{
  const std::vector<PeridemBatchPlan::Law> slim(laws.begin(), laws.end());
  thePlan.build(bonds, slim, stiffness, dashpot, forced);
  broken_seen = bonds->broken.size();

  int mine = 0, any;
  for (int i = 0; i < atom->nlocal && !mine; i++)
    if (laws[atom->type[i]].here && bonds->num[i] > 0 && !bonds->rigid[i] && !covers(i)) mine = 1;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  general = any;
  if (!reported) report();
  reported = true;
}

/* ----------------------------------------------------------------------
   at the start of a run, if it is news: what is batched, and why not the rest
------------------------------------------------------------------------- */

void PeridemBatch::report()
{
  const std::string reasons[PeridemBatchPlan::NREASONS] = {
      "wider than half the periodic box, or across its sheared or changing faces",
      "of several types or out of the plane", "with rigid nodes",
      fmt::format("with more than {} nodes", PeridemBatchPlan::MAXNODES),
      "with too few of their shape and size"};
  std::array<bigint, PeridemBatchPlan::NREASONS + 1> mine, all;
  std::copy(thePlan.left.begin(), thePlan.left.end(), mine.begin());
  mine.back() = thePlan.grains_batched();
  MPI_Reduce(mine.data(), all.data(), static_cast<int>(mine.size()), MPI_LMP_BIGINT, MPI_SUM, 0,
             world);
  if (comm->me) return;

  bigint left = 0;
  std::string why;
  for (int k = 0; k < PeridemBatchPlan::NREASONS; k++) {
    left += all[k];
    if (all[k]) why += fmt::format("{}{} {}", why.empty() ? ": " : ", ", all[k], reasons[k]);
  }
  const auto news =
      fmt::format("{} grains computed {} at a time, {} one by one{}", all.back(), WIDTH, left, why);
  if (news == said) return;
  said = news;
  utils::logmesg(lmp, "PERIDEM: {}\n", news);
  if (forced && left)
    error->warning(FLERR, "Pair style peridem/lps engine batched: {} grains cannot be batched{}",
                   left, why);
}

/* ----------------------------------------------------------------------
   while positions of borrowed nodes travel, grains without any are computed
------------------------------------------------------------------------- */

void PeridemBatch::compute(bool tally)
{
  tallying = tally;
  std::fill(std::begin(tallies), std::end(tallies), 0.0);
  drop_broken();
  auto &share = thePlan.share;
  const auto alone = thePlan.first_shared, all = thePlan.groups.size();
  if (share.any()) {
    share.send_places(atom->x, any_viscous ? atom->v : nullptr);
    compute_groups(0, alone);
    share.receive_places();
    compute_groups(alone, all);
    share.send_results();
    lent_sums.resize(atom->nlocal);
    share.receive_results([this](int i, const double *result) {
      take_results(i, result);
    });
    drop_broken();
  } else
    compute_groups(0, all);
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::compute_groups(std::size_t begin, std::size_t end)
{
  for (auto g = begin; g < end; g++) {
    if (domain->dimension == 3)
      one_group<3>(thePlan.groups[g]);
    else
      one_group<2>(thePlan.groups[g]);
  }
}

/* ----------------------------------------------------------------------
   what another rank has found for an owned node; bonds that it has broken are broken here too
------------------------------------------------------------------------- */

void PeridemBatch::take_results(int i, const double *result)
{
  for (int k = 0; k < 3; k++) atom->f[i][k] += result[k];
  lent_sums[i] = result[3];
  const auto &law = laws[atom->type[i]];
  const double reached = result[4] / law.s0;
  if (reached > 1.0 - MARGIN)
    careful_row(i);
  else if (reached > bonds->maxstretch[i])
    bonds->maxstretch[i] = reached;
}

/* ---------------------------------------------------------------------- */

bool PeridemBatch::outdated()
{
  if (!thePlan.share.any()) return false;
  int mine = bonds->broken.size() > broken_seen, any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  return any;
}

/* ----------------------------------------------------------------------
   bonds that broke since the batches were last looked at, at both of their ends
------------------------------------------------------------------------- */

void PeridemBatch::drop_broken()
{
  for (; broken_seen < bonds->broken.size(); broken_seen++) {
    const auto &bond = bonds->broken[broken_seen];
    const auto &place = thePlan.places[bond.i];
    if (place.group < 0) continue;
    thePlan.groups[place.group].drop_bond(place.lane, thePlan.number[bond.i],
                                          thePlan.number_of(bond.j));
  }
}

/* ---------------------------------------------------------------------- */

template <int DIM>
void PeridemBatch::gather(const PeridemBatchGroup &group, const double *own, Borrowed borrowed,
                          std::vector<Pack> &to) const
{
  const int nlocal = atom->nlocal;
  const int *index = group.index.data();
  to.resize(static_cast<std::size_t>(DIM) * group.nodes);
  Pack *pack = to.data();
  for (int n = 0; n < group.nodes; n++, pack += DIM)
    for (int lane = 0; lane < WIDTH; lane++) {
      const int i = *index++;
      const double *const one = i < nlocal ? own + 3 * static_cast<bigint>(i)
                                           : (thePlan.share.*borrowed)(i - nlocal);
      for (int m = 0; m < DIM; m++) PeridemSimd::set(pack[m], lane, one[m]);
    }
}

/* ---------------------------------------------------------------------- */

template <int DIM> void PeridemBatch::shift(const PeridemBatchGroup &group)
{
  if (group.shift.empty()) return;
  for (int n = 0; n < group.nodes; n++)
    for (int lane = 0; lane < WIDTH; lane++)
      for (int m = 0; m < DIM; m++) {
        auto &pack = x[DIM * n + m];
        PeridemSimd::set(pack, lane,
                         PeridemSimd::get(pack, lane) + group.shift[3 * (n * WIDTH + lane) + m]);
      }
}

/* ---------------------------------------------------------------------- */

template <int DIM> void PeridemBatch::one_group(PeridemBatchGroup &group)
{
  gather<DIM>(group, atom->x[0], &PeridemBatchShare::place, x);
  shift<DIM>(group);
  stretches<DIM>(group);
  if (std::isfinite(laws[group.type].s0)) {
    if (look_closely(group)) stretches<DIM>(group);
    record_stretches(group);
  }
  forces<DIM>(group);
  scatter<DIM>(group, atom->f[0]);
}

/* ----------------------------------------------------------------------
   what the loops take the bonds of a group from
------------------------------------------------------------------------- */

template <class What> static void with_bonds(const PeridemBatchGroup &group, What what)
{
  using namespace PeridemBatchKernel;
  const Bonds bonds{group.nodes, group.first.data(), group.partner.data()};
  if (group.lean)
    what(LeanBonds{bonds, group.common.data(), group.one_strength.data(), group.rest.data(),
                   group.here.data()});
  else
    what(FullBonds{bonds, group.inverse.data(), group.strength.data()});
}

/* ----------------------------------------------------------------------
   does the second pass use what the first has found?
------------------------------------------------------------------------- */

bool PeridemBatch::keeps_found(const PeridemBatchGroup &group) const
{
  return !laws[group.type].viscous && group.partner.size() <= PeridemBatchKernel::FOUND_BONDS;
}

/* ---------------------------------------------------------------------- */

template <int DIM> void PeridemBatch::stretches(PeridemBatchGroup &group)
{
  std::fill(group.sum.begin(), group.sum.end(), Pack{});
  top.assign(group.nodes, Pack{});
  if (keeps_found(group)) {
    found.resize(MAX(found.size(), group.partner.size()));
    stretch_pass<DIM, true>(group);
  } else
    stretch_pass<DIM, false>(group);
}

/* ---------------------------------------------------------------------- */

template <int DIM, bool KEEP> void PeridemBatch::stretch_pass(PeridemBatchGroup &group)
{
  using namespace PeridemBatchKernel;
  with_bonds(group, [&](const auto &list) {
    const auto &law = laws[group.type];
    const Pack *const place = x.data();
    Pack *const sum = group.sum.data(), *const most = top.data();
    if (!std::isfinite(law.s0))
      PeridemBatchKernel::stretch_pass<DIM, false, false, KEEP>(list, place, sum, most,
                                                                found.data());
    else if (law.both)
      PeridemBatchKernel::stretch_pass<DIM, true, true, KEEP>(list, place, sum, most, found.data());
    else
      PeridemBatchKernel::stretch_pass<DIM, true, false, KEEP>(list, place, sum, most,
                                                               found.data());
  });
}

/* ----------------------------------------------------------------------
   does a bond break? the general engine's rows decide, at both ends of it
------------------------------------------------------------------------- */

bool PeridemBatch::look_closely(PeridemBatchGroup &group)
{
  const double limit = laws[group.type].s0 * (1.0 - MARGIN);
  bool close = false;
  for (int n = 0; n < group.nodes && !close; n++)
    close = PeridemSimd::any_above(top[n].v, PeridemSimd::all(limit));
  if (!close) return false;

  const int nlocal = atom->nlocal;
  const auto before = bonds->broken.size();
  bool any = false;
  for (int n = 0; n < group.nodes; n++)
    for (int lane = 0; lane < group.lanes; lane++) {
      if (PeridemSimd::get(top[n], lane) <= limit) continue;
      const int i = group.index[n * WIDTH + lane];
      if (i < nlocal)
        careful_row(i);
      else if (careful_borrowed(group, lane, n))
        any = true;
    }
  any = any || bonds->broken.size() > before;
  drop_broken();
  return any;
}

/* ----------------------------------------------------------------------
   the same for a node of another rank, which finds the same once it hears of the stretch
------------------------------------------------------------------------- */

bool PeridemBatch::careful_borrowed(PeridemBatchGroup &group, int lane, int n)
{
  const auto &law = laws[group.type];
  auto &share = thePlan.share;
  const int dim = domain->dimension, slot = group.index[n * WIDTH + lane] - atom->nlocal;
  share.result(slot)[4] = PeridemSimd::get(top[n], lane);
  auto place = [&](int node, double *to) {
    to[2] = 0.0;
    for (int m = 0; m < dim; m++) to[m] = PeridemSimd::get(x[dim * node + m], lane);
  };
  double xn[3], xm[3];
  place(n, xn);
  bool any = false;
  for (auto k = share.first[slot]; k < share.first[slot + 1]; k++) {
    const int m = thePlan.number_of_tag(static_cast<tagint>(share.rows[k].tag));
    if (thePlan.unbroken(group.index[n * WIDTH + lane]) &&
        thePlan.unbroken(group.index[m * WIDTH + lane]))
      continue;
    place(m, xm);
    const double s = bonds->stretch(xn, xm, share.rows[k].length);
    if ((s > law.s0 || (law.both && s < -law.s0)) && group.drop_bond(lane, n, m)) any = true;
  }
  return any;
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::record_stretches(PeridemBatchGroup &group)
{
  const double scale = 1.0 / laws[group.type].s0;
  for (int n = 0; n < group.nodes; n++)
    if (PeridemSimd::any_above(scale * top[n].v, group.most[n].v)) record_stretch(group, n, scale);
}

/* ----------------------------------------------------------------------
   of nodes near breaking the row has recorded it: bonds that never break do not count there
------------------------------------------------------------------------- */

void PeridemBatch::record_stretch(PeridemBatchGroup &group, int n, double scale)
{
  for (int lane = 0; lane < group.lanes; lane++) {
    const int i = group.index[n * WIDTH + lane];
    const double reached = scale * PeridemSimd::get(top[n], lane);
    if (i >= atom->nlocal) {
      double &told = thePlan.share.result(i - atom->nlocal)[4];
      told = MAX(told, PeridemSimd::get(top[n], lane));
      continue;
    }
    double &known = bonds->maxstretch[i];
    if (reached > known && reached <= 1.0 - MARGIN) known = reached;
    PeridemSimd::set(group.most[n], lane, known);
  }
}

/* ---------------------------------------------------------------------- */

template <int DIM> void PeridemBatch::forces(PeridemBatchGroup &group)
{
  pressure.resize(group.nodes);
  for (int n = 0; n < group.nodes; n++) pressure[n].v = group.soft[n].v * group.sum[n].v;
  force.assign(static_cast<std::size_t>(DIM) * group.nodes, Pack{});
  if (laws[group.type].viscous) gather<DIM>(group, atom->v[0], &PeridemBatchShare::velocity, v);
  if (!tallying) {
    force_pass<DIM, false>(group, nullptr);
    return;
  }
  Pack lanes[PeridemBatchKernel::TALLIES] = {};
  force_pass<DIM, true>(group, lanes);
  for (int n = 0; n < group.nodes; n++)
    lanes[0].v += 0.5 * pressure[n].v * group.sum[n].v;    // (lambda' - G)/2 theta^2 V
  add_tallies(group, lanes);
}

/* ---------------------------------------------------------------------- */

template <int DIM, bool TALLY>
void PeridemBatch::force_pass(const PeridemBatchGroup &group, Pack *lanes)
{
  with_bonds(group, [&](const auto &list) {
    const Pack *const a = pressure.data(), *const b = group.stiff.data();
    if (keeps_found(group))
      PeridemBatchKernel::short_force_pass<DIM, TALLY>(list, x.data(), a, b, found.data(),
                                                       force.data(), lanes);
    else if (laws[group.type].viscous)
      PeridemBatchKernel::force_pass<DIM, true, TALLY>(list, x.data(), v.data(), a, b,
                                                       group.dashpot.data(), force.data(), lanes);
    else
      PeridemBatchKernel::force_pass<DIM, false, TALLY>(list, x.data(), nullptr, a, b, nullptr,
                                                        force.data(), lanes);
  });
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::add_tallies(const PeridemBatchGroup &group, const Pack *lanes)
{
  for (int k = 0; k < PeridemBatchKernel::TALLIES; k++)
    for (int lane = 0; lane < group.lanes; lane++) tallies[k] += PeridemSimd::get(lanes[k], lane);
}

/* ---------------------------------------------------------------------- */

template <int DIM> void PeridemBatch::scatter(const PeridemBatchGroup &group, double *to)
{
  const int nlocal = atom->nlocal;
  const Pack *pack = force.data();
  for (int n = 0; n < group.nodes; n++, pack += DIM)
    for (int lane = 0; lane < group.lanes; lane++) {
      const int i = group.index[n * WIDTH + lane];
      double *one = to + 3 * static_cast<bigint>(i);
      if (i >= nlocal) {
        one = thePlan.share.result(i - nlocal);
        one[3] = PeridemSimd::get(group.sum[n], lane);
      }
      for (int m = 0; m < DIM; m++) one[m] += PeridemSimd::get(pack[m], lane);
    }
}

// ---- linear response ----------------------------------------------------------------------------

bool PeridemBatch::responds(int i) const
{
  const int group = thePlan.places[i].group;
  return group >= 0 && static_cast<std::size_t>(group) < thePlan.first_shared;
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::respond(const std::vector<double> &u, std::vector<double> &forces)
{
  drop_broken();
  for (std::size_t g = 0; g < thePlan.first_shared; g++) {
    if (domain->dimension == 3)
      respond<3>(thePlan.groups[g], u, forces);
    else
      respond<2>(thePlan.groups[g], u, forces);
  }
}

/* ---------------------------------------------------------------------- */

template <int DIM>
void PeridemBatch::respond(const PeridemBatchGroup &group, const std::vector<double> &u,
                           std::vector<double> &forces)
{
  gather<DIM>(group, atom->x[0], &PeridemBatchShare::place, x);
  shift<DIM>(group);
  gather<DIM>(group, u.data(), &PeridemBatchShare::place, v);
  pressure.assign(group.nodes, Pack{});
  force.assign(static_cast<std::size_t>(DIM) * group.nodes, Pack{});
  found.resize(MAX(found.size(), group.partner.size()));
  with_bonds(group, [&](const auto &list) {
    PeridemBatchKernel::linear_pass<DIM>(list, x.data(), v.data(), pressure.data(), found.data());
    for (int n = 0; n < group.nodes; n++) pressure[n].v *= group.soft[n].v;
    PeridemBatchKernel::short_force_pass<DIM, false>(
        list, x.data(), pressure.data(), group.stiff.data(), found.data(), force.data(), nullptr);
  });
  scatter<DIM>(group, forces.data());
}

/* ---------------------------------------------------------------------- */

void PeridemBatch::each_sum(const std::function<void(int, double)> &tell) const
{
  for (const auto &group : thePlan.groups)
    for (int n = 0; n < group.nodes; n++)
      for (int lane = 0; lane < group.lanes; lane++) {
        const int i = group.index[n * WIDTH + lane];
        if (i < atom->nlocal) tell(i, PeridemSimd::get(group.sum[n], lane));
      }
  for (int i : thePlan.share.lent()) tell(i, lent_sums[i]);
}

/* ---------------------------------------------------------------------- */

double PeridemBatch::memory_usage() const
{
  return thePlan.memory_usage() +
      static_cast<double>((x.size() + v.size() + top.size() + pressure.size() + force.size()) *
                          sizeof(Pack)) +
      static_cast<double>(found.size() * sizeof(PeridemBatchKernel::Found));
}

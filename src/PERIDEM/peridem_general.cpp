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

#include "peridem_general.h"

#include "fix_peridem_bonds.h"
#include "peridem_general_kernel.h"

#include "atom.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

using namespace LAMMPS_NS;
using PeridemGeneralKernel::GONE;
using PeridemSimd::Node;
using PeridemSimd::WIDTH;

static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// The vectorised pass picks nodes that may have a breaking bond; the rows of the fix decide. The
// margin covers what the two may differ by.
static constexpr double MARGIN = 1.0e-10;

// One part in so many bonds may lead to images of nodes across the periodic boundary, and so be listed
// from both ends, before the list has to be moved to make room
static constexpr std::size_t SPARE = 16;

/* ---------------------------------------------------------------------- */

PeridemGeneral::PeridemGeneral(LAMMPS *lmp, CarefulRow _careful_row) :
    Pointers(lmp), careful_row(std::move(_careful_row))
{
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::init(FixPeridemBonds *_bonds, const std::vector<Law> &_laws, Strength _kind)
{
  bonds = _bonds;
  laws = _laws;
  kind = _kind;
  layout = -1;
  breaks = both = viscous = false;
  horizon = 0.0;
  for (const auto &law : laws) {
    breaks = breaks || std::isfinite(law.least);
    both = both || law.any_both;
    viscous = viscous || law.viscous;
    horizon = MAX(horizon, law.horizon);
  }
}

// ---- the list -----------------------------------------------------------------------------------

void PeridemGeneral::build(const std::function<bool(int)> &here)
{
  if (still_holds(here)) {
    slot.resize(atom->nlocal + atom->nghost, -1);
    close_gaps();
  } else {
    enter_rows(here);
    fill_rows();
    fill_strengths();
    layout = bonds->layout;
  }
  const std::size_t count = members.size();
  x.assign(count, Node());
  v.assign(viscous ? count : 0, Node());
  sums.assign(count, Node());
  known.assign(count, INFINITE);
  has_news.assign(count, 0);
  for (int n = WIDTH; n < WIDTH + rows; n++) set_known(n);
  broken_seen = bonds->broken.size();
}

/* ----------------------------------------------------------------------
   are all nodes where they were, are those computed here that were, and is every bond known that
   broke? nodes that lost their last bond may stay
------------------------------------------------------------------------- */

bool PeridemGeneral::still_holds(const std::function<bool(int)> &here) const
{
  if (layout != bonds->layout) return false;
  std::size_t now = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    const bool had = slot[i] >= WIDTH && slot[i] < WIDTH + rows;
    if (had && bonds->num[i] == 0) continue;
    if (had != here(i)) return false;
    if (had) now += bonds->num[i];
  }
  return now == held;
}

/* ----------------------------------------------------------------------
   what a new list would have where bonds broke since
------------------------------------------------------------------------- */

void PeridemGeneral::close_gaps()
{
  if (!gaps) return;
  std::size_t at = 0, begin = 0;
  for (int n = 0; n < rows; n++) {
    const auto end = first[n + 1];
    for (auto k = begin; k < end; k++) {
      if (length[k] == GONE) continue;
      partner[at] = partner[k];
      length[at] = length[k];
      strength[at++] = strength[k];
    }
    for (int lane = 0; at % WIDTH; at++) {
      partner[at] = lane++;
      length[at] = GONE;
      strength[at] = 0.0;
    }
    first[n + 1] = at;
    begin = end;
  }
  partner.resize(at);
  length.resize(at);
  strength.resize(at);
  gaps = false;
}

/* ----------------------------------------------------------------------
   In an order that follows from the reference positions and IDs alone, so that sums do not depend
   on where in memory nodes are, and nodes that are near each other in space are so here: rows of
   cells as wide as the horizon.
------------------------------------------------------------------------- */

std::vector<int> PeridemGeneral::in_order(const std::function<bool(int)> &here) const
{
  struct Place {
    tagint grain;
    bigint cell[3];
    tagint id;
    int i;
  };
  std::vector<Place> places;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!here(i)) continue;
    Place one{atom->molecule[i], {0, 0, 0}, atom->tag[i], i};
    for (int k = 0; k < 3; k++)
      one.cell[k] = static_cast<bigint>(std::floor(atom->x0[i][k] / horizon));
    places.push_back(one);
  }
  std::sort(places.begin(), places.end(), [](const Place &a, const Place &b) {
    return std::tie(a.grain, a.cell[2], a.cell[1], a.cell[0], a.id) <
        std::tie(b.grain, b.cell[2], b.cell[1], b.cell[0], b.id);
  });
  std::vector<int> nodes;
  for (const auto &place : places) nodes.push_back(place.i);
  return nodes;
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::enter(int i)
{
  slot[i] = static_cast<int>(members.size());
  members.push_back(i);
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::enter_rows(const std::function<bool(int)> &here)
{
  slot.assign(atom->nlocal + atom->nghost, -1);
  members.assign(WIDTH, -1);
  for (const int i : in_order(here)) enter(i);
  rows = static_cast<int>(members.size()) - WIDTH;
}

/* ----------------------------------------------------------------------
   Place for the bonds of all rows, each of them once. What is not used of it costs no memory until
   it is touched; how much is used is known only when all partners have been looked up.
------------------------------------------------------------------------- */

void PeridemGeneral::reserve_list()
{
  held = 0;
  gaps = false;
  for (int n = WIDTH; n < WIDTH + rows; n++) held += bonds->num[members[n]];
  const std::size_t most = (held + held / SPARE + bonds->ghost_bonds) / 2 + rows * WIDTH;
  partner.clear();
  length.clear();
  partner.reserve(most);
  length.reserve(most);
}

/* ----------------------------------------------------------------------
   a bond is in the row of the lower node: those without a row have higher numbers than those with one
------------------------------------------------------------------------- */

void PeridemGeneral::fill_rows()
{
  reserve_list();
  first.assign(1, 0);
  const PeridemLookup find(atom);
  for (int n = WIDTH; n < WIDTH + rows; n++) {
    const int i = members[n];
    for (auto k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
      const int j = bonds->nearest(i, find(bonds->ptag[k]));
      if (slot[j] < 0) enter(j);
      if (slot[j] < n) continue;
      partner.push_back(slot[j]);
      length.push_back(bonds->length[k]);
    }
    for (int lane = 0; partner.size() % WIDTH; lane++) {
      partner.push_back(lane);
      length.push_back(GONE);
    }
    first.push_back(partner.size());
  }
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::fill_strengths()
{
  if (strength.capacity() < first.back())
    std::vector<double>().swap(strength);    // the old goes first
  strength.assign(first.back(), 0.0);
  for (int n = WIDTH; n < WIDTH + rows; n++)
    for (auto k = first[n - WIDTH]; k < first[n - WIDTH + 1]; k++)
      if (length[k] != GONE) strength[k] = strength_of(members[n], members[partner[k]], length[k]);
}

/* ---------------------------------------------------------------------- */

double PeridemGeneral::strength_of(int i, int j, double R) const
{
  const double weight = bonds->bond_weight(i, j, R);
  return kind == WEIGHT ? weight : weight / R;
}

/* ----------------------------------------------------------------------
   bonds that broke since the list was last looked at
------------------------------------------------------------------------- */

void PeridemGeneral::drop_broken()
{
  for (; broken_seen < bonds->broken.size(); broken_seen++) {
    const auto &bond = bonds->broken[broken_seen];
    const int n = slot[bond.i], m = slot[bond.j];
    if (n >= WIDTH && n < WIDTH + rows) held--;
    if (n >= 0 && m >= 0 && !drop_bond(n, m)) drop_bond(m, n);
  }
}

/* ---------------------------------------------------------------------- */

bool PeridemGeneral::drop_bond(int n, int m)
{
  if (n >= WIDTH + rows) return false;
  for (auto k = first[n - WIDTH]; k < first[n - WIDTH + 1]; k++)
    if (partner[k] == m) {
      length[k] = GONE;
      strength[k] = 0.0;
      gaps = true;
      return true;
    }
  return false;
}

// ---- forces -------------------------------------------------------------------------------------

void PeridemGeneral::first_pass(const double *stiffness, const double *dashpot)
{
  drop_broken();
  gather(stiffness, viscous ? dashpot : nullptr);
  std::fill(sums.begin(), sums.end(), Node());
  if (viscous)
    extend<true>();
  else
    extend<false>();
  judge(stiffness, dashpot);
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::gather(const double *stiffness, const double *dashpot)
{
  for (std::size_t n = WIDTH; n < members.size(); n++) {
    const int i = members[n];
    const double *const place = atom->x[i], *const speed = atom->v[i];
    x[n] = {{place[0], place[1], place[2], stiffness[i]}};
    if (dashpot) v[n] = {{speed[0], speed[1], speed[2], dashpot[i]}};
  }
}

/* ---------------------------------------------------------------------- */

template <bool VISCOUS> void PeridemGeneral::extend()
{
  using namespace PeridemGeneralKernel;
  const Bonds list{rows, first.data(), partner.data(), length.data(), strength.data()};
  auto to_look = [this](int n, std::size_t k) {
    look(n, k);
  };
  const Node *const speeds = v.data();
  const double *const told = known.data();
  if (!breaks)
    PeridemGeneralKernel::first_pass<false, false, VISCOUS, false>(list, x.data(), speeds, told,
                                                                   sums.data(), to_look);
  else if (both)
    PeridemGeneralKernel::first_pass<true, true, VISCOUS, false>(list, x.data(), speeds, told,
                                                                 sums.data(), to_look);
  else
    PeridemGeneralKernel::first_pass<true, false, VISCOUS, false>(list, x.data(), speeds, told,
                                                                  sums.data(), to_look);
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::each_sum(const std::function<void(int, double)> &tell) const
{
  for (int n = WIDTH; n < WIDTH + rows; n++) tell(members[n], sums[n].v[3]);
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::second_pass(const double *pressure)
{
  for (std::size_t n = WIDTH; n < members.size(); n++) x[n].v[3] = pressure[members[n]];
  PeridemGeneralKernel::second_pass(
      {rows, first.data(), partner.data(), length.data(), strength.data()}, x.data(), sums.data());
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::add_forces(double *f) const
{
  for (int n = WIDTH; n < WIDTH + rows; n++)
    for (int m = 0; m < 3; m++) f[3 * static_cast<bigint>(members[n]) + m] += sums[n].v[m];
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::first_response(const std::vector<double> &u, const double *stiffness)
{
  drop_broken();
  gather(stiffness, nullptr);
  v.resize(members.size());
  for (std::size_t n = WIDTH; n < members.size(); n++) {
    const double *const mine = &u[3 * static_cast<std::size_t>(members[n])];
    v[n] = {{mine[0], mine[1], mine[2], 0.0}};
  }
  std::fill(sums.begin(), sums.end(), Node());
  PeridemGeneralKernel::first_pass<false, false, false, true>(
      {rows, first.data(), partner.data(), length.data(), strength.data()}, x.data(), v.data(),
      nullptr, sums.data(), [](int, std::size_t) {
      });
}

// ---- breaking -----------------------------------------------------------------------------------

/* ----------------------------------------------------------------------
   News of a node is a stretch larger than any so far, or near a critical one. Nodes that are not
   computed here want none.
------------------------------------------------------------------------- */

void PeridemGeneral::set_known(int n)
{
  const int i = members[n];
  const auto &law = laws[atom->type[i]];
  const double least = bonds->mixed[i] ? law.least : law.s0;
  if (std::isfinite(least)) known[n] = MIN(bonds->maxstretch[i], 1.0 - MARGIN) * least;
}

/* ----------------------------------------------------------------------
   at WIDTH bonds of node n: at least one of them has news
------------------------------------------------------------------------- */

void PeridemGeneral::look(int n, std::size_t k)
{
  for (const auto end = k + WIDTH; k < end; k++) {
    if (length[k] == GONE) continue;
    const int m = partner[k];
    const double s = FixPeridemBonds::stretch(x[n].v, x[m].v, length[k]);
    tell(n, s);
    tell(m, s);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemGeneral::tell(int n, double stretch)
{
  if (!(std::fabs(stretch) > known[n])) return;    // so it is computed here
  const int i = members[n];
  const auto &law = laws[atom->type[i]];
  const bool compressed_too = bonds->mixed[i] ? law.any_both : law.both;
  const double size = compressed_too ? std::fabs(stretch) : stretch;
  if (!(size > known[n])) return;
  known[n] = size;
  if (!has_news[n]) news.push_back(n);
  has_news[n] = 1;
}

/* ----------------------------------------------------------------------
   does a bond of those nodes break? their rows decide, those of both its ends
------------------------------------------------------------------------- */

void PeridemGeneral::judge(const double *stiffness, const double *dashpot)
{
  for (const int n : news) {
    has_news[n] = 0;
    const int i = members[n], before = bonds->num[i];
    const double reached = known[n] / laws[atom->type[i]].s0;
    if (bonds->mixed[i] || reached > 1.0 - MARGIN)
      careful_row(i);
    else if (reached > bonds->maxstretch[i])
      bonds->maxstretch[i] = reached;
    set_known(n);
    if (bonds->num[i] < before) sums[n] = first_sums(i, stiffness, dashpot);
  }
  news.clear();
  drop_broken();
}

/* ----------------------------------------------------------------------
   of one node, from its row
------------------------------------------------------------------------- */

Node PeridemGeneral::first_sums(int i, const double *stiffness, const double *dashpot) const
{
  Node found{};
  const double *const xi = atom->x[i], *const vi = atom->v[i];
  for (auto k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    const double *const xj = atom->x[j], *const vj = atom->v[j];
    double d[3], square = PeridemGeneralKernel::TINY, rate = 0.0;
    for (int m = 0; m < 3; m++) {
      d[m] = xj[m] - xi[m];
      square += d[m] * d[m];
      rate += viscous ? (vj[m] - vi[m]) * d[m] : 0.0;
    }
    const double R = bonds->length[k], q = strength_of(i, j, R);
    const double r = std::sqrt(square), e = r - R;
    double pull = (stiffness[i] + stiffness[j]) * e;
    if (viscous) pull += (dashpot[i] + dashpot[j]) * rate / r;
    for (int m = 0; m < 3; m++) found.v[m] += q * pull / r * d[m];
    found.v[3] += q * R * e;
  }
  return found;
}

/* ---------------------------------------------------------------------- */

double PeridemGeneral::memory_usage() const
{
  return static_cast<double>(
      (members.capacity() + slot.capacity() + partner.size() + news.capacity()) * sizeof(int) +
      first.capacity() * sizeof(std::size_t) +
      (length.size() + strength.size() + known.capacity()) * sizeof(double) +
      (x.capacity() + v.capacity() + sums.capacity()) * sizeof(Node));
}

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

#include "peridem_bodies.h"

#include "fix_peridem_bonds.h"

#include "atom.h"
#include "domain.h"

#include <algorithm>
#include <type_traits>
#include <unordered_map>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

PeridemBodies::PeridemBodies(LAMMPS *lmp) :
    Pointers(lmp), sharing_grains(lmp), sharing(lmp), pieces(lmp)
{
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::sort_nodes(const FixPeridemBonds *_bonds)
{
  bonds = _bonds;
  find_grains();
  pieces.start(bonds);
  find_bodies();
}

/* ----------------------------------------------------------------------
   owned nodes grain by grain, grains by their molecule-IDs
------------------------------------------------------------------------- */

void PeridemBodies::find_grains()
{
  const tagint *const mol = atom->molecule;
  const int nlocal = atom->nlocal;
  std::unordered_map<tagint, int> numbers_of;
  for (int i = 0; i < nlocal; i++)
    if (mol[i] != 0 && (i == 0 || mol[i] != mol[i - 1])) numbers_of.emplace(mol[i], 0);
  std::vector<bigint> ids;
  ids.reserve(numbers_of.size());
  for (const auto &entry : numbers_of) ids.push_back(entry.first);
  std::sort(ids.begin(), ids.end());
  const std::vector<Grain> before(std::move(grains));
  grains.assign(ids.size(), Grain());
  for (std::size_t g = 0; g < ids.size(); g++) {
    grains[g].id = static_cast<tagint>(ids[g]);
    numbers_of[grains[g].id] = static_cast<int>(g);
  }

  grain_of.resize(nlocal);
  for (int i = 0; i < nlocal; i++) {
    const bool same = i > 0 && mol[i] == mol[i - 1];
    grain_of[i] = same ? grain_of[i - 1] : (mol[i] == 0 ? -1 : numbers_of[mol[i]]);
    if (grain_of[i] >= 0) grains[grain_of[i]].last++;    // counts, so far
  }
  int at = 0;
  for (auto &grain : grains) {
    grain.first = at;
    at += grain.last;
    grain.last = grain.first;
  }
  nodes.resize(at);
  for (int i = 0; i < nlocal; i++)
    if (grain_of[i] >= 0) nodes[grains[grain_of[i]].last++] = i;
  sharing_grains.find(ids);
  for (const int g : sharing_grains.shared()) grains[g].shared = true;
  keep_pieces(before);
}

/* ----------------------------------------------------------------------
   of grains that this rank has alone as before: deleted nodes may have been a piece
------------------------------------------------------------------------- */

void PeridemBodies::keep_pieces(const std::vector<Grain> &before)
{
  auto old = before.begin();
  for (auto &grain : grains) {
    while (old != before.end() && old->id < grain.id) ++old;
    if (old == before.end() || old->id != grain.id) continue;
    if (!old->shared && !grain.shared && old->last - old->first == grain.last - grain.first)
      grain.pieces = old->pieces;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::label(Grain &grain)
{
  const int *const list = nodes.data();
  grain.pieces = pieces.label(list + grain.first, list + grain.last, grain.pieces);
}

/* ----------------------------------------------------------------------
   bonds are missing: all ranks with a part of a grain hear of it
------------------------------------------------------------------------- */

void PeridemBodies::find_broken()
{
  if (!bonds) return;
  broken_seen = bonds->broken.size();
  falling.clear();
  torn_among_ranks = false;
  for (int i = 0; i < atom->nlocal; i++)
    if (grain_of[i] >= 0 && bonds->nref[i] != MAX(bonds->num[i], 0))
      grains[grain_of[i]].broken = true;
  numbers.clear();
  for (const int g : sharing_grains.shared()) numbers.push_back(grains[g].broken ? 1.0 : 0.0);
  sharing_grains.sum(numbers, 1);
  const double *of_grain = numbers.data();
  for (const int g : sharing_grains.shared()) grains[g].broken = *of_grain++ > 0.0;
}

/* ----------------------------------------------------------------------
   what holds together in broken grains, over all ranks
------------------------------------------------------------------------- */

void PeridemBodies::find_pieces()
{
  for (auto &grain : grains)
    if (grain.broken) label(grain);

  std::vector<std::vector<PeridemPieces::Link>> lists;
  for (const int g : sharing_grains.shared()) {
    lists.emplace_back();
    const auto &grain = grains[g];
    if (grain.broken)
      pieces.add_links(nodes.data() + grain.first, nodes.data() + grain.last, lists.back());
  }
  auto links = sharing_grains.swap(lists);
  for (const auto &list : lists) links.insert(links.end(), list.begin(), list.end());
  pieces.join(links);
  for (const int g : sharing_grains.shared())
    if (grains[g].broken)
      pieces.relabel(nodes.data() + grains[g].first, nodes.data() + grains[g].last);
}

/* ----------------------------------------------------------------------
   collective
------------------------------------------------------------------------- */

void PeridemBodies::find_bodies()
{
  changes++;
  find_broken();
  find_pieces();
  bodies.clear();
  for (const auto &grain : grains) grain.broken ? add_pieces(grain) : add_whole(grain);
  add_loose();
  number_bodies();
  find_origins();
  pushed.clear();
  started = false;
}

/* ----------------------------------------------------------------------
   numbers of grains are even, those of pieces odd
------------------------------------------------------------------------- */

void PeridemBodies::add_whole(const Grain &grain)
{
  Body body;
  body.id = 2 * static_cast<bigint>(grain.id);
  body.first = grain.first;
  body.last = grain.last;
  bodies.push_back(body);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::add_pieces(const Grain &grain)
{
  std::sort(nodes.begin() + grain.first, nodes.begin() + grain.last, [this](int i, int j) {
    const tagint a = pieces.label_of(i), b = pieces.label_of(j);
    return a != b ? a < b : i < j;
  });
  for (int n = grain.first; n < grain.last; n++) {
    const bigint id = 2 * static_cast<bigint>(pieces.label_of(nodes[n])) + 1;
    if (n == grain.first || bodies.back().id != id) {
      bodies.emplace_back();
      bodies.back().id = id;
      bodies.back().first = n;
    }
    bodies.back().last = n + 1;
  }
}

/* ----------------------------------------------------------------------
   a node of no grain is a body by itself
------------------------------------------------------------------------- */

void PeridemBodies::add_loose()
{
  for (int i = 0; i < atom->nlocal; i++) {
    if (grain_of[i] >= 0) continue;
    Body body;
    body.id = 2 * static_cast<bigint>(atom->tag[i]) + 1;
    body.first = static_cast<int>(nodes.size());
    body.last = body.first + 1;
    nodes.push_back(i);
    bodies.push_back(body);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::number_bodies()
{
  std::sort(bodies.begin(), bodies.end(), [](const Body &a, const Body &b) {
    return a.id < b.id;
  });
  std::vector<bigint> ids;
  ids.reserve(bodies.size());
  for (const auto &body : bodies) ids.push_back(body.id);
  sharing.find(ids);
  for (const int b : sharing.shared()) bodies[b].shared = true;
  body_of.resize(atom->nlocal);
  for (std::size_t b = 0; b < bodies.size(); b++)
    for (int n = bodies[b].first; n < bodies[b].last; n++) body_of[nodes[n]] = static_cast<int>(b);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::find_unwrap(Body &body) const
{
  const bool periodic = domain->xperiodic || domain->yperiodic || domain->zperiodic;
  body.unwrap = periodic && body.shared;
  for (int n = body.first; n < body.last && periodic && !body.unwrap; n++)
    body.unwrap = atom->image[nodes[n]] != atom->image[nodes[body.first]];
}

/* ----------------------------------------------------------------------
   sums about an origin far away would lose digits; all ranks have the same one
------------------------------------------------------------------------- */

void PeridemBodies::find_origins()
{
  for (auto &body : bodies) {
    find_unwrap(body);
    place_of(nodes[body.first], body, body.origin);
  }

  constexpr int N = 4;
  numbers.clear();
  for (const int b : sharing.shared()) {
    numbers.push_back(1.0);
    for (const double x : bodies[b].origin) numbers.push_back(x);
  }
  sharing.sum(numbers, N);
  const double *of_body = numbers.data();
  for (const int b : sharing.shared()) {
    for (int k = 0; k < 3; k++) bodies[b].origin[k] = of_body[1 + k] / of_body[0];
    of_body += N;
  }
}

/* ----------------------------------------------------------------------
   bonds that have broken since: which grains may have fallen apart?
------------------------------------------------------------------------- */

bool PeridemBodies::torn()
{
  if (!bonds) return false;
  for (; broken_seen < bonds->broken.size(); broken_seen++) {
    const auto &bond = bonds->broken[broken_seen];
    const int g = grain_of[bond.i];
    if (g < 0 || pieces.still_tied(bond.i, bond.j)) continue;
    if (grains[g].shared)
      torn_among_ranks = true;
    else if (std::find(falling.begin(), falling.end(), g) == falling.end())
      falling.push_back(g);
  }
  return torn_among_ranks;
}

/* ----------------------------------------------------------------------
   a grain of this rank alone falls apart: its bodies so far stay, without nodes
------------------------------------------------------------------------- */

void PeridemBodies::split(int g)
{
  auto &grain = grains[g];
  changes++;
  grain.broken = true;
  const auto before = bodies.size();
  label(grain);
  add_pieces(grain);
  for (auto b = before; b < bodies.size(); b++) {
    auto &body = bodies[b];
    find_unwrap(body);
    place_of(nodes[body.first], body, body.origin);
    for (int n = body.first; n < body.last; n++) body_of[nodes[n]] = static_cast<int>(b);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::start(bool any_torn)
{
  if (started) return;
  if (any_torn) find_bodies();
  started = true;
  evaluation++;
  for (const int g : falling) split(g);
  falling.clear();
  start_shared();
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::start_shared()
{
  static_assert(std::is_trivially_copyable<PeridemSums>::value, "sums travel as numbers");
  constexpr int N = sizeof(PeridemSums) / sizeof(double);
  numbers.clear();
  for (const int b : sharing.shared()) {
    const auto part = sum(bodies[b]);
    const auto *const raw = reinterpret_cast<const double *>(&part);
    numbers.insert(numbers.end(), raw, raw + N);
  }
  sharing.sum(numbers, N);
  const auto *of_body = reinterpret_cast<const PeridemSums *>(numbers.data());
  for (const int b : sharing.shared()) {
    bodies[b].motion = PeridemMotion(*of_body++, bodies[b].origin);
    bodies[b].known = evaluation;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::place_of(int i, const Body &body, double *x) const
{
  if (body.unwrap)
    domain->unmap(atom->x[i], atom->image[i], x);
  else
    for (int k = 0; k < 3; k++) x[k] = atom->x[i][k];
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::arm_of(int i, const Body &body, double *arm) const
{
  place_of(i, body, arm);
  for (int k = 0; k < 3; k++) arm[k] -= body.motion.place[k];
  if (domain->dimension == 2) arm[2] = 0.0;
}

/* ----------------------------------------------------------------------
   of the nodes that this rank owns
------------------------------------------------------------------------- */

PeridemSums PeridemBodies::sum(const Body &body) const
{
  if (domain->dimension == 2)
    return body.unwrap ? sum_nodes<2, true>(body) : sum_nodes<2, false>(body);
  return body.unwrap ? sum_nodes<3, true>(body) : sum_nodes<3, false>(body);
}

/* ----------------------------------------------------------------------
   Runs over all nodes of bodies that touch, at each step: rows of x and v lie one behind the other.
   Two sums in turns do not wait for each other.
------------------------------------------------------------------------- */

template <int DIM, bool UNWRAP> PeridemSums PeridemBodies::sum_nodes(const Body &body) const
{
  const double *const places = atom->x[0], *const velocities = atom->v[0];
  const double *const rmass = atom->rmass;
  const double origin[3] = {body.origin[0], body.origin[1], body.origin[2]};
  auto add = [&](int i, PeridemSums &s) {
    const double *const xi = places + 3 * static_cast<std::size_t>(i);
    const double *const v = velocities + 3 * static_cast<std::size_t>(i);
    double x[3] = {};
    if (UNWRAP) domain->unmap(xi, atom->image[i], x);
    for (int k = 0; k < DIM; k++) x[k] = (UNWRAP ? x[k] : xi[k]) - origin[k];
    s.add<DIM>(rmass[i], x, v);
  };
  const int *const list = nodes.data();
  PeridemSums one, other;
  int n = body.first;
  for (; n + 1 < body.last; n += 2) {
    add(list[n], one);
    add(list[n + 1], other);
  }
  if (n < body.last) add(list[n], one);
  return one + other;
}

/* ---------------------------------------------------------------------- */

PeridemBodies::Body &PeridemBodies::moving(int i)
{
  auto &body = bodies[body_of[i]];
  if (body.known != evaluation) {
    body.motion = PeridemMotion(sum(body), body.origin);
    body.known = evaluation;
  }
  return body;
}

/* ---------------------------------------------------------------------- */

PeridemBody PeridemBodies::body(int i)
{
  const auto &mine = moving(i);
  const auto &motion = mine.motion;
  PeridemBody body;
  double arm[3];
  body.name(mine.id);
  arm_of(i, mine, arm);
  motion.velocity_at(arm, body.velocity);
  for (int k = 0; k < 3; k++) body.offset[k] = -arm[k];
  body.lightness = 1.0 / motion.mass;
  for (int k = 0; k < 6; k++) body.inverse[k] = motion.inverse[k];
  return body;
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::push(int i, const double *force)
{
  auto &body = moving(i);
  if (!body.pushed) pushed.push_back(body_of[i]);
  body.pushed = true;
  double arm[3];
  arm_of(i, body, arm);
  for (int k = 0; k < 3; k++) body.force[k] += force[k];
  body.torque[0] += arm[1] * force[2] - arm[2] * force[1];
  body.torque[1] += arm[2] * force[0] - arm[0] * force[2];
  body.torque[2] += arm[0] * force[1] - arm[1] * force[0];
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::apply(PeridemSpread &spread, bool with_others)
{
  if (with_others) sum_pushes();
  for (const int b : pushed) {
    auto &body = bodies[b];
    spread_over(body, spread);
    body.pushed = false;
    for (int k = 0; k < 3; k++) body.force[k] = body.torque[k] = 0.0;
  }
  pushed.clear();
}

/* ----------------------------------------------------------------------
   forces on parts of a body move all of it
------------------------------------------------------------------------- */

void PeridemBodies::sum_pushes()
{
  constexpr int N = 6;
  numbers.clear();
  for (const int b : sharing.shared()) {
    const auto &body = bodies[b];
    numbers.insert(numbers.end(), body.force, body.force + 3);
    numbers.insert(numbers.end(), body.torque, body.torque + 3);
  }
  sharing.sum(numbers, N);
  const double *of_body = numbers.data();
  for (const int b : sharing.shared()) {
    auto &body = bodies[b];
    if (!body.pushed && std::any_of(of_body, of_body + N, [](double p) {
          return p != 0.0;
        })) {
      pushed.push_back(b);
      body.pushed = true;
    }
    for (int k = 0; k < 3; k++) {
      body.force[k] = of_body[k];
      body.torque[k] = of_body[3 + k];
    }
    of_body += N;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::spread_over(const Body &body, PeridemSpread &spread) const
{
  if (domain->dimension == 2)
    body.unwrap ? spread_nodes<2, true>(body, spread) : spread_nodes<2, false>(body, spread);
  else
    body.unwrap ? spread_nodes<3, true>(body, spread) : spread_nodes<3, false>(body, spread);
}

/* ----------------------------------------------------------------------
   as sum_nodes()
------------------------------------------------------------------------- */

template <int DIM, bool UNWRAP>
void PeridemBodies::spread_nodes(const Body &body, PeridemSpread &spread) const
{
  const auto &motion = body.motion;
  const double *const places = atom->x[0], *const rmass = atom->rmass;
  double linear[3], angular[3];    // accelerations
  for (int k = 0; k < 3; k++) linear[k] = body.force[k] / motion.mass;
  motion.angular_acceleration(body.torque, angular);
  for (int n = body.first; n < body.last; n++) {
    const int i = nodes[n];
    const double m = rmass[i], *const xi = places + 3 * static_cast<std::size_t>(i);
    double open[3], arm[3] = {}, force[3] = {};
    if (UNWRAP) domain->unmap(xi, atom->image[i], open);
    for (int k = 0; k < DIM; k++) {
      arm[k] = (UNWRAP ? open[k] : xi[k]) - motion.place[k];
      force[k] = m * linear[k];
    }
    force[0] -= m * angular[2] * arm[1];
    force[1] += m * angular[2] * arm[0];
    if (DIM == 3) {
      force[0] += m * angular[1] * arm[2];
      force[1] -= m * angular[0] * arm[2];
      force[2] += m * (angular[0] * arm[1] - angular[1] * arm[0]);
    }
    spread.add<DIM>(i, force);
  }
}

/* ---------------------------------------------------------------------- */

double PeridemBodies::memory_usage() const
{
  return static_cast<double>(grains.capacity()) * sizeof(Grain) +
      static_cast<double>(bodies.capacity()) * sizeof(Body) +
      static_cast<double>(nodes.capacity() + grain_of.capacity() + body_of.capacity() +
                          pushed.capacity()) *
      sizeof(int) +
      static_cast<double>(numbers.capacity()) * sizeof(double) + sharing.memory_usage() +
      sharing_grains.memory_usage() + pieces.memory_usage();
}

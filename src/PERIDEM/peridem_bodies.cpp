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
#include "comm.h"
#include "domain.h"

#include <algorithm>
#include <type_traits>
#include <unordered_map>

using namespace LAMMPS_NS;

// nodes are on one line if their smallest moment of inertia is this small a part of the others
static constexpr double THIN = 1e-10;

// what is left of a moment of inertia about the centre of mass is rounding below this part of that
// about the origin of the sums
static constexpr double ROUNDING = 1e-12;

/* ---------------------------------------------------------------------- */

static void add_cross(const double *a, const double *b, double factor, double *sum)
{
  sum[0] += factor * (a[1] * b[2] - a[2] * b[1]);
  sum[1] += factor * (a[2] * b[0] - a[0] * b[2]);
  sum[2] += factor * (a[0] * b[1] - a[1] * b[0]);
}

static void add_inertia(double m, const double *r, double *tensor)
{
  tensor[0] += m * (r[1] * r[1] + r[2] * r[2]);
  tensor[1] += m * (r[0] * r[0] + r[2] * r[2]);
  tensor[2] += m * (r[0] * r[0] + r[1] * r[1]);
  tensor[3] -= m * r[0] * r[1];
  tensor[4] -= m * r[0] * r[2];
  tensor[5] -= m * r[1] * r[2];
}

static void multiply(const double *t, const double *v, double *result)
{
  result[0] = t[0] * v[0] + t[3] * v[1] + t[4] * v[2];
  result[1] = t[3] * v[0] + t[1] * v[1] + t[5] * v[2];
  result[2] = t[4] * v[0] + t[5] * v[1] + t[2] * v[2];
}

/* ---------------------------------------------------------------------- */

void PeridemMotion::velocity_at(const double *arm, double *v) const
{
  for (int k = 0; k < 3; k++) v[k] = velocity[k];
  add_cross(spin, arm, 1.0, v);
}

/* ---------------------------------------------------------------------- */

void PeridemMotion::acceleration_at(const double *arm, const double *force, const double *torque,
                                    double *a) const
{
  double angular[3];
  multiply(inverse, torque, angular);
  for (int k = 0; k < 3; k++) a[k] = force[k] / mass;
  add_cross(angular, arm, 1.0, a);
}

/* ----------------------------------------------------------------------
   an impulse along each axis in turn
------------------------------------------------------------------------- */

void PeridemMotion::mobility_at(const double *arm, double *tensor) const
{
  double column[3][3];
  for (int k = 0; k < 3; k++) {
    double impulse[3] = {}, torque[3] = {};
    impulse[k] = 1.0;
    add_cross(arm, impulse, 1.0, torque);
    acceleration_at(arm, impulse, torque, column[k]);
  }
  for (int k = 0; k < 3; k++) tensor[k] = column[k][k];
  tensor[3] = column[0][1];
  tensor[4] = column[0][2];
  tensor[5] = column[1][2];
}

/* ---------------------------------------------------------------------- */

double PeridemBody::mobility_along(const double *n) const
{
  double column[3];
  multiply(mobility, n, column);
  return n[0] * column[0] + n[1] * column[1] + n[2] * column[2];
}

/* ----------------------------------------------------------------------
   nodes on one line do not turn about it, and a single node does not turn at all
------------------------------------------------------------------------- */

void PeridemMotion::turn(const double *momentum, const double *I)
{
  const double half = 0.5 * (I[0] + I[1] + I[2]);
  if (!(half > 0.0)) return;
  const double minor[6] = {I[1] * I[2] - I[5] * I[5], I[0] * I[2] - I[4] * I[4],
                           I[0] * I[1] - I[3] * I[3], I[4] * I[5] - I[2] * I[3],
                           I[3] * I[5] - I[1] * I[4], I[3] * I[4] - I[0] * I[5]};
  const double determinant = I[0] * minor[0] + I[3] * minor[3] + I[4] * minor[4];
  const bool line = determinant < THIN * half * half * half;
  for (int k = 0; k < 6; k++) inverse[k] = line ? I[k] / (half * half) : minor[k] / determinant;
  multiply(inverse, momentum, spin);
}

/* ---------------------------------------------------------------------- */

PeridemBodies::PeridemBodies(LAMMPS *lmp) : Pointers(lmp), sharing(lmp) {}

/* ---------------------------------------------------------------------- */

void PeridemBodies::sort_nodes(const FixPeridemBonds *_bonds)
{
  bonds = _bonds;
  const auto ids = find_grains();
  sharing.find(ids);
  for (const int g : sharing.shared()) grains[g].shared = true;
  find_origins();

  any_broken = false;
  if (bonds) {
    broken_seen = bonds->broken.size();
    for (int i = 0; i < atom->nlocal; i++)
      if (grain_of[i] >= 0 && bonds->nref[i] != MAX(bonds->num[i], 0))
        grains[grain_of[i]].broken = any_broken = true;
  }
  pushed.clear();
  patches.clear();
  patch_of.assign(atom->nlocal, -1);
  started = false;
}

/* ----------------------------------------------------------------------
   owned nodes grain by grain; returns the molecule-IDs of the grains, ascending
------------------------------------------------------------------------- */

std::vector<tagint> PeridemBodies::find_grains()
{
  const tagint *const mol = atom->molecule;
  const int nlocal = atom->nlocal;
  std::unordered_map<tagint, int> numbers_of;
  loose = false;
  for (int i = 0; i < nlocal; i++)
    if (mol[i] == 0)
      loose = true;
    else if (i == 0 || mol[i] != mol[i - 1])
      numbers_of.emplace(mol[i], 0);
  std::vector<tagint> ids;
  ids.reserve(numbers_of.size());
  for (const auto &entry : numbers_of) ids.push_back(entry.first);
  std::sort(ids.begin(), ids.end());
  for (std::size_t g = 0; g < ids.size(); g++) numbers_of[ids[g]] = static_cast<int>(g);

  grain_of.resize(nlocal);
  grains.assign(ids.size(), Grain());
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
  return ids;
}

/* ----------------------------------------------------------------------
   sums about an origin far away would lose digits; all ranks have the same one
------------------------------------------------------------------------- */

void PeridemBodies::find_origins()
{
  const bool periodic = domain->xperiodic || domain->yperiodic || domain->zperiodic;
  for (auto &grain : grains) {
    grain.unwrap = periodic && grain.shared;
    for (int n = grain.first; n < grain.last && periodic && !grain.unwrap; n++)
      grain.unwrap = atom->image[nodes[n]] != atom->image[nodes[grain.first]];
    const auto whole = sum(grain);
    for (int k = 0; k < 3; k++) grain.origin[k] = whole.place[k] / whole.mass;
  }

  constexpr int N = 4;
  numbers.clear();
  for (const int g : sharing.shared()) {
    const auto &grain = grains[g];
    numbers.push_back(grain.last - grain.first);
    for (const double x : grain.origin) numbers.push_back(x * (grain.last - grain.first));
  }
  sharing.sum(numbers, N);
  const double *of_grain = numbers.data();
  for (const int g : sharing.shared()) {
    for (int k = 0; k < 3; k++) grains[g].origin[k] = of_grain[1 + k] / of_grain[0];
    of_grain += N;
  }
}

/* ----------------------------------------------------------------------
   bonds that have broken since local indices were new
------------------------------------------------------------------------- */

void PeridemBodies::note_broken()
{
  if (!bonds) return;
  for (; broken_seen < bonds->broken.size(); broken_seen++) {
    const int g = grain_of[bonds->broken[broken_seen].i];
    if (g >= 0) grains[g].broken = any_broken = true;
  }
}

/* ---------------------------------------------------------------------- */

bool PeridemBodies::any_patch()
{
  note_broken();
  return loose || any_broken;
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::start()
{
  if (started) return;
  started = true;
  evaluation++;
  for (const auto &old : patches) patch_of[old.node] = -1;
  patches.clear();
  note_broken();
  start_shared();
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::start_shared()
{
  static_assert(std::is_trivially_copyable<Sums>::value, "sums travel as numbers");
  constexpr int N = sizeof(Sums) / sizeof(double);
  numbers.clear();
  for (const int g : sharing.shared()) {
    const auto part = sum(grains[g]);
    const auto *const raw = reinterpret_cast<const double *>(&part);
    numbers.insert(numbers.end(), raw, raw + N);
  }
  sharing.sum(numbers, N);
  const auto *of_grain = reinterpret_cast<const Sums *>(numbers.data());
  for (const int g : sharing.shared()) {
    auto &grain = grains[g];
    grain.motion = motion_of(*of_grain, grain.origin);
    grain.known = evaluation;
    grain.broken = of_grain->broken > 0.0;
    any_broken = any_broken || grain.broken;
    of_grain++;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::place_of(int i, const Grain &grain, double *x) const
{
  if (grain.unwrap)
    domain->unmap(atom->x[i], atom->image[i], x);
  else
    for (int k = 0; k < 3; k++) x[k] = atom->x[i][k];
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::arm_of(int i, const Grain &grain, double *arm) const
{
  place_of(i, grain, arm);
  for (int k = 0; k < 3; k++) arm[k] -= grain.motion.place[k];
  if (domain->dimension == 2) arm[2] = 0.0;
}

/* ----------------------------------------------------------------------
   of the nodes that this rank owns
------------------------------------------------------------------------- */

PeridemBodies::Sums PeridemBodies::sum(const Grain &grain) const
{
  Sums sums;
  if (domain->dimension == 2)
    sums = grain.unwrap ? sum_nodes<2, true>(grain) : sum_nodes<2, false>(grain);
  else
    sums = grain.unwrap ? sum_nodes<3, true>(grain) : sum_nodes<3, false>(grain);
  sums.broken = grain.broken ? 1.0 : 0.0;
  return sums;
}

/* ----------------------------------------------------------------------
   runs over all nodes of grains that touch, at each step: rows of x and v lie one behind the other
------------------------------------------------------------------------- */

template <int DIM, bool UNWRAP>
PeridemBodies::Sums PeridemBodies::sum_nodes(const Grain &grain) const
{
  const double *const places = atom->x[0], *const velocities = atom->v[0];
  const double *const rmass = atom->rmass;
  const double origin[3] = {grain.origin[0], grain.origin[1], grain.origin[2]};
  Sums s;
  for (int n = grain.first; n < grain.last; n++) {
    const int i = nodes[n];
    const double m = rmass[i], *const xi = places + 3 * static_cast<std::size_t>(i);
    const double *const v = velocities + 3 * static_cast<std::size_t>(i);
    double open[3], x[3], p[3];
    if (UNWRAP) domain->unmap(xi, atom->image[i], open);
    for (int k = 0; k < DIM; k++) {
      x[k] = (UNWRAP ? open[k] : xi[k]) - origin[k];
      p[k] = m * x[k];
      s.place[k] += p[k];
      s.velocity[k] += m * v[k];
      s.square[k] += p[k] * x[k];
    }
    s.mass += m;
    s.momentum[2] += p[0] * v[1] - p[1] * v[0];
    if (DIM == 2) continue;
    s.momentum[0] += p[1] * v[2] - p[2] * v[1];
    s.momentum[1] += p[2] * v[0] - p[0] * v[2];
    s.square[3] += p[0] * x[1];
    s.square[4] += p[0] * x[2];
    s.square[5] += p[1] * x[2];
  }
  return s;
}

/* ----------------------------------------------------------------------
   from sums about the origin to those about the centre of mass
------------------------------------------------------------------------- */

PeridemMotion PeridemBodies::motion_of(const Sums &sums, const double *origin)
{
  PeridemMotion motion;
  double c[3], momentum[3];
  motion.mass = sums.mass;
  for (int k = 0; k < 3; k++) {
    c[k] = sums.place[k] / sums.mass;
    motion.place[k] = origin[k] + c[k];
    motion.velocity[k] = sums.velocity[k] / sums.mass;
    momentum[k] = sums.momentum[k];
  }
  add_cross(c, motion.velocity, -sums.mass, momentum);

  const double *const q = sums.square;
  double inertia[6] = {q[1] + q[2], q[0] + q[2], q[0] + q[1], -q[3], -q[4], -q[5]};
  const double before = q[0] + q[1] + q[2];
  add_inertia(-sums.mass, c, inertia);
  if (0.5 * (inertia[0] + inertia[1] + inertia[2]) > ROUNDING * before)
    motion.turn(momentum, inertia);
  return motion;
}

/* ---------------------------------------------------------------------- */

const PeridemBodies::Grain &PeridemBodies::moving(int g)
{
  auto &grain = grains[g];
  if (grain.known != evaluation) {
    grain.motion = motion_of(sum(grain), grain.origin);
    grain.known = evaluation;
  }
  return grain;
}

/* ---------------------------------------------------------------------- */

PeridemBody PeridemBodies::body(int i)
{
  PeridemBody body{};
  double arm[3];
  auto fill = [&](const PeridemMotion &motion) {
    for (int k = 0; k < 3; k++) body.offset[k] = -arm[k];
    motion.velocity_at(arm, body.velocity);
    motion.mobility_at(arm, body.mobility);
  };
  if (whole(i)) {
    const auto &grain = moving(grain_of[i]);
    arm_of(i, grain, arm);
    fill(grain.motion);
    body.whole = 1.0;
  } else {
    const auto &motion = patch(i).motion;
    for (int k = 0; k < 3; k++) arm[k] = atom->x[i][k] - motion.place[k];
    fill(motion);
  }
  return body;
}

/* ----------------------------------------------------------------------
   the node and those that intact bonds tie to it
------------------------------------------------------------------------- */

template <class Visit> void PeridemBodies::for_patch(int i, Visit visit) const
{
  visit(i);
  if (!bonds) return;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
    visit(bonds->partner[k]);
}

/* ---------------------------------------------------------------------- */

PeridemMotion PeridemBodies::motion_of_patch(int i) const
{
  double **x = atom->x, **v = atom->v;
  Sums s;
  for_patch(i, [&](int j) {
    const double m = atom->rmass[j], *const u = v[j];
    const double at[3] = {x[j][0] - x[i][0], x[j][1] - x[i][1], x[j][2] - x[i][2]};
    const double p[3] = {m * at[0], m * at[1], m * at[2]};
    s.mass += m;
    for (int k = 0; k < 3; k++) {
      s.place[k] += p[k];
      s.velocity[k] += m * u[k];
      s.square[k] += p[k] * at[k];
    }
    s.momentum[0] += p[1] * u[2] - p[2] * u[1];
    s.momentum[1] += p[2] * u[0] - p[0] * u[2];
    s.momentum[2] += p[0] * u[1] - p[1] * u[0];
    s.square[3] += p[0] * at[1];
    s.square[4] += p[0] * at[2];
    s.square[5] += p[1] * at[2];
  });
  return motion_of(s, x[i]);
}

/* ----------------------------------------------------------------------
   a node may touch several others: its patch is summed once
------------------------------------------------------------------------- */

PeridemBodies::Patch &PeridemBodies::patch(int i)
{
  if (patch_of[i] < 0) {
    patch_of[i] = static_cast<int>(patches.size());
    patches.emplace_back();
    patches.back().node = i;
    patches.back().motion = motion_of_patch(i);
  }
  return patches[patch_of[i]];
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::push(int i, const double *force)
{
  if (!whole(i)) {
    auto &mine = patch(i);
    for (int k = 0; k < 3; k++) mine.force[k] += force[k];
    mine.pushed = true;
    return;
  }
  moving(grain_of[i]);
  auto &grain = grains[grain_of[i]];
  if (!grain.pushed) pushed.push_back(grain_of[i]);
  grain.pushed = true;
  double arm[3];
  arm_of(i, grain, arm);
  for (int k = 0; k < 3; k++) grain.force[k] += force[k];
  add_cross(arm, force, 1.0, grain.torque);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::apply_patches(PeridemSpread &spread)
{
  for (auto &mine : patches) {
    if (mine.pushed) spread_patch(mine, spread);
    mine.pushed = false;
    for (int k = 0; k < 3; k++) mine.force[k] = 0.0;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::spread_patch(const Patch &mine, PeridemSpread &spread) const
{
  const auto &motion = mine.motion;
  double arm[3], torque[3] = {};
  for (int k = 0; k < 3; k++) arm[k] = atom->x[mine.node][k] - motion.place[k];
  add_cross(arm, mine.force, 1.0, torque);
  for_patch(mine.node, [&](int j) {
    double a[3], at[3];
    for (int k = 0; k < 3; k++) at[k] = atom->x[j][k] - motion.place[k];
    motion.acceleration_at(at, mine.force, torque, a);
    for (int k = 0; k < 3; k++) a[k] *= atom->rmass[j];
    spread.add(j, a);
  });
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::apply(PeridemSpread &spread)
{
  sum_pushes();
  for (const int g : pushed) {
    auto &grain = grains[g];
    spread_over(grain, spread);
    grain.pushed = false;
    for (int k = 0; k < 3; k++) grain.force[k] = grain.torque[k] = 0.0;
  }
  pushed.clear();
}

/* ----------------------------------------------------------------------
   forces on parts of a grain move all of it
------------------------------------------------------------------------- */

void PeridemBodies::sum_pushes()
{
  constexpr int N = 6;
  numbers.clear();
  for (const int g : sharing.shared()) {
    const auto &grain = grains[g];
    numbers.insert(numbers.end(), grain.force, grain.force + 3);
    numbers.insert(numbers.end(), grain.torque, grain.torque + 3);
  }
  sharing.sum(numbers, N);
  const double *of_grain = numbers.data();
  for (const int g : sharing.shared()) {
    auto &grain = grains[g];
    if (!grain.pushed && std::any_of(of_grain, of_grain + N, [](double p) {
          return p != 0.0;
        })) {
      pushed.push_back(g);
      grain.pushed = true;
    }
    for (int k = 0; k < 3; k++) {
      grain.force[k] = of_grain[k];
      grain.torque[k] = of_grain[3 + k];
    }
    of_grain += N;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::spread_over(const Grain &grain, PeridemSpread &spread) const
{
  if (domain->dimension == 2)
    grain.unwrap ? spread_nodes<2, true>(grain, spread) : spread_nodes<2, false>(grain, spread);
  else
    grain.unwrap ? spread_nodes<3, true>(grain, spread) : spread_nodes<3, false>(grain, spread);
}

/* ----------------------------------------------------------------------
   as sum_nodes()
------------------------------------------------------------------------- */

template <int DIM, bool UNWRAP>
void PeridemBodies::spread_nodes(const Grain &grain, PeridemSpread &spread) const
{
  const auto &motion = grain.motion;
  const double *const places = atom->x[0], *const rmass = atom->rmass;
  double linear[3], angular[3];    // accelerations
  for (int k = 0; k < 3; k++) linear[k] = grain.force[k] / motion.mass;
  multiply(motion.inverse, grain.torque, angular);
  for (int n = grain.first; n < grain.last; n++) {
    const int i = nodes[n];
    const double m = rmass[i], *const xi = places + 3 * static_cast<std::size_t>(i);
    double open[3], arm[3] = {}, force[3] = {};
    if (UNWRAP) domain->unmap(xi, atom->image[i], open);
    for (int k = 0; k < DIM; k++) {
      arm[k] = (UNWRAP ? open[k] : xi[k]) - motion.place[k];
      force[k] = m * linear[k];
    }
    if (DIM == 3)
      add_cross(angular, arm, m, force);
    else {
      force[0] -= m * angular[2] * arm[1];
      force[1] += m * angular[2] * arm[0];
    }
    spread.add_owned<DIM>(i, force);
  }
}

/* ---------------------------------------------------------------------- */

double PeridemBodies::memory_usage() const
{
  return static_cast<double>(grains.capacity()) * sizeof(Grain) +
      static_cast<double>(nodes.capacity() + grain_of.capacity() + pushed.capacity()) *
      sizeof(int) +
      static_cast<double>(numbers.capacity()) * sizeof(double) + sharing.memory_usage();
}

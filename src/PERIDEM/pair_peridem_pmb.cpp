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

#include "pair_peridem_pmb.h"

#include "fix_peridem_bonds.h"
#include "peridem_general.h"

#include "atom.h"
#include "comm.h"
#include "force.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// the vectorised pass picks rows that may hold a breaking bond; the scalar pass over such a row
// decides. The margin covers what the two may differ by.
static constexpr double MARGIN = 1.0e-10;

// square of a distance below which two nodes have no direction: no force, no division by 0
static constexpr double TINY = 1.0e-300;

// A bond of the regularised potential counts as broken at this many times the stretch at which it
// pulls hardest: exp(-50) of its stiffness and of its energy are then left.
static constexpr double SOFTENED = 10.0;

/* ---------------------------------------------------------------------- */

double PairPeridemPMB::Law::softening(double R, double s) const
{
  return beta > 0.0 ? std::exp(-beta * R * s * s) : 1.0;
}

/* ---------------------------------------------------------------------- */

double PairPeridemPMB::Law::energy(double R, double s) const
{
  return beta > 0.0 ? -0.5 * c / beta * std::expm1(-beta * R * s * s) : 0.5 * c * R * s * s;
}

/* ----------------------------------------------------------------------
   fraction of the stretch that breaks
------------------------------------------------------------------------- */

double PairPeridemPMB::Law::reached(double R, double s) const
{
  const double measure = beta > 0.0 ? s * std::sqrt(R) : s;
  return (both ? std::fabs(measure) : measure) / s0;
}

/* ---------------------------------------------------------------------- */

PairPeridemPMB::PairPeridemPMB(LAMMPS *lmp) : PairPeridem(lmp, "peridem/pmb") {}

/* ---------------------------------------------------------------------- */

PairPeridemPMB::~PairPeridemPMB() = default;

/* ---------------------------------------------------------------------- */

void PairPeridemPMB::init_style()
{
  PairPeridem::init_style();

  const int ntypes = atom->ntypes;
  laws.assign(index(ntypes, ntypes) + 1, Law());
  for (int i = 1; i <= ntypes; i++) {
    if (!covers(i)) continue;
    report(i);
    for (int j = 1; j <= ntypes; j++) {
      if (!covers(j)) continue;
      laws[index(i, j)] = make_law(material(i, j));
    }
  }
  init_list();
}

/* ---------------------------------------------------------------------- */

void PairPeridemPMB::init_list()
{
  list_version = -1;
  std::vector<PeridemGeneral::Law> of_types(atom->ntypes + 1);
  for (int i = 1; i <= atom->ntypes; i++) {
    if (!covers(i) || law(i, i).beta > 0.0) continue;
    auto &one = of_types[i];
    one.s0 = one.least = law(i, i).s0;
    one.both = one.any_both = law(i, i).both;
    one.viscous = law(i, i).dashpot > 0.0;
    one.horizon = material(i, i).horizon;
  }
  if (!list)
    list = std::make_unique<PeridemGeneral>(lmp, [this](int i) {
      careful_row(i);
    });
  list->init(bonds, of_types, PeridemGeneral::WEIGHT_OVER_LENGTH);
}

/* ----------------------------------------------------------------------
   those of the regularised potential, and of grains of several types
------------------------------------------------------------------------- */

bool PairPeridemPMB::reads_rows() const
{
  int types = 0;
  bool soft = false;
  for (int i = 1; i <= atom->ntypes; i++) {
    if (!covers(i)) continue;
    types++;
    soft = soft || law(i, i).beta > 0.0;
  }
  return soft || types > 1 || PairPeridem::reads_rows();
}

/* ---------------------------------------------------------------------- */

PairPeridemPMB::Law PairPeridemPMB::make_law(const PeridemMaterial &mat) const
{
  Law one;
  one.c = mat.micromodulus();
  one.dashpot = one.c * mat.viscosity / mat.shear;
  one.both = mat.break_both;
  one.s0 = mat.s0;
  if (mat.potential == PeridemMaterial::RNP) {
    one.beta = mat.rnp_beta();
    one.s0 = mat.strength == PeridemMaterial::UNBREAKABLE
        ? INFINITE
        : SOFTENED * mat.s0 * std::sqrt(mat.horizon);
  }
  return one;
}

/* ----------------------------------------------------------------------
   say what followed from what was given
------------------------------------------------------------------------- */

void PairPeridemPMB::report(int itype) const
{
  if (comm->me) return;
  const auto &own = material(itype, itype);
  auto text = fmt::format("PERIDEM: type {}: micro-modulus {:.6g}", itype, own.micromodulus());
  if (own.potential == PeridemMaterial::RNP)
    text += fmt::format(", C {:.6g}, beta {:.6g}; bonds as long as the horizon pull hardest at "
                        "stretch {:.6g}",
                        own.rnp_depth(), own.rnp_beta(), own.s0);
  else if (own.strength == PeridemMaterial::GC)
    text += fmt::format(", critical stretch {:.6g} from gc {:.6g}{}", own.s0, own.gc,
                        own.spacing_text());
  utils::logmesg(lmp, text + "\n");
}

/* ---------------------------------------------------------------------- */

bool PairPeridemPMB::listed(int i) const
{
  const int itype = atom->type[i];
  return bonds->num[i] > 0 && !bonds->rigid[i] && covers(itype) && !bonds->mixed[i] &&
      !(law(itype, itype).beta > 0.0);
}

/* ---------------------------------------------------------------------- */

void PairPeridemPMB::update_list()
{
  if (list_version == bonds->version) return;
  list->build([this](int i) {
    return listed(i);
  });
  const int nall = atom->nlocal + atom->nghost;
  half_spring.assign(nall, 0.0);
  half_dashpot.assign(nall, 0.0);
  for (int i = 0; i < nall; i++) {
    const int itype = atom->type[i];
    if (!covers(itype)) continue;
    half_spring[i] = 0.5 * law(itype, itype).c;
    half_dashpot[i] = 0.5 * law(itype, itype).dashpot;
  }
  list_version = bonds->version;
}

/* ----------------------------------------------------------------------
   one pass: bonds do not know of each other
------------------------------------------------------------------------- */

void PairPeridemPMB::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  update_list();
  list->first_pass(half_spring.data(), half_dashpot.data());
  list->add_forces(atom->f[0]);

  for (int i = 0; i < atom->nlocal; i++) {
    if (bonds->num[i] <= 0 || bonds->rigid[i] || !covers(atom->type[i])) continue;
    if (!listed(i)) row(i);
    if (evflag) tally(i);
  }
  if (books.open) book_viscous_forces();
}

/* ----------------------------------------------------------------------
   forces of the bonds of a node, whatever they are; which of them break
------------------------------------------------------------------------- */

void PairPeridemPMB::row(int i)
{
  double fi[3] = {0.0, 0.0, 0.0};
  const double reached = bonds->mixed[i] ? INFINITE : fast_row(i, fi);
  if (reached > 1.0 - MARGIN) {
    careful_row(i);
    slow_row(i, fi);
  } else if (reached > bonds->maxstretch[i]) {
    bonds->maxstretch[i] = reached;
  }
  for (int m = 0; m < 3; m++) atom->f[i][m] += fi[m];
}

/* ---------------------------------------------------------------------- */

PairPeridemPMB::Bond PairPeridemPMB::look_at(int i, bigint k) const
{
  double **x = atom->x;
  Bond bond;
  bond.j = bonds->partner(i, k);
  double rsq = TINY;
  for (int m = 0; m < 3; m++) {
    bond.d[m] = x[bond.j][m] - x[i][m];
    rsq += bond.d[m] * bond.d[m];
  }
  bond.r = std::sqrt(rsq);
  bond.R = bonds->length[k];
  bond.s = (bond.r - bond.R) / bond.R;
  bond.weight = bonds->weight(i, bond.j, k);
  return bond;
}

/* ---------------------------------------------------------------------- */

template <class What> void PairPeridemPMB::each_bond(int i, What what) const
{
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) what(look_at(i, k));
}

/* ----------------------------------------------------------------------
   how fast a bond gets longer
------------------------------------------------------------------------- */

double PairPeridemPMB::rate(int i, const Bond &bond) const
{
  double **v = atom->v;
  double sum = 0.0;
  for (int m = 0; m < 3; m++) sum += (v[bond.j][m] - v[i][m]) * bond.d[m];
  return sum / bond.r;
}

/* ----------------------------------------------------------------------
   all bonds of node i lead to its own type: sum of their forces, returns the largest fraction of
   the critical stretch
------------------------------------------------------------------------- */

double PairPeridemPMB::fast_row(int i, double *f) const
{
  const auto &one = law(atom->type[i], atom->type[i]);
  return one.dashpot > 0.0 ? fast_row<true>(i, one, f) : fast_row<false>(i, one, f);
}

/* ---------------------------------------------------------------------- */

template <bool VISCOUS> double PairPeridemPMB::fast_row(int i, const Law &one, double *f) const
{
  const double *const x = atom->x[0];
  const double *const v = atom->v[0];
  const int *const partner = bonds->partners.data();
  const double *const length = bonds->length.data();
  const double *const weight = bonds->weights.data();
  const double xi = x[3 * i], yi = x[3 * i + 1], zi = x[3 * i + 2];
  const double vx = v[3 * i], vy = v[3 * i + 1], vz = v[3 * i + 2];
  const double c = one.c, dashpot = one.dashpot, beta = one.beta;
  const bigint begin = bonds->start[i], end = begin + bonds->num[i];

  double fx = 0.0, fy = 0.0, fz = 0.0, top = -INFINITE, bottom = INFINITE;
#if defined(_OPENMP) || defined(__GNUC__)
#pragma omp simd reduction(+ : fx, fy, fz) reduction(max : top) reduction(min : bottom)
#endif
  for (bigint k = begin; k < end; k++) {
    const int j = 3 * partner[k];
    const double dx = x[j] - xi, dy = x[j + 1] - yi, dz = x[j + 2] - zi;
    const double r = std::sqrt(dx * dx + dy * dy + dz * dz + TINY);
    const double R = length[k];
    const double s = (r - R) / R;
    double pull = c * s;
    if (VISCOUS)
      pull += dashpot * ((v[j] - vx) * dx + (v[j + 1] - vy) * dy + (v[j + 2] - vz) * dz) / (r * R);
    pull *= std::exp(-beta * R * s * s) * weight[k] / r;
    fx += pull * dx;
    fy += pull * dy;
    fz += pull * dz;
    const double measure = s * std::sqrt(R);
    top = measure > top ? measure : top;
    bottom = measure < bottom ? measure : bottom;
  }
  f[0] = fx;
  f[1] = fy;
  f[2] = fz;
  return (one.both ? MAX(top, -bottom) : top) / one.s0;
}

/* ----------------------------------------------------------------------
   look at every bond of node i: how far it is stretched, whether it breaks. The other end runs the
   same lines on the same numbers and decides alike.
------------------------------------------------------------------------- */

void PairPeridemPMB::careful_row(int i)
{
  const int *const type = atom->type;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i];) {
    const Bond bond = look_at(i, k);
    if (atom->mask[i] & atom->mask[bond.j] & bonds->unbroken_bit) {
      k++;
      continue;
    }
    const double reached = law(type[i], type[bond.j]).reached(bond.R, bond.s);
    if (reached > bonds->maxstretch[i]) bonds->maxstretch[i] = reached;
    if (reached > 1.0) {
      broken_energy += 0.5 * energy_to_break(i, bond);
      bonds->break_bond(i, k);
    } else
      k++;
  }
}

/* ---------------------------------------------------------------------- */

double PairPeridemPMB::energy_to_break(int i, const Bond &bond) const
{
  const auto &one = law(atom->type[i], atom->type[bond.j]);
  const double energy = bond.weight * one.energy(bond.R, bond.s);
  const double late = time_without_broken();
  return late > 0.0 ? energy - late * spring(i, bond) * rate(i, bond) : energy;
}

/* ----------------------------------------------------------------------
   what a bond pulls with: its spring, and its dashpot, which softens with the spring
------------------------------------------------------------------------- */

double PairPeridemPMB::spring(int i, const Bond &bond) const
{
  const auto &one = law(atom->type[i], atom->type[bond.j]);
  return bond.weight * one.c * bond.s * one.softening(bond.R, bond.s);
}

/* ---------------------------------------------------------------------- */

double PairPeridemPMB::viscous(int i, const Bond &bond) const
{
  const auto &one = law(atom->type[i], atom->type[bond.j]);
  if (!(one.dashpot > 0.0)) return 0.0;
  return bond.weight * one.dashpot * rate(i, bond) / bond.R * one.softening(bond.R, bond.s);
}

/* ---------------------------------------------------------------------- */

void PairPeridemPMB::slow_row(int i, double *f) const
{
  f[0] = f[1] = f[2] = 0.0;
  each_bond(i, [&](const Bond &bond) {
    const double force = (spring(i, bond) + viscous(i, bond)) / bond.r;
    for (int m = 0; m < 3; m++) f[m] += force * bond.d[m];
  });
}

/* ----------------------------------------------------------------------
   energy and virial; each end of a bond tallies its half
------------------------------------------------------------------------- */

void PairPeridemPMB::tally(int i)
{
  if (eflag_either) {
    const double energy = strain_energy(i);
    if (eflag_global) eng_vdwl += energy;
    if (eflag_atom) eatom[i] += energy;
  }
  if (!vflag_either) return;

  double w[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  each_bond(i, [&](const Bond &bond) {
    const double half = 0.5 * (spring(i, bond) + viscous(i, bond)) / bond.r;
    const double *const d = bond.d;
    w[0] -= half * d[0] * d[0];
    w[1] -= half * d[1] * d[1];
    w[2] -= half * d[2] * d[2];
    w[3] -= half * d[0] * d[1];
    w[4] -= half * d[0] * d[2];
    w[5] -= half * d[1] * d[2];
  });
  for (int m = 0; m < 6; m++) {
    if (vflag_global) virial[m] += w[m];
    if (vflag_atom) vatom[i][m] += w[m];
  }
}

/* ----------------------------------------------------------------------
   the forces of the dashpots alone, once more: only while energies are booked
------------------------------------------------------------------------- */

void PairPeridemPMB::book_viscous_forces()
{
  books.clear(atom->nlocal);
  for (int i = 0; i < atom->nlocal; i++)
    if (covers(atom->type[i]))
      each_bond(i, [&](const Bond &bond) {
        PeridemBooks::add(books.damping, i, bond.d, viscous(i, bond) / bond.r);
      });
}

/* ----------------------------------------------------------------------
   half of what the bonds of node i hold
------------------------------------------------------------------------- */

double PairPeridemPMB::strain_energy(int i) const
{
  const int *const type = atom->type;
  double sum = 0.0;
  each_bond(i, [&](const Bond &bond) {
    sum += 0.5 * bond.weight * law(type[i], type[bond.j]).energy(bond.R, bond.s);
  });
  return sum;
}

/* ----------------------------------------------------------------------
   d/m_i sum w R e v V_j, as in the linear peridynamic solid; for output only
------------------------------------------------------------------------- */

double PairPeridemPMB::dilatation(int i) const
{
  const double m = bonds->wvolume[i];
  if (!(m > 0.0)) return 0.0;
  double sum = 0.0;
  each_bond(i, [&](const Bond &bond) {
    sum += bond.weight * bond.R * bond.R * bond.s;
  });
  const int itype = atom->type[i];
  return material(itype, itype).dim() * sum / (m * atom->vfrac[i]);
}

/* ----------------------------------------------------------------------
   sigma_i = 1/J sum t_i v V_j n (x) (x_j - x_i), with t_i = half the pull of the bond's spring and
   J = 1 + dilatation
------------------------------------------------------------------------- */

void PairPeridemPMB::stress(int i, double *sigma) const
{
  for (int k = 0; k < 6; k++) sigma[k] = 0.0;
  if (!(bonds->wvolume[i] > 0.0)) return;
  each_bond(i, [&](const Bond &bond) {
    const double t = 0.5 * spring(i, bond) / bond.r;
    const double *const d = bond.d;
    sigma[0] += t * d[0] * d[0];
    sigma[1] += t * d[1] * d[1];
    sigma[2] += t * d[2] * d[2];
    sigma[3] += t * d[0] * d[1];
    sigma[4] += t * d[0] * d[2];
    sigma[5] += t * d[1] * d[2];
  });
  const double J = 1.0 + dilatation(i);
  for (int k = 0; k < 6; k++) sigma[k] /= atom->vfrac[i] * (J > 0.0 ? J : 1.0);
  const auto &own = material(atom->type[i], atom->type[i]);
  if (own.plane == PeridemMaterial::STRAIN) sigma[2] = own.poisson() * (sigma[0] + sigma[1]);
}

/* ----------------------------------------------------------------------
   bonds change length by n (u_j - u_i). Those of the regularised potential are taken as stiff as
   they are unstretched, where they are stiffest.
------------------------------------------------------------------------- */

void PairPeridemPMB::apply_stiffness(const std::vector<double> &u, std::vector<double> &force)
{
  const int *const type = atom->type;
  std::fill(force.begin(), force.end(), 0.0);
  const bool use_list = list_version == bonds->version;
  if (use_list) {
    list->first_response(u, half_spring.data());
    list->add_forces(force.data());
  }
  for (int i = 0; i < atom->nlocal; i++) {
    if (!covers(type[i]) || (use_list && listed(i))) continue;
    double *const f = &force[3 * i];
    each_bond(i, [&](const Bond &bond) {
      double e = 0.0;
      for (int m = 0; m < 3; m++) e += bond.d[m] / bond.r * (u[3 * bond.j + m] - u[3 * i + m]);
      const double t = bond.weight * law(type[i], type[bond.j]).c * e / bond.R;
      for (int m = 0; m < 3; m++) f[m] += t * bond.d[m] / bond.r;
    });
  }
}

/* ---------------------------------------------------------------------- */

double PairPeridemPMB::memory_usage()
{
  return Pair::memory_usage() + (list ? list->memory_usage() : 0.0) +
      static_cast<double>((half_spring.capacity() + half_dashpot.capacity()) * sizeof(double));
}

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

#include "pair_peridem_lps.h"

#include "fix_peridem_bonds.h"
#include "peridem_batch.h"
#include "peridem_general.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "memory.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

using namespace LAMMPS_NS;

// square of a distance below which two nodes have no direction: no force, no division by 0
static constexpr double TINY = 1.0e-300;

/* ---------------------------------------------------------------------- */

PairPeridemLPS::PairPeridemLPS(LAMMPS *lmp) : PairPeridem(lmp, "peridem/lps") {}

/* ---------------------------------------------------------------------- */

PairPeridemLPS::~PairPeridemLPS()
{
  memory->destroy(theta);
  memory->destroy(pressure);
  memory->destroy(stiffness);
  memory->destroy(dashpot);
}

/* ----------------------------------------------------------------------
   engine auto|general|batched
------------------------------------------------------------------------- */

void PairPeridemLPS::settings(int narg, char **arg)
{
  static const char *const known[] = {"auto", "general", "batched"};
  engine = AUTO;
  if (narg) {
    if (strcmp(arg[0], "engine") != 0)
      error->all(FLERR, Error::NOPOINTER, "Unknown pair style {} keyword {}: known is engine", name,
                 arg[0]);
    if (narg != 2)
      error->all(FLERR, Error::NOPOINTER,
                 "Pair style {} engine needs one word: auto, general or batched", name);
    const auto *const which = std::find(known, known + 3, std::string(arg[1]));
    if (which == known + 3)
      error->all(FLERR, Error::NOPOINTER,
                 "Pair style {} engine {}: must be auto, general or batched", name, arg[1]);
    engine = static_cast<int>(which - known);
  }
  PairPeridem::settings(0, nullptr);
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::init_style()
{
  PairPeridem::init_style();

  const int ntypes = atom->ntypes;
  moduli.assign(ntypes + 1, {0.0, 0.0, 0.0});
  any_viscous = false;
  for (int i = 1; i <= ntypes; i++) {
    if (!covers(i)) continue;
    auto &of_type = moduli[i];
    const auto &own = material(i, i);
    of_type.dilatation_modulus = own.dilatation_modulus();
    of_type.extension_modulus = own.extension_modulus();
    of_type.viscous_modulus = own.viscous_modulus();
    any_viscous = any_viscous || own.viscosity > 0.0;
    if (own.strength == PeridemMaterial::GC && comm->me == 0)
      utils::logmesg(lmp, "PERIDEM: type {}: critical stretch {:.6g} from gc {:.6g}{}\n", i, own.s0,
                     own.gc, own.spacing_text());
  }
  constants_version = -1;
  init_general();
  init_batch();
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::init_general()
{
  list_version = -1;
  const int ntypes = atom->ntypes;
  std::vector<PeridemGeneral::Law> laws(ntypes + 1);
  for (int i = 1; i <= ntypes; i++) {
    if (!covers(i)) continue;
    auto &law = laws[i];
    law.s0 = material(i, i).s0;
    law.both = material(i, i).break_both;
    law.viscous = material(i, i).viscosity > 0.0;
    law.horizon = material(i, i).horizon;
    for (int j = 1; j <= ntypes; j++) {
      if (!covers(j)) continue;
      law.least = MIN(law.least, material(i, j).s0);
      law.any_both = law.any_both || material(i, j).break_both;
    }
  }
  if (!general)
    general = std::make_unique<PeridemGeneral>(lmp, [this](int i) {
      careful_row(i);
    });
  general->init(bonds, laws, PeridemGeneral::WEIGHT);
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::init_batch()
{
  batch_version = -1;
  batching = theta_stale = false;
  if (engine == GENERAL) {
    batch.reset();
    return;
  }
  std::vector<PeridemBatch::Law> laws(atom->ntypes + 1);
  for (int i = 1; i <= atom->ntypes; i++) {
    laws[i].here = covers(i);
    if (!covers(i)) continue;
    const auto &own = material(i, i);
    laws[i].softness = own.dilatation_modulus() * own.dim();
    laws[i].s0 = own.s0;
    laws[i].both = own.break_both;
    laws[i].viscous = own.viscosity > 0.0;
  }
  if (!batch)
    batch = std::make_unique<PeridemBatch>(lmp, [this](int i) {
      careful_row(i);
    });
  batch->init(bonds, laws, engine == BATCHED);
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  grow();
  if (constants_version != bonds->version) node_constants();

  if (batch && batch_version != bonds->version) {
    batch->plan(stiffness, dashpot);
    batch_version = bonds->version;
    list_version = -1;
  }

  // energy and virial of single nodes are tallied by the general engine alone

  const bool batched_before = batching;
  batching = batch && !(eflag_atom || vflag_atom || cvflag_atom);
  if (batching != batched_before) list_version = -1;
  theta_stale = false;
  if (batching) {
    batch->compute(evflag);
    if (eflag_global) eng_vdwl += batch->energy();
    if (vflag_global)
      for (int m = 0; m < 6; m++) virial[m] += batch->virial()[m];
  }
  if (!batching || batch->general_too()) general_passes();
  theta_stale = batching;
  if (batch && !batching && batch->outdated()) batch_version = -1;
  if (books.open) book_viscous_forces();
}

/* ----------------------------------------------------------------------
   nodes that are in no batch
------------------------------------------------------------------------- */

void PairPeridemLPS::general_passes()
{
  if (list_version != bonds->version) {
    general->build([this](int i) {
      return !elsewhere(i);
    });
    list_version = bonds->version;
  }
  general->first_pass(stiffness, dashpot);
  std::fill_n(theta, atom->nlocal, 0.0);
  std::fill_n(pressure, atom->nlocal, 0.0);
  general->each_sum([this](int i, double sum) {
    set_dilatation(i, sum);
  });
  to_ghosts(pressure, 1);
  general->second_pass(pressure);
  general->add_forces(atom->f[0]);
  if (evflag) tally();
}

/* ----------------------------------------------------------------------
   has node i nothing to compute here?
------------------------------------------------------------------------- */

inline bool PairPeridemLPS::elsewhere(int i) const
{
  return bonds->num[i] <= 0 || bonds->rigid[i] || (batching && batch->covers(i));
}

/* ----------------------------------------------------------------------
   dilatations that the batches hold, once somebody asks
------------------------------------------------------------------------- */

void PairPeridemLPS::fetch_dilatations() const
{
  if (!theta_stale) return;
  theta_stale = false;
  batch->each_sum([this](int i, double sum) {
    set_dilatation(i, sum);
  });
}

/* ---------------------------------------------------------------------- */

double PairPeridemLPS::dilatation(int i) const
{
  if (!theta) return 0.0;
  fetch_dilatations();
  return theta[i];
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::grow()
{
  if (atom->nmax <= nmax) return;
  nmax = atom->nmax;
  memory->destroy(theta);
  memory->destroy(pressure);
  memory->destroy(stiffness);
  memory->destroy(dashpot);
  memory->create(theta, nmax, "peridem/lps:theta");
  memory->create(pressure, nmax, "peridem/lps:pressure");
  memory->create(stiffness, nmax, "peridem/lps:stiffness");
  memory->create(dashpot, nmax, "peridem/lps:dashpot");
  constants_version = -1;
}

/* ----------------------------------------------------------------------
   what depends on the type and the weighted volume alone; a node without family has no stiffness
------------------------------------------------------------------------- */

void PairPeridemLPS::node_constants()
{
  const int nall = atom->nlocal + atom->nghost;
  const int *const type = atom->type;
  const double *const m = bonds->wvolume;
  for (int i = 0; i < nall; i++) {
    pressure[i] = 0.0;
    stiffness[i] = m[i] > 0.0 ? moduli[type[i]].extension_modulus / m[i] : 0.0;
    dashpot[i] = m[i] > 0.0 ? moduli[type[i]].viscous_modulus / m[i] : 0.0;
  }
  constants_version = bonds->version;
}

/* ----------------------------------------------------------------------
   sum = sum over bonds of w v V_i V_j R e
------------------------------------------------------------------------- */

void PairPeridemLPS::set_dilatation(int i, double sum) const
{
  const double m = bonds->wvolume[i];
  if (!(m > 0.0)) return;
  const int itype = atom->type[i];
  theta[i] = material(itype, itype).dim() * sum / (m * atom->vfrac[i]);
  pressure[i] = moduli[itype].dilatation_modulus * theta[i] / m;
}

/* ----------------------------------------------------------------------
   sum of w v V_i V_j R e over the bonds of node i
------------------------------------------------------------------------- */

double PairPeridemLPS::extension_sum(int i) const
{
  double **x = atom->x;
  double sum = 0.0;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    const double dx = x[j][0] - x[i][0], dy = x[j][1] - x[i][1], dz = x[j][2] - x[i][2];
    const double R = bonds->length[k];
    sum += bonds->weight(i, j, k) * R * (std::sqrt(dx * dx + dy * dy + dz * dz) - R);
  }
  return sum;
}

/* ----------------------------------------------------------------------
   look at every bond of node i: how far it is stretched, whether it breaks. The other end runs the
   same lines on the same numbers and decides alike.
------------------------------------------------------------------------- */

void PairPeridemLPS::careful_row(int i)
{
  double **x = atom->x;
  const int *const type = atom->type;
  double energy_before = 0.0;
  bool any = false;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i];) {
    const int j = bonds->partner(i, k);
    const double s = FixPeridemBonds::stretch(x[i], x[j], bonds->length[k]);
    if (atom->mask[i] & atom->mask[j] & bonds->unbroken_bit) {
      k++;
      continue;
    }
    const auto &mat = material(type[i], type[j]);
    const double reached = (mat.break_both ? std::fabs(s) : s) / mat.s0;
    if (reached > bonds->maxstretch[i]) bonds->maxstretch[i] = reached;
    if (s > mat.s0 || (mat.break_both && s < -mat.s0)) {
      if (!any) {
        set_dilatation(i, extension_sum(i));
        energy_before = energy_to_break(i);
      }
      any = true;
      bonds->break_bond(i, k);
    } else
      k++;
  }
  if (!any) return;
  set_dilatation(i, extension_sum(i));
  broken_energy += energy_before - energy_to_break(i);
}

/* ----------------------------------------------------------------------
   V_i W_i, with W_i = (lambda' - G)/2 theta^2 + d (d + 2) G / (2 m) sum w e^2 v V_j
------------------------------------------------------------------------- */

double PairPeridemLPS::strain_energy(int i) const
{
  const double m = bonds->wvolume[i];
  if (!theta || !(m > 0.0)) return 0.0;
  fetch_dilatations();
  double **x = atom->x;
  double sum = 0.0;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    const double dx = x[j][0] - x[i][0], dy = x[j][1] - x[i][1], dz = x[j][2] - x[i][2];
    const double e = std::sqrt(dx * dx + dy * dy + dz * dz) - bonds->length[k];
    sum += bonds->weight(i, j, k) * e * e;
  }
  const auto &own = material(atom->type[i], atom->type[i]);
  return 0.5 * (own.lambda() - own.shear) * theta[i] * theta[i] * atom->vfrac[i] +
      0.5 * own.extension_modulus() / m * sum;
}

/* ----------------------------------------------------------------------
   time derivative of the same
------------------------------------------------------------------------- */

double PairPeridemLPS::energy_rate(int i) const
{
  double **x = atom->x, **v = atom->v;
  double dilating = 0.0, extending = 0.0;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    double rsq = TINY, rate = 0.0;
    for (int m = 0; m < 3; m++) {
      const double d = x[j][m] - x[i][m];
      rsq += d * d;
      rate += d * (v[j][m] - v[i][m]);
    }
    const double r = std::sqrt(rsq), R = bonds->length[k];
    const double pull = bonds->weight(i, j, k) * rate / r;
    dilating += pull * R;
    extending += pull * (r - R);
  }
  return pressure[i] * dilating + stiffness[i] * extending;
}

/* ----------------------------------------------------------------------
   what breaking bonds take away is the loss of this
------------------------------------------------------------------------- */

double PairPeridemLPS::energy_to_break(int i) const
{
  const double late = time_without_broken();
  return late > 0.0 ? strain_energy(i) - late * energy_rate(i) : strain_energy(i);
}

/* ----------------------------------------------------------------------
   sigma_i = 1/J sum t_i v V_j n (x) (x_j - x_i), with J = 1 + theta: for a uniform deformation of
   a whole family this is the classical Cauchy stress as far as the quadrature of the family goes
   (force state of Silling et al. 2007, collapsed as by Silling & Lehoucq 2008)
------------------------------------------------------------------------- */

void PairPeridemLPS::stress(int i, double *sigma) const
{
  for (int k = 0; k < 6; k++) sigma[k] = 0.0;
  fetch_dilatations();
  if (!theta || !(bonds->wvolume[i] > 0.0)) return;
  double **x = atom->x;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    const double dx = x[j][0] - x[i][0], dy = x[j][1] - x[i][1], dz = x[j][2] - x[i][2];
    const double r = std::sqrt(dx * dx + dy * dy + dz * dz + TINY);
    const double R = bonds->length[k];
    const double t = bonds->weight(i, j, k) * (pressure[i] * R + stiffness[i] * (r - R)) / r;
    sigma[0] += t * dx * dx;
    sigma[1] += t * dy * dy;
    sigma[2] += t * dz * dz;
    sigma[3] += t * dx * dy;
    sigma[4] += t * dx * dz;
    sigma[5] += t * dy * dz;
  }
  const double J = 1.0 + theta[i];
  for (int k = 0; k < 6; k++) sigma[k] /= atom->vfrac[i] * (J > 0.0 ? J : 1.0);
  const auto &own = material(atom->type[i], atom->type[i]);
  if (own.plane == PeridemMaterial::STRAIN) sigma[2] = own.poisson() * (sigma[0] + sigma[1]);
}

/* ----------------------------------------------------------------------
   energy and virial of what the general engine computes; each end of a bond tallies its half
------------------------------------------------------------------------- */

void PairPeridemLPS::tally()
{
  for (int i = 0; i < atom->nlocal; i++) {
    if (elsewhere(i)) continue;
    if (eflag_either) {
      const double energy = strain_energy(i);
      if (eflag_global) eng_vdwl += energy;
      if (eflag_atom) eatom[i] += energy;
    }
    if (!vflag_either) continue;
    double w[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    tally_virial(i, w);
    for (int m = 0; m < 6; m++) {
      if (vflag_global) virial[m] += w[m];
      if (vflag_atom) vatom[i][m] += w[m];
    }
  }
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::tally_virial(int i, double *w) const
{
  double **x = atom->x, **v = atom->v;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    const double d[3] = {x[j][0] - x[i][0], x[j][1] - x[i][1], x[j][2] - x[i][2]};
    const double r = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + TINY);
    const double R = bonds->length[k];
    double force = (pressure[i] + pressure[j]) * R + (stiffness[i] + stiffness[j]) * (r - R);
    if (any_viscous) {
      double rate = 0.0;
      for (int m = 0; m < 3; m++) rate += (v[j][m] - v[i][m]) * d[m];
      force += (dashpot[i] + dashpot[j]) * rate / r;
    }
    force *= 0.5 * bonds->weight(i, j, k) / r;
    w[0] -= force * d[0] * d[0];
    w[1] -= force * d[1] * d[1];
    w[2] -= force * d[2] * d[2];
    w[3] -= force * d[0] * d[1];
    w[4] -= force * d[0] * d[2];
    w[5] -= force * d[1] * d[2];
  }
}

/* ----------------------------------------------------------------------
   the forces of the dashpots alone, once more: only while energies are booked
------------------------------------------------------------------------- */

void PairPeridemLPS::book_viscous_forces()
{
  books.clear(atom->nlocal);
  if (!any_viscous) return;
  double **x = atom->x, **v = atom->v;
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
      const int j = bonds->partner(i, k);
      double d[3], rsq = TINY, rate = 0.0;
      for (int m = 0; m < 3; m++) {
        d[m] = x[j][m] - x[i][m];
        rsq += d[m] * d[m];
        rate += d[m] * (v[j][m] - v[i][m]);
      }
      PeridemBooks::add(books.damping, i, d,
                        bonds->weight(i, j, k) * (dashpot[i] + dashpot[j]) * rate / rsq);
    }
}

/* ----------------------------------------------------------------------
   the force law, linearised in the displacements u: bonds change length by n (u_j - u_i)
------------------------------------------------------------------------- */

void PairPeridemLPS::apply_stiffness(const std::vector<double> &u, std::vector<double> &force)
{
  std::fill(force.begin(), force.end(), 0.0);
  std::vector<char> by_row(atom->nlocal);
  const bool in_batches = batching && batch_version == bonds->version;
  const bool in_list = list_version == bonds->version && (!in_batches || batch->general_too());
  for (int i = 0; i < atom->nlocal; i++)
    by_row[i] = bonds->wvolume[i] > 0.0 && !(in_batches && batch->responds(i)) &&
        !(in_list && !elsewhere(i));

  if (in_batches) batch->respond(u, force);
  std::vector<double> p(atom->nlocal + atom->nghost, 0.0);
  auto set = [&](int i, double sum) {
    p[i] = softness(i) * sum;
  };
  if (in_list) {
    general->first_response(u, stiffness);
    general->each_sum(set);
  }
  for (int i = 0; i < atom->nlocal; i++)
    if (by_row[i]) set(i, extension_sum(i, u));
  to_ghosts(p.data(), 1);
  if (in_list) {
    general->second_pass(p.data());
    general->add_forces(force.data());
  }
  for (int i = 0; i < atom->nlocal; i++)
    if (by_row[i]) add_response(i, u, p, &force[3 * i]);
}

/* ----------------------------------------------------------------------
   what the sum of w v V_i V_j R e over its bonds makes of a_i
------------------------------------------------------------------------- */

double PairPeridemLPS::softness(int i) const
{
  const double m = bonds->wvolume[i];
  if (!(m > 0.0)) return 0.0;
  const auto &own = material(atom->type[i], atom->type[i]);
  return own.dilatation_modulus() * own.dim() / (m * m * atom->vfrac[i]);
}

/* ----------------------------------------------------------------------
   how much longer small displacements make a bond; n: its direction
------------------------------------------------------------------------- */

double PairPeridemLPS::extension(int i, int j, const std::vector<double> &u, double *n) const
{
  double **x = atom->x;
  double rsq = TINY, e = 0.0;
  for (int m = 0; m < 3; m++) {
    n[m] = x[j][m] - x[i][m];
    rsq += n[m] * n[m];
  }
  const double inverse = 1.0 / std::sqrt(rsq);
  for (int m = 0; m < 3; m++) {
    n[m] *= inverse;
    e += n[m] * (u[3 * j + m] - u[3 * i + m]);
  }
  return e;
}

/* ---------------------------------------------------------------------- */

double PairPeridemLPS::extension_sum(int i, const std::vector<double> &u) const
{
  double sum = 0.0, n[3];
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    sum += bonds->weight(i, j, k) * bonds->length[k] * extension(i, j, u, n);
  }
  return sum;
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::add_response(int i, const std::vector<double> &u, const std::vector<double> &p,
                                  double *f) const
{
  double n[3];
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const int j = bonds->partner(i, k);
    const double e = extension(i, j, u, n);
    const double t = bonds->weight(i, j, k) *
        ((p[i] + p[j]) * bonds->length[k] + (stiffness[i] + stiffness[j]) * e);
    for (int m = 0; m < 3; m++) f[m] += t * n[m];
  }
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::write_restart_settings(FILE *fp)
{
  PairPeridem::write_restart_settings(fp);
  fwrite(&engine, sizeof(int), 1, fp);
}

/* ---------------------------------------------------------------------- */

void PairPeridemLPS::read_restart_settings(FILE *fp)
{
  PairPeridem::read_restart_settings(fp);
  if (comm->me == 0) utils::sfread(FLERR, &engine, sizeof(int), 1, fp, nullptr, error);
  MPI_Bcast(&engine, 1, MPI_INT, 0, world);
}

/* ---------------------------------------------------------------------- */

double PairPeridemLPS::memory_usage()
{
  return Pair::memory_usage() + 4.0 * nmax * sizeof(double) +
      (general ? general->memory_usage() : 0.0) + (batch ? batch->memory_usage() : 0.0);
}

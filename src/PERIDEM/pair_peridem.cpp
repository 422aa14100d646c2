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

#include "pair_peridem.h"

#include "fix_peridem_bonds.h"
#include "fix_peridem_ledger.h"
#include "peridem_level.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "pair_hybrid.h"
#include "peridem_lanczos.h"
#include "peridem_stamp.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

PairPeridem::PairPeridem(LAMMPS *lmp, const char *_name) : Pair(lmp), name(_name)
{
  single_enable = 0;
  restartinfo = 1;
  manybody_flag = 1;
  comm_forward = 3;               // the most that to_ghosts() sends
  no_virial_fdotr_compute = 1;    // bonds of owned nodes only: the virial is tallied bond by bond
}

/* ----------------------------------------------------------------------
   a fix that keeps the place of fix peridem/bonds among the fixes until it is known whether the
   script has one of its own: it must come before fixes that migrate nodes
------------------------------------------------------------------------- */

std::string PairPeridem::placeholder() const
{
  return "PERIDEM_BONDS_PLACE";
}

/* ---------------------------------------------------------------------- */

PairPeridem::~PairPeridem()
{
  if (copymode) return;
  if (modify && modify->get_fix_by_id(placeholder())) modify->delete_fix(placeholder());
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

/* ---------------------------------------------------------------------- */

std::vector<PairPeridem *> PairPeridem::find_all(LAMMPS *lmp)
{
  std::vector<PairPeridem *> found;
  std::vector<Pair *> seen;    // the last match is returned again when there are no more
  for (int nth = 1;; nth++) {
    auto *pair = lmp->force->pair_match("^peridem/", 0, nth);
    if (!pair || std::find(seen.begin(), seen.end(), pair) != seen.end()) break;
    seen.push_back(pair);
    if (auto *solid = dynamic_cast<PairPeridem *>(pair)) found.push_back(solid);
  }
  return found;
}

/* ---------------------------------------------------------------------- */

void PairPeridem::allocate()
{
  allocated = 1;
  ntypes = atom->ntypes;
  memory->create(setflag, ntypes + 1, ntypes + 1, "pair:setflag");
  memory->create(cutsq, ntypes + 1, ntypes + 1, "pair:cutsq");
  for (int i = 0; i <= ntypes; i++)
    for (int j = 0; j <= ntypes; j++) {
      setflag[i][j] = 0;
      cutsq[i][j] = 0.0;
    }
  given.assign(index(ntypes, ntypes) + 1, PeridemMaterial());
  mixed = given;
}

/* ---------------------------------------------------------------------- */

void PairPeridem::settings(int narg, char **arg)
{
  if (narg) error->all(FLERR, "Pair style {} takes no arguments; given: {}", name, arg[0]);
  keep_places();
}

/* ----------------------------------------------------------------------
   at the head of the list of fixes, for those that are made later
------------------------------------------------------------------------- */

void PairPeridem::keep_places()
{
  if (modify->get_fix_by_style("^peridem/bonds$").empty() && !modify->get_fix_by_id(placeholder()))
    modify->add_fix(placeholder() + " all DUMMY");
  FixPeridemLedger::keep_place(lmp);
}

/* ---------------------------------------------------------------------- */

void PairPeridem::coeff(int narg, char **arg)
{
  if (narg < 2) utils::missing_cmd_args(FLERR, "pair_coeff " + name, error);
  if (!allocated) allocate();

  int ilo, ihi, jlo, jhi;
  utils::bounds(FLERR, arg[0], 1, ntypes, ilo, ihi, error);
  utils::bounds(FLERR, arg[1], 1, ntypes, jlo, jhi, error);

  // under hybrid the input line has the name of the style as well

  const int offset = dynamic_cast<PairHybrid *>(force->pair) ? 3 : 2;
  PeridemMaterialParser parser(lmp, "Pair style " + name, offset, model());

  bool one_type = false;
  for (int i = ilo; i <= ihi; i++)
    if (i >= jlo && i <= jhi) one_type = true;
  const PeridemMaterial mat = parser.parse(narg - 2, arg + 2, one_type);
  ncoeff++;

  int count = 0;
  for (int i = ilo; i <= ihi; i++)
    for (int j = MAX(jlo, i); j <= jhi; j++) {
      given[index(i, j)] = given[index(j, i)] = mat;
      setflag[i][j] = 1;
      count++;
    }
  if (count == 0)
    error->all(FLERR, Error::ARGZERO, "pair_coeff {}: no type pair I <= J in it", name);
}

/* ---------------------------------------------------------------------- */

void PairPeridem::init_style()
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {} requires atom style peridem; the atom style is {}", name,
               atom->get_style());
  PeridemLevel(lmp).find(this, fmt::format("Pair style {}", name));    // it has one

  // types of other solids: their bonds are not for this one to break
  PeridemMaterial none;
  none.s0 = std::numeric_limits<double>::infinity();
  mixed.assign(given.size(), none);

  bool viscous = false;
  for (int i = 1; i <= ntypes; i++)
    for (int j = 1; j <= ntypes; j++) {
      if (!covers(i) || !covers(j)) continue;
      if (own_material(i).plane != own_material(j).plane)
        error->all(FLERR, Error::NOLASTLINE, "Pair style {}: all types must have the same plane",
                   name);
      const auto mat = mixed[index(i, j)] = mix(MIN(i, j), MAX(i, j));
      viscous = viscous || mat.viscosity > 0.0;
    }
  find_bonds();
  ninit++;
  const bool booked = !modify->get_compute_by_style("^peridem/energy$").empty();
  books_viscous = viscous && booked;
  if (viscous || booked) comm->ghost_velocity = 1;
}

/* ---------------------------------------------------------------------- */

PeridemMaterial PairPeridem::mix(int i, int j) const
{
  PeridemMaterial mat = setflag[i][j] ? given[index(i, j)] : given[index(i, i)];
  if (i != j) mix_unlike(mat, i, j);
  if (mat.strength == PeridemMaterial::GC && mat.spacing > mat.horizon)
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {}: types {} {}: gc spacing {:.8g} must be <= the horizon {:.8g}", name,
               i, j, mat.spacing, mat.horizon);
  if (mat.strength == PeridemMaterial::GC) mat.s0 = mat.stretch_from_gc();
  if (mat.strength == PeridemMaterial::GC && !std::isnormal(mat.s0))
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {}: types {} {}: gc {:.6g} with horizon {:.6g} gives a critical stretch "
               "of {:.6g}: are these the right units?",
               name, i, j, mat.gc, mat.horizon, mat.s0);
  return mat;
}

/* ----------------------------------------------------------------------
   Bonds between two types of one grain: mean moduli and horizon, smaller critical stretch, unless
   pair_coeff I J says otherwise. In the linear peridynamic solid each end keeps its own moduli:
   those of I J serve gc only.
------------------------------------------------------------------------- */

void PairPeridem::mix_unlike(PeridemMaterial &mat, int i, int j) const
{
  const auto &a = given[index(i, i)], &b = given[index(j, j)];
  const bool said = setflag[i][j];

  if (!said) check_alike(i, j);
  if (mat.plane == PeridemMaterial::AS_TYPES) mat.plane = a.plane;
  if (mat.plane != a.plane)
    error->all(FLERR, Error::NOLASTLINE, "Pair style {}: all types must have the same plane", name);
  if (!said || mat.bulk == 0.0) {
    mat.bulk = 0.5 * (a.bulk + b.bulk);
    mat.shear = 0.5 * (a.shear + b.shear);
  }
  if (!said || mat.viscosity == 0.0) mat.viscosity = 0.5 * (a.viscosity + b.viscosity);
  if (!said || mat.horizon == 0.0) mat.horizon = 0.5 * (a.horizon + b.horizon);
  if (!said) mat.cell = 0.5 * (a.cell + b.cell);

  if (!said || mat.strength == PeridemMaterial::UNSET) {
    const double sa = a.strength == PeridemMaterial::GC ? a.stretch_from_gc() : a.s0;
    const double sb = b.strength == PeridemMaterial::GC ? b.stretch_from_gc() : b.s0;
    mat.s0 = MIN(sa, sb);
    const bool never =
        a.strength == PeridemMaterial::UNBREAKABLE && b.strength == PeridemMaterial::UNBREAKABLE;
    mat.strength = never ? PeridemMaterial::UNBREAKABLE : PeridemMaterial::UNSET;
  }
}

/* ---------------------------------------------------------------------- */

void PairPeridem::check_alike(int i, int j) const
{
  const auto &a = given[index(i, i)], &b = given[index(j, j)];
  if (!(a.influence == b.influence) || a.volume != b.volume || a.break_both != b.break_both)
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {}: types {} and {} differ in influence, volume or break; say with "
               "'pair_coeff {} {}' what holds between them",
               name, i, j, i, j);
  if (a.potential != b.potential)
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {}: types {} and {} differ in potential; say with 'pair_coeff {} {}' "
               "what holds between them",
               name, i, j, i, j);
}

/* ----------------------------------------------------------------------
   the fix that holds the families: the script's, or one made here. A restart file keeps families
   and broken bonds under the ID of the fix, so after a restart it must be that one.
------------------------------------------------------------------------- */

void PairPeridem::find_bonds()
{
  auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  if (fixes.empty()) {
    const auto command = bonds_id + " all peridem/bonds";
    if (modify->get_fix_by_id(placeholder()))
      modify->replace_fix(placeholder(), command, 1);
    else
      modify->add_fix(command);
    fixes = modify->get_fix_by_style("^peridem/bonds$");
  } else if (from_restart && bonds_id != fixes[0]->id) {
    error->all(
        FLERR, Error::NOLASTLINE,
        "The restart file keeps bonds under fix ID {}, but the script has fix {} {}: use the "
        "same ID, or leave the fix out",
        bonds_id, fixes[0]->id, fixes[0]->style);
  }
  bonds = dynamic_cast<FixPeridemBonds *>(fixes[0]);
  bonds_id = bonds->id;
}

/* ----------------------------------------------------------------------
   bonds need no neighbour list; the fix asks for the ghosts that they need
------------------------------------------------------------------------- */

double PairPeridem::init_one(int i, int j)
{
  if (setflag[i][i] == 0 || setflag[j][j] == 0)
    error->all(FLERR, Error::NOLASTLINE, "Pair style {}: pair_coeff {} {} is not set", name,
               setflag[i][i] ? j : i, setflag[i][i] ? j : i);
  return 0.0;
}

/* ---------------------------------------------------------------------- */

void PairPeridem::to_ghosts(double *values, int size)
{
  comm_values = values;
  const int most = comm_forward;
  comm_forward = size;
  comm->forward_comm(this);
  comm_forward = most;
}

/* ---------------------------------------------------------------------- */

int PairPeridem::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  int m = 0;
  for (int i = 0; i < n; i++)
    for (int k = 0; k < comm_forward; k++) buf[m++] = comm_values[comm_forward * list[i] + k];
  return m;
}

/* ---------------------------------------------------------------------- */

void PairPeridem::unpack_forward_comm(int n, int first, double *buf)
{
  for (int m = 0; m < comm_forward * n; m++) comm_values[comm_forward * first + m] = buf[m];
}

/* ----------------------------------------------------------------------
   largest eigenvalue of M^-1/2 K M^-1/2
------------------------------------------------------------------------- */

double PairPeridem::largest_frequency_sq()
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost;
  const int dim = domain->dimension;
  std::vector<double> u(3 * nall, 0.0), f(3 * nlocal), root(nlocal), start(3 * nlocal, 0.0);
  for (int i = 0; i < nlocal; i++) {
    root[i] = std::sqrt(atom->rmass[i]);
    if (!covers(atom->type[i])) continue;
    // a start that does not depend on how nodes are spread over processors
    for (int k = 0; k < dim; k++)
      start[3 * i + k] = std::sin(1.0 + 12.9898 * (3.0 * atom->tag[i] + k));
  }

  auto apply = [&](const std::vector<double> &in, std::vector<double> &out) {
    for (int i = 0; i < nlocal; i++)
      for (int k = 0; k < 3; k++) u[3 * i + k] = in[3 * i + k] / root[i];
    to_ghosts(u.data(), 3);
    apply_stiffness(u, f);
    for (int i = 0; i < nlocal; i++)
      for (int k = 0; k < 3; k++) out[3 * i + k] = -f[3 * i + k] / root[i];
  };
  auto dot = [&](const std::vector<double> &a, const std::vector<double> &b) {
    double mine = 0.0, all;
    for (std::size_t i = 0; i < a.size(); i++) mine += a[i] * b[i];
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
    return all;
  };
  return PeridemLanczos::largest_eigenvalue(start, apply, dot);
}

/* ----------------------------------------------------------------------
   A bond that is found broken pulled at the start of the step, but not at its end: of the last half
   step it has taken no part, so it goes with the energy of half a step ago. 0 while nothing moves,
   and while nobody books energies: ghosts may have no velocities then.
------------------------------------------------------------------------- */

double PairPeridem::time_without_broken() const
{
  const bool stepping = update->whichflag == 1 && !update->setupflag;
  return books.open && stepping ? 0.5 * update->dt : 0.0;
}

/* ---------------------------------------------------------------------- */

double PairPeridem::largest_viscous_time() const
{
  double largest = 0.0;
  for (int i = 1; i <= ntypes; i++)
    for (int j = 1; j <= ntypes; j++)
      if (covers(i) && covers(j))
        largest = MAX(largest, material(i, j).viscosity / material(i, j).shear);
  return largest;
}

/* ---------------------------------------------------------------------- */

void *PairPeridem::extract(const char *str, int &dim)
{
  dim = 0;
  if (strcmp(str, "broken_energy") == 0) return &broken_energy;
  return nullptr;
}

/* ----------------------------------------------------------------------
   hybrid styles write settings only
------------------------------------------------------------------------- */

static constexpr PeridemStamp SETTINGS(1), COEFFICIENTS(1, sizeof(PeridemMaterial));

void PairPeridem::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  COEFFICIENTS.write(fp);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      fwrite(&setflag[i][j], sizeof(int), 1, fp);
      if (setflag[i][j]) given[index(i, j)].write_restart(fp);
    }
}

/* ---------------------------------------------------------------------- */

void PairPeridem::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  COEFFICIENTS.read(fp, "Pair style " + name, lmp);
  allocate();
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      if (comm->me == 0) utils::sfread(FLERR, &setflag[i][j], sizeof(int), 1, fp, nullptr, error);
      MPI_Bcast(&setflag[i][j], 1, MPI_INT, 0, world);
      if (!setflag[i][j]) continue;
      given[index(i, j)].read_restart(fp, lmp);
      given[index(j, i)] = given[index(i, j)];
    }
}

/* ---------------------------------------------------------------------- */

void PairPeridem::write_restart_settings(FILE *fp)
{
  SETTINGS.write(fp);
  const int n = static_cast<int>(bonds_id.size());
  fwrite(&n, sizeof(int), 1, fp);
  fwrite(bonds_id.data(), 1, n, fp);
}

/* ---------------------------------------------------------------------- */

void PairPeridem::read_restart_settings(FILE *fp)
{
  SETTINGS.read(fp, "Pair style " + name, lmp);
  int n;
  if (comm->me == 0) utils::sfread(FLERR, &n, sizeof(int), 1, fp, nullptr, error);
  MPI_Bcast(&n, 1, MPI_INT, 0, world);
  bonds_id.resize(n);
  if (comm->me == 0) utils::sfread(FLERR, &bonds_id[0], 1, n, fp, nullptr, error);
  MPI_Bcast(&bonds_id[0], n, MPI_CHAR, 0, world);
  from_restart = true;
  keep_places();
}

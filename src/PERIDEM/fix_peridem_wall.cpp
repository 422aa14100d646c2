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

#include "fix_peridem_wall.h"

#include "fix_peridem_bonds.h"
#include "pair_peridem_contact.h"
#include "peridem_grains.h"
#include "peridem_patch.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "respa.h"
#include "update.h"

#include <cmath>
#include <cstring>
#include <map>

using namespace LAMMPS_NS;
using namespace FixConst;

/* ---------------------------------------------------------------------- */

FixPeridemWall::FixPeridemWall(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, 2, "Fix {} requires atom style peridem; the atom style is {}", style,
               atom->get_style());

  restart_global = restart_peratom = 1;
  create_attribute = 1;
  maxexchange = 4;
  comm_reverse = 3;
  scalar_flag = vector_flag = 1;
  size_vector = 8;
  global_freq = 1;
  extscalar = 1;
  extvector = -1;
  extlist = new int[size_vector]{1, 1, 1, 1, 1, 1, 0, 1};
  energy_global_flag = 1;
  respa_level_support = 1;
  dynamic_group_allow = 1;

  if (narg < 4) error->all(FLERR, Error::ARGZERO, "Fix {} needs a surface: plane x y z nx ny nz", style);
  int iarg = parse_plane(3, narg, arg);
  PeridemContactParser parser(lmp, std::string("Fix ") + style, 0);
  bool velocity_given = false;
  while (iarg < narg) {
    const int next = parser.parse(iarg, narg, arg, given);
    if (next > iarg) {
      iarg = next;
    } else if (strcmp(arg[iarg], "velocity") == 0) {
      if (velocity_given) error->all(FLERR, iarg, "Repeated fix {} keyword velocity", style);
      velocity_given = true;
      iarg = parse_vector(iarg, narg, arg, "velocity", velocity);
    } else {
      error->all(FLERR, iarg, "Unknown fix {} keyword {}: known are velocity, {}", style, arg[iarg],
                 PeridemContactParser::keywords());
    }
  }
  moving = velocity[0] != 0.0 || velocity[1] != 0.0 || velocity[2] != 0.0;
  if (domain->dimension == 2 && velocity[2] != 0.0)
    error->all(FLERR, Error::ARGZERO, "Fix {} velocity in z must be 0 in a 2d simulation", style);

  for (int k = 0; k < 3; k++) force[k] = torque[k] = 0.0;
  deepest = energy = 0.0;

  FixPeridemWall::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixPeridemWall::set_arrays(i);
}

/* ---------------------------------------------------------------------- */

FixPeridemWall::~FixPeridemWall()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  memory->destroy(memory_at_wall);
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::parse_vector(int iarg, int narg, char **arg, const char *name, double *vec)
{
  if (iarg + 3 >= narg) error->all(FLERR, iarg, "Fix {} {} needs three numbers", style, name);
  for (int k = 0; k < 3; k++) {
    vec[k] = utils::numeric(FLERR, arg[iarg + 1 + k], false, lmp);
    if (!std::isfinite(vec[k]))
      error->all(FLERR, iarg + 1 + k, "Fix {} {} {}: must be finite", style, name,
                 arg[iarg + 1 + k]);
  }
  return iarg + 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::parse_plane(int iarg, int narg, char **arg)
{
  if (strcmp(arg[iarg], "plane") != 0)
    error->all(FLERR, iarg, "Unknown fix {} surface {}: must be plane x y z nx ny nz", style,
               arg[iarg]);
  if (iarg + 6 >= narg)
    error->all(FLERR, iarg, "Fix {} plane needs six numbers: x y z nx ny nz", style);
  parse_vector(iarg, narg, arg, "plane", point);
  parse_vector(iarg + 3, narg, arg, "plane", normal);

  const double length =
      std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  if (length == 0.0) error->all(FLERR, iarg + 4, "Fix {} plane: the normal is zero", style);
  for (int k = 0; k < 3; k++) {
    normal[k] /= length;
    if (normal[k] == 0.0) continue;
    if (domain->dimension == 2 && k == 2)
      error->all(FLERR, iarg + 6, "Fix {} plane: nz must be 0 in a 2d simulation", style);
    if (domain->periodicity[k])
      error->all(FLERR, iarg + 4 + k, "Fix {} plane: the box is periodic in {}, which the plane cuts",
                 style, "xyz"[k]);
  }
  return iarg + 7;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::setmask()
{
  int mask = POST_FORCE | POST_FORCE_RESPA | MIN_POST_FORCE;
  if (moving) mask |= INITIAL_INTEGRATE;
  return mask;
}

/* ----------------------------------------------------------------------
   coefficients: what the fix says; else what contact of the node's type with itself says; else
   what the solid says
------------------------------------------------------------------------- */

void FixPeridemWall::init()
{
  if (utils::strmatch(update->integrate_style, "^respa"))
    ilevel_respa = (respa_level >= 0)
        ? MIN(respa_level, (dynamic_cast<Respa *>(update->integrate))->nlevels - 1)
        : (dynamic_cast<Respa *>(update->integrate))->nlevels - 1;

  const auto *contact =
      dynamic_cast<PairPeridemContact *>(lmp->force->pair_match("peridem/contact", 1));
  const auto spacings = PeridemGrains::spacings(lmp);
  extremes = PeridemGrains::extremes(lmp);
  const int ntypes = atom->ntypes;
  std::vector<int> used(ntypes + 1, 0);
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) used[atom->type[i]] = 1;
  MPI_Allreduce(MPI_IN_PLACE, used.data(), ntypes + 1, MPI_INT, MPI_MAX, world);

  laws.assign(ntypes + 1, PeridemContactLaw());
  any_restitution = false;
  for (int t = 1; t <= ntypes; t++) {
    if (!used[t]) continue;
    const auto what = (contact && contact->covers(t)) ? given.over(contact->own(t)) : given;
    const auto where = fmt::format("Fix {} {}, type {}", id, style, t);
    laws[t] = PeridemContactLaw::resolve(
        what, PairPeridemContact::known(lmp, t, t, spacings), where, lmp);
    any_restitution = any_restitution || laws[t].uses_restitution();
  }
  if (comm->me == 0) describe(used);
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
}

/* ----------------------------------------------------------------------
   one line for all types with the same law
------------------------------------------------------------------------- */

void FixPeridemWall::describe(const std::vector<int> &used) const
{
  std::map<std::string, std::string> types;
  for (int t = 1; t <= atom->ntypes; t++)
    if (used[t]) types[laws[t].describe()] += fmt::format(" {}", t);
  for (const auto &one : types)
    utils::logmesg(lmp, "PERIDEM: wall {} and types{}: {}\n", id, one.second, one.first);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::setup(int vflag)
{
  if (!started) check_start();
  started = true;
  if (utils::strmatch(update->integrate_style, "^respa")) {
    auto *respa = dynamic_cast<Respa *>(update->integrate);
    respa->copy_flevel_f(ilevel_respa);
    post_force_respa(vflag, ilevel_respa, 0);
    respa->copy_f_flevel(ilevel_respa);
  } else
    post_force(vflag);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::min_setup(int vflag)
{
  setup(vflag);
}

/* ----------------------------------------------------------------------
   nodes behind the plane at the start: most likely its normal points the wrong way
------------------------------------------------------------------------- */

void FixPeridemWall::check_start()
{
  bigint behind = 0, behind_all;
  tagint lowest = MAXTAGINT, lowest_all;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    double distance = 0.0;
    for (int k = 0; k < 3; k++) distance += (atom->x[i][k] - point[k] - shift[k]) * normal[k];
    if (distance >= 0.0) continue;
    behind++;
    lowest = MIN(lowest, atom->tag[i]);
  }
  MPI_Allreduce(&behind, &behind_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&lowest, &lowest_all, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (behind_all)
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {} {}: {} nodes start behind the plane (the first is atom-ID {}): its normal must "
               "point to the side where the grains are",
               id, style, behind_all, lowest_all);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::initial_integrate(int)
{
  for (int k = 0; k < 3; k++) shift[k] += update->dt * velocity[k];
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::post_force(int)
{
  for (int k = 0; k < 3; k++) force[k] = torque[k] = 0.0;
  deepest = energy = 0.0;
  totals_known = false;
  advance = update->setupflag == 0;

  if (any_restitution) pushes.assign(3 * (atom->nlocal + atom->nghost), 0.0);
  double **x = atom->x;
  double at[3];    // a point of the plane, now
  for (int k = 0; k < 3; k++) at[k] = point[k] + shift[k];
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double distance = (x[i][0] - at[0]) * normal[0] + (x[i][1] - at[1]) * normal[1] +
        (x[i][2] - at[2]) * normal[2];
    if (distance < laws[atom->type[i]].radius)
      touch(i, distance, at);
    else
      set_arrays(i);
  }
  if (any_restitution) bring_pushes_home();
  if (moving && update->ntimestep > update->beginstep)
    work -= update->dt *
        (force[0] * velocity[0] + force[1] * velocity[1] + force[2] * velocity[2]);
}

/* ----------------------------------------------------------------------
   force between node i and the wall, a body of infinite mass
------------------------------------------------------------------------- */

void FixPeridemWall::touch(int i, double distance, const double *at)
{
  const auto &law = laws[atom->type[i]];
  const double *const x = atom->x[i], *const v = atom->v[i];
  const double overlap = law.radius - distance;
  const double k = law.spring(atom->vfrac[i], atom->vfrac[i]);

  double slide[3], rate = 0.0;    // of the wall as the node sees it; rate = growth of the distance
  for (int m = 0; m < 3; m++) {
    slide[m] = velocity[m] - v[m];
    rate -= slide[m] * normal[m];
  }
  for (int m = 0; m < 3; m++) slide[m] += rate * normal[m];

  const double beta = law.dashpot();
  const double fn = PeridemContactLaw::normal(k, beta, overlap, rate);
  double drag[3] = {0.0, 0.0, 0.0};
  if (law.friction > 0.0)
    law.tangential({k, beta, fn, atom->rmass[i], update->dt, advance, normal}, slide,
                   memory_at_wall[i], drag);

  double on_node[3], arm[3];
  for (int m = 0; m < 3; m++) {
    on_node[m] = fn * normal[m] + drag[m];
    atom->f[i][m] += on_node[m];
  }
  if (law.uses_restitution()) impact(i, fn, on_node);
  for (int m = 0; m < 3; m++) {
    force[m] -= on_node[m];
    arm[m] = x[m] - distance * normal[m] - at[m];    // where the node touches the plane
  }
  torque[0] -= arm[1] * on_node[2] - arm[2] * on_node[1];
  torque[1] -= arm[2] * on_node[0] - arm[0] * on_node[2];
  torque[2] -= arm[0] * on_node[1] - arm[1] * on_node[0];
  deepest = MAX(deepest, overlap);
  energy += 0.5 * k * overlap * overlap;
}

/* ----------------------------------------------------------------------
   energy that a collision with the wall loses: a force on the patch of node i
------------------------------------------------------------------------- */

void FixPeridemWall::impact(int i, double elastic, double *total)
{
  const auto patch = PeridemPatch::of(atom, bonds, i);
  double approach = 0.0;
  for (int m = 0; m < 3; m++) approach -= (patch.velocity[m] - velocity[m]) * normal[m];
  const double size = laws[atom->type[i]].impact_force(elastic, approach, patch.mass, update->dt,
                                                       advance, memory_at_wall[i][3]);
  double push[3];
  for (int m = 0; m < 3; m++) {
    push[m] = size * normal[m];
    total[m] += push[m];
  }
  patch.push(atom, bonds, i, push, pushes.data());
}

/* ----------------------------------------------------------------------
   members of a patch may be ghosts
------------------------------------------------------------------------- */

void FixPeridemWall::bring_pushes_home()
{
  comm->reverse_comm(this);
  for (int i = 0; i < atom->nlocal; i++)
    for (int m = 0; m < 3; m++) atom->f[i][m] += pushes[3 * i + m];
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::pack_reverse_comm(int n, int first, double *buf)
{
  for (int m = 0; m < 3 * n; m++) buf[m] = pushes[3 * first + m];
  return 3 * n;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::unpack_reverse_comm(int n, int *list, double *buf)
{
  for (int m = 0; m < n; m++)
    for (int k = 0; k < 3; k++) pushes[3 * list[m] + k] += buf[3 * m + k];
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::min_post_force(int vflag)
{
  post_force(vflag);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::post_force_respa(int vflag, int ilevel, int)
{
  if (ilevel == ilevel_respa) post_force(vflag);
}

/* ----------------------------------------------------------------------
   a node in a corner touches as many walls as there are dimensions, one spring in each direction
------------------------------------------------------------------------- */

double FixPeridemWall::largest_frequency_sq() const
{
  double largest = 0.0;
  for (int t = 1; t <= atom->ntypes; t++) {
    if (laws[t].radius == 0.0 || extremes.largest[t] == 0.0) continue;
    const double k = laws[t].spring(extremes.smallest[t], extremes.smallest[t]);
    largest = MAX(largest, k / extremes.lightest[t]);
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

double FixPeridemWall::largest_dashpot_ratio() const
{
  double largest = 0.0;
  for (int t = 1; t <= atom->ntypes; t++) {
    if (laws[t].radius == 0.0 || extremes.largest[t] == 0.0) continue;
    const double k = laws[t].spring(extremes.smallest[t], extremes.smallest[t]);
    const double beta = laws[t].dashpot();
    largest = MAX(largest, beta / (2.0 * std::sqrt(k * extremes.lightest[t])));
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::sum_totals()
{
  if (totals_known) return;
  double mine[8] = {force[0],  force[1],  force[2], torque[0],
                    torque[1], torque[2], work,     energy};
  double sums[8];
  MPI_Allreduce(mine, sums, 8, MPI_DOUBLE, MPI_SUM, world);
  for (int k = 0; k < 6; k++) total[k] = sums[k];
  total[7] = sums[6];
  total[8] = sums[7];
  MPI_Allreduce(&deepest, &total[6], 1, MPI_DOUBLE, MPI_MAX, world);
  totals_known = true;
}

/* ----------------------------------------------------------------------
   elastic energy of the overlaps with the wall
------------------------------------------------------------------------- */

double FixPeridemWall::compute_scalar()
{
  sum_totals();
  return total[8];
}

/* ----------------------------------------------------------------------
   1-3 force on the wall, 4-6 torque about its point, 7 deepest overlap, 8 work of the wall
------------------------------------------------------------------------- */

double FixPeridemWall::compute_vector(int n)
{
  sum_totals();
  return total[n];
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::write_restart(FILE *fp)
{
  double all_work;
  MPI_Allreduce(&work, &all_work, 1, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me) return;
  const double list[4] = {shift[0], shift[1], shift[2], all_work};
  const int size = sizeof(list);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(list, sizeof(double), 4, fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::restart(char *buf)
{
  const auto *list = reinterpret_cast<double *>(buf);
  for (int k = 0; k < 3; k++) shift[k] = list[k];
  work = comm->me == 0 ? list[3] : 0.0;
  started = true;
}

/* ----------------------------------------------------------------------
   what contacts with the wall remember travels with the nodes
------------------------------------------------------------------------- */

void FixPeridemWall::grow_arrays(int nmax)
{
  memory->grow(memory_at_wall, nmax, 4, "peridem/wall:memory");
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::copy_arrays(int i, int j, int)
{
  for (int m = 0; m < 4; m++) memory_at_wall[j][m] = memory_at_wall[i][m];
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::set_arrays(int i)
{
  for (int m = 0; m < 4; m++) memory_at_wall[i][m] = 0.0;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::pack_exchange(int i, double *buf)
{
  for (int m = 0; m < 4; m++) buf[m] = memory_at_wall[i][m];
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::unpack_exchange(int i, double *buf)
{
  for (int m = 0; m < 4; m++) memory_at_wall[i][m] = buf[m];
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::pack_restart(int i, double *buf)
{
  buf[0] = 5;
  return 1 + pack_exchange(i, buf + 1);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::unpack_restart(int i, int nth)
{
  double *buf = atom->extra[i];
  int m = 0;
  for (int k = 0; k < nth; k++) m += static_cast<int>(buf[m]);
  unpack_exchange(i, buf + m + 1);
}

/* ---------------------------------------------------------------------- */

double FixPeridemWall::memory_usage()
{
  return 4.0 * atom->nmax * sizeof(double);
}

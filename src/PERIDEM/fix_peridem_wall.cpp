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

#include "fix_peridem_adapt.h"
#include "fix_peridem_bonds.h"
#include "pair_peridem_contact.h"
#include "peridem_contact_parser.h"
#include "peridem_contact_stiffness.h"
#include "peridem_grains.h"
#include "peridem_stamp.h"
#include "peridem_surface_plane.h"
#include "peridem_surface_region.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "neighbor.h"
#include "respa.h"
#include "update.h"

#include <cmath>
#include <cstring>
#include <map>

using namespace LAMMPS_NS;
using namespace FixConst;

// overlaps at the start deeper than this fraction of the contact distance are worth a warning
static constexpr double WORTH_A_WARNING = 0.01;

/* ---------------------------------------------------------------------- */

FixPeridemWall::FixPeridemWall(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), motion(lmp, style), nearby(lmp), own_bodies(lmp), collisions(lmp),
    level(lmp), clock(lmp)
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, 2, "Fix {} requires atom style peridem; the atom style is {}", style,
               atom->get_style());

  restart_global = restart_peratom = 1;
  create_attribute = 1;
  scalar_flag = vector_flag = 1;
  size_vector = 8;
  global_freq = 1;
  extscalar = 1;
  extvector = -1;
  extlist = new int[size_vector]{1, 1, 1, 1, 1, 1, 0, 1};
  energy_global_flag = 1;
  virial_global_flag = virial_peratom_flag = 1;
  dynamic_group_allow = 1;

  int iarg = parse_surface(3, narg, arg);
  while (iarg < narg) iarg = parse_keyword(iarg, narg, arg);

  maxexchange = PeridemWallMemory::size(surface->most_feet());
  clear_loads();
  FixPeridemWall::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
}

/* ---------------------------------------------------------------------- */

FixPeridemWall::~FixPeridemWall()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  delete[] extlist;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::parse_surface(int iarg, int narg, char **arg)
{
  if (iarg >= narg)
    error->all(FLERR, Error::ARGZERO, "Fix {} needs a surface: plane x y z nx ny nz, or region ID",
               style);
  if (strcmp(arg[iarg], "plane") == 0) {
    surface = std::make_unique<PeridemSurfacePlane>(lmp, style, iarg, narg, arg);
    return iarg + PeridemSurfacePlane::WORDS;
  }
  if (strcmp(arg[iarg], "region") == 0) {
    surface = std::make_unique<PeridemSurfaceRegion>(lmp, style, iarg, narg, arg);
    return iarg + PeridemSurfaceRegion::WORDS;
  }
  error->all(FLERR, iarg, "Unknown fix {} surface {}: must be plane x y z nx ny nz, or region ID",
             style, arg[iarg]);
  return narg;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::parse_keyword(int iarg, int narg, char **arg)
{
  if (strcmp(arg[iarg], "fragments") == 0)
    error->all(
        FLERR, iarg,
        "Fix {} takes no fragments: that is about nodes of one grain, a keyword of pair style "
        "peridem/contact",
        style);
  PeridemContactParser parser(lmp, std::string("fix ") + style, 0);
  int next = parser.parse(iarg, narg, arg, given);
  if (next == iarg) next = motion.parse(iarg, narg, arg);
  if (next > iarg) return next;
  if (strcmp(arg[iarg], "plane") == 0 || strcmp(arg[iarg], "region") == 0)
    error->all(FLERR, iarg, "Fix {} has one surface, a plane or a region: make another fix for {}",
               style, arg[iarg]);
  error->all(FLERR, iarg, "Unknown fix {} keyword {}: known are velocity, {}, move", style,
             arg[iarg], PeridemContactParser::keywords());
  return narg;
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::setmask()
{
  return POST_FORCE | POST_FORCE_RESPA | MIN_POST_FORCE;
}

/* ----------------------------------------------------------------------
   coefficients: what the fix says; else what contact of the node's type with itself says; else
   what the solid says
------------------------------------------------------------------------- */

void FixPeridemWall::init()
{
  surface->init();
  motion.init();
  own_bodies.init();

  const auto *contact =
      dynamic_cast<PairPeridemContact *>(lmp->force->pair_match("peridem/contact", 1));
  find_level(contact);
  const auto spacings = PeridemGrains::spacings(lmp);
  extremes = PeridemGrains::extremes(lmp);
  const auto adapts = modify->get_fix_by_style("^peridem/adapt$");
  adapt = adapts.empty() ? nullptr : dynamic_cast<FixPeridemAdapt *>(adapts[0]);
  const int ntypes = atom->ntypes;
  std::vector<int> used(ntypes + 1, 0);
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) used[atom->type[i]] = 1;
  MPI_Allreduce(MPI_IN_PLACE, used.data(), ntypes + 1, MPI_INT, MPI_MAX, world);

  laws.assign(ntypes + 1, PeridemContactLaw());
  any_restitution = false;
  largest_radius = 0.0;
  for (int t = 1; t <= ntypes; t++) {
    if (!used[t]) continue;
    const auto what = (contact && contact->covers(t)) ? given.over(contact->own(t)) : given;
    const auto where = fmt::format("Fix {} {}, type {}", id, style, t);
    laws[t] = PeridemContactLaw::resolve(what, PairPeridemContact::known(lmp, t, t, spacings),
                                         where, lmp);
    any_restitution = any_restitution || laws[t].uses_restitution();
    largest_radius = MAX(largest_radius, laws[t].radius);
  }
  if (comm->me == 0) describe(used);
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
}

/* ----------------------------------------------------------------------
   at the level of contacts among nodes: springs of both are alike, and collisions share the bodies
------------------------------------------------------------------------- */

void FixPeridemWall::find_level(const PairPeridemContact *contact)
{
  level.find(contact, "Pair style peridem/contact");
  if (level.respa()) respa_level = level.index();    // for LAMMPS to print
  if (level.count() > 1 && surface->changes_shape())
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {} {}: a region of variable shape changes at the outermost level of run_style "
               "respa only, and this wall acts at level {}",
               id, style, level.index() + 1);
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
  follow_surface();
  if (!started) check_start();
  if (level.respa()) level.respa()->copy_flevel_f(level.index());
  post_force(vflag);
  if (level.respa()) level.respa()->copy_f_flevel(level.index());
  if (!started) check_overlaps();
  started = true;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::min_setup(int vflag)
{
  setup(vflag);
}

/* ----------------------------------------------------------------------
   once for each step: forces may be evaluated more than once at the same time
------------------------------------------------------------------------- */

void FixPeridemWall::follow_surface()
{
  now = clock.next(level);
  surface->advance(now);
  motion.advance(now);
}

/* ---------------------------------------------------------------------- */

bool FixPeridemWall::misplaced(int i) const
{
  double x[3];    // as if the wall had not moved
  for (int k = 0; k < 3; k++) x[k] = atom->x[i][k] - motion.shift[k];
  return !surface->permits(x);
}

/* ---------------------------------------------------------------------- */

bigint FixPeridemWall::sum_misplaced(bigint count, tagint &lowest) const
{
  bigint count_all;
  tagint lowest_all;
  MPI_Allreduce(&count, &count_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&lowest, &lowest_all, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  lowest = lowest_all;
  return count_all;
}

/* ----------------------------------------------------------------------
   most likely a normal that points the wrong way, or side in for side out
------------------------------------------------------------------------- */

void FixPeridemWall::check_start()
{
  bigint count = 0;
  tagint lowest = MAXTAGINT;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit) || !misplaced(i)) continue;
    count++;
    lowest = MIN(lowest, atom->tag[i]);
  }
  count = sum_misplaced(count, lowest);
  if (count)
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {} {}: {} nodes start {} (the first is atom-ID {}): {}", id, style, count,
               surface->wrong_side(), lowest, surface->right_side());
}

/* ----------------------------------------------------------------------
   most likely a wall at the outline of a grain, and not R_c away from it
------------------------------------------------------------------------- */

void FixPeridemWall::check_overlaps()
{
  bigint count = 0;
  double deepest_part = 0.0;
  for (const int i : nearby.nodes()) {
    double x[3], depth = 0.0;
    for (int k = 0; k < 3; k++) x[k] = atom->x[i][k] - motion.shift[k];
    const double radius = laws[atom->type[i]].radius;
    feet.clear();
    surface->feet(x, radius, feet);
    for (const auto &foot : feet) depth = MAX(depth, 1.0 - foot.distance / radius);
    if (depth > WORTH_A_WARNING) count++;
    deepest_part = MAX(deepest_part, depth);
  }
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, &deepest_part, 1, MPI_DOUBLE, MPI_MAX, world);
  if (count && comm->me == 0)
    error->warning(FLERR,
                   "Fix {} {}: {} nodes overlap the wall at the start, the deepest by {:.1f} % of "
                   "the contact distance: they will be pushed off",
                   id, style, count, 100.0 * deepest_part);
}

/* ----------------------------------------------------------------------
   a region does not see nodes behind it: they would fly on without a word
------------------------------------------------------------------------- */

void FixPeridemWall::check_lost()
{
  bigint count = 0;
  tagint lowest = MAXTAGINT;
  for (const int i : nearby.nodes()) {
    if (!misplaced(i)) continue;
    count++;
    lowest = MIN(lowest, atom->tag[i]);
  }
  count = sum_misplaced(count, lowest);
  if (count)
    error->all(
        FLERR, Error::NOLASTLINE,
        "Fix {} {}: {} nodes have gone through the wall, they are {} at step {} (the first is "
        "atom-ID {}): take a stiffer contact, a larger radius or a smaller timestep",
        id, style, count, surface->wrong_side(), update->ntimestep, lowest);
}

/* ----------------------------------------------------------------------
   lossy = normal force beyond that of the spring; direct = force on the node
------------------------------------------------------------------------- */

void FixPeridemWall::book(int i, const PeridemSurface::Foot &foot, double lossy, const double *drag,
                          const double *direct)
{
  Touch touch{i, {}, {}, {}, {}};
  for (int m = 0; m < 3; m++) {
    touch.friction[m] = drag[m];
    touch.damping[m] = lossy * foot.normal[m];
    touch.wall_velocity[m] = foot.velocity[m] + motion.velocity[m];
    touch.direct[m] = direct[m];
  }
  touches.push_back(touch);
}

/* ---------------------------------------------------------------------- */

FixPeridemWall::Power FixPeridemWall::power() const
{
  double **v = atom->v;
  Power sum{0.0, 0.0, 0.0};
  for (const auto &touch : touches) {
    const double *const vi = v[touch.node], *const vw = touch.wall_velocity;
    for (int m = 0; m < 3; m++) {
      sum.friction += touch.friction[m] * (vi[m] - vw[m]);
      sum.damping += touch.damping[m] * (vi[m] - vw[m]);
      sum.on_nodes += touch.direct[m] * vi[m];
    }
  }
  if (pushing) {
    const double pushed = PeridemBooks::power(pushes, v, atom->nlocal);
    sum.damping += pushed - push_power;
    sum.on_nodes += pushed;
  }
  return sum;
}

/* ----------------------------------------------------------------------
   new local indices ask for a new list on all ranks, a wall that has moved on this one
------------------------------------------------------------------------- */

void FixPeridemWall::renew_list()
{
  const bool new_indices = level.lists_are_new();
  if (any_restitution) find_bodies(new_indices);
  if (!new_indices && !nearby.stale(*surface, motion)) return;
  nearby.build(*surface, motion, groupbit, largest_radius);
  if (new_indices && !surface->pushes_back()) check_lost();

  // nodes that are not on the list do not touch
  auto next = nearby.nodes().begin();
  for (int i = 0; i < atom->nlocal; i++)
    if (next != nearby.nodes().end() && *next == i)
      ++next;
    else if (!memories.empty(i))
      memories.clear(i);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::clear_loads()
{
  loads.assign(surface->parts().size(), Load());
  shape_power = deepest = energy = springs = 0.0;
  most_touched = 0;
  touches.clear();
  totals_known = false;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::post_force(int vflag)
{
  if (!update->setupflag) follow_surface();
  renew_list();

  v_init(vflag);
  loads_before.swap(loads);
  clear_loads();
  advance = update->setupflag == 0;
  dt = level.dt();

  impacts.clear();
  touch_all();
  if (any_restitution) impact_pass();
  if (advance && update->whichflag == 1) add_work();
  average_loads();
}

/* ----------------------------------------------------------------------
   At an inner level forces swing within each step of the run, and where it ends, at the kick of
   the outer level, they are always at the same phase: only their mean is what the wall feels.
------------------------------------------------------------------------- */

void FixPeridemWall::average_loads()
{
  const double share = now.stepping ? 1.0 / level.count() : 1.0;
  if (now.begins || mean_loads.size() != loads.size()) mean_loads.assign(loads.size(), Load());
  for (std::size_t n = 0; n < loads.size(); n++)
    for (int m = 0; m < 3; m++) {
      mean_loads[n].force[m] += share * loads[n].force[m];
      mean_loads[n].torque[m] += share * loads[n].torque[m];
    }
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::post_force_respa(int vflag, int ilevel, int /*iloop*/)
{
  if (ilevel == level.index()) post_force(vflag);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::touch_all()
{
  const double *const shift = motion.shift;
  for (const int i : nearby.nodes()) {
    const double x[3] = {atom->x[i][0] - shift[0], atom->x[i][1] - shift[1],
                         atom->x[i][2] - shift[2]};
    const double radius = laws[atom->type[i]].radius;
    const double wide = memories.empty(i) ? 0.0 : linger(i);
    feet.clear();
    surface->feet(x, radius + wide, feet);
    most_touched = MAX(most_touched, static_cast<int>(feet.size()));
    for (const auto &foot : feet)
      if (foot.distance < radius)
        touch(i, foot);
      else
        part(i, foot);
    if (!memories.empty(i)) memories.forget_unused(i);
  }
}

/* ----------------------------------------------------------------------
   how wide a gap node i has to make before its collisions are over
------------------------------------------------------------------------- */

double FixPeridemWall::linger(int i) const
{
  double deepest_yet = 0.0;
  for (const auto &slot : memories.of(i)) deepest_yet = MAX(deepest_yet, slot.deepest);
  return laws[atom->type[i]].lingering_gap(deepest_yet, neighbor->skin);
}

/* ----------------------------------------------------------------------
   a node that does not touch any more: friction starts anew if it comes back, a collision goes on
   until the gap is wide
------------------------------------------------------------------------- */

void FixPeridemWall::part(int i, const PeridemSurface::Foot &foot)
{
  auto *const memory = memories.known(i, foot.key);
  if (!memory) return;
  const auto &law = laws[atom->type[i]];
  for (double &slip : memory->slip) slip = 0.0;
  memory->used = foot.distance - law.radius < law.lingering_gap(memory->deepest, neighbor->skin);
}

/* ----------------------------------------------------------------------
   force between node i and the wall, a body of infinite mass
------------------------------------------------------------------------- */

void FixPeridemWall::touch(int i, const PeridemSurface::Foot &foot)
{
  const auto &law = laws[atom->type[i]];
  const double *const v = atom->v[i], *const normal = foot.normal;
  const double overlap = law.radius - foot.distance;
  const double k = law.spring(atom->vfrac[i], atom->vfrac[i]);

  double slide[3], rate = 0.0;    // of the wall as the node sees it; rate = growth of the distance
  for (int m = 0; m < 3; m++) {
    slide[m] = foot.velocity[m] + motion.velocity[m] - v[m];
    rate -= slide[m] * normal[m];
  }
  for (int m = 0; m < 3; m++) slide[m] += rate * normal[m];

  PeridemWallMemory::Slot none{};
  const bool remembers = law.uses_history() || law.uses_restitution();
  auto &memory = remembers ? memories.at(i, foot.key) : none;
  memory.deepest = MAX(memory.deepest, overlap);

  const double elastic = law.elastic(k, overlap), beta = law.dashpot();
  const double fn = law.normal(elastic, rate), stored = law.energy(k, overlap);
  double drag[3] = {0.0, 0.0, 0.0};
  if (law.friction > 0.0)
    law.tangential({k, beta, fn, atom->rmass[i], dt, advance, normal}, slide, memory.slip, drag);

  double on_node[3];
  for (int m = 0; m < 3; m++) {
    on_node[m] = fn * normal[m] + drag[m];
    atom->f[i][m] += on_node[m];
  }
  if (adapt) adapt->note_spring(i, k);
  if (law.uses_restitution()) impacts.push_back({i, foot, fn, 2.0 * stored, {}, -1});
  react(i, foot, on_node);
  deepest = MAX(deepest, overlap);
  energy += stored;
  springs += law.spring_energy(k, memory.slip);
  if (books.open) book(i, foot, fn - elastic, drag, on_node);
}

/* ----------------------------------------------------------------------
   energy that a collision with the wall loses: a force on the body of node i
------------------------------------------------------------------------- */

void FixPeridemWall::impact(const Impact &one)
{
  const int i = one.node;
  const auto &collision = collisions.at(one.collision);
  double &peak = memories.known(i, one.foot.key)->peak;
  peak = MAX(peak, collision.peak);
  const double approach = collision.approach();
  if (advance) peak = MAX(peak, approach);
  const double mobility = one.body.mobility_along(one.foot.normal);
  const auto &law = laws[atom->type[i]];
  const double size = law.impact_force(one.elastic, collision.stored, approach, peak, mobility, dt);
  double push[3];
  for (int m = 0; m < 3; m++) {
    push[m] = size * one.foot.normal[m];
    push_power += push[m] * (one.foot.velocity[m] + motion.velocity[m]);
  }
  react(i, one.foot, push);
  bodies->push(i, push);
}

/* ----------------------------------------------------------------------
   what the wall feels of the force on node i
------------------------------------------------------------------------- */

void FixPeridemWall::react(int i, const PeridemSurface::Foot &foot, const double *on_node)
{
  const auto &part = surface->parts()[foot.part];
  auto &load = loads[foot.part];
  const double *const f = on_node;
  double arm[3];
  for (int m = 0; m < 3; m++) {
    load.force[m] -= f[m];
    arm[m] = foot.at[m] - part.point[m];
  }
  load.torque[0] -= arm[1] * f[2] - arm[2] * f[1];
  load.torque[1] -= arm[2] * f[0] - arm[0] * f[2];
  load.torque[2] -= arm[0] * f[1] - arm[1] * f[0];

  // what is left of the velocity of the face when the motion of its part is taken off
  const double *const w = part.spin;
  const double turn[3] = {w[1] * arm[2] - w[2] * arm[1], w[2] * arm[0] - w[0] * arm[2],
                          w[0] * arm[1] - w[1] * arm[0]};
  for (int m = 0; m < 3; m++) shape_power += f[m] * (foot.velocity[m] - part.velocity[m] - turn[m]);

  if (!evflag) return;
  double d[3], virial_of[6];
  for (int m = 0; m < 3; m++) d[m] = foot.distance * foot.normal[m];
  virial_of[0] = f[0] * d[0];
  virial_of[1] = f[1] * d[1];
  virial_of[2] = f[2] * d[2];
  virial_of[3] = f[1] * d[0];
  virial_of[4] = f[2] * d[0];
  virial_of[5] = f[2] * d[1];
  v_tally(i, virial_of);
}

/* ----------------------------------------------------------------------
   velocities are those over the step, so forces are taken in the middle of it
------------------------------------------------------------------------- */

void FixPeridemWall::add_work()
{
  const auto &parts = surface->parts();
  loads_before.resize(loads.size(), Load());
  double power = shape_power;
  for (std::size_t n = 0; n < loads.size(); n++)
    for (int m = 0; m < 3; m++) {
      power -= 0.5 * (loads[n].force[m] + loads_before[n].force[m]) *
          (parts[n].velocity[m] + motion.velocity[m]);
      power -= 0.5 * (loads[n].torque[m] + loads_before[n].torque[m]) * parts[n].spin[m];
    }
  work += dt * power;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::find_bodies(bool new_indices)
{
  auto *contact = dynamic_cast<PairPeridemContact *>(lmp->force->pair_match("peridem/contact", 1));
  bodies = contact ? contact->moving_bodies() : nullptr;
  if (new_indices) collisions.clear();
  if (bodies) return;
  bodies = &own_bodies;
  if (new_indices) bodies->sort_nodes(bonds);
  bodies->forget();
}

/* ----------------------------------------------------------------------
   a body may touch a face at several nodes: that is one collision
------------------------------------------------------------------------- */

void FixPeridemWall::find_collisions()
{
  auto place_of = [&](int i, int key) {
    const int place = collisions.find(-1 - static_cast<bigint>(key), bodies->id(i));
    if (bodies->shared(i)) collisions.seen_elsewhere(place);
    return place;
  };
  collisions.begin();
  for (auto &one : impacts) {
    one.body = bodies->body(one.node);
    one.collision = place_of(one.node, one.foot.key);
    double approach = 0.0;
    for (int m = 0; m < 3; m++)
      approach -=
          (one.body.velocity[m] - one.foot.velocity[m] - motion.velocity[m]) * one.foot.normal[m];
    collisions.add(one.collision, one.elastic, one.stored, approach, 1.0);
  }
  // contacts that are open for a moment remember too
  for (const int i : nearby.nodes())
    for (const auto &slot : memories.of(i)) collisions.remember(place_of(i, slot.key), slot.peak);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::impact_pass()
{
  // most walls touch no body that several ranks have parts of: then one question is enough
  const bool known = bodies->known();
  if (known) find_collisions();
  int any[3] = {!impacts.empty(), !known && bodies->torn(), !known || collisions.abroad()};
  MPI_Allreduce(MPI_IN_PLACE, any, 3, MPI_INT, MPI_MAX, world);
  pushing = any[0];
  push_power = 0.0;
  if (!pushing) return;

  if (books.open) pushes.assign(3 * static_cast<std::size_t>(atom->nlocal), 0.0);
  if (!known) {
    bodies->start(any[1]);
    find_collisions();
  }
  if (any[2]) collisions.merge();
  for (const auto &one : impacts) impact(one);
  spread.begin(atom->f[0], books.open ? &pushes : nullptr);
  bodies->apply(spread, any[2]);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::min_post_force(int vflag)
{
  post_force(vflag);
}

/* ----------------------------------------------------------------------
   Springs of faces at right angles act on their own; in a sharp corner those of several faces pull
   almost the same way.  A node is taken to touch as many faces as there are dimensions, or as it
   does now.
------------------------------------------------------------------------- */

double FixPeridemWall::springs_at_a_node() const
{
  int most = MAX(MIN(surface->most_feet(), domain->dimension), most_touched);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, world);
  return most;
}

/* ---------------------------------------------------------------------- */

bool FixPeridemWall::begins_softly() const
{
  for (const auto &law : laws)
    if (law.radius > 0.0 && !law.begins_softly()) return false;
  return true;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::add_stiffness(PeridemContactStiffness &stiffness, double time)
{
  const double *const shift = motion.shift;
  for (const int i : nearby.nodes()) {
    const double x[3] = {atom->x[i][0] - shift[0], atom->x[i][1] - shift[1],
                         atom->x[i][2] - shift[2]};
    const auto &law = laws[atom->type[i]];
    const double V = atom->vfrac[i], k = law.spring(V, V), *const v = atom->v[i];
    feet.clear();
    surface->feet(x, law.radius + neighbor->skin, feet);
    for (const auto &foot : feet) {
      double slide[3];
      for (int m = 0; m < 3; m++) slide[m] = foot.velocity[m] + motion.velocity[m] - v[m];
      if (foot.distance < PeridemContactStiffness::reach(law.radius, slide, time))
        stiffness.add(i, PeridemContactStiffness::WALL, k, law.tangential_ratio() * k, foot.normal);
    }
  }
}

/* ---------------------------------------------------------------------- */

double FixPeridemWall::lightest(int itype) const
{
  return adapt ? adapt->lightest(itype) : extremes.lightest[itype];
}

/* ---------------------------------------------------------------------- */

double FixPeridemWall::largest_frequency_sq() const
{
  const double count = springs_at_a_node();
  double largest = 0.0;
  for (int t = 1; t <= atom->ntypes; t++) {
    if (laws[t].radius == 0.0 || extremes.largest[t] == 0.0) continue;
    const double k = laws[t].spring(extremes.smallest[t], extremes.smallest[t]);
    largest = MAX(largest, count * k / lightest(t));
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

double FixPeridemWall::largest_dashpot_ratio() const
{
  const double count = springs_at_a_node();
  double largest = 0.0;
  for (int t = 1; t <= atom->ntypes; t++) {
    if (laws[t].radius == 0.0 || extremes.largest[t] == 0.0) continue;
    const double k = laws[t].spring(extremes.smallest[t], extremes.smallest[t]);
    const double beta = laws[t].dashpot();
    largest = MAX(largest, std::sqrt(count) * beta / (2.0 * std::sqrt(k * lightest(t))));
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::sum_totals()
{
  if (totals_known) return;
  double mine[8] = {}, centre[3];
  surface->centre(centre);
  for (std::size_t n = 0; n < mean_loads.size(); n++) {
    const double *const f = mean_loads[n].force;
    double arm[3];
    for (int m = 0; m < 3; m++) {
      mine[m] += f[m];
      mine[3 + m] += mean_loads[n].torque[m];
      arm[m] = surface->parts()[n].point[m] - centre[m];
    }
    mine[3] += arm[1] * f[2] - arm[2] * f[1];
    mine[4] += arm[2] * f[0] - arm[0] * f[2];
    mine[5] += arm[0] * f[1] - arm[1] * f[0];
  }
  mine[6] = work;
  mine[7] = energy;
  MPI_Allreduce(mine, total, 8, MPI_DOUBLE, MPI_SUM, world);
  totals_known = true;
}

/* ----------------------------------------------------------------------
   elastic energy of the overlaps with the wall
------------------------------------------------------------------------- */

double FixPeridemWall::compute_scalar()
{
  sum_totals();
  return total[7];
}

/* ----------------------------------------------------------------------
   1-3 force on the wall, 4-6 torque about its point, which moves with it, 7 deepest overlap,
   8 work of the wall
------------------------------------------------------------------------- */

double FixPeridemWall::compute_vector(int n)
{
  if (n != 6) {    // forces are asked for at every step, the overlap seldom
    sum_totals();
    return total[n < 6 ? n : 6];
  }
  double deepest_all;
  MPI_Allreduce(&deepest, &deepest_all, 1, MPI_DOUBLE, MPI_MAX, world);
  return deepest_all;
}

/* ---------------------------------------------------------------------- */

static constexpr PeridemStamp STAMP(1);    // for what nodes have in the file too

void FixPeridemWall::write_restart(FILE *fp)
{
  double all_work;
  MPI_Allreduce(&work, &all_work, 1, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me) return;
  std::vector<double> list(2 + PeridemWallMotion::SIZE);
  list[0] = STAMP.number;
  list[1] = all_work;
  motion.pack(&list[2]);
  const auto more = surface->state();
  list.push_back(static_cast<double>(more.size()));
  list.insert(list.end(), more.begin(), more.end());
  const int size = static_cast<int>(list.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(list.data(), sizeof(double), list.size(), fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::restart(char *buf)
{
  const auto *list = reinterpret_cast<double *>(buf);
  STAMP.check(list[0], fmt::format("Fix {}", style), error);
  work = comm->me == 0 ? list[1] : 0.0;
  motion.unpack(list + 2);
  list += 2 + PeridemWallMotion::SIZE;
  surface->restore(list + 1, static_cast<int>(list[0]));
  started = true;
}

/* ----------------------------------------------------------------------
   what contacts with the wall remember travels with the nodes
------------------------------------------------------------------------- */

void FixPeridemWall::grow_arrays(int nmax)
{
  memories.grow(nmax);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::copy_arrays(int i, int j, int)
{
  memories.copy(i, j);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::set_arrays(int i)
{
  memories.clear(i);
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::pack_exchange(int i, double *buf)
{
  return memories.pack(i, buf);
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::unpack_exchange(int i, double *buf)
{
  return memories.unpack(i, buf);
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::pack_restart(int i, double *buf)
{
  buf[0] = 1 + memories.pack(i, buf + 1);
  return static_cast<int>(buf[0]);
}

/* ---------------------------------------------------------------------- */

void FixPeridemWall::unpack_restart(int i, int nth)
{
  double *buf = atom->extra[i];
  int m = 0;
  for (int k = 0; k < nth; k++) m += static_cast<int>(buf[m]);
  memories.unpack(i, buf + m + 1);
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::size_restart(int i)
{
  return 1 + memories.size_of(i);
}

/* ---------------------------------------------------------------------- */

int FixPeridemWall::maxsize_restart()
{
  return 1 + PeridemWallMemory::size(surface->most_feet());
}

/* ---------------------------------------------------------------------- */

double FixPeridemWall::memory_usage()
{
  return memories.bytes();
}

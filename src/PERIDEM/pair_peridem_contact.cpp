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

#include "pair_peridem_contact.h"

#include "fix_peridem_adapt.h"
#include "fix_peridem_bonds.h"
#include "fix_peridem_history.h"
#include "fix_peridem_ledger.h"
#include "pair_peridem.h"
#include "peridem_compat.h"
#include "peridem_contact_parser.h"
#include "peridem_grains.h"
#include "peridem_stamp.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_hybrid_overlay.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <type_traits>

using namespace LAMMPS_NS;

// overlaps at the start deeper than this fraction of the contact distance are worth a warning
static constexpr double WORTH_A_WARNING = 0.01;

// keeps the place of the fix that holds the springs: before any fix that migrates nodes
static constexpr char PLACEHOLDER[] = "PERIDEM_HISTORY_PLACE";

// Default skin, as a fraction of the contact distance.  A list costs as much as ten steps, and nodes
// that rattle between their neighbors would ask for a new one again and again.
static constexpr double SKIN = 1.25;

/* ---------------------------------------------------------------------- */

PairPeridemContact::PairPeridemContact(LAMMPS *lmp) :
    Pair(lmp), level(lmp), bodies(lmp), collisions(lmp)
{
  single_enable = 0;
  restartinfo = 1;
  no_virial_fdotr_compute = 1;
  comm_forward = PeridemBody::SIZE;
}

/* ---------------------------------------------------------------------- */

PairPeridemContact::~PairPeridemContact()
{
  if (copymode) return;
  if (modify && modify->nfix) {
    if (history) modify->delete_fix(history->id);
    if (modify->get_fix_by_id(PLACEHOLDER)) modify->delete_fix(PLACEHOLDER);
  }
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::allocate()
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
  given.assign(index(ntypes, ntypes) + 1, PeridemContactGiven());
  laws.assign(given.size(), PeridemContactLaw());
  mixed.assign(given.size(), 0);
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::settings(int narg, char **arg)
{
  if (narg) error->all(FLERR, "Pair style peridem/contact takes no arguments; given: {}", arg[0]);
  if (!modify->get_fix_by_id(PLACEHOLDER)) modify->add_fix(std::string(PLACEHOLDER) + " all DUMMY");
  FixPeridemLedger::keep_place(lmp);
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::coeff(int narg, char **arg)
{
  if (narg < 2) utils::missing_cmd_args(FLERR, "pair_coeff peridem/contact", error);
  if (!allocated) allocate();

  int ilo, ihi, jlo, jhi;
  utils::bounds(FLERR, arg[0], 1, ntypes, ilo, ihi, error);
  utils::bounds(FLERR, arg[1], 1, ntypes, jlo, jhi, error);

  const int offset = dynamic_cast<PairHybrid *>(force->pair) ? 1 : 0;
  PeridemContactParser parser(lmp, "pair style peridem/contact", offset);
  PeridemContactGiven one;
  const int iarg = parser.parse(2, narg, arg, one);
  if (iarg < narg)
    error->all(FLERR, iarg + offset,
               "Unknown pair style peridem/contact keyword {}: known are {}, fragments", arg[iarg],
               PeridemContactParser::keywords());

  int count = 0;
  for (int i = ilo; i <= ihi; i++)
    for (int j = MAX(jlo, i); j <= jhi; j++) {
      given[index(i, j)] = given[index(j, i)] = one;
      mixed[index(i, j)] = mixed[index(j, i)] = 0;
      setflag[i][j] = 1;
      count++;
    }
  if (count == 0)
    error->all(FLERR, Error::ARGZERO, "pair_coeff peridem/contact: no type pair I <= J in it");
}

/* ----------------------------------------------------------------------
   what the solids say of two types
------------------------------------------------------------------------- */

PeridemContactKnown PairPeridemContact::known(LAMMPS *lmp, int itype, int jtype,
                                              const std::vector<double> &spacings)
{
  double bulk[2] = {0.0, 0.0}, horizon[2] = {0.0, 0.0};
  const int types[2] = {itype, jtype};
  for (auto *solid : PairPeridem::find_all(lmp))
    for (int k = 0; k < 2; k++)
      if (solid->covers(types[k])) {
        bulk[k] = solid->own_material(types[k]).bulk;
        horizon[k] = solid->own_material(types[k]).horizon;
      }

  PeridemContactKnown result{0.0, 0.0, 0.0};
  // a type without a solid (a wall of nodes) touches as if it were like the other
  for (int k = 0; k < 2; k++) {
    if (bulk[k] == 0.0) bulk[k] = bulk[1 - k];
    if (horizon[k] == 0.0) horizon[k] = horizon[1 - k];
  }
  if (bulk[0] > 0.0) result.bulk = 2.0 * bulk[0] * bulk[1] / (bulk[0] + bulk[1]);
  result.horizon = 0.5 * (horizon[0] + horizon[1]);
  const double si = spacings[itype], sj = spacings[jtype];
  result.spacing = (si > 0.0 && sj > 0.0) ? MIN(si, sj) : MAX(si, sj);
  return result;
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::init_style()
{
  check_styles();
  level.find(this, "Pair style peridem/contact");
  bodies.init();
  mix_pairs();
  find_laws();
  const auto adapts = modify->get_fix_by_style("^peridem/adapt$");
  adapt = adapts.empty() ? nullptr : dynamic_cast<FixPeridemAdapt *>(adapts[0]);

  bonded_types.assign(ntypes + 1, 0);
  for (auto *solid : PairPeridem::find_all(lmp))
    for (int i = 1; i <= ntypes; i++)
      if (solid->covers(i)) bonded_types[i] = 1;

  if (any_velocity || any_restitution) comm->ghost_velocity = 1;
  shrink_skin();
  find_history();

  // a pair that crosses to another rank is listed on both, whatever newton says

  neighbor->add_request(this, NeighConst::REQ_NEWTON_OFF);
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::check_styles()
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style peridem/contact requires atom style peridem; the atom style is {}",
               atom->get_style());
  if (mix_flag != GEOMETRIC && comm->me == 0)
    error->warning(FLERR,
                   "pair_modify mix has no effect on pair style peridem/contact: types without "
                   "pair_coeff of their own are mixed as its manual page says");
}

/* ----------------------------------------------------------------------
   A hybrid style calls this one only for pairs of types with a pair_coeff line of its own: without
   such a line, and with one for another style, grains of two types would not feel each other.
------------------------------------------------------------------------- */

void PairPeridemContact::mix_pairs()
{
  auto *const hybrid = dynamic_cast<PairHybridOverlay *>(force->pair);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i + 1; j <= ntypes; j++) {
      if (setflag[i][j] || !setflag[i][i] || !setflag[j][j]) continue;
      if (hybrid && hybrid->setflag[i][j]) {
        std::string words[3] = {std::to_string(i), std::to_string(j), "peridem/contact"};
        char *line[3] = {&words[0][0], &words[1][0], &words[2][0]};
        hybrid->coeff(3, line);
      }
      mixed[index(i, j)] = mixed[index(j, i)] = 1;
    }
}

/* ---------------------------------------------------------------------- */

PeridemContactLaw PairPeridemContact::find_law(int i, int j,
                                               const std::vector<double> &spacings) const
{
  auto resolved = [&](int a, int b, const PeridemContactGiven &what) {
    const auto where = fmt::format("Pair style peridem/contact, types {} {}", a, b);
    return PeridemContactLaw::resolve(what, known(lmp, a, b, spacings), where, lmp);
  };
  if (!mixed[index(i, j)]) return resolved(i, j, given[index(i, j)]);

  const auto &gi = own(i), &gj = own(j);
  const auto where = fmt::format("Pair style peridem/contact, types {} {}", i, j);
  auto law = PeridemContactLaw::mix(resolved(i, i, gi), resolved(j, j, gj), where, lmp);
  if (std::isnan(gi.radius) && std::isnan(gj.radius)) {    // radius auto, of the pair
    const double fi = std::isnan(gi.auto_factor) ? PeridemContactGiven::AUTO_FACTOR
                                                 : gi.auto_factor;
    const double fj = std::isnan(gj.auto_factor) ? PeridemContactGiven::AUTO_FACTOR
                                                 : gj.auto_factor;
    law.radius = MAX(fi, fj) * known(lmp, i, j, spacings).spacing;
  }
  return law;
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::find_laws()
{
  std::vector<double> widest;
  const auto spacings = PeridemGrains::spacings(lmp, &widest);
  extremes = PeridemGrains::extremes(lmp);
  any_velocity = any_restitution = any_springs = false;
  laws.assign(given.size(), PeridemContactLaw());
  widest_rcsq.assign(ntypes + 1, 0.0);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const bool mix = mixed[index(i, j)];
      if (!setflag[i][j] && !mix) continue;
      if (spacings[i] == 0.0 && spacings[j] == 0.0) continue;             // no nodes of either type
      if (mix && (spacings[i] == 0.0 || spacings[j] == 0.0)) continue;    // they never meet
      const auto law = find_law(i, j, spacings);
      laws[index(i, j)] = laws[index(j, i)] = law;
      for (const int type : {i, j})
        widest_rcsq[type] = MAX(widest_rcsq[type], law.radius * law.radius);
      any_velocity = any_velocity || law.uses_velocity();
      any_restitution = any_restitution || law.uses_restitution();
      any_springs = any_springs || law.uses_history() || law.uses_restitution();
      if (comm->me == 0)
        utils::logmesg(lmp, "PERIDEM: contact of types {} {}{}: {}\n", i, j, mix ? " (mixed)" : "",
                       law.describe());
    }
  if (!holes_checked && comm->me == 0) check_holes(widest);
  holes_checked = true;
}

/* ----------------------------------------------------------------------
   grains whose nodes are far apart, compared with the contact distance, are sieves for small ones:
   a node fits through the middle of two nodes in 2d, of four on a square in 3d
------------------------------------------------------------------------- */

void PairPeridemContact::check_holes(const std::vector<double> &widest) const
{
  const double part = domain->dimension == 2 ? 0.5 : std::sqrt(0.5);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const double radius = laws[index(i, j)].radius, gap = MAX(widest[i], widest[j]);
      if (radius == 0.0 || radius >= part * gap) continue;
      error->warning(
          FLERR,
          "The contact distance of types {} {} is {:.6g}, but nodes of type {} are up to "
          "{:.6g} apart: other nodes fit through between them; give this pair a radius "
          "of {:.6g} or more, or mesh with one spacing",
          i, j, radius, widest[i] > widest[j] ? i : j, gap, part * gap);
    }
}

/* ----------------------------------------------------------------------
   LAMMPS's default skin is made for molecules (in si units it is 1 mm, as large as a grain)
------------------------------------------------------------------------- */

void PairPeridemContact::shrink_skin() const
{
  static const std::map<std::string, double> defaults = {
      {"lj", 0.3},  {"real", 2.0},     {"metal", 2.0}, {"si", 0.001},
      {"cgs", 0.1}, {"electron", 2.0}, {"micro", 0.1}, {"nano", 0.1}};
  double least = 0.0;
  for (const auto &law : laws)
    if (law.radius > 0.0 && (least == 0.0 || law.radius < least)) least = law.radius;
  const auto it = defaults.find(update->unit_style);
  if (it == defaults.end() || neighbor->skin != it->second || neighbor->skin <= least ||
      least == 0.0)
    return;
  neighbor->skin = SKIN * least;
  if (comm->me == 0)
    utils::logmesg(lmp,
                   "PERIDEM: neighbor skin set to {:.6g}, {:.2f} of the contact distance (the "
                   "default of units {} is {:g})\n",
                   neighbor->skin, SKIN, update->unit_style, it->second);
}

/* ----------------------------------------------------------------------
   what contacts remember travels in a fix of its own
------------------------------------------------------------------------- */

void PairPeridemContact::find_history()
{
  if (any_springs && !history) {
    const std::string command = "PERIDEM_HISTORY all PERIDEM_HISTORY";
    history = dynamic_cast<FixPeridemHistory *>(modify->get_fix_by_id(PLACEHOLDER)
                                                    ? modify->replace_fix(PLACEHOLDER, command, 1)
                                                    : modify->add_fix(command));
  }
  if (history) history->set_source(this);
}

/* ---------------------------------------------------------------------- */

double PairPeridemContact::init_one(int i, int j)
{
  if (!setflag[i][j] && !(setflag[i][i] && setflag[j][j]))
    error->all(FLERR, Error::NOLASTLINE, "Pair style peridem/contact: pair_coeff {} {} is not set",
               i, j);
  return laws[index(i, j)].radius;
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (level.lists_are_new()) pick_candidates();
  add_broken_bonds();
  if (!overlaps_checked) check_overlaps();

  advance = update->setupflag == 0;
  dt = level.dt();
  impacts.clear();
  if (books.open) books.clear(atom->nlocal);
  if (any_springs) {
    touch_all<true>();
    live = true;
  } else
    touch_all<false>();
  if (any_restitution) impact_pass();
}

/* ---------------------------------------------------------------------- */

template <bool HISTORY> void PairPeridemContact::touch_all()
{
  if (row_node.empty() && fragments.empty()) return;
  // rows of x lie one behind the other: no need to look up where each begins
  const double *const x = atom->x[0];
  const int *const type = atom->type;
  const int nrows = static_cast<int>(row_node.size());
  for (int row = 0; row < nrows; row++) {
    const int i = row_node[row];
    const double *const xi = x + 3 * static_cast<std::size_t>(i);
    const double here[3] = {xi[0], xi[1], xi[2]}, widest = widest_rcsq[type[i]];
    for (int k = row_first[row]; k < row_first[row + 1]; k++) {
      const int j = candidates[k];
      const double *const xj = x + 3 * static_cast<std::size_t>(j);
      const double d[3] = {xj[0] - here[0], xj[1] - here[1], xj[2] - here[2]};
      const double rsq = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      if (rsq >= widest && (!HISTORY || memories[k] < 0)) continue;    // nearly all
      const auto &law = laws[index(type[i], type[j])];
      if (rsq < law.radius * law.radius) {
        if (HISTORY && memories[k] < 0) memories[k] = remember(i, j);
        touch(i, j, law.radius, rsq, d, HISTORY ? memories[k] : -1);
      } else if (HISTORY && memories[k] >= 0)
        part(law, std::sqrt(rsq) - law.radius, memories[k]);
    }
  }
  for (auto &pair : fragments) {
    const double *const xi = x + 3 * static_cast<std::size_t>(pair.i);
    const double *const xj = x + 3 * static_cast<std::size_t>(pair.j);
    const double d[3] = {xj[0] - xi[0], xj[1] - xi[1], xj[2] - xi[2]};
    const double rsq = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (rsq < pair.distance * pair.distance) {
      if (HISTORY && pair.memory < 0) pair.memory = remember(pair.i, pair.j);
      touch(pair.i, pair.j, pair.distance, rsq, d, pair.memory);
    } else if (HISTORY && pair.memory >= 0)
      part(laws[index(type[pair.i], type[pair.j])], std::sqrt(rsq) - pair.distance, pair.memory);
  }
}

/* ----------------------------------------------------------------------
   a new contact: the place of what it will remember
------------------------------------------------------------------------- */

int PairPeridemContact::remember(int i, int j)
{
  Spring fresh;
  fresh.i = i;
  fresh.j = j;
  if (free_springs.empty()) {
    springs.push_back(fresh);
    return static_cast<int>(springs.size()) - 1;
  }
  const int place = free_springs.back();
  free_springs.pop_back();
  springs[place] = fresh;
  return place;
}

/* ----------------------------------------------------------------------
   nodes that do not touch any more: friction starts anew if they come back, a collision goes on
   until the gap is wide
------------------------------------------------------------------------- */

void PairPeridemContact::part(const PeridemContactLaw &law, double gap, int &memory)
{
  auto &spring = springs[memory];
  for (double &slip : spring.slip) slip = 0.0;
  if (gap < law.lingering_gap(spring.deepest, neighbor->skin)) return;
  spring.i = spring.j = -1;
  free_springs.push_back(memory);
  memory = -1;
}

/* ----------------------------------------------------------------------
   from LAMMPS's neighbour list: nodes of different grains, and nodes of one grain whose bond is
   broken or never was. Nodes of one grain that no solid holds together (a wall of nodes, a rigid
   grain) do not touch each other.
------------------------------------------------------------------------- */

void PairPeridemContact::pick_candidates()
{
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
  broken_seen = 0;
  list_nlocal = atom->nlocal;

  const tagint *const mol = atom->molecule;
  const int *const type = atom->type;
  row_node.clear();
  row_first.assign(1, 0);
  candidates.clear();
  fragments.clear();
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    const int *const jlist = list->firstneigh[i];
    const auto before = candidates.size();
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const int j = jlist[jj] & NEIGHMASK;
      if (mol[i] == 0 || mol[i] != mol[j])
        candidates.push_back(j);
      else if (bonds && bonded_types[type[i]] && bonded_types[type[j]] &&
               !bonds->bonded(i, atom->tag[j]))
        add_fragment(i, j);
    }
    if (candidates.size() == before) continue;
    row_node.push_back(i);
    row_first.push_back(static_cast<int>(candidates.size()));
  }

  if (any_restitution) {
    bodies.sort_nodes(bonds);
    collisions.clear();
  }
  find_springs();
}

/* ----------------------------------------------------------------------
   what pairs remembered before their nodes migrated
------------------------------------------------------------------------- */

void PairPeridemContact::find_springs()
{
  springs.clear();
  free_springs.clear();
  if (!any_springs) return;
  memories.resize(candidates.size());
  for (std::size_t row = 0; row < row_node.size(); row++)
    for (int k = row_first[row]; k < row_first[row + 1]; k++)
      memories[k] = find_spring(row_node[row], candidates[k]);
  for (auto &pair : fragments) pair.memory = find_spring(pair.i, pair.j);
}

/* ---------------------------------------------------------------------- */

int PairPeridemContact::find_spring(int i, int j)
{
  for (const auto &one : history->rows[i])
    if (one.tag == atom->tag[j]) {
      const int place = remember(i, j);
      auto &spring = springs[place];
      for (int m = 0; m < 3; m++) spring.slip[m] = one.slip[m];
      spring.peak = one.peak;
      spring.deepest = one.deepest;
      return place;
    }
  return -1;
}

/* ----------------------------------------------------------------------
   give each owned node its springs
------------------------------------------------------------------------- */

void PairPeridemContact::store_springs(FixPeridemHistory &fix) const
{
  for (const auto &one : springs) {
    if (one.i < 0) continue;
    const double *const s = one.slip;
    fix.rows[one.i].push_back({atom->tag[one.j], {s[0], s[1], s[2]}, one.peak, one.deepest});
    if (one.j < atom->nlocal)
      fix.rows[one.j].push_back({atom->tag[one.i], {-s[0], -s[1], -s[2]}, one.peak, one.deepest});
  }
}

/* ----------------------------------------------------------------------
   two nodes of one grain touch at d_c = min(R_c, R): where a bond breaks they do not touch yet
------------------------------------------------------------------------- */

void PairPeridemContact::add_fragment(int i, int j)
{
  const auto &law = laws[index(atom->type[i], atom->type[j])];
  if (!law.fragments || law.radius == 0.0) return;
  double **X = atom->x0;
  double d[3] = {X[j][0] - X[i][0], X[j][1] - X[i][1], X[j][2] - X[i][2]};
  PeridemCompat::minimum_image(domain, d);
  const double R = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  fragments.push_back({i, j, MIN(law.radius, R), -1});
}

/* ----------------------------------------------------------------------
   bonds that broke since the candidates were picked; both ends of a bond report it: of two owned
   nodes, the lower ID takes the pair
------------------------------------------------------------------------- */

void PairPeridemContact::add_broken_bonds()
{
  if (!bonds) return;
  for (; broken_seen < bonds->broken.size(); broken_seen++) {
    const auto &bond = bonds->broken[broken_seen];
    if (bond.j >= atom->nlocal || atom->tag[bond.i] < atom->tag[bond.j])
      add_fragment(bond.i, bond.j);
  }
}

/* ----------------------------------------------------------------------
   grains that overlap when the simulation starts were packed too closely
------------------------------------------------------------------------- */

void PairPeridemContact::check_overlaps()
{
  overlaps_checked = true;
  double **x = atom->x;
  const int *const type = atom->type;
  double deepest = 0.0;
  bigint count = 0;
  for (std::size_t row = 0; row < row_node.size(); row++) {
    const int i = row_node[row];
    for (int k = row_first[row]; k < row_first[row + 1]; k++) {
      const int j = candidates[k];
      const double dx = x[j][0] - x[i][0], dy = x[j][1] - x[i][1], dz = x[j][2] - x[i][2];
      const double rc = laws[index(type[i], type[j])].radius;
      if (rc == 0.0) continue;
      const double depth = 1.0 - std::sqrt(dx * dx + dy * dy + dz * dz) / rc;
      // a pair that crosses to another rank is known to both
      const bool mine = j < atom->nlocal || atom->tag[i] < atom->tag[j];
      if (mine && depth > WORTH_A_WARNING) count++;
      deepest = MAX(deepest, depth);
    }
  }
  double deepest_all;
  bigint count_all;
  MPI_Allreduce(&deepest, &deepest_all, 1, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(&count, &count_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (count_all && comm->me == 0)
    error->warning(
        FLERR,
        "{} pairs of nodes of different grains overlap at the start, the deepest by {:.1f} "
        "% of the contact distance: they will be pushed apart",
        count_all, 100.0 * deepest_all);
}

/* ----------------------------------------------------------------------
   force between two nodes nearer than their contact distance; d points from i to j
------------------------------------------------------------------------- */

void PairPeridemContact::touch(int i, int j, double distance, double rsq, const double *d,
                               int memory)
{
  double **f = atom->f;
  const int nlocal = atom->nlocal;
  const auto &law = laws[index(atom->type[i], atom->type[j])];
  const double r = std::sqrt(rsq);

  // nodes at the same place are pushed apart along x, the lower ID to the left
  double n[3] = {atom->tag[i] < atom->tag[j] ? 1.0 : -1.0, 0.0, 0.0};
  if (r > 0.0)
    for (int m = 0; m < 3; m++) n[m] = d[m] / r;

  const double k = law.spring(atom->vfrac[i], atom->vfrac[j]), overlap = distance - r;
  double fn = law.elastic(k, overlap);
  double total[3];    // force on node i
  if (law.uses_velocity())
    fn = lose(i, j, law, k, fn, n, memory, total);
  else
    for (int m = 0; m < 3; m++) total[m] = -fn * n[m];
  if (memory >= 0) springs[memory].deepest = MAX(springs[memory].deepest, overlap);
  if (adapt) {
    adapt->note_spring(i, k);
    if (j < nlocal) adapt->note_spring(j, k);
  }
  if (law.uses_restitution())
    impacts.push_back({i, j, fn, 2.0 * law.energy(k, overlap), memory, {n[0], n[1], n[2]}});

  for (int m = 0; m < 3; m++) f[i][m] += total[m];
  if (j < nlocal)
    for (int m = 0; m < 3; m++) f[j][m] -= total[m];

  if (evflag)
    ev_tally_xyz(i, j, nlocal, 0, law.energy(k, overlap), 0.0, total[0], total[1], total[2], -d[0],
                 -d[1], -d[2]);
}

/* ----------------------------------------------------------------------
   the same with damping and friction: force on node i, of which the normal part is returned
------------------------------------------------------------------------- */

double PairPeridemContact::lose(int i, int j, const PeridemContactLaw &law, double k,
                                double elastic, const double *n, int memory, double *total)
{
  double **v = atom->v;
  double slide[3], rate = 0.0;
  for (int m = 0; m < 3; m++) {
    slide[m] = v[j][m] - v[i][m];
    rate += slide[m] * n[m];
  }
  for (int m = 0; m < 3; m++) slide[m] -= rate * n[m];

  const double beta = law.dashpot(), fn = law.normal(elastic, rate);
  for (int m = 0; m < 3; m++) total[m] = -fn * n[m];
  if (law.friction > 0.0) {
    const double mi = atom->rmass[i], mj = atom->rmass[j];
    double drag[3];
    law.tangential({k, beta, fn, mi * mj / (mi + mj), dt, advance, n}, slide,
                   memory >= 0 ? springs[memory].slip : nullptr, drag);
    for (int m = 0; m < 3; m++) total[m] += drag[m];
    if (books.open) book(i, j, books.friction, drag);
  }
  if (books.open) {
    const double lossy = elastic - fn;
    const double dashpot[3] = {lossy * n[0], lossy * n[1], lossy * n[2]};
    book(i, j, books.damping, dashpot);
  }
  return fn;
}

/* ----------------------------------------------------------------------
   force on node i by node j, and back
------------------------------------------------------------------------- */

void PairPeridemContact::book(int i, int j, std::vector<double> &forces, const double *force)
{
  PeridemBooks::add(forces, i, force);
  if (j < atom->nlocal) PeridemBooks::add(forces, j, force, -1.0);
}

/* ----------------------------------------------------------------------
   visit(i, j, contact distance, square of their distance, memory) for every pair that may touch
------------------------------------------------------------------------- */

template <class Visit> void PairPeridemContact::for_near(Visit visit) const
{
  if (!indices_valid()) return;
  double **x = atom->x;
  auto look = [&](int i, int j, double distance, int memory) {
    double rsq = 0.0;
    for (int m = 0; m < 3; m++) rsq += (x[j][m] - x[i][m]) * (x[j][m] - x[i][m]);
    visit(i, j, distance, rsq, memory);
  };
  for (std::size_t row = 0; row < row_node.size(); row++)
    for (int k = row_first[row]; k < row_first[row + 1]; k++) {
      const int i = row_node[row], j = candidates[k];
      look(i, j, laws[index(atom->type[i], atom->type[j])].radius, any_springs ? memories[k] : -1);
    }
  for (const auto &pair : fragments) look(pair.i, pair.j, pair.distance, pair.memory);
}

/* ----------------------------------------------------------------------
   visit(i, j, depth, spring, share of this rank) for every pair that touches
------------------------------------------------------------------------- */

template <class Visit> void PairPeridemContact::for_touching(Visit visit) const
{
  for_near([&](int i, int j, double distance, double rsq, int memory) {
    if (rsq < distance * distance)
      visit(i, j, distance - std::sqrt(rsq), memory < 0 ? nullptr : &springs[memory],
            j < atom->nlocal ? 1.0 : 0.5);
  });
}

/* ---------------------------------------------------------------------- */

double PairPeridemContact::elastic_energy() const
{
  double sum = 0.0;
  for_touching([&](int i, int j, double depth, const Spring *, double share) {
    const auto &law = laws[index(atom->type[i], atom->type[j])];
    sum += share * law.energy(law.spring(atom->vfrac[i], atom->vfrac[j]), depth);
  });
  return sum;
}

/* ---------------------------------------------------------------------- */

double PairPeridemContact::spring_energy() const
{
  double sum = 0.0;
  for_touching([&](int i, int j, double, const Spring *spring, double share) {
    if (!spring) return;
    const auto &law = laws[index(atom->type[i], atom->type[j])];
    sum += share * law.spring_energy(law.spring(atom->vfrac[i], atom->vfrac[j]), spring->slip);
  });
  return sum;
}

/* ----------------------------------------------------------------------
   energy that collisions lose: a force between the two bodies, as if they were rigid, along the
   line of the nodes that touch, so that linear and angular momentum stay
------------------------------------------------------------------------- */

void PairPeridemContact::impact_pass()
{
  bodies.forget();
  moved = update->ntimestep;
  int any[2] = {!impacts.empty(), bodies.torn()};
  MPI_Allreduce(MPI_IN_PLACE, any, 2, MPI_INT, MPI_MAX, world);
  if (!any[0]) return;

  bodies.start(any[1]);
  find_touching();
  find_collisions();
  for (const auto &impact : impacts) add_impact(impact);
  spread.begin(atom->f[0], books.open ? &books.damping : nullptr);
  bodies.apply(spread, true);
}

/* ----------------------------------------------------------------------
   the bodies of nodes that touch, those of other ranks too
------------------------------------------------------------------------- */

void PairPeridemContact::find_touching()
{
  const int nlocal = atom->nlocal;
  body_of.resize(nlocal + atom->nghost);
  has_body.assign(nlocal, 0);
  auto find = [&](int i) {
    if (i >= nlocal || has_body[i]) return;
    has_body[i] = 1;
    body_of[i] = bodies.body(i);
  };
  for (const auto &impact : impacts) {
    find(impact.i);
    find(impact.j);
  }
  comm->forward_comm(this);
}

/* ----------------------------------------------------------------------
   of owned nodes, and of ghosts since they were sent
------------------------------------------------------------------------- */

bigint PairPeridemContact::body_id(int i) const
{
  return i < atom->nlocal ? bodies.id(i) : body_of[i].number();
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::find_collisions()
{
  const int nlocal = atom->nlocal;
  const bool same_bodies = bodies_known == bodies.version();
  bodies_known = bodies.version();
  collisions.begin();
  // contacts that are open for a moment remember too
  for (auto &spring : springs) {
    if (spring.i < 0) continue;
    // only other ranks know when the bodies of their nodes become others
    if (!same_bodies || spring.collision == Spring::UNKNOWN || spring.j >= nlocal)
      find_collision(spring);
    if (spring.collision >= 0) collisions.remember(spring.collision, spring.peak);
  }
  for (const auto &impact : impacts) {
    const auto &spring = springs[impact.spring];
    if (spring.collision < 0) continue;
    const auto &bi = body_of[impact.i], &bj = body_of[impact.j];
    double approach = 0.0;
    for (int m = 0; m < 3; m++) approach -= impact.n[m] * (bj.velocity[m] - bi.velocity[m]);
    collisions.add(spring.collision, impact.elastic, impact.stored, approach,
                   impact.j < nlocal ? 1.0 : 0.5);
  }
  collisions.merge();
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::find_collision(Spring &spring)
{
  const int i = spring.i, j = spring.j;
  const bigint a = body_id(i), b = body_id(j);
  spring.collision = a == b ? Spring::WITHIN : collisions.find(a, b, spring.collision);
  if (a != b && (j >= atom->nlocal || bodies.shared(i) || bodies.shared(j)))
    collisions.seen_elsewhere(spring.collision);
}

/* ----------------------------------------------------------------------
   nodes of one body do not collide
------------------------------------------------------------------------- */

void PairPeridemContact::add_impact(const Impact &impact)
{
  auto &spring = springs[impact.spring];
  if (spring.collision < 0) return;
  const int i = impact.i, j = impact.j, nlocal = atom->nlocal;
  const auto &bi = body_of[i], &bj = body_of[j];
  const auto &collision = collisions.at(spring.collision);
  const double approach = collision.approach();
  spring.peak = MAX(spring.peak, collision.peak);
  if (advance) spring.peak = MAX(spring.peak, approach);

  const auto &law = laws[index(atom->type[i], atom->type[j])];
  const double mobility = bi.mobility_along(impact.n) + bj.mobility_along(impact.n);
  const double force =
      law.impact_force(impact.elastic, collision.stored, approach, spring.peak, mobility, dt);
  double push[3], pull[3], centres[3];
  for (int m = 0; m < 3; m++) {
    push[m] = -force * impact.n[m];
    pull[m] = -push[m];
    centres[m] = bi.offset[m] - (atom->x[j][m] - atom->x[i][m]) - bj.offset[m];
  }
  bodies.push(i, push);
  if (j < nlocal) bodies.push(j, pull);
  if (evflag)
    ev_tally_xyz(i, j, nlocal, 0, 0.0, 0.0, push[0], push[1], push[2], centres[0], centres[1],
                 centres[2]);
}

/* ----------------------------------------------------------------------
   which body every node belongs to, and how that moves if the node touches; or what the bound on
   frequencies asks for
------------------------------------------------------------------------- */

int PairPeridemContact::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  if (sending == HELD_BY) {
    for (int m = 0; m < n; m++) buf[m] = held_by[list[m]];
    return n;
  }
  if (sending == VELOCITIES) {
    for (int m = 0; m < n; m++) memcpy(buf + 3 * m, velocity(list[m]), 3 * sizeof(double));
    return 3 * n;
  }
  for (int m = 0; m < n; m++) {
    const int i = list[m];
    if (i < atom->nlocal && !has_body[i]) body_of[i].name(bodies.id(i));
    memcpy(buf + m * PeridemBody::SIZE, &body_of[i], sizeof(PeridemBody));
  }
  return n * PeridemBody::SIZE;
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::unpack_forward_comm(int n, int first, double *buf)
{
  if (!n) return;
  if (sending == HELD_BY)
    memcpy(&held_by[first], buf, n * sizeof(double));
  else if (sending == VELOCITIES)
    memcpy(&ghost_velocity[3 * (first - atom->nlocal)], buf, 3 * n * sizeof(double));
  else
    memcpy(static_cast<void *>(&body_of[first]), buf, n * sizeof(PeridemBody));
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::send(Message what)
{
  sending = what;
  comm->forward_comm(this);
  sending = BODIES;
}

/* ---------------------------------------------------------------------- */

double PairPeridemContact::lightest(int itype) const
{
  return adapt ? adapt->lightest(itype) : extremes.lightest[itype];
}

/* ---------------------------------------------------------------------- */

bool PairPeridemContact::begins_softly() const
{
  for (const auto &law : laws)
    if (law.radius > 0.0 && !law.begins_softly()) return false;
  return true;
}

/* ----------------------------------------------------------------------
   two nodes that touch, the lighter one of the lightest of its type, with so many springs each
------------------------------------------------------------------------- */

double PairPeridemContact::frequency_sq_with(double springs) const
{
  double largest = 0.0;
  for (int i = 1; i <= ntypes; i++)
    for (int j = 1; j <= ntypes; j++) {
      const auto &law = laws[index(i, j)];
      if (law.radius == 0.0 || extremes.largest[i] == 0.0 || extremes.largest[j] == 0.0) continue;
      // the lightest node of type i against the largest of type j
      const double k = law.spring(extremes.smallest[i], extremes.largest[j]);
      largest = MAX(largest, 2.0 * springs * k / lightest(i));
    }
  return largest;
}

/* ---------------------------------------------------------------------- */

double PairPeridemContact::largest_frequency_sq()
{
  // of contacts that come at any time: a node is taken to touch so many others
  const double most = timed ? 1.0 : domain->dimension + 1;
  double largest = frequency_sq_with(most);
  largest = std::max(largest, frequency_sq_now());    // MAX would ask all ranks twice, or not
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  return largest;
}

/* ---------------------------------------------------------------------- */

PeridemContactStiffness &PairPeridemContact::gather_stiffness()
{
  timed = false;
  stiffness.start(atom->nlocal, domain->dimension);
  for_touching([&](int i, int j, double, const Spring *, double) {
    add_stiffness(i, j);
  });
  return stiffness;
}

/* ----------------------------------------------------------------------
   contacts that there may be within the time
------------------------------------------------------------------------- */

PeridemContactStiffness &PairPeridemContact::gather_stiffness(double time)
{
  timed = true;
  stiffness.start(atom->nlocal, domain->dimension);
  ghost_velocity.resize(3 * static_cast<std::size_t>(atom->nghost));
  send(VELOCITIES);
  for_near([&](int i, int j, double distance, double rsq, int) {
    const double *const vi = velocity(i), *const vj = velocity(j);
    const double slide[3] = {vj[0] - vi[0], vj[1] - vi[1], vj[2] - vi[2]};
    const double reach = PeridemContactStiffness::reach(distance, slide, time);
    if (rsq < reach * reach) add_stiffness(i, j);
  });
  return stiffness;
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::add_stiffness(int i, int j)
{
  double n[3] = {}, rsq = 0.0;
  for (int m = 0; m < 3; m++) {
    n[m] = atom->x[j][m] - atom->x[i][m];
    rsq += n[m] * n[m];
  }
  if (rsq > 0.0)
    for (double &part : n) part /= std::sqrt(rsq);
  else
    n[0] = 1.0;    // as the force has it
  const auto &law = laws[index(atom->type[i], atom->type[j])];
  const double k = law.spring(atom->vfrac[i], atom->vfrac[j]);
  stiffness.add(i, j, k, law.tangential_ratio() * k, n);
}

/* ---------------------------------------------------------------------- */

const double *PairPeridemContact::velocity(int i) const
{
  return i < atom->nlocal ? atom->v[i] : &ghost_velocity[3 * (i - atom->nlocal)];
}

/* ----------------------------------------------------------------------
   Nodes that do not move alone have bounds of their own; here they count as the other node of a
   contact. The proofs are in doc/theory.rst.
------------------------------------------------------------------------- */

double PairPeridemContact::frequency_sq_now()
{
  held_by.assign(atom->nlocal + atom->nghost, 0.0);
  const auto &nodes = stiffness.nodes();
  for (std::size_t n = 0; n < nodes.size(); n++) {
    const int i = nodes[n];
    const double k = timed ? stiffness.largest(n) : stiffness.springs(n);
    held_by[i] = adapt && !adapt->moves_alone(i) ? -1.0 : k / atom->rmass[i];
  }
  send(HELD_BY);
  if (!timed) return stiffness.largest_pair(held_by);    // Gershgorin's bound

  stiffness.share(held_by);
  double largest = 0.0;
  for (std::size_t n = 0; n < nodes.size(); n++)
    if (held_by[nodes[n]] > 0.0)
      largest = MAX(largest, stiffness.largest(n) / atom->rmass[nodes[n]]);
  return largest;
}

/* ----------------------------------------------------------------------
   dashpot over 2 sqrt(spring mass) for the lightest nodes
------------------------------------------------------------------------- */

double PairPeridemContact::largest_dashpot_ratio() const
{
  double largest = 0.0;
  const double most = domain->dimension + 1;
  for (int i = 1; i <= ntypes; i++)
    for (int j = 1; j <= ntypes; j++) {
      const auto &law = laws[index(i, j)];
      if (law.radius == 0.0 || extremes.largest[i] == 0.0 || extremes.largest[j] == 0.0) continue;
      const double light = 1.0 / lightest(i) + 1.0 / lightest(j);    // 0 where both are held
      const double k = law.spring(extremes.smallest[i], extremes.smallest[j]);
      if (!(k > 0.0)) continue;    // volumes so small that there is no spring
      largest = MAX(largest, 0.5 * law.dashpot() * std::sqrt(most * light / k));
    }
  return largest;
}

/* ---------------------------------------------------------------------- */

static_assert(std::is_trivially_copyable<PeridemContactGiven>::value,
              "restart files hold the bytes of contact coefficients");
static constexpr PeridemStamp STAMP(2, sizeof(PeridemContactGiven));

void PairPeridemContact::write_restart(FILE *fp)
{
  STAMP.write(fp);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const int set = setflag[i][j] && !mixed[index(i, j)];
      fwrite(&set, sizeof(int), 1, fp);
      if (set) fwrite(&given[index(i, j)], sizeof(PeridemContactGiven), 1, fp);
    }
}

/* ---------------------------------------------------------------------- */

void PairPeridemContact::read_restart(FILE *fp)
{
  STAMP.read(fp, "Pair style peridem/contact", lmp);
  allocate();
  overlaps_checked = true;
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      if (comm->me == 0) utils::sfread(FLERR, &setflag[i][j], sizeof(int), 1, fp, nullptr, error);
      MPI_Bcast(&setflag[i][j], 1, MPI_INT, 0, world);
      if (!setflag[i][j]) continue;
      auto &one = given[index(i, j)];
      if (comm->me == 0) utils::sfread(FLERR, &one, sizeof(one), 1, fp, nullptr, error);
      MPI_Bcast(&one, sizeof(one), MPI_BYTE, 0, world);
      given[index(j, i)] = one;
    }
}

/* ---------------------------------------------------------------------- */

double PairPeridemContact::memory_usage()
{
  return Pair::memory_usage() + sizeof(int) * static_cast<double>(candidates.capacity()) +
      sizeof(FragmentPair) * static_cast<double>(fragments.capacity()) +
      sizeof(int) * static_cast<double>(memories.capacity()) +
      sizeof(Spring) * static_cast<double>(springs.capacity()) +
      sizeof(PeridemBody) * static_cast<double>(body_of.capacity()) + bodies.memory_usage() +
      sizeof(double) * static_cast<double>(held_by.capacity() + ghost_velocity.capacity()) +
      stiffness.memory_usage();
}

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

#include "atom_vec_peridem.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "modify.h"
#include "peridem_copies.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   density * volume, one unit in the last place up: so it is never the round number that somebody
   sets as the density, and sync_mass() can tell
------------------------------------------------------------------------- */

static double mass(double density, double volume)
{
  return std::nextafter(density * volume, std::numeric_limits<double>::infinity());
}

/* ---------------------------------------------------------------------- */

AtomVecPeridem::AtomVecPeridem(LAMMPS *lmp) : AtomVec(lmp)
{
  molecular = Atom::ATOMIC;
  mass_type = PER_ATOM;

  atom->molecule_flag = 1;
  atom->rmass_flag = 1;
  atom->vfrac_flag = 1;

  // bond partners are known by atom-ID: an atom map is always needed

  atom->map_style = Atom::MAP_YES;

  // per-node arrays that class Atom does not know; a former instance of this style may have
  // registered them at its own addresses

  auto &known = atom->peratom;
  known.erase(std::remove_if(known.begin(), known.end(),
                             [](const Atom::PerAtom &item) {
                               return item.name == "peridem_density" ||
                                   item.name == "peridem_mass_seen";
                             }),
              known.end());
  atom->add_peratom("peridem_density", &density, Atom::DOUBLE, 0);
  atom->add_peratom("peridem_mass_seen", &mass_seen, Atom::DOUBLE, 0);

  // only "replicate" makes an instance in a box that exists already

  if (domain->box_exist) copies = std::make_unique<PeridemCopies>(lmp);
}

/* ----------------------------------------------------------------------
   "replicate" deletes the instance of the originals once that of the copies is full: nothing else
   tells the copies that they are whole
------------------------------------------------------------------------- */

AtomVecPeridem::~AtomVecPeridem()
{
  if (!lmp->atom || lmp->atom->avec == this) return;
  auto *next = dynamic_cast<AtomVecPeridem *>(lmp->atom->avec);
  if (next && next->copies) next->copies->finish(copies.get());
}

/* ----------------------------------------------------------------------
   optional word "reference": data files carry reference positions
------------------------------------------------------------------------- */

void AtomVecPeridem::process_args(int narg, char **arg)
{
  with_reference = false;
  for (int iarg = 0; iarg < narg; iarg++) {
    const std::string word = arg[iarg];
    if (word != "reference")
      error->all(FLERR, iarg + 1,
                 "Unknown atom_style peridem argument {}: only 'reference' is known", word);
    if (with_reference)
      error->all(FLERR, iarg + 1, "Repeated atom_style peridem argument {}", word);
    with_reference = true;
  }

  const std::vector<std::string> mine = {"rmass",    "vfrac",           "x0",
                                         "molecule", "peridem_density", "peridem_mass_seen"};
  fields_grow = fields_copy = fields_exchange = fields_restart = fields_create = mine;
  fields_border = fields_border_vel = {"rmass", "vfrac", "x0", "molecule"};
  fields_data_atom = {"id", "molecule", "type", "vfrac", "peridem_density", "x"};
  if (with_reference) fields_data_atom.emplace_back("x0");
  fields_data_vel = {"id", "v"};

  setup_fields();
}

/* ---------------------------------------------------------------------- */

void AtomVecPeridem::grow_pointers()
{
  rmass = atom->rmass;
  vfrac = atom->vfrac;
  x0 = atom->x0;
}

/* ----------------------------------------------------------------------
   Between read_restart, which has its own ways, and the first run there are rows for fixes that are
   still to come, one for each node in the order of nodes.  LAMMPS refuses commands that change that
   order but delete_atoms, which fills gaps: there the row goes with the node.
------------------------------------------------------------------------- */

void AtomVecPeridem::copy(int i, int j, int delflag)
{
  AtomVec::copy(i, j, delflag);
  if (!atom->nextra_store || i == j || modify->get_fix_by_id("_read_restart")) return;
  std::copy(atom->extra[i], atom->extra[i] + atom->nextra_store, atom->extra[j]);
}

/* ----------------------------------------------------------------------
   a created node has no volume and no density yet: init() asks for them
------------------------------------------------------------------------- */

void AtomVecPeridem::create_atom_post(int ilocal)
{
  vfrac[ilocal] = density[ilocal] = rmass[ilocal] = mass_seen[ilocal] = 0.0;
  for (int k = 0; k < 3; k++) x0[ilocal][k] = atom->x[ilocal][k];
}

/* ---------------------------------------------------------------------- */

void AtomVecPeridem::data_atom_post(int ilocal)
{
  if (!(vfrac[ilocal] > 0.0))
    error->one(FLERR, "Node {} in Atoms section of data file has volume {}: it must be > 0",
               atom->tag[ilocal], vfrac[ilocal]);
  if (!(density[ilocal] > 0.0))
    error->one(FLERR, "Node {} in Atoms section of data file has density {}: it must be > 0",
               atom->tag[ilocal], density[ilocal]);

  if (atom->molecule[ilocal] < 0)
    error->one(FLERR, "Node {} in Atoms section of data file has molecule-ID {}: it must be >= 0",
               atom->tag[ilocal], atom->molecule[ilocal]);

  rmass[ilocal] = mass_seen[ilocal] = mass(density[ilocal], vfrac[ilocal]);
  if (!with_reference)
    for (int k = 0; k < 3; k++) x0[ilocal][k] = atom->x[ilocal][k];
}

/* ---------------------------------------------------------------------- */

void AtomVecPeridem::unpack_restart_init(int ilocal)
{
  if (copies) copies->note(ilocal);
}

/* ---------------------------------------------------------------------- */

void AtomVecPeridem::init()
{
  AtomVec::init();
  if (copies) copies->check();
  sync_mass();
  check_nodes();
}

/* ----------------------------------------------------------------------
   "set volume" changes vfrac and "set density" (like "set mass") writes its number to rmass:
   bring density, volume and mass together again
------------------------------------------------------------------------- */

void AtomVecPeridem::sync_mass()
{
  bigint changed = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (rmass[i] != mass_seen[i]) {
      density[i] = rmass[i];
      changed++;
    }
    rmass[i] = mass_seen[i] = mass(density[i], vfrac[i]);
  }

  bigint total;
  MPI_Allreduce(&changed, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (total && comm->me == 0)
    utils::logmesg(lmp, "PERIDEM: density of {} nodes was set; mass = density * volume\n", total);
}

/* ---------------------------------------------------------------------- */

void AtomVecPeridem::check_nodes()
{
  tagint none = MAXTAGINT;
  bigint bad[2] = {0, 0};
  tagint lowest[2] = {none, none};
  for (int i = 0; i < atom->nlocal; i++) {
    const double value[2] = {vfrac[i], density[i]};
    for (int k = 0; k < 2; k++)
      if (!(value[k] > 0.0)) {
        bad[k]++;
        lowest[k] = MIN(lowest[k], atom->tag[i]);
      }
  }

  bigint bad_all[2];
  tagint lowest_all[2];
  MPI_Allreduce(bad, bad_all, 2, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(lowest, lowest_all, 2, MPI_LMP_TAGINT, MPI_MIN, world);
  const char *name[2] = {"volume", "density"};
  for (int k = 0; k < 2; k++)
    if (bad_all[k])
      error->all(FLERR, Error::NOLASTLINE,
                 "{} nodes have no {} > 0 (the first is atom-ID {}): give it in the data file or "
                 "with 'set ... {} value'",
                 bad_all[k], name[k], lowest_all[k], name[k]);
}

/* ----------------------------------------------------------------------
   a data file keeps reference positions only with "atom_style peridem reference",
   and never keeps which bonds are broken: say so when it matters
------------------------------------------------------------------------- */

void AtomVecPeridem::pack_data(double **buf)
{
  int moved = 0;
  if (!with_reference)
    for (int i = 0; i < atom->nlocal && !moved; i++)
      for (int k = 0; k < 3; k++)
        if (x0[i][k] != atom->x[i][k]) moved = 1;
  int moved_any;
  MPI_Allreduce(&moved, &moved_any, 1, MPI_INT, MPI_MAX, world);
  if (moved_any && comm->me == 0)
    error->warning(FLERR,
                   "Nodes have moved from their reference positions, which this data file does not "
                   "keep: use 'atom_style peridem reference' or write_restart");

  double broken = 0.0;
  for (const auto &fix : modify->get_fix_by_style("^peridem/bonds"))
    broken += fix->compute_vector(1);    // counts over all ranks
  if (broken > 0.0 && comm->me == 0)
    error->warning(FLERR, "{:.0f} broken bonds are not kept by a data file: use write_restart",
                   broken);

  AtomVec::pack_data(buf);
}

/* ----------------------------------------------------------------------
   names for compute property/atom
------------------------------------------------------------------------- */

int AtomVecPeridem::property_atom(const std::string &name)
{
  const std::vector<std::string> names = {"volume", "density", "xref", "yref", "zref"};
  for (int k = 0; k < (int) names.size(); k++)
    if (name == names[k]) return k;
  return -1;
}

/* ---------------------------------------------------------------------- */

void AtomVecPeridem::pack_property_atom(int index, double *buf, int nvalues, int groupbit)
{
  for (int i = 0, n = 0; i < atom->nlocal; i++, n += nvalues) {
    if (!(atom->mask[i] & groupbit))
      buf[n] = 0.0;
    else if (index == 0)
      buf[n] = vfrac[i];
    else if (index == 1)
      buf[n] = density[i];
    else
      buf[n] = x0[i][index - 2];
  }
}

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

#include "fix_peridem_history.h"

#include "pair_peridem_contact.h"
#include "peridem_stamp.h"

#include "atom.h"
#include "comm.h"
#include "error.h"

#include <cstring>
#include <utility>

using namespace LAMMPS_NS;
using namespace FixConst;

// contacts of one node that a restart file has room for: many more than fit around a node
static constexpr int MAXTOUCH = 64;

// numbers that one contact packs into
static constexpr int SIZE = 6;

/* ---------------------------------------------------------------------- */

FixPeridemHistory::FixPeridemHistory(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  restart_global = 1;
  restart_peratom = 1;
  create_attribute = 1;
  stores_ids = 1;
  maxexchange_dynamic = 1;
  maxexchange = 1;

  FixPeridemHistory::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
}

/* ---------------------------------------------------------------------- */

FixPeridemHistory::~FixPeridemHistory()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
}

/* ---------------------------------------------------------------------- */

int FixPeridemHistory::setmask()
{
  return PRE_EXCHANGE | POST_RUN;
}

/* ----------------------------------------------------------------------
   bring the springs from the pair style to the nodes, at both ends
------------------------------------------------------------------------- */

void FixPeridemHistory::collect()
{
  if (!source || !source->springs_live()) return;
  for (auto &row : rows) row.clear();
  source->store_springs(*this);
  std::size_t most = 0;
  for (const auto &row : rows) most = MAX(most, row.size());
  maxexchange = 1 + SIZE * static_cast<int>(most);
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::pre_exchange()
{
  collect();
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::post_run()
{
  collect();
  if (source) source->rest_springs();    // until the next force evaluation, the rows hold them
}

/* ---------------------------------------------------------------------- */

static constexpr PeridemStamp STAMP(1);    // for what nodes have in the file

void FixPeridemHistory::write_restart(FILE *fp)
{
  collect();
  if (comm->me) return;
  const int size = sizeof(double);
  fwrite(&size, sizeof(int), 1, fp);
  STAMP.write(fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::restart(char *buf)
{
  double stamp;
  memcpy(&stamp, buf, sizeof(double));
  STAMP.check(stamp, "Pair style peridem/contact", error);
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::grow_arrays(int nmax)
{
  rows.resize(nmax);
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::copy_arrays(int i, int j, int)
{
  if (i != j) rows[j] = rows[i];
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::set_arrays(int i)
{
  rows[i].clear();
}

/* ---------------------------------------------------------------------- */

int FixPeridemHistory::pack_exchange(int i, double *buf)
{
  int m = 0;
  buf[m++] = static_cast<double>(rows[i].size());
  for (const auto &spring : rows[i]) {
    buf[m++] = ubuf(spring.tag).d;
    for (double slip : spring.slip) buf[m++] = slip;
    buf[m++] = spring.peak;
    buf[m++] = spring.deepest;
  }
  return m;
}

/* ---------------------------------------------------------------------- */

int FixPeridemHistory::unpack_exchange(int i, double *buf)
{
  int m = 0;
  rows[i].resize(static_cast<std::size_t>(buf[m++]));
  for (auto &spring : rows[i]) {
    spring.tag = (tagint) ubuf(buf[m++]).i;
    for (double &slip : spring.slip) slip = buf[m++];
    spring.peak = buf[m++];
    spring.deepest = buf[m++];
  }
  return m;
}

/* ---------------------------------------------------------------------- */

int FixPeridemHistory::size_restart(int i)
{
  return 2 + SIZE * static_cast<int>(rows[i].size());
}

/* ---------------------------------------------------------------------- */

int FixPeridemHistory::maxsize_restart()
{
  return 2 + SIZE * MAXTOUCH;
}

/* ---------------------------------------------------------------------- */

int FixPeridemHistory::pack_restart(int i, double *buf)
{
  if (rows[i].size() > MAXTOUCH)
    error->one(FLERR, "Node {} touches {} nodes: a restart file has room for {}", atom->tag[i],
               rows[i].size(), MAXTOUCH);
  buf[0] = size_restart(i);
  return 1 + pack_exchange(i, buf + 1);
}

/* ---------------------------------------------------------------------- */

void FixPeridemHistory::unpack_restart(int i, int nth)
{
  double *buf = atom->extra[i];
  int m = 0;
  for (int k = 0; k < nth; k++) m += static_cast<int>(buf[m]);
  unpack_exchange(i, buf + m + 1);
}

/* ---------------------------------------------------------------------- */

double FixPeridemHistory::memory_usage()
{
  double bytes = static_cast<double>(rows.capacity()) * sizeof(std::vector<Spring>);
  for (const auto &row : rows) bytes += static_cast<double>(row.capacity()) * sizeof(Spring);
  return bytes;
}

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

#include "peridem_deleted.h"

#include "peridem_messages.h"
#include "peridem_rows.h"

#include "atom.h"
#include "comm.h"
#include "error.h"

#include <algorithm>
#include <vector>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   delete_atoms numbers nodes anew unless told not to, and asks no fix; bonds and the memory of
   contacts go by the old IDs.  Nodes that came afterwards get IDs behind all others.
------------------------------------------------------------------------- */

void PeridemDeleted::give_ids_back(const PeridemRows &rows)
{
  tagint *const tag = atom->tag;
  const tagint *const known_id = rows.known_id;
  int mine = 0, any;
  for (int i = 0; i < atom->nlocal; i++)
    if (known_id[i] && known_id[i] != tag[i]) mine = 1;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;
  std::copy(known_id, known_id + atom->nlocal, tag);
  atom->tag_extend();
  atom->nghost = 0;
  atom->map_init();
  atom->map_set();
  if (comm->me == 0)
    error->warning(FLERR,
                   "Bonds go by atom-IDs, and delete_atoms has numbered the nodes anew: they have "
                   "their IDs back; say delete_atoms ... compress no");
}

/* ----------------------------------------------------------------------
   partners of nodes of any rank that no rank owns
------------------------------------------------------------------------- */

std::set<tagint> PeridemDeleted::missing_partners(const PeridemRows &rows) const
{
  std::vector<tagint> missing;
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = rows.start[i]; k < rows.start[i] + rows.num[i]; k++)
      if (atom->map(rows.ptag[k]) < 0) missing.push_back(rows.ptag[k]);
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());

  const auto all = PeridemMessages::gather(world, missing);
  std::vector<int> exists(all.size(), 0);
  for (std::size_t m = 0; m < all.size(); m++) {
    const int j = atom->map(all[m]);
    exists[m] = j >= 0 && j < atom->nlocal;
  }
  MPI_Allreduce(MPI_IN_PLACE, exists.data(), static_cast<int>(exists.size()), MPI_INT, MPI_MAX,
                world);
  std::set<tagint> deleted;
  for (std::size_t m = 0; m < all.size(); m++)
    if (!exists[m]) deleted.insert(all[m]);
  return deleted;
}

/* ----------------------------------------------------------------------
   bonds to nodes that are gone count as broken
------------------------------------------------------------------------- */

void PeridemDeleted::drop_bonds(PeridemRows &rows)
{
  const auto deleted = missing_partners(rows);
  bigint dropped = 0, dropped_all;
  for (int i = 0; i < atom->nlocal; i++)
    for (bigint k = rows.start[i]; k < rows.start[i] + rows.num[i];)
      if (deleted.count(rows.ptag[k])) {
        rows.erase_bond(i, k);
        dropped++;
      } else
        k++;
  MPI_Allreduce(&dropped, &dropped_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (dropped_all && comm->me == 0)
    error->warning(FLERR, "{} bonds to {} deleted nodes count as broken", dropped_all,
                   deleted.size());
}

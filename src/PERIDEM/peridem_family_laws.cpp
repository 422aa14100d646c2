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

#include "peridem_family_laws.h"

#include "peridem_material.h"

#include "error.h"
#include "fix.h"

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

void PeridemFamilyLaws::note(int ntypes, const MaterialOf &material)
{
  laws.assign(static_cast<std::size_t>(ntypes) * ntypes, {0.0, 0.0, {}, 0});
  for (int i = 1; i <= ntypes; i++)
    for (int j = 1; j <= ntypes; j++)
      if (const auto *mat = material(i, j))
        laws[(i - 1) * ntypes + j - 1] = {mat->horizon, mat->cell, mat->influence, mat->volume};
}

/* ---------------------------------------------------------------------- */

void PeridemFamilyLaws::check(const Fix &fix, int ntypes, const MaterialOf &material) const
{
  if (laws.empty()) return;
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const auto *mat = material(i, j);
      if (!mat) continue;
      const auto &law = laws[(i - 1) * ntypes + j - 1];
      if (law.horizon == 0.0) continue;
      if (law.horizon != mat->horizon || law.cell != mat->cell || law.volume != mat->volume ||
          !(law.influence == mat->influence))
        error->all(FLERR, Error::NOLASTLINE,
                   "Families of types {} {} were built with horizon {:.8g}: horizon (now {:.8g}), "
                   "influence and volume cannot change afterwards, unless fix {} is made anew "
                   "(unfix {})",
                   i, j, law.horizon, mat->horizon, fix.style, fix.id);
    }
}

/* ---------------------------------------------------------------------- */

void PeridemFamilyLaws::pack(std::vector<double> &list) const
{
  list.push_back(static_cast<double>(laws.size()));
  for (const auto &law : laws)
    list.insert(list.end(),
                {law.horizon, law.cell, static_cast<double>(law.influence.kind),
                 law.influence.width, static_cast<double>(law.volume)});
}

/* ---------------------------------------------------------------------- */

void PeridemFamilyLaws::unpack(const double *list)
{
  laws.resize(static_cast<std::size_t>(*list++));
  for (auto &law : laws) {
    law.horizon = *list++;
    law.cell = *list++;
    law.influence.kind = static_cast<int>(*list++);
    law.influence.width = *list++;
    law.volume = static_cast<int>(*list++);
  }
}

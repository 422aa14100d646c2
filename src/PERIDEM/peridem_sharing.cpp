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

#include "peridem_sharing.h"

#include "comm.h"

#include <algorithm>
#include <map>
#include <utility>

using namespace LAMMPS_NS;

static constexpr int PARTS = 6031;    // tag of messages

/* ----------------------------------------------------------------------
   outgoing[p] goes to rank p; returns what each rank has sent here
------------------------------------------------------------------------- */

PeridemSharing::Lists PeridemSharing::exchange(const Lists &outgoing) const
{
  const int nprocs = comm->nprocs;
  std::vector<int> nsend(nprocs), nrecv(nprocs), sendat(nprocs, 0), recvat(nprocs, 0);
  for (int p = 0; p < nprocs; p++) nsend[p] = static_cast<int>(outgoing[p].size());
  MPI_Alltoall(nsend.data(), 1, MPI_INT, nrecv.data(), 1, MPI_INT, world);
  for (int p = 1; p < nprocs; p++) {
    sendat[p] = sendat[p - 1] + nsend[p - 1];
    recvat[p] = recvat[p - 1] + nrecv[p - 1];
  }
  std::vector<tagint> send, recv(recvat.back() + nrecv.back());
  send.reserve(sendat.back() + nsend.back());
  for (const auto &part : outgoing) send.insert(send.end(), part.begin(), part.end());
  MPI_Alltoallv(send.data(), nsend.data(), sendat.data(), MPI_LMP_TAGINT, recv.data(), nrecv.data(),
                recvat.data(), MPI_LMP_TAGINT, world);
  Lists incoming(nprocs);
  for (int p = 0; p < nprocs; p++)
    incoming[p].assign(recv.begin() + recvat[p], recv.begin() + recvat[p] + nrecv[p]);
  return incoming;
}

/* ----------------------------------------------------------------------
   ids[p]: those that rank p has asked about here. Each rank hears of every other one that has a
   part of the same: id, rank, id, rank, ...
------------------------------------------------------------------------- */

PeridemSharing::Lists PeridemSharing::tell_sharers(const Lists &ids) const
{
  std::vector<std::pair<tagint, int>> parts;
  for (int p = 0; p < comm->nprocs; p++)
    for (const tagint id : ids[p]) parts.emplace_back(id, p);
  std::sort(parts.begin(), parts.end());

  Lists answers(comm->nprocs);
  for (std::size_t m = 0, end = 0; m < parts.size(); m = end) {
    while (end < parts.size() && parts[end].first == parts[m].first) end++;
    for (std::size_t a = m; a < end; a++)
      for (std::size_t b = m; b < end; b++)
        if (a != b)
          answers[parts[a].second].insert(answers[parts[a].second].end(),
                                          {parts[b].first, parts[b].second});
  }
  return answers;
}

/* ---------------------------------------------------------------------- */

void PeridemSharing::find(const std::vector<tagint> &ids)
{
  places.clear();
  peers.clear();
  if (comm->nprocs == 1) return;

  Lists asked(comm->nprocs);
  for (const tagint id : ids) asked[id % comm->nprocs].push_back(id);
  std::vector<std::pair<tagint, int>> sharers;
  for (const auto &list : exchange(tell_sharers(exchange(asked))))
    for (std::size_t m = 0; m < list.size(); m += 2)
      sharers.emplace_back(list[m], static_cast<int>(list[m + 1]));
  std::sort(sharers.begin(), sharers.end());    // all ranks have them in the same order

  std::map<int, std::vector<int>> things;
  for (std::size_t m = 0; m < sharers.size(); m++) {
    if (m == 0 || sharers[m].first != sharers[m - 1].first)
      places.push_back(static_cast<int>(std::lower_bound(ids.begin(), ids.end(), sharers[m].first) -
                                        ids.begin()));
    things[sharers[m].second].push_back(static_cast<int>(places.size()) - 1);
  }
  for (auto &entry : things) peers.push_back({entry.first, std::move(entry.second), {}, {}});
}

/* ---------------------------------------------------------------------- */

void PeridemSharing::swap_parts(const std::vector<double> &data, int width)
{
  requests.clear();
  for (auto &peer : peers) {
    peer.theirs.resize(width * peer.things.size());
    requests.emplace_back();
    MPI_Irecv(peer.theirs.data(), static_cast<int>(peer.theirs.size()), MPI_DOUBLE, peer.rank,
              PARTS, world, &requests.back());
  }
  for (auto &peer : peers) {
    peer.ours.clear();
    for (const int n : peer.things)
      peer.ours.insert(peer.ours.end(), &data[n * width], &data[n * width] + width);
    requests.emplace_back();
    MPI_Isend(peer.ours.data(), static_cast<int>(peer.ours.size()), MPI_DOUBLE, peer.rank, PARTS,
              world, &requests.back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

/* ----------------------------------------------------------------------
   added up in the order of the ranks
------------------------------------------------------------------------- */

void PeridemSharing::sum(std::vector<double> &data, int width)
{
  if (peers.empty()) return;
  swap_parts(data, width);
  own.swap(data);
  data.assign(own.size(), 0.0);
  bool added = false;
  auto add_own = [&] {
    for (std::size_t n = 0; n < own.size(); n++) data[n] += own[n];
    added = true;
  };
  for (const auto &peer : peers) {
    if (!added && peer.rank > comm->me) add_own();
    const double *part = peer.theirs.data();
    for (const int n : peer.things)
      for (int k = 0; k < width; k++) data[n * width + k] += *part++;
  }
  if (!added) add_own();
}

/* ---------------------------------------------------------------------- */

double PeridemSharing::memory_usage() const
{
  double numbers = static_cast<double>(own.capacity());
  for (const auto &peer : peers) numbers += peer.ours.capacity() + peer.theirs.capacity();
  return numbers * sizeof(double);
}

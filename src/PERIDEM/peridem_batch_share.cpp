/* --------------------------------------------------------------------
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

#include "peridem_batch_share.h"

#include "fix_peridem_bonds.h"
#include "peridem_messages.h"

#include "atom.h"
#include "comm.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

using namespace LAMMPS_NS;

static constexpr int PLACES = 6021, RESULTS_BACK = 6022;    // tags of messages

/* ----------------------------------------------------------------------
   outgoing[p] goes to rank p; returns what each rank has sent here
------------------------------------------------------------------------- */

PeridemBatchShare::Lists PeridemBatchShare::exchange(const Lists &outgoing) const
{
  std::vector<int> count;
  const auto received = PeridemMessages::exchange(world, outgoing, count);
  Lists incoming;
  auto at = received.begin();
  for (const int n : count) {
    incoming.emplace_back(at, at + n);
    at += n;
  }
  return incoming;
}

/* ----------------------------------------------------------------------
   counts[p]: grain, nodes of it, grain, ... that rank p owns. Of grains on several ranks each of
   those is told which of them owns most nodes, the lowest among equals.
------------------------------------------------------------------------- */

PeridemBatchShare::Lists PeridemBatchShare::choose_hosts(const Lists &counts) const
{
  struct Choice {
    int host, ranks;
    double most;
  };
  std::map<double, Choice> choices;
  for (int p = 0; p < comm->nprocs; p++)
    for (std::size_t m = 0; m < counts[p].size(); m += 2) {
      auto &choice = choices.insert({counts[p][m], {p, 0, 0.0}}).first->second;
      choice.ranks++;
      if (counts[p][m + 1] > choice.most) {
        choice.most = counts[p][m + 1];
        choice.host = p;
      }
    }
  Lists answers(comm->nprocs);
  for (int p = 0; p < comm->nprocs; p++)
    for (std::size_t m = 0; m < counts[p].size(); m += 2) {
      const auto &choice = choices.at(counts[p][m]);
      if (choice.ranks > 1)
        answers[p].insert(answers[p].end(), {counts[p][m], static_cast<double>(choice.host)});
    }
  return answers;
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::assemble(const FixPeridemBonds *bonds, const std::vector<int> &mine,
                                 const double *stiffness, const double *dashpot)
{
  any_shared = false;
  hosts.clear();
  slots.clear();
  lenders.clear();
  borrowers.clear();
  lent_nodes.clear();
  nodes.clear();
  rows.clear();
  first.assign(1, 0);
  if (comm->nprocs == 1) return;

  const tagint *const mol = atom->molecule;
  Lists counts(comm->nprocs);
  for (std::size_t m = 0, end = 0; m < mine.size(); m = end) {
    while (end < mine.size() && mol[mine[end]] == mol[mine[m]]) end++;
    auto &list = counts[mol[mine[m]] % comm->nprocs];
    list.insert(list.end(), {static_cast<double>(mol[mine[m]]), static_cast<double>(end - m)});
  }
  bool shared = false;
  for (const auto &list : exchange(choose_hosts(exchange(counts))))
    for (std::size_t m = 0; m < list.size(); m += 2) {
      shared = true;
      const int host = static_cast<int>(list[m + 1]);
      if (host != comm->me) hosts[static_cast<tagint>(list[m])] = host;
    }
  int any = shared;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, world);
  any_shared = any;
  if (!any_shared) return;

  Lists outgoing(comm->nprocs);
  std::map<int, std::vector<int>> lent;
  for (int i : mine) {
    const auto at = hosts.find(mol[i]);
    if (at == hosts.end()) continue;
    pack_node(bonds, i, stiffness, dashpot, outgoing[at->second]);
    lent[at->second].push_back(i);
  }
  for (auto &entry : lent) borrowers.push_back({entry.first, std::move(entry.second), {}, {}});
  const auto incoming = exchange(outgoing);
  for (int p = 0; p < comm->nprocs; p++)
    if (!incoming[p].empty()) unpack_nodes(p, incoming[p]);
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::pack_node(const FixPeridemBonds *bonds, int i, const double *stiffness,
                                  const double *dashpot, std::vector<double> &out) const
{
  const double *const X = atom->x0[i], *const x = atom->x[i];
  const Node node{static_cast<double>(atom->tag[i]),
                  static_cast<double>(atom->molecule[i]),
                  static_cast<double>(atom->type[i]),
                  {X[0], X[1], X[2]},
                  {x[0], x[1], x[2]},
                  atom->v[i][2],
                  atom->vfrac[i],
                  bonds->wvolume[i],
                  stiffness[i],
                  dashpot[i],
                  static_cast<double>(bonds->mixed[i]),
                  static_cast<double>(bonds->rigid[i]),
                  (atom->mask[i] & bonds->unbroken_bit) ? 1.0 : 0.0,
                  static_cast<double>(bonds->num[i])};
  const auto *const raw = reinterpret_cast<const double *>(&node);
  out.insert(out.end(), raw, raw + sizeof(Node) / sizeof(double));
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
    out.insert(out.end(),
               {static_cast<double>(bonds->ptag[k]), bonds->length[k],
                bonds->weight(i, atom->map(bonds->ptag[k]), k)});
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::unpack_nodes(int rank, const std::vector<double> &in)
{
  Peer lender{rank, {}, {}, {}};
  for (std::size_t m = 0; m < in.size();) {
    Node node;
    memcpy(&node, &in[m], sizeof(Node));
    m += sizeof(Node) / sizeof(double);
    const int k = static_cast<int>(nodes.size());
    slots[static_cast<tagint>(node.tag)] = k;
    lender.nodes.push_back(k);
    nodes.push_back(node);
    for (int b = 0; b < static_cast<int>(node.bonds); b++, m += 3)
      rows.push_back({in[m], in[m + 1], in[m + 2]});
    first.push_back(rows.size());
  }
  lenders.push_back(std::move(lender));
}

/* ---------------------------------------------------------------------- */

int PeridemBatchShare::slot(tagint tag) const
{
  const auto at = slots.find(tag);
  return at == slots.end() ? -1 : at->second;
}

/* ----------------------------------------------------------------------
   of grains that the general engine computes after all no node is lent
------------------------------------------------------------------------- */

void PeridemBatchShare::settle(const std::vector<char> &taken)
{
  if (!any_shared) return;
  Lists verdicts(comm->nprocs);
  for (auto &peer : lenders) {
    auto &verdict = verdicts[peer.rank];
    for (int k : peer.nodes) verdict.push_back(taken[k]);
    peer.nodes.erase(std::remove_if(peer.nodes.begin(), peer.nodes.end(),
                                    [&](int k) {
                                      return !taken[k];
                                    }),
                     peer.nodes.end());
  }
  const auto heard = exchange(verdicts);
  for (auto &peer : borrowers) {
    std::vector<int> kept;
    for (std::size_t m = 0; m < peer.nodes.size(); m++)
      if (heard[peer.rank][m] != 0.0) kept.push_back(peer.nodes[m]);
    peer.nodes.swap(kept);
    lent_nodes.insert(lent_nodes.end(), peer.nodes.begin(), peer.nodes.end());
  }
  auto idle = [](const Peer &peer) {
    return peer.nodes.empty();
  };
  lenders.erase(std::remove_if(lenders.begin(), lenders.end(), idle), lenders.end());
  borrowers.erase(std::remove_if(borrowers.begin(), borrowers.end(), idle), borrowers.end());
  results.assign(RESULTS * nodes.size(), 0.0);
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::send_places(double **x, double **v)
{
  width = v ? 6 : 3;
  places.resize(width * nodes.size());
  for (auto &peer : lenders) {
    peer.buffer.resize(width * peer.nodes.size());
    requests.emplace_back();
    MPI_Irecv(peer.buffer.data(), static_cast<int>(peer.buffer.size()), MPI_DOUBLE, peer.rank,
              PLACES, world, &requests.back());
  }
  for (auto &peer : borrowers) {
    peer.buffer.clear();
    for (int i : peer.nodes) {
      peer.buffer.insert(peer.buffer.end(), x[i], x[i] + 3);
      if (v) peer.buffer.insert(peer.buffer.end(), v[i], v[i] + 3);
    }
    requests.emplace_back();
    MPI_Isend(peer.buffer.data(), static_cast<int>(peer.buffer.size()), MPI_DOUBLE, peer.rank,
              PLACES, world, &requests.back());
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::receive_places()
{
  PeridemMessages::wait_for(requests);
  for (const auto &peer : lenders)
    for (std::size_t m = 0; m < peer.nodes.size(); m++)
      std::copy_n(&peer.buffer[width * m], width, &places[width * peer.nodes[m]]);
  std::fill(results.begin(), results.end(), 0.0);
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::send_results()
{
  for (auto &peer : borrowers) {
    peer.answers.resize(RESULTS * peer.nodes.size());
    requests.emplace_back();
    MPI_Irecv(peer.answers.data(), static_cast<int>(peer.answers.size()), MPI_DOUBLE, peer.rank,
              RESULTS_BACK, world, &requests.back());
  }
  for (auto &peer : lenders) {
    peer.answers.clear();
    for (int k : peer.nodes)
      peer.answers.insert(peer.answers.end(), result(k), result(k) + RESULTS);
    requests.emplace_back();
    MPI_Isend(peer.answers.data(), static_cast<int>(peer.answers.size()), MPI_DOUBLE, peer.rank,
              RESULTS_BACK, world, &requests.back());
  }
}

/* ---------------------------------------------------------------------- */

void PeridemBatchShare::receive_results(const std::function<void(int, const double *)> &take)
{
  PeridemMessages::wait_for(requests);
  for (const auto &peer : borrowers)
    for (std::size_t m = 0; m < peer.nodes.size(); m++)
      take(peer.nodes[m], &peer.answers[RESULTS * m]);
}

/* ---------------------------------------------------------------------- */

double PeridemBatchShare::memory_usage() const
{
  return static_cast<double>(nodes.size() * sizeof(Node) + rows.size() * sizeof(Bond) +
                             (places.size() + results.size()) * sizeof(double));
}

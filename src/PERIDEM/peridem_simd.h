/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Several doubles side by side, computed at once: as many as one register of the processor holds.
// GNU's vector types give +, -, *, / and ?: on all lanes for any processor; a compiler without
// them gets one lane, an ordinary double.

#ifndef LMP_PERIDEM_SIMD_H
#define LMP_PERIDEM_SIMD_H

#include <cmath>
#include <cstring>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace LAMMPS_NS {
namespace PeridemSimd {

#if !defined(__GNUC__)
  static constexpr int WIDTH = 1;
  using Lanes = double;
#else
#if defined(__AVX512F__)
  static constexpr int WIDTH = 8;
#elif defined(__AVX__)
  static constexpr int WIDTH = 4;
#else
  static constexpr int WIDTH = 2;    // SSE2, NEON
#endif
  typedef double Lanes __attribute__((vector_size(WIDTH * sizeof(double))));
#endif

  // what containers hold: the alignment is the struct's, not an attribute of a template argument
  struct alignas(WIDTH * sizeof(double)) Pack {
    Lanes v;
  };

  inline Lanes all(double value)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_set1_pd(value);
#elif defined(__AVX__)
    return (Lanes) _mm256_set1_pd(value);
#else
    return Lanes{} + value;
#endif
  }

  // four numbers of a node, moved as one
  struct alignas(4 * sizeof(double)) Node {
    double v[4];
  };

  inline double get(const Pack &p, int lane)
  {
    return reinterpret_cast<const double *>(&p)[lane];
  }

  inline void set(Pack &p, int lane, double value)
  {
    reinterpret_cast<double *>(&p)[lane] = value;
  }

  inline Lanes larger(Lanes a, Lanes b)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_max_pd((__m512d) a, (__m512d) b);
#elif defined(__AVX__)
    return (Lanes) _mm256_max_pd((__m256d) a, (__m256d) b);
#else
    return a > b ? a : b;
#endif
  }

  inline Lanes smaller(Lanes a, Lanes b)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_min_pd((__m512d) a, (__m512d) b);
#elif defined(__AVX__)
    return (Lanes) _mm256_min_pd((__m256d) a, (__m256d) b);
#else
    return a < b ? a : b;
#endif
  }

  // is a > b in any lane?
  inline bool any_above(Lanes a, Lanes b)
  {
#if defined(__AVX512F__)
    return _mm512_cmp_pd_mask((__m512d) a, (__m512d) b, _CMP_GT_OQ) != 0;
#elif defined(__AVX__)
    return _mm256_movemask_pd(_mm256_cmp_pd((__m256d) a, (__m256d) b, _CMP_GT_OQ)) != 0;
#elif defined(__GNUC__)
    const auto above = a > b;
    return above[0] || above[1];
#else
    return a > b;
#endif
  }

#if defined(__AVX512F__)
  // From 14 bits to the last place in a third of the time of the processor's square root: where y is
  // nearly 1/r, and h = 1 - r^2 y^2 below 2^-13, 1/r is y (1 - h)^(-1/2), and r is r^2 times that.
  // Of the series of (1 - h)^(-1/2) - 1 = h/2 + 3/8 h^2 + 5/16 h^3 + 35/128 h^4 ... the last term that
  // counts is at most 2^-54; the 3.4e-9 stand for it, as well as a multiple of h^2 can.
  struct Root {
    Lanes inverse, root, rest;    // to 14 bits; and the part of both that they lack

    explicit Root(Lanes square)
    {
      inverse = (Lanes) _mm512_rsqrt14_pd((__m512d) square);
      root = square * inverse;
      const Lanes h = 1.0 - root * inverse;
      rest = h * (0.5 + h * (0.375 + 3.4e-9 + h * 0.3125));
    }
  };

  inline Lanes root(Lanes square)
  {
    const Root found(square);
    return found.root + found.root * found.rest;
  }

  // inverse: 1/r
  inline Lanes root(Lanes square, Lanes &inverse)
  {
    const Root found(square);
    inverse = found.inverse + found.inverse * found.rest;
    return found.root + found.root * found.rest;
  }

  // 1/r alone
  inline Lanes inverse_root(Lanes square)
  {
    const Root found(square);
    return found.inverse + found.inverse * found.rest;
  }
#else
  inline Lanes root(Lanes square)
  {
#if defined(__AVX__)
    return (Lanes) _mm256_sqrt_pd((__m256d) square);
#elif defined(__SSE2__)
    return (Lanes) _mm_sqrt_pd((__m128d) square);
#elif defined(__GNUC__)
    return Lanes{std::sqrt(square[0]), std::sqrt(square[1])};
#else
    return std::sqrt(square);
#endif
  }

  inline Lanes root(Lanes square, Lanes &inverse)
  {
    const Lanes r = root(square);
    inverse = 1.0 / r;
    return r;
  }

  inline Lanes inverse_root(Lanes square)
  {
    return 1.0 / root(square);
  }
#endif

  // ---- from and to memory ----------------------------------------------------------------------

  inline Lanes load(const double *from)
  {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof(Lanes));
    return lanes;
  }

  // ask for what will soon be read
  inline void expect(const void *place)
  {
#if defined(__GNUC__)
    __builtin_prefetch(place);
#endif
  }

  // one number each from the places index[0], index[1], ...
  inline Lanes gather(const double *from, const int *index)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_i32gather_pd(_mm256_loadu_si256((const __m256i *) index), from, 8);
#else
    Pack p;
    for (int lane = 0; lane < WIDTH; lane++) set(p, lane, from[index[lane]]);
    return p.v;
#endif
  }

  // WIDTH floats
  inline Lanes widen(const float *from)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_cvtps_pd(_mm256_loadu_ps(from));
#elif defined(__AVX__)
    return (Lanes) _mm256_cvtps_pd(_mm_loadu_ps(from));
#else
    Pack p;
    for (int lane = 0; lane < WIDTH; lane++) set(p, lane, from[lane]);
    return p.v;
#endif
  }

  // value in the lanes whose bit is set, 0 in the others
  inline Lanes only(unsigned char bits, Lanes value)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_maskz_mov_pd(bits, (__m512d) value);
#elif defined(__GNUC__)
    typedef long long Bits __attribute__((vector_size(WIDTH * sizeof(double))));
    Bits own;
    for (int lane = 0; lane < WIDTH; lane++) own[lane] = 1 << lane;
    return (own & (Bits{} + bits)) == own ? value : Lanes{};
#else
    return bits ? value : 0.0;
#endif
  }

  // the larger of a and b in the lanes whose bit is set, a in the others, which must not be below 0
  inline Lanes larger_where(unsigned char bits, Lanes a, Lanes b)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_mask_max_pd((__m512d) a, bits, (__m512d) a, (__m512d) b);
#else
    return larger(only(bits, b), a);
#endif
  }

#if defined(__AVX512F__)
  // nodes index[0] and index[4] one behind the other, and so on
  inline __m512d two_nodes(const Node *nodes, const int *index)
  {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(nodes[index[0]].v)),
                              _mm256_load_pd(nodes[index[4]].v), 1);
  }

  inline void subtract_two(Node *nodes, const int *index, __m512d two)
  {
    double *const a = nodes[index[0]].v, *const b = nodes[index[4]].v;
    _mm256_store_pd(a, _mm256_sub_pd(_mm256_load_pd(a), _mm512_castpd512_pd256(two)));
    _mm256_store_pd(b, _mm256_sub_pd(_mm256_load_pd(b), _mm512_extractf64x4_pd(two, 1)));
  }

  // first or second halves of the halves of a and b
  inline __m512d low_pairs(__m512d a, __m512d b)
  {
    return _mm512_permutex2var_pd(a, _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), b);
  }

  inline __m512d high_pairs(__m512d a, __m512d b)
  {
    return _mm512_permutex2var_pd(a, _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2), b);
  }

  // the numbers of the nodes index[0], index[1], ...: to[m] holds the m-th of each
  inline void load_nodes(const Node *nodes, const int *index, Lanes *to)
  {
    const __m512d a = two_nodes(nodes, index), b = two_nodes(nodes, index + 1);
    const __m512d c = two_nodes(nodes, index + 2), d = two_nodes(nodes, index + 3);
    const __m512d ab = _mm512_unpacklo_pd(a, b), cd = _mm512_unpacklo_pd(c, d);
    const __m512d ba = _mm512_unpackhi_pd(a, b), dc = _mm512_unpackhi_pd(c, d);
    to[0] = (Lanes) low_pairs(ab, cd);
    to[1] = (Lanes) low_pairs(ba, dc);
    to[2] = (Lanes) high_pairs(ab, cd);
    to[3] = (Lanes) high_pairs(ba, dc);
  }

  // the way back: what[m] is taken from the m-th number of each
  inline void subtract_nodes(Node *nodes, const int *index, const Lanes *what)
  {
    const auto x = (__m512d) what[0], y = (__m512d) what[1];
    const auto z = (__m512d) what[2], w = (__m512d) what[3];
    const __m512d ab = low_pairs(x, z), cd = high_pairs(x, z);
    const __m512d ba = low_pairs(y, w), dc = high_pairs(y, w);
    subtract_two(nodes, index, _mm512_unpacklo_pd(ab, ba));
    subtract_two(nodes, index + 1, _mm512_unpackhi_pd(ab, ba));
    subtract_two(nodes, index + 2, _mm512_unpacklo_pd(cd, dc));
    subtract_two(nodes, index + 3, _mm512_unpackhi_pd(cd, dc));
  }

  // total[m] = sum of the lanes of what[m]
  inline void sum_lanes(const Lanes *what, double *total)
  {
    const auto x = (__m512d) what[0], y = (__m512d) what[1];
    const auto z = (__m512d) what[2], w = (__m512d) what[3];
    const __m512d xy = _mm512_add_pd(_mm512_unpacklo_pd(x, y), _mm512_unpackhi_pd(x, y));
    const __m512d zw = _mm512_add_pd(_mm512_unpacklo_pd(z, w), _mm512_unpackhi_pd(z, w));
    const __m512d four = _mm512_add_pd(low_pairs(xy, zw), high_pairs(xy, zw));
    _mm256_storeu_pd(total,
                     _mm256_add_pd(_mm512_castpd512_pd256(four), _mm512_extractf64x4_pd(four, 1)));
  }
#elif defined(__AVX__)
  inline void load_nodes(const Node *nodes, const int *index, Lanes *to)
  {
    const __m256d a = _mm256_load_pd(nodes[index[0]].v), b = _mm256_load_pd(nodes[index[1]].v);
    const __m256d c = _mm256_load_pd(nodes[index[2]].v), d = _mm256_load_pd(nodes[index[3]].v);
    const __m256d ab = _mm256_unpacklo_pd(a, b), cd = _mm256_unpacklo_pd(c, d);
    const __m256d ba = _mm256_unpackhi_pd(a, b), dc = _mm256_unpackhi_pd(c, d);
    to[0] = (Lanes) _mm256_permute2f128_pd(ab, cd, 0x20);
    to[1] = (Lanes) _mm256_permute2f128_pd(ba, dc, 0x20);
    to[2] = (Lanes) _mm256_permute2f128_pd(ab, cd, 0x31);
    to[3] = (Lanes) _mm256_permute2f128_pd(ba, dc, 0x31);
  }

  inline void subtract_one(Node *nodes, int index, __m256d what)
  {
    double *const a = nodes[index].v;
    _mm256_store_pd(a, _mm256_sub_pd(_mm256_load_pd(a), what));
  }

  inline void subtract_nodes(Node *nodes, const int *index, const Lanes *what)
  {
    const auto x = (__m256d) what[0], y = (__m256d) what[1];
    const auto z = (__m256d) what[2], w = (__m256d) what[3];
    const __m256d ab = _mm256_unpacklo_pd(x, y), ba = _mm256_unpackhi_pd(x, y);
    const __m256d cd = _mm256_unpacklo_pd(z, w), dc = _mm256_unpackhi_pd(z, w);
    subtract_one(nodes, index[0], _mm256_permute2f128_pd(ab, cd, 0x20));
    subtract_one(nodes, index[1], _mm256_permute2f128_pd(ba, dc, 0x20));
    subtract_one(nodes, index[2], _mm256_permute2f128_pd(ab, cd, 0x31));
    subtract_one(nodes, index[3], _mm256_permute2f128_pd(ba, dc, 0x31));
  }
#else
  inline void load_nodes(const Node *nodes, const int *index, Lanes *to)
  {
    Pack p[4];
    for (int lane = 0; lane < WIDTH; lane++)
      for (int m = 0; m < 4; m++) set(p[m], lane, nodes[index[lane]].v[m]);
    for (int m = 0; m < 4; m++) to[m] = p[m].v;
  }

  inline void subtract_nodes(Node *nodes, const int *index, const Lanes *what)
  {
    Pack p[4];
    for (int m = 0; m < 4; m++) p[m].v = what[m];
    for (int lane = 0; lane < WIDTH; lane++)
      for (int m = 0; m < 4; m++) nodes[index[lane]].v[m] -= get(p[m], lane);
  }
#endif

#if !defined(__AVX512F__)
  inline void sum_lanes(const Lanes *what, double *total)
  {
    for (int m = 0; m < 4; m++) {
      const Pack p{what[m]};
      total[m] = 0.0;
      for (int lane = 0; lane < WIDTH; lane++) total[m] += get(p, lane);
    }
  }
#endif

}    // namespace PeridemSimd
}    // namespace LAMMPS_NS

#endif

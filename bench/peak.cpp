// What this core can do at most: `peak` prints, one a line, the clock [GHz], the rate of multiply-adds [GFLOP/s] in packs of
// four, which is what the kernel of AVX2 uses, and in packs of eight (AVX-512's) where the processor has them. Minima over
// short pieces.
#include <chrono>
#include <cstdio>

namespace {

constexpr int kPieces = 400, kSteps = 2000;
volatile double sink;
volatile unsigned long long sink_whole;

// Shortest time [s] of a piece of work.
template <class Work>
double shortest(Work work) {
  double best = 1e9;
  for (int piece = 0; piece < kPieces; ++piece) {
    const auto began = std::chrono::steady_clock::now();
    work();
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    best = took < best ? took : best;
  }
  return best;
}

// A multiplication of whole numbers waits three cycles for the one before it.
void dependent_products() {
  unsigned long long product = 3, factor = sink_whole | 5;
  for (int step = 0; step < kSteps; ++step) {
    product *= factor;
    asm volatile("" : "+r"(product));
  }
  sink_whole = product;
}

// LANES numbers in each of CHAINS registers; enough of them that no multiply-add waits for another.
#define MULTIPLY_ADDS(LANES, CHAINS)                                                  \
  typedef double Pack __attribute__((vector_size(8 * LANES)));                        \
  const double close_to_one = 1.0 - 1e-9 * (sink == 1.0);                             \
  Pack sum[CHAINS], factor = Pack{} + close_to_one, summand = Pack{} + 1e-9;          \
  for (int c = 0; c < CHAINS; ++c) sum[c] = Pack{} + double(c);                       \
  for (int step = 0; step < kSteps; ++step)                                           \
    _Pragma("GCC unroll 16") for (int c = 0; c < CHAINS; ++c) sum[c] = sum[c] * factor + summand; \
  Pack total = {};                                                                    \
  for (int c = 0; c < CHAINS; ++c) total += sum[c];                                   \
  sink = total[0] + total[LANES - 1];

constexpr int kChains = 12;

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void packs_of_four() { MULTIPLY_ADDS(4, kChains) }
__attribute__((target("avx512f"))) void packs_of_eight() { MULTIPLY_ADDS(8, kChains) }
void packs_of_two() { MULTIPLY_ADDS(2, kChains) }
#else
void packs_of_four() { MULTIPLY_ADDS(4, kChains) }
#endif

void print(const char* name, int lanes, double seconds) {
  std::printf("%s %.2f\n", name, 2e-9 * lanes * kChains * kSteps / seconds);
}

}  // namespace

int main() {
  std::printf("clock %.3f\n", 3e-9 * kSteps / shortest(dependent_products));
#if defined(__x86_64__)
  const bool has_four = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  print("peak", has_four ? 4 : 2, shortest(has_four ? packs_of_four : packs_of_two));
  if (__builtin_cpu_supports("avx512f")) print("peak_of_eight", 8, shortest(packs_of_eight));
#else
  print("peak", 4, shortest(packs_of_four));
#endif
}

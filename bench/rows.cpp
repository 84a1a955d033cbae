// Rows of a batch and nothing else, for counting instructions: `rows FILE COUNT LAW [REPEATS]` answers the paper's arm's COUNT rows of
// FILE, which holds q (COUNT, 11), twist (COUNT, 6), lower (11), upper (11) as doubles; all of it in piece(), which
// bench/stages.py tells callgrind to look at. With REPEATS behind it, each piece is answered so often, and the last word is
// what a row took [ns], by the pieces' shortest times. `rows` alone lists the laws.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "robot.hpp"

// A function of C, because callgrind is told its name.
extern "C" __attribute__((noinline)) void piece(const stillreach::Batch& b, std::ptrdiff_t first, std::ptrdiff_t last, const stillreach::Memory& m) {
  kernel().batch(b, first, last, m);
}

namespace {

constexpr std::ptrdiff_t kRowsAtOnce = 256;  // as in bindings/batch.cpp

std::vector<double> numbers(const char* path, std::size_t count) {
  std::vector<double> read(count);
  std::FILE* file = std::fopen(path, "rb");
  if (!file || std::fread(read.data(), sizeof(double), count, file) != count) {
    std::fprintf(stderr, "%s: expected %zu doubles\n", path, count);
    std::exit(2);
  }
  std::fclose(file);
  return read;
}

// Shortest times of all pieces together [s].
double answer(const stillreach::LawSettings& law, const std::vector<double>& given, std::ptrdiff_t count, long repeats) {
  Robot robot(paper_chain(), law);
  const int n = robot.n;
  std::vector<double> rates(count * n), doubles(kernel().batch_doubles(n, false) + 8);
  std::vector<std::int32_t> status(count);
  std::vector<int> ints(kernel().batch_ints(n));
  std::vector<std::int8_t> bytes(kernel().batch_bytes(n));
  double* start = doubles.data();
  while (reinterpret_cast<std::uintptr_t>(start) % 64 != 0) ++start;
  stillreach::Batch b{};
  b.arm = robot.state.arm, b.m = 6, b.every_row = 1, b.law = law;
  for (int r = 0; r < 6; ++r) b.rows[r] = r;
  b.q = given.data(), b.twist = b.q + count * n, b.twist_stride = 6, b.lower = b.twist + count * 6, b.upper = b.lower + n;
  b.rates = rates.data(), b.status = status.data();
  std::vector<double> shortest((count + kRowsAtOnce - 1) / kRowsAtOnce, 1e9);
  for (long repeat = 0; repeat < repeats; ++repeat)
    for (std::ptrdiff_t at = 0; at < count; at += kRowsAtOnce) {
      const auto began = std::chrono::steady_clock::now();
      piece(b, at, std::min(at + kRowsAtOnce, count), {start, ints.data(), bytes.data()});
      const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      shortest[at / kRowsAtOnce] = std::min(shortest[at / kRowsAtOnce], took);
    }
  double sum = 0.0;
  for (double time : shortest) sum += time;
  return sum;
}

}  // namespace

int main(int count, char** arguments) {
  const bool asked = count == 4 || count == 5;
  const std::ptrdiff_t rows = asked ? std::atol(arguments[2]) : 0;
  const long repeats = count == 5 ? std::atol(arguments[4]) : 1;
  if (rows > 0 && repeats > 0)
    for (const NamedLaw& law : every_law())
      if (std::strcmp(law.name, arguments[3]) == 0) {
        const std::vector<double> given = numbers(arguments[1], rows * 17 + 22);
        std::printf("%s, %s: %.2f\n", law.name, kernel().instruction_set, 1e9 / rows * answer(law.settings, given, rows, repeats));
        return 0;
      }
  if (count != 1) {
    std::fprintf(stderr, "usage: rows FILE COUNT LAW [REPEATS]; rows alone lists the laws\n");
    return 2;
  }
  for (const NamedLaw& law : every_law()) std::printf("%s\n", law.name);
}

// What the calls with many rows share: arrays by name, scratch memory, the task.
#pragma once

#include <algorithm>
#include <vector>

#include "settings.hpp"

// Rows between two looks at the signals: fewer of long arms, and of those whose full joint weight is factored in each
// row.
inline std::ptrdiff_t rows_at_once(std::ptrdiff_t n, bool full) {
  return full ? std::clamp<std::ptrdiff_t>(4096 / (n * n), 1, 256)
              : std::clamp<std::ptrdiff_t>(4096 / n / 8 * 8, 8, 256);
}

// The core's scratch memory of one thread.
struct BatchScratch {
  std::vector<double> doubles;
  std::vector<int> ints;
  std::vector<std::int8_t> bytes;
  std::vector<double> more;
  stillreach::Memory fit(int n, bool full) {
    const auto grow = [](auto& v, std::size_t count) {
      if (v.size() < count) v.resize(count);
    };
    grow(ints, kernel().batch_ints(n));
    grow(bytes, kernel().batch_bytes(n));
    return {aligned(doubles, kernel().batch_doubles(n, full)), ints.data(), bytes.data()};
  }
  double* fit_more(std::size_t count) {
    if (more.size() < count) more.resize(count);
    return more.data();
  }
};

BatchScratch& batch_scratch();  // this thread's

// Opens the arrays of a call and keeps them open.
class Arrays {
 public:
  explicit Arrays(nb::dict named) : named_(std::move(named)) { open_.reserve(32); }
  // The named array in place, or null where it is missing. argument: what the caller calls it.
  double* numbers(const char* name, std::initializer_list<long> shape, bool writable, const char* argument = nullptr) {
    if (!named_.contains(name)) return nullptr;
    open_.push_back(strict(argument ? argument : name, named_[name], shape, writable));
    return open_.back().data();
  }
  // Rows of `length` numbers, one each or one shared by all; stride: 0 where it is shared.
  const double* rows(const char* name, long count, long length, std::ptrdiff_t& stride) {
    stride = 0;
    if (!named_.contains(name)) return nullptr;
    View view;
    if (view.open(named_[name]) && view.ndim() == 1) return numbers(name, {length}, false);
    stride = length;
    return numbers(name, {count, length}, false);
  }
  template <class T>
  T* integers(const char* name, long count, const char* kind) {
    if (!named_.contains(name)) return nullptr;
    open_.emplace_back();
    View& view = open_.back();
    const nb::object array = named_[name];
    const bool fits = view.open(array) && view.is_contiguous() && view.is_writable();
    if (!fits || view.bytes() != static_cast<long>(sizeof(T)) * count)
      refuse(name, describe(array),
             std::string("a writable C-contiguous ") + kind + " array of " + std::to_string(count));
    return static_cast<T*>(static_cast<void*>(view.data()));
  }

 private:
  nb::dict named_;
  std::vector<View> open_;
};

inline void set_task(stillreach::Batch& b, const Law& law, const Metric& metric, nb::sequence rows, bool tool_axes) {
  const int m = metric.data->m;
  b.law = law.settings;
  b.metric = metric.data->view();
  b.m = m;
  b.tool_axes = tool_axes;
  b.arm.n = metric.data->n;
  int r = 0;
  for (nb::handle row : rows)
    if (r < 6) b.rows[r++] = nb::cast<int>(row);
  if (r != m) refuse("rows", std::to_string(r) + " rows", std::to_string(m) + ", as the metric has");
  b.every_row = m == 6 && !tool_axes;
}

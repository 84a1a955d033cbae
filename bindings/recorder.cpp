// Ticks on their way to a file: a ring of rows of numbers, which one thread fills and another one empties.
#include "controller.hpp"

#include <atomic>
#include <cstring>
#include <ctime>

struct Recorder {
  Controller* c;  // kept alive by the recorder
  long capacity, width;
  std::vector<double> rows, spare;
  std::int64_t seen = 0;  // ticks of the controller, when one was recorded last
  bool open = true;
  std::atomic<long> written{0}, taken{0}, dropped{0};
};

// Numbers of a row: time, q, rates, twist, pose, target, health, status.
static long row_width(int n) { return 1 + 3L * n + 6 + 12 + 12 + 1; }

static std::int64_t now() {
  std::timespec time{};
  std::timespec_get(&time, TIME_UTC);
  return std::int64_t{1000000000} * time.tv_sec + time.tv_nsec;
}

// [ns] of a time [s].
static std::int64_t read_time(nb::handle time) {
  const double seconds = PyFloat_CheckExact(time.ptr())
                             ? PyFloat_AsDouble(time.ptr())
                             : nb::cast<double>(nb::module_::import_("stillreach._door").attr("scalar")("time", time));
  if (!(seconds >= 0.0 && seconds < 2147483648.0)) refuse("time", describe(time), "seconds from 0 to below 2^31");
  return static_cast<std::int64_t>(std::nearbyint(1e9 * seconds));
}

static void make_recorder(Recorder* self, Controller& c, long capacity) {
  new (self) Recorder();
  self->c = &c;
  self->capacity = capacity;
  self->width = row_width(c.n());
  self->seen = c.ticks;
  self->spare.assign(to_size(self->width), 0.0);
  self->rows.assign(to_size(capacity * self->width), 0.0);
}

static bool add(Recorder& r, nb::handle q, nb::handle target, nb::handle time) {
  const Controller& c = *r.c;
  const int n = c.n();
  const long written = r.written.load(std::memory_order_relaxed);
  const bool room = written - r.taken.load(std::memory_order_acquire) < r.capacity && r.open;
  double frame[12];
  if (!target.is_none()) read_target("target", target, frame);
  const std::int64_t stamp = time.is_none() ? now() : read_time(time);
  double* to = room ? r.rows.data() + (written % r.capacity) * r.width : r.spare.data();
  read_vector("q", q, n, to + 1, false, c.labels);
  if (!room) {
    r.dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  std::memcpy(to, &stamp, sizeof stamp);
  to += 1 + n;
  const auto put = [&to](const double* from, int count, bool there) {
    if (there)
      std::copy_n(from, count, to);
    else
      std::fill_n(to, count, std::nan(""));
    to += count;
  };
  const bool made = c.ticks > r.seen;  // a tick, since the last one that was recorded
  const bool valid = made && !(c.core.answer.status & stillreach::INVALID_INPUT);
  r.seen = c.ticks;
  put(c.core.state.last.rates, n, made);
  put(c.core.state.now.command, 6, valid);
  put(c.core.state.now.pose, 12, valid);
  put(frame, 12, !target.is_none());
  for (int i = 0; i < n; ++i) *to++ = static_cast<double>(c.core.state.faults.of[i].health);
  *to = static_cast<double>(made ? c.core.answer.status : stillreach::INVALID_INPUT);
  r.written.store(written + 1, std::memory_order_release);
  return true;
}

static long take(Recorder& r, nb::handle out) {
  View view = strict("out", out, {-1, r.width}, true);
  const long taken = r.taken.load(std::memory_order_relaxed);
  const long count = std::min(r.written.load(std::memory_order_acquire) - taken, view.size(0));
  const long first = std::min(count, r.capacity - taken % r.capacity);
  const double* const from = r.rows.data() + (taken % r.capacity) * r.width;
  std::copy_n(from, first * r.width, view.data());
  std::copy_n(r.rows.data(), (count - first) * r.width, view.data() + first * r.width);
  r.taken.store(taken + count, std::memory_order_release);
  return count;
}

void bind_recorder(nb::module_& m) {
  nb::class_<Recorder> c(m, "RecorderCore", nb::is_weak_referenceable(), "The compiled part of stillreach.Recorder.");
  c.def("__init__", &make_recorder, nb::arg("controller"), nb::arg("capacity"), nb::keep_alive<1, 2>());
  c.def(
      "add", &add, nb::arg("q").none(), nb::arg("target").none() = nb::none(), nb::arg("time").none() = nb::none(),
      nb::sig("def add(self, q: numpy.typing.ArrayLike | collections.abc.Mapping[str, float], target: "
              "numpy.typing.ArrayLike | None = None, time: float | None = None) -> bool"),
      "Records the controller's last tick; the only call that a loop needs.\n\n"
      "Call it right after the tick, before faults change. q (n,) [rad, m] measured, as that tick was given; it may be "
      "NaN. target (4, 4) [m] the pose that was tracked. time [s] of the loop's own clock; None: the time of day. If "
      "no "
      "tick was made since the last call, because its input was refused, the status is INVALID_INPUT, and rates and "
      "pose "
      "are left out. False if the tick was dropped: the file did not keep up, failed or is closed. Raises InputError "
      "for "
      "anything of another shape, and records nothing then.");
  c.def("_end", [](Recorder& r) { r.open = false; }, "Every later tick is dropped.");
  c.def("_take", &take, nb::arg("out"));
  c.def_prop_ro(
      "dropped", [](const Recorder& r) { return r.dropped.load(); },
      "How many ticks were dropped: the file did not keep up, failed or was closed.");
  c.def_prop_ro("_width", [](const Recorder& r) { return r.width; });
}

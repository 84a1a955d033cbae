// A few threads, started once, that work through the rows of a batch beside the thread that calls.
#pragma once

#include <cstddef>
#include <functional>

// Threads to use where nothing says how many: STILLREACH_THREADS, or the processors that this process may run on.
int default_threads();

// Runs work(first, last, stopped) over [0, count) in blocks, on up to `threads` threads, the calling one among them;
// `work` is called by several at once, on different blocks. between: called by the calling thread every now and then;
// false ends early: no block is begun any more, and stopped(), which work on long blocks asks, is true. Returns false
// where that happened. What `work` throws, on whatever thread, ends early, too, and is thrown to the caller once all
// threads are done. Threads are started when first needed, and again after a fork.
using Stopped = std::function<bool()>;
bool run_blocks(std::ptrdiff_t count, std::ptrdiff_t block, int threads,
                const std::function<void(std::ptrdiff_t, std::ptrdiff_t, const Stopped&)>& work,
                const std::function<bool()>& between);

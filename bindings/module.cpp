#include "settings.hpp"

NB_MODULE(_core, m) {
  m.doc() = "The compiled core of stillreach.";
  nb::set_leak_warnings(false);  // arms that live in modules outlast the interpreter's own clean-up
  bind_enums(m);
  bind_settings(m);
  bind_arm(m);
  bind_solution(m);
  bind_solve(m);
  bind_controller(m);
  bind_recorder(m);
  bind_batch(m);
  bind_inverse(m);
  bind_losses(m);
  m.def(
      "instruction_set", []() { return kernel().instruction_set; },
      "Which build of the core runs here: \"avx512\", \"avx2\" or \"baseline\"; STILLREACH_INSTRUCTIONS names the most "
      "that may be used.");
}

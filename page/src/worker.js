// The worker: runs the closed loop at its own period, and tells the page what happened whenever that asks for a frame.

import { Drag, Shape } from "./motions.js";
import { Simulation } from "./simulation.js";

const SLICE = 8; // [ms] at most computed at a time, so that messages are heard
const REST = 2; // [ms] between slices
const BEHIND = 0.1; // [s] that the loop catches up at most, after the computer was busy elsewhere

let simulation = null;
let running = false;
let speed = 1;
let owed = 0; // ticks to be made
let before = 0;

function loop() {
  const now = performance.now();
  if (running) {
    const { period } = simulation.task;
    const share = Math.min((now - before) / 1000, BEHIND) * speed;
    owed = Math.min(owed + share / period, (BEHIND * speed) / period + 1);
    while (owed >= 1 && performance.now() - now < SLICE) {
      const ticks = Math.min(Math.floor(owed), 256);
      simulation.advance(ticks);
      owed -= ticks;
    }
  } else owed = 0;
  before = now;
  setTimeout(loop, REST);
}

const commands = {
  // A task, also instead of another one.
  begin({ module, task }) {
    const first = simulation === null;
    simulation = new Simulation(module, task);
    running = false;
    if (first) loop();
  },
  run({ value }) {
    running = value;
  },
  step({ ticks }) {
    running = false;
    simulation.advance(ticks);
  },
  speed({ value }) {
    speed = value;
  },
  restart() {
    simulation.restart();
  },
  fail({ joint, fault, ticks }) {
    simulation.fail(joint, fault, ticks);
  },
  change({ setup }) {
    simulation.change(setup);
  },
  goOn({ tick, q, rates, faults }) {
    simulation.goOn(tick, q, rates, faults);
  },
  // From the beginning with these faults instead of the scenario's own, up to a tick at once.
  play({ changes, known, to, delayed, onset, id }) {
    simulation.restart();
    simulation.case = { id, onset, worst: [0, 0] };
    simulation.changes = changes.slice();
    simulation.known = known.slice();
    simulation.delayed = delayed;
    simulation.advance(to);
    simulation.trail = [];
  },
  // The plan from its beginning, or a motion of the page's own about the tool's pose. Another size or speed of the same
  // shape changes it where it is.
  motion({ kind, right, up, size, seconds }) {
    const { motion } = simulation;
    if (kind === "plan") return simulation.restart();
    if (motion instanceof Shape && motion.kind === kind) return Object.assign(motion, { size, seconds });
    const { pose } = simulation.snapshot();
    simulation.planned = false;
    simulation.motion = kind === "drag" ? new Drag(pose, size) : new Shape(kind, pose, right, up, size, seconds);
    simulation.changed();
  },
  goal({ point }) {
    if (simulation.motion instanceof Drag) simulation.motion.goal = point;
  },
  frame() {
    const found = { ...simulation.snapshot(), running, speed };
    postMessage(found);
  },
};

onmessage = ({ data }) => commands[data.do](data);

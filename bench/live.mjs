// Minima of the time of a tick [us] of rollouts in WebAssembly, 128 ticks a call. Arguments: the page's folder, that of
// the tasks.
import { readFileSync } from "node:fs";

const [page, folder] = process.argv.slice(2);
const { CHUNK } = await import(`${page}/src/core.js`);
const { Simulation } = await import(`${page}/src/simulation.js`);
const { inflate, unpack } = await import(`${page}/src/unpack.js`);
const module = new WebAssembly.Module(readFileSync(`${page}/core/controller.wasm`));
const tasks = unpack(readFileSync(`${folder}/tasks.json`, "utf8"), await inflate(readFileSync(`${folder}/tasks.b64`, "utf8")));
const found = tasks.map((task) => {
  const { core } = new Simulation(module, task);
  core.twists.set(task.parts[0].twists.subarray(0, 6 * CHUNK));
  for (let k = 0; k < CHUNK; ++k) core.targets.set([...task.parts[0].poses.subarray(12 * k, 12 * k + 12), 0, 0, 0, 1], 16 * k);
  let best = Infinity;
  for (let repeat = 0; repeat < 300; ++repeat) {
    core.q.set(task.start);
    const began = performance.now();
    core.exports.run(CHUNK, 1, 1, 1, 0, 0);
    best = Math.min(best, (1000 * (performance.now() - began)) / CHUNK);
  }
  return best;
});
console.log(JSON.stringify(found));

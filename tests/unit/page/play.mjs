// Plays tasks as the page's worker does, and writes their records. Arguments: the page's folder, that of the tasks.
import { readFileSync, writeFileSync } from "node:fs";

const [page, folder] = process.argv.slice(2);
const { RECORD } = await import(`${page}/src/core.js`);
const { Simulation } = await import(`${page}/src/simulation.js`);
const { inflate, numbered, unpack } = await import(`${page}/src/unpack.js`);
const sizes = { pose: 16, command: 6, residual: 6, task_error: 1, damping: 1, scale: 1, status: 1 };
const module = new WebAssembly.Module(readFileSync(`${page}/core/controller.wasm`));
let ticks = 0, spent = 0;
for (const name of readFileSync(`${folder}/names.txt`, "utf8").split("\n")) {
  const block = await inflate(readFileSync(`${folder}/${name}.b64`, "utf8"));
  const { task } = unpack(readFileSync(`${folder}/${name}.json`, "utf8"), block);
  task.changes = task.changes.map(numbered);
  task.known = task.known.map(numbered);
  const simulation = new Simulation(module, task);
  const found = Object.fromEntries(RECORD.map((array) => [array, []]));
  const keep = (core, count) => {
    for (const array of RECORD) found[array].push(core[`record.${array}`].slice(0, (sizes[array] ?? core.n) * count));
  };
  simulation.snapshot(); // looking changes nothing
  const began = performance.now();
  for (let left = task.steps + 1; left > 0; left -= 77) {
    simulation.advance(Math.min(left, 77), keep);
    if (left % 5 === 0) simulation.snapshot();
  }
  spent += performance.now() - began;
  ticks += task.steps + 1;
  for (const array of RECORD)
    writeFileSync(`${folder}/${name}.${array}`, Buffer.concat(found[array].map((part) => Buffer.from(part.buffer, part.byteOffset, part.byteLength))));
}
console.log(JSON.stringify({ ticks, microseconds: (1000 * spent) / ticks }));

// What the page says of arms at rest: relative manipulability, what each loss costs, the ellipsoid.
import { readFileSync } from "node:fs";

const [page, folder] = process.argv.slice(2);
const { Simulation } = await import(`${page}/src/simulation.js`);
const { stations } = await import(`${page}/src/kinematics.js`);
const { inflate, unpack } = await import(`${page}/src/unpack.js`);
const module = new WebAssembly.Module(readFileSync(`${page}/core/controller.wasm`));
const all = unpack(readFileSync(`${folder}/looks.json`, "utf8"), await inflate(readFileSync(`${folder}/looks.b64`, "utf8")));
const said = all.map((task) => {
  const simulation = new Simulation(module, task);
  for (const joint of task.broken) simulation.fail(joint, { health: 1, first: 0, second: 0 }, 0);
  const found = simulation.snapshot();
  const { relative, costs, cost, lost, sigma, direction, pose } = found;
  const lists = Object.fromEntries(Object.entries({ relative, costs, cost, sigma, direction, pose }).map(([name, array]) => [name, Array.from(array)]));
  return { ...lists, lost, drawn: Array.from(stations(task.arm, task.start).tool) };
});
console.log(JSON.stringify(said));

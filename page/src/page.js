// Reads the page's data, starts the viewer, and gives the page around it a handle.

import { numbered, inflate, unpack } from "./unpack.js";
import { Viewer } from "./viewer.js";

const text = (id) => document.getElementById(id).textContent;

async function begin() {
  const [block, core] = await Promise.all([inflate(text("stillreach-block")), inflate(text("stillreach-core"))]);
  const data = unpack(text("stillreach-document"), block);
  for (const task of data.tasks)
    for (const list of ["changes", "known"]) task[list] = task[list].map(numbered);
  for (const run of data.runs) run.faults = run.faults.map(numbered);
  return new Viewer(document.getElementById("viewer"), data, await WebAssembly.compile(core));
}

window.stillreach = { viewer: null, error: null };
window.stillreach.ready = begin().then(
  (viewer) => (window.stillreach.viewer = viewer),
  (error) => {
    window.stillreach.error = String(error);
    const box = document.getElementById("viewer");
    box.textContent = `This page cannot run here: ${error.message}. It needs a browser with WebAssembly, vector instructions and DecompressionStream (2023 or newer).`;
    throw error;
  },
);

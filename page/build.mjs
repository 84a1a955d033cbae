// Builds the page's program into src/stillreach/page/dist, from which Python makes pages.
import { copyFile, mkdir, readFile, writeFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = new URL(".", import.meta.url).pathname;
const out = `${here}../src/stillreach/page/dist`;
const common = { bundle: true, minify: true, format: "iife", target: "es2022", write: false, legalComments: "none" };

const worker = await build({ ...common, entryPoints: [`${here}src/worker.js`] });
const page = await build({
  ...common,
  entryPoints: [`${here}src/page.js`],
  define: { WORKER: JSON.stringify(worker.outputFiles[0].text) },
  banner: { js: "/* three.js: MIT, three.js authors. uPlot: MIT, Leon Sorokin. stillreach: Apache-2.0. */" },
});
const css = await Promise.all([`${here}node_modules/uplot/dist/uPlot.min.css`, `${here}src/page.css`].map((path) => readFile(path, "utf8")));

await mkdir(out, { recursive: true });
await writeFile(`${out}/page.js`, page.outputFiles[0].text.replaceAll("</script", "<\\/script"));
await writeFile(`${out}/page.css`, css.join("\n"));
await writeFile(`${out}/core.b64`, gzipSync(await readFile(`${here}core/controller.wasm`), { level: 9 }).toString("base64"));
await copyFile(`${here}src/page.html`, `${out}/page.html`);
